// PLY. Source: G. Turk, "The PLY Polygon File Format", 1994.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/counted.h"
#include "formats/element_runs.h"
#include "formats/file_marks.h"
#include "formats/mesh_builder.h"
#include "formats/ply.h"
#include "formats/ply_curves.h"
#include "formats/ply_header.h"
#include "formats/ply_roles.h"
#include "formats/ply_rows.h"
#include "formats/ply_sections.h"
#include "formats/ply_values.h"
#include "formats/text_scanner.h"

namespace diesink {
namespace {

template <class Values>
class BodyReader {
 public:
  BodyReader(TextScanner& text, Values values, const PlyHeader& header, const ReadOptions& options,
             Diagnostics& diagnostics)
      : rows_(text, std::move(values), header, options),
        text_(text),
        header_(header),
        options_(options),
        diagnostics_(diagnostics),
        builder_(mesh_, options) {}

  Result<TriangleMesh> read() {
    read_comments();
    if (const Status order = check_elements(); !order) return order.error();
    // Faces need their vertices' positions to be cut, and may come before them.
    std::vector<std::pair<const PlyElement*, const char*>> early;
    for (const PlyElement& element : header_.elements) {
      // One numbering for all: normals of corners leave those of vertices aside.
      const bool is_face = element.name == "face" || element.name == "tristrips";
      own_normals_ = own_normals_ || (is_face && ply_face_normals(element).any());
    }
    for (const PlyElement& element : header_.elements) {
      if (const Status fits = rows_.check_size(element); !fits) return fits.error();
      const bool is_face = element.name == "face" || element.name == "tristrips";
      Status status = ok();
      if (is_face && !vertices_read_) {
        early.emplace_back(&element, text_.at());
        status = rows_.skip(element);
      } else if (is_face) {
        status = read_faces(element);
      } else if (element.name == "vertex") {
        status = read_vertices(element);
      } else if (element.name == "normal") {
        status = read_normals(element);
      } else if (element.name == "edge") {
        status = read_edges(element);
      } else {
        if (element.count > 0) ignored_.push_back("element " + quoted(element.name) + " is");
        status = rows_.skip(element);
      }
      if (!status) return status.error();
    }
    rows_.values().finish();
    const char* const end = text_.at();
    for (const auto& [element, at] : early) {
      text_.move_to(at);
      if (const Status status = read_faces(*element); !status) return status.error();
    }
    text_.move_to(end);
    if (const Status status = finish(); !status) return status.error();
    return std::move(mesh_);
  }

 private:
  Error error(std::string message, const char* at, ErrorCode code = ErrorCode::kInput) const {
    return rows_.error(std::move(message), at, code);
  }

  // Whether so many fit in memory; the place, for which lines are counted, only where they do not.
  Status fits(std::size_t vertices, std::size_t triangles) const {
    const Status fit = mesh_fits(vertices, triangles, options_, {});
    if (fit) return ok();
    return error(fit.error().message, text_.at(), fit.error().code);
  }

  void read_comments() {
    for (const std::string_view comment : header_.comments) {
      TextScanner words(comment, {});
      const std::string_view kind = words.word();
      const std::optional<std::int64_t> number = integer_of(words.word());
      if (!number || *number < 0) {
        read_mark(comment, mesh_);
        continue;
      }
      const auto index = static_cast<std::size_t>(*number);
      if (kind == "element" && index == elements_.size()) {
        elements_.add({std::string(words.rest_of_line()), {}, std::nullopt});
      } else if (kind == "solid" && index < elements_.size()) {
        elements_.elements()[index].solid = std::string(words.rest_of_line());
      } else if (kind == "color" && index < elements_.size()) {
        Color color{0, 0, 0, 255};
        for (std::uint8_t& part : color) {
          const std::optional<std::int64_t> value = integer_of(words.word());
          if (value && *value >= 0 && *value <= 255) part = static_cast<std::uint8_t>(*value);
        }
        elements_.elements()[index].color = color;
      } else if (kind == "curve" && index == curve_labels_.size()) {
        curve_labels_.push_back(words.rest_of_line());
      }
    }
    own_elements_ = elements_.size();
  }

  Status check_elements() const {
    const auto vertex = std::find_if(header_.elements.begin(), header_.elements.end(),
                                     [](const PlyElement& e) { return e.name == "vertex"; });
    if (vertex == header_.elements.end())
      return error("the file has no element 'vertex'", text_.at());
    for (const std::string_view axis : {"x", "y", "z"}) {
      const PlyProperty* const property = vertex->find(axis);
      if (property == nullptr || property->list) {
        return error("the vertices have no property '" + std::string(axis) + "'", text_.at());
      }
    }
    return ok();
  }

  PlyPlan plan_of(const PlyElement& element) {
    std::string skipped;
    PlyPlan plan = ply_plan(element, skipped);
    if (!skipped.empty() && element.count > 0) {
      // Names are words, so a blank tells of several.
      const bool several = skipped.find(' ') != std::string::npos;
      ignored_.push_back((several ? "properties " : "property ") + quoted(skipped) + " of " +
                         quoted(element.name) + (several ? " are" : " is"));
    }
    return plan;
  }

  Status read_vertices(const PlyElement& element) {
    vertices_read_ = true;
    const PlyPlan plan = plan_of(element);
    const bool normals = plan.all(PlyRole::kNx, PlyRole::kNy, PlyRole::kNz);
    const bool colors = plan.all(PlyRole::kRed, PlyRole::kGreen, PlyRole::kBlue);
    if (Status fit = fits(element.count, 0); !fit) return fit;
    mesh_.positions.reserve(element.count);
    if (normals) vertex_normals_.reserve(element.count);
    if (colors) mesh_.vertex_colors.reserve(element.count);
    return rows_.each_row_by_role(
        element, plan, [&](const PlyRow& row, const char* start) -> Status {
          const Vec3 p = vector_of(row, PlyRole::kX);
          if (!p.allFinite()) return error("a coordinate that is no finite number", start);
          if (const double size = p.cwiseAbs().maxCoeff(); size > options_.max_coordinate) {
            return error("coordinate " + to_text(size) + " is beyond the limit of " +
                             to_text(options_.max_coordinate),
                         start, ErrorCode::kLimit);
          }
          mesh_.positions.emplace_back(p + Vec3::Zero());
          if (normals) vertex_normals_.push_back(unit_normal(vector_of(row, PlyRole::kNx), start));
          if (colors) mesh_.vertex_colors.push_back(plan.color_of(row));
          return ok();
        });
  }

  // As it is where it is a unit vector up to its file's rounding.
  Vec3 unit_normal(const Vec3& n, const char* start) {
    const double length = n.norm();
    if (!(length > 0) || !std::isfinite(length)) {
      no_direction_.hit(start);
      return Vec3::UnitZ();
    }
    return std::abs(length - 1) < 1e-3 ? Vec3(n + Vec3::Zero()) : Vec3(n / length);
  }

  Status read_normals(const PlyElement& element) {
    const PlyPlan plan = plan_of(element);
    if (!plan.all(PlyRole::kNx, PlyRole::kNy, PlyRole::kNz))
      return error("normals need nx, ny and nz", text_.at());
    mesh_.normals.reserve(element.count);
    return rows_.each_row_by_role(
        element, plan, [&](const PlyRow& row, const char* start) -> Status {
          mesh_.normals.push_back(unit_normal(vector_of(row, PlyRole::kNx), start));
          return ok();
        });
  }

  Status to_vertices(const std::vector<double>& list, const char* start) {
    face_.clear();
    for (const double item : list) {
      if (item < 0 || item >= static_cast<double>(mesh_.positions.size())) {
        return error("vertex " + to_text(item) + ", expected 0 to " +
                         std::to_string(static_cast<std::int64_t>(mesh_.positions.size()) - 1),
                     start);
      }
      face_.push_back(static_cast<std::uint32_t>(item));
    }
    return ok();
  }

  Status add_face(std::span<const std::uint32_t> normals, std::uint32_t element,
                  const char* start) {
    switch (builder_.add(face_, normals, element)) {
      case FaceVerdict::kTooFew:
        few_.hit(start);
        break;
      case FaceVerdict::kCrossing:
        crossing_.hit(start);
        break;
      case FaceVerdict::kTooMany:
        return error("more triangles than the limit of " + std::to_string(options_.max_triangles),
                     start, ErrorCode::kLimit);
      case FaceVerdict::kOutOfRange:
      case FaceVerdict::kFine:
        break;
    }
    return ok();
  }

  Status read_faces(const PlyElement& element) {
    const bool strips = element.name == "tristrips";
    const PlyProperty* indices = element.find("vertex_indices");
    if (indices == nullptr) indices = element.find("vertex_index");
    if (indices == nullptr || !indices->list || is_real(indices->type)) {
      if (element.count == 0) return ok();
      return error("the faces have no list property 'vertex_indices' of whole numbers",
                   element.named_at);
    }
    const PlyFaceNormals own_normals = ply_face_normals(element);
    const PlyProperty* number = own_elements_ > 0 ? element.find("element") : nullptr;
    if (number != nullptr && number->list) number = nullptr;
    PlyPlan colors;
    std::vector<double> list, normal_items;
    std::vector<std::uint32_t> normals;
    if (Status fit = fits(mesh_.positions.size(), element.count); !fit) return fit;
    const bool room = element.count <= options_.max_triangles;
    if (room) mesh_.triangles.reserve(element.count);
    PlyRow row{};
    for (const PlyProperty& property : element.properties) {
      const PlyRole role = property.list ? PlyRole::kSkip : ply_role_of(property.name);
      const bool color = role >= PlyRole::kRed;
      colors.roles.push_back(color ? role : PlyRole::kSkip);
      if (color) {
        colors.has[static_cast<std::size_t>(role)] = true;
        colors.type[static_cast<std::size_t>(role)] = property.type;
      } else if (&property != indices && &property != number && &property != own_normals.list &&
                 own_normals.corner_of(property) < 0 && element.count > 0) {
        ignored_.push_back("property " + quoted(property.name) + " of faces is");
      }
    }
    const bool colored =
        number == nullptr && colors.all(PlyRole::kRed, PlyRole::kGreen, PlyRole::kBlue);
    double own = 0;
    const auto read = [&](const PlyProperty& property, std::size_t p) {
      if (&property == indices) return rows_.read_list(property, list);
      if (&property == own_normals.list) return rows_.read_list(property, normal_items);
      if (const int corner = own_normals.corner_of(property); corner >= 0) {
        normal_items.resize(3);
        return rows_.read_value(property.type, normal_items[static_cast<std::size_t>(corner)]);
      }
      if (&property == number) return rows_.read_value(property.type, own);
      if (property.list) return rows_.skip_property(property);
      return rows_.read_value(property.type, row[static_cast<std::size_t>(colors.roles[p])]);
    };
    return rows_.each_row(element, read, [&](const char* start) -> Status {
      std::uint32_t of_face = 0;
      if (number != nullptr) {
        if (!(own >= 0 && own < static_cast<double>(own_elements_))) {
          return error(
              "element " + to_text(own) + ", expected 0 to " + std::to_string(own_elements_ - 1),
              start);
        }
        of_face = static_cast<std::uint32_t>(own);
      } else if (colored) {
        of_face = elements_.colored(colors.color_of(row));
      }
      if (strips) return read_strip(list, of_face, start);
      if (const Status face = to_vertices(list, start); !face) return face;
      normals.clear();
      if (own_normals.any() && normal_items.size() == list.size()) {
        for (const double n : normal_items) {
          normals.push_back(n >= 0 && n < 4294967295.0 ? static_cast<std::uint32_t>(n)
                                                       : FaceBuilder::kNoNormal);
        }
      } else if (!vertex_normals_.empty() && !own_normals_) {
        normals = face_;
      }
      return add_face(normals, of_face, start);
    });
  }

  // One list of vertices, each but the first two making a triangle, -1 beginning anew.
  Status read_strip(const std::vector<double>& list, std::uint32_t of_face, const char* start) {
    std::size_t first = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (list[i] < 0) {
        first = i + 1;
        continue;
      }
      if (i < first + 2) continue;
      const bool odd = (i - first) % 2 == 1;
      std::vector<double> corners{list[i - 2], list[i - 1], list[i]};
      if (odd) std::swap(corners[0], corners[1]);
      // Strips turn a corner by repeating a vertex.
      if (corners[0] == corners[1] || corners[1] == corners[2] || corners[0] == corners[2])
        continue;
      if (const Status face = to_vertices(corners, start); !face) return face;
      const std::vector<std::uint32_t> normals =
          vertex_normals_.empty() || own_normals_ ? std::vector<std::uint32_t>{} : face_;
      if (const Status added = add_face(normals, of_face, start); !added) return added;
    }
    return ok();
  }

  Status read_edges(const PlyElement& element) {
    const PlyProperty* const a = element.find("vertex1");
    const PlyProperty* const b = element.find("vertex2");
    if (a == nullptr || b == nullptr || a->list || b->list) {
      if (element.count > 0) ignored_.push_back("element 'edge' without vertex1 and vertex2 is");
      return rows_.skip(element);
    }
    const PlyProperty* const curve = element.find("curve");
    edges_.reserve(element.count);
    double from = 0, to = 0, number = -1, other = 0;
    const auto read = [&](const PlyProperty& property, std::size_t) {
      double& value = &property == a       ? from
                      : &property == b     ? to
                      : &property == curve ? number
                                           : other;
      return property.list ? rows_.skip_property(property) : rows_.read_value(property.type, value);
    };
    return rows_.each_row(element, read, [&](const char* start) -> Status {
      edge_start_ = start;
      const double most = 4294967294.0;
      if (!(from >= 0 && to >= 0 && from <= most && to <= most))
        return error("an edge to no vertex", start);
      edges_.push_back({static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(to),
                        number >= 0 && number <= most ? static_cast<std::int64_t>(number) : -1});
      return ok();
    });
  }

  Status finish() {
    if (own_normals_ && !mesh_.corner_normals.empty()) {
      for (std::array<std::uint32_t, 3>& corner : mesh_.corner_normals) {
        for (std::uint32_t& n : corner) {
          if (n != FaceBuilder::kNoNormal && n >= mesh_.normals.size()) {
            return error("a face's normal " + std::to_string(n) + " is past the last", text_.at());
          }
        }
      }
    } else {
      mesh_.normals = std::move(vertex_normals_);
    }
    const std::size_t given = builder_.finish(elements_);
    if (given > 0) {
      diagnostics_.warning(counted(given,
                                   "triangle has no normal: it was given its own|triangles have no "
                                   "normals: they were given their own|"),
                           rows_.place(text_.at()));
    }
    if (!make_ply_curves(edges_, curve_labels_, mesh_)) {
      return error("an edge to a vertex past the last", edge_start_);
    }
    const char* const end = text_.at();
    for (const std::string& what : ignored_)
      diagnostics_.warning(what + " not kept", {options_.file_name});
    if (mesh_.triangles.empty())
      diagnostics_.warning("the file has no faces", {options_.file_name});
    warn(few_, "face|faces| with fewer than three corners, left out");
    warn(crossing_, "polygon crosses itself or is flat|polygons cross themselves or are flat|");
    warn(no_direction_, "normal has|normals have| no direction");
    warn(rows_.values().longer,
         "row has|rows have| more values than the header announces, left out");
    const bool rest = rows_.ascii() ? text_.more() : !text_.at_end();
    if (rest)
      diagnostics_.warning(
          counted(text_.left(), "byte after the data is|bytes after the data are| left out"),
          rows_.place(end));
    return ok();
  }

  void warn(const Tally& odd, std::string_view what) {
    if (odd.count() > 0) {
      diagnostics_.warning(counted(odd.count(), what), rows_.place(odd.first()));
    }
  }

  PlyRows<Values> rows_;
  TextScanner& text_;
  const PlyHeader& header_;
  const ReadOptions& options_;
  Diagnostics& diagnostics_;
  TriangleMesh mesh_;
  FaceBuilder builder_;
  ElementTable elements_;
  std::size_t own_elements_ = 0;
  bool vertices_read_ = false, own_normals_ = false;
  std::vector<Vec3> vertex_normals_;
  std::vector<std::uint32_t> face_;
  std::vector<PlyEdge> edges_;
  const char* edge_start_ = nullptr;
  std::vector<std::string_view> curve_labels_;
  std::vector<std::string> ignored_;
  Tally few_, crossing_, no_direction_;
};

}  // namespace

bool looks_like_ply(std::span<const std::byte> bytes) { return first_word_of(bytes) == "ply"; }

Result<TriangleMesh> read_ply(std::span<const std::byte> bytes, const ReadOptions& options,
                              Diagnostics& diagnostics) {
  TextScanner text(text_of(bytes), options.file_name);
  const Result<PlyHeader> header = read_ply_header(text);
  if (!header) return header.error();
  const auto read = [&](auto values, TextScanner& body, Diagnostics& told) {
    return BodyReader(body, std::move(values), *header, options, told).read();
  };
  switch (header->encoding) {
    case PlyEncoding::kLittleEndian:
      return read(BinaryValues<false>(text), text, diagnostics);
    case PlyEncoding::kBigEndian:
      return read(BinaryValues<true>(text), text, diagnostics);
    case PlyEncoding::kAscii:
      break;
  }
  if (PlySectionValues::fit(text, *header, options)) {
    TextScanner body = text;
    Diagnostics told;
    if (Result<TriangleMesh> mesh = read(PlySectionValues(body, *header, options), body, told)) {
      for (const Diagnostic& each : told.all()) diagnostics.warning(each.message, each.where);
      return mesh;
    }
  }
  return read(AsciiValues(text), text, diagnostics);
}

}  // namespace diesink
