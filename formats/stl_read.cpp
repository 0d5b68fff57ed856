// STL, both kinds. Source: 3D Systems' StereoLithography Interface Specification; the two colour
// layouts are those of VisCAM/SolidView and Materialise Magics. SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/mesh_tools/vertex_table.h"
#include "formats/element_table.h"
#include "formats/file_marks.h"
#include "formats/mesh_builder.h"
#include "formats/parallel.h"
#include "formats/stl.h"
#include "formats/text_scanner.h"

namespace diesink {
namespace {

// Facets as they come, three corners each, given to the weld in batches.
class FacetGatherer {
 public:
  FacetGatherer(std::size_t expected, bool weld)
      : weld_(weld), table_(weld ? expected / 2 + 4 : 0) {
    triangles_.reserve(expected);
    if (!weld) positions_.reserve(3 * expected);
  }

  // Room for the next facet's corners.
  std::array<Vec3, 3>& next() { return batch_[waiting_]; }
  void took() {
    if (++waiting_ == batch_.size()) flush();
  }

  void move_into(TriangleMesh& mesh) {
    flush();
    mesh.positions = weld_ ? table_.take() : std::move(positions_);
    mesh.triangles = std::move(triangles_);
  }

 private:
  static constexpr std::size_t kFacets = VertexTable::kBatch / 3;

  void flush() {
    if (weld_) {
      std::array<std::uint32_t, 3 * kFacets> indices{};
      table_.add({batch_[0].data(), 3 * waiting_}, std::span(indices).first(3 * waiting_));
      for (std::size_t i = 0; i < waiting_; ++i) {
        triangles_.push_back({indices[3 * i], indices[3 * i + 1], indices[3 * i + 2]});
      }
    } else {
      for (std::size_t i = 0; i < waiting_; ++i) {
        const auto first = static_cast<std::uint32_t>(positions_.size());
        for (const Vec3& corner : batch_[i]) positions_.emplace_back(corner + Vec3::Zero());
        triangles_.push_back({first, first + 1, first + 2});
      }
    }
    waiting_ = 0;
  }

  bool weld_;
  std::array<std::array<Vec3, 3>, kFacets> batch_;
  std::size_t waiting_ = 0;
  VertexTable table_;
  std::vector<Vec3> positions_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
};

enum class NormalVerdict : std::uint8_t { kFine, kNotFinite, kOpposed };

NormalVerdict judge_normal(const Vec3& normal, const std::array<Vec3, 3>& corners) {
  const double against = normal.dot((corners[1] - corners[0]).cross(corners[2] - corners[0]));
  if (against >= 0) return NormalVerdict::kFine;
  return std::isnan(against) || !normal.allFinite() ? NormalVerdict::kNotFinite
                                                    : NormalVerdict::kOpposed;
}

constexpr std::string_view kNotFiniteNormals =
    "facets have a normal that is not finite: it is left out, the vertices tell it";
constexpr std::string_view kOpposedNormals =
    "facets have a normal against the turn of their vertices: the vertices are believed";

class BinaryReader {
 public:
  BinaryReader(std::span<const std::byte> bytes, const ReadOptions& options,
               Diagnostics& diagnostics)
      : bytes_(bytes), options_(options), diagnostics_(diagnostics) {}

  Result<TriangleMesh> read() {
    std::uint32_t claimed = 0;
    std::memcpy(&claimed, bytes_.data() + 80, 4);
    const std::size_t held = (bytes_.size() - kStlHeaderBytes) / kStlFacetBytes;
    if (claimed > held) {
      return error("the header counts " + std::to_string(claimed) +
                       " facets, the file has room for " + std::to_string(held),
                   80);
    }
    if (claimed > options_.max_triangles) {
      Error over = error(std::to_string(claimed) + " facets are more than the limit of " +
                             std::to_string(options_.max_triangles),
                         80);
      over.code = ErrorCode::kLimit;
      return over;
    }
    // A closed mesh has half as many vertices as triangles.
    const std::size_t vertices = options_.weld ? claimed / 2 : std::size_t{3} * claimed;
    if (const Status fits = mesh_fits(vertices, claimed, options_, at(80)); !fits) {
      return fits.error();
    }
    const std::size_t end = kStlHeaderBytes + kStlFacetBytes * std::size_t{claimed};
    if (end != bytes_.size()) {
      diagnostics_.warning(std::to_string(bytes_.size() - end) + " bytes after the last of " +
                               std::to_string(claimed) + " facets are left out",
                           at(end));
    }
    TriangleMesh mesh;
    read_header(mesh);
    FacetGatherer gatherer(claimed, options_.weld);
    for (std::size_t i = 0; i < claimed; ++i) {
      const std::size_t offset = kStlHeaderBytes + kStlFacetBytes * i;
      std::array<float, 12> numbers{};
      std::memcpy(numbers.data(), bytes_.data() + offset, sizeof numbers);
      std::array<Vec3, 3>& corners = gatherer.next();
      bool fits = true;
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t k = 0; k < 3; ++k) {
          const auto x = static_cast<double>(numbers[3 + 3 * c + k]);
          corners[c][static_cast<int>(k)] = x;
          fits &= std::abs(x) <= options_.max_coordinate;
        }
      }
      if (!fits) return bad_coordinate(corners, offset);
      const Vec3 normal(static_cast<double>(numbers[0]), static_cast<double>(numbers[1]),
                        static_cast<double>(numbers[2]));
      const NormalVerdict verdict = judge_normal(normal, corners);
      if (verdict != NormalVerdict::kFine) [[unlikely]] {
        Odd& odd = verdict == NormalVerdict::kNotFinite ? not_finite_ : opposed_;
        if (odd.count++ == 0) odd.first = offset;
      }
      gatherer.took();
    }
    gatherer.move_into(mesh);
    read_colors(mesh);
    warn(not_finite_, kNotFiniteNormals);
    warn(opposed_, kOpposedNormals);
    return mesh;
  }

 private:
  struct Odd {
    std::size_t count = 0, first = 0;
  };

  [[nodiscard]] Place at(std::size_t offset) const {
    return {options_.file_name, 0, 0, static_cast<std::int64_t>(offset)};
  }
  [[nodiscard]] Error error(std::string message, std::size_t offset) const {
    return {ErrorCode::kInput, std::move(message), at(offset)};
  }
  void warn(const Odd& odd, std::string_view what) {
    if (odd.count > 0)
      diagnostics_.warning(std::to_string(odd.count) + " " + std::string(what), at(odd.first));
  }

  [[nodiscard]] Error bad_coordinate(const std::array<Vec3, 3>& corners, std::size_t offset) const {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double x = corners[c][static_cast<int>(k)];
        const std::size_t place = offset + 12 + 12 * c + 4 * k;
        if (!std::isfinite(x)) return error("a coordinate that is no finite number", place);
        if (std::abs(x) > options_.max_coordinate) {
          Error over = error("coordinate " + to_text(x) + " is beyond the limit of " +
                                 to_text(options_.max_coordinate),
                             place);
          over.code = ErrorCode::kLimit;
          return over;
        }
      }
    }
    return error("a coordinate that cannot be read", offset);
  }

  void read_header(TriangleMesh& mesh) {
    std::string_view header =
        std::string_view(static_cast<const char*>(static_cast<const void*>(bytes_.data())), 80);
    if (const std::size_t color = header.find("COLOR=");
        color != std::string_view::npos && color + 10 <= 80) {
      Color of_object{};
      std::memcpy(of_object.data(), bytes_.data() + color + 6, 4);
      magics_ = of_object;
    }
    header = header.substr(0, header.find('\0'));
    // What the writer puts there; other programs' headers say nothing that can be relied on.
    if (const std::size_t units = header.find(" units="); units != std::string_view::npos) {
      const std::string_view word = header.substr(units + 7);
      mesh.unit = unit_of(word.substr(0, word.find(' ')));
    }
    if (header.find(" up=z") != std::string_view::npos) mesh.up = UpAxis::kZ;
    if (header.find(" up=y") != std::string_view::npos) mesh.up = UpAxis::kY;
    if (const std::size_t name = header.find(" name="); name != std::string_view::npos) {
      mesh.name = std::string(header.substr(name + 6));
    }
  }

  void read_colors(TriangleMesh& mesh) {
    const auto attribute = [&](std::size_t facet) {
      std::uint16_t value = 0;
      std::memcpy(&value, bytes_.data() + kStlHeaderBytes + kStlFacetBytes * facet + 48, 2);
      return value;
    };
    // Without the Magics mark a word without bit 15 is no colour: zero, or another program's
    // attribute.
    bool any = magics_.has_value();
    std::size_t foreign = 0, first_foreign = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const std::uint16_t word = attribute(i);
      if ((word & 0x8000U) != 0) {
        any = true;
      } else if (word != 0 && !magics_ && foreign++ == 0) {
        first_foreign = i;
      }
    }
    if (foreign > 0) {
      diagnostics_.warning(std::to_string(foreign) +
                               " facets have an attribute word that is no colour: it is left out",
                           at(kStlHeaderBytes + kStlFacetBytes * first_foreign + 48));
    }
    if (!any || mesh.triangles.empty()) return;
    ElementTable elements;
    mesh.triangle_element.resize(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const unsigned word = attribute(i);
      const auto part = [&](unsigned shift) {
        return static_cast<std::uint8_t>(((word >> shift & 31U) * 255 + 15) / 31);
      };
      const bool marked = (word & 0x8000U) != 0;
      if (magics_) {
        // Bit 15 says that the facet has the object's colour; red is in the low bits.
        mesh.triangle_element[i] =
            elements.colored(marked ? *magics_ : Color{part(0), part(5), part(10), 255});
      } else if (marked) {
        mesh.triangle_element[i] = elements.colored(Color{part(10), part(5), part(0), 255});
      } else {
        mesh.triangle_element[i] = elements.named("", "");
      }
    }
    elements.move_into(mesh);
  }

  std::span<const std::byte> bytes_;
  const ReadOptions& options_;
  Diagnostics& diagnostics_;
  std::optional<Color> magics_;
  Odd not_finite_, opposed_;
};

bool is_word(std::string_view word, std::string_view lower) {
  if (word.size() != lower.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if ((word[i] | 0x20) != lower[i]) return false;
  }
  return true;
}

// Below this a file is read by one thread.
constexpr std::size_t kParallelBytes = std::size_t{16} << 20;

// The facets of a part of the file, and where solids begin and end between them.
struct AsciiSection {
  struct Event {
    bool begins = false;
    std::size_t facet = 0;  // number of facets before it in the section
    const char* at = nullptr;
    std::string_view name;
  };
  std::vector<std::array<Vec3, 3>> facets;
  std::vector<Event> events;
  Tally not_finite, opposed;
};

class SectionReader {
 public:
  // `inside`: the section begins within a solid.
  SectionReader(const TextScanner& text, const ReadOptions& options, bool inside,
                AsciiSection& section)
      : text_(text), options_(options), section_(section), inside_(inside) {}

  Status read() {
    // A facet takes about 150 bytes with short numbers.
    section_.facets.reserve(std::min(text_.left() / 150 + 1, options_.max_triangles));
    while (text_.more()) {
      const char* const at = text_.at();
      const std::string_view word = text_.word();
      if (inside_ && is_word(word, "facet")) {
        if (section_.facets.size() == options_.max_triangles) return too_many(text_, options_, at);
        if (const Status facet = read_facet(); !facet) return facet;
      } else if (is_word(word, "solid")) {
        // Files glued together without their ends are common enough.
        section_.events.push_back({true, section_.facets.size(), at, text_.rest_of_line()});
        inside_ = true;
      } else if (inside_ && (is_word(word, "endsolid") ||
                             (is_word(word, "end") && is_word(text_.word(), "solid")))) {
        text_.rest_of_line();
        section_.events.push_back({false, section_.facets.size(), at, {}});
        inside_ = false;
      } else {
        return text_.error("found " + quoted(word) + ", expected " +
                               (inside_ ? "'facet' or 'endsolid'" : "'solid'"),
                           at);
      }
    }
    return ok();
  }

  static Error too_many(const TextScanner& text, const ReadOptions& options, const char* at) {
    Error over =
        text.error("more facets than the limit of " + std::to_string(options.max_triangles), at);
    over.code = ErrorCode::kLimit;
    return over;
  }

 private:
  Status expect(std::string_view word) {
    text_.more();
    const char* const at = text_.at();
    const std::string_view found = text_.word();
    if (is_word(found, word)) return ok();
    return text_.error((found.empty() ? "the file ends" : "found " + quoted(found)) +
                           ", expected '" + std::string(word) + "'",
                       at);
  }

  Status read_facet() {
    const char* const start = text_.at();
    if (const Status word = expect("normal"); !word) return word;
    Vec3 normal = Vec3::Zero();
    bool finite = true;
    for (int k = 0; k < 3; ++k) {
      text_.more();
      const NumberState state = text_.number(normal[k]);
      if (state == NumberState::kOk) continue;
      if (state == NumberState::kNotANumber && !is_signed_nan())
        return text_.number_error(state, "a normal");
      finite = false;
      text_.word();
    }
    if (const Status word = expect("outer"); !word) return word;
    if (const Status word = expect("loop"); !word) return word;
    std::array<Vec3, 3> corners;
    for (Vec3& corner : corners) {
      if (const Status word = expect("vertex"); !word) return word;
      for (int k = 0; k < 3; ++k) {
        text_.more();
        const NumberState state = text_.number(corner[k]);
        if (state != NumberState::kOk) return text_.number_error(state, "a coordinate");
        if (std::abs(corner[k]) > options_.max_coordinate) {
          Error over = text_.error("coordinate " + to_text(corner[k]) + " is beyond the limit of " +
                                   to_text(options_.max_coordinate));
          over.code = ErrorCode::kLimit;
          return over;
        }
      }
    }
    if (const Status word = expect("endloop"); !word) return word;
    if (const Status word = expect("endfacet"); !word) return word;
    if (!finite) {
      section_.not_finite.hit(start);
    } else if (judge_normal(normal, corners) == NormalVerdict::kOpposed) {
      section_.opposed.hit(start);
    }
    section_.facets.push_back(corners);
    return ok();
  }

  // "-nan(ind)", "1.#QNAN" and the like, as C libraries print them.
  [[nodiscard]] bool is_signed_nan() const {
    TextScanner ahead = text_;
    const std::string_view word = ahead.word();
    return word.find("nan") != std::string_view::npos ||
           word.find("NAN") != std::string_view::npos || word.find("#I") != std::string_view::npos;
  }

  TextScanner text_;
  const ReadOptions& options_;
  AsciiSection& section_;
  bool inside_;
};

class AsciiReader {
 public:
  AsciiReader(std::string_view text, const ReadOptions& options, Diagnostics& diagnostics)
      : text_(text, options.file_name), options_(options), diagnostics_(diagnostics) {}

  Result<TriangleMesh> read() {
    cut_into_sections();
    std::vector<Status> states(sections_.size(), ok());
    run_parallel(sections_.size(), thread_count(options_.threads), [&](std::size_t i) {
      states[i] =
          SectionReader(text_.section(starts_[i], starts_[i + 1]), options_, i > 0, sections_[i])
              .read();
    });
    std::size_t facets = 0;
    for (std::size_t i = 0; i < sections_.size(); ++i) {
      if (!states[i]) return states[i].error();
      facets += sections_[i].facets.size();
      if (facets > options_.max_triangles)
        return SectionReader::too_many(text_, options_, starts_[i]);
    }
    if (const Status fits = mesh_fits(3 * facets, facets, options_, text_.place()); !fits) {
      return fits.error();
    }
    TriangleMesh mesh;
    FacetGatherer gatherer(facets, options_.weld);
    triangle_element_.reserve(facets);
    for (AsciiSection& section : sections_) take(section, gatherer);
    if (solids_ == 0) return text_.error("no 'solid' in the file", text_.end());
    if (inside_) end_solid(false);
    if (elements_.size() == 0)
      diagnostics_.warning("the file has no facets", text_.place(text_.end()));
    empty_.warn("solids without facets", text_, diagnostics_);
    not_finite_.warn(kNotFiniteNormals, text_, diagnostics_);
    opposed_.warn(kOpposedNormals, text_, diagnostics_);
    gatherer.move_into(mesh);
    mesh.triangle_element = std::move(triangle_element_);
    elements_.move_into(mesh);
    return mesh;
  }

 private:
  // Sections begin behind an `endfacet` that is the first word of its line, which no solid's name
  // can be.
  void cut_into_sections() {
    const char* const begin = text_.begin();
    const char* const end = text_.end();
    const std::size_t size = text_.left();
    const auto threads = static_cast<std::size_t>(thread_count(options_.threads));
    const std::size_t wanted =
        size < kParallelBytes ? 1 : std::min(threads, size / (kParallelBytes / 4));
    starts_.assign(1, begin);
    for (std::size_t i = 1; i < wanted; ++i) {
      TextScanner ahead = text_.section(std::max(begin + size / wanted * i, starts_.back()), end);
      while (!ahead.at_end()) {
        ahead.skip_line();
        if (is_word(ahead.word(), "endfacet")) {
          starts_.push_back(ahead.at());
          break;
        }
      }
    }
    starts_.push_back(end);
    sections_.resize(starts_.size() - 1);
  }

  void take(AsciiSection& section, FacetGatherer& gatherer) {
    auto event = section.events.begin();
    for (std::size_t facet = 0; facet <= section.facets.size(); ++facet) {
      for (; event != section.events.end() && event->facet == facet; ++event) {
        if (inside_) end_solid(!event->begins);
        inside_ = event->begins;
        if (!inside_) continue;
        ++solids_;
        start_ = event->at;
        name_ = event->name;
        any_ = false;
      }
      if (facet == section.facets.size()) break;
      if (!any_) element_ = elements_.add({std::string(name_), {}, std::nullopt});
      any_ = true;
      triangle_element_.push_back(element_);
      gatherer.next() = section.facets[facet];
      gatherer.took();
    }
    not_finite_.add(section.not_finite);
    opposed_.add(section.opposed);
    section = {};
  }

  void end_solid(bool told) {
    if (!told) diagnostics_.warning("the solid has no 'endsolid'", text_.place(start_));
    if (!any_) empty_.hit(start_);
  }

  TextScanner text_;
  const ReadOptions& options_;
  Diagnostics& diagnostics_;
  std::vector<const char*> starts_;
  std::vector<AsciiSection> sections_;
  ElementTable elements_;
  std::vector<std::uint32_t> triangle_element_;
  // The solid that is being gathered.
  bool inside_ = false, any_ = false;
  const char* start_ = nullptr;
  std::string_view name_;
  std::uint32_t element_ = 0;
  std::size_t solids_ = 0;
  Tally empty_, not_finite_, opposed_;
};

bool is_binary(std::span<const std::byte> bytes) {
  if (bytes.size() < kStlHeaderBytes) return false;
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  return kStlHeaderBytes + std::uint64_t{kStlFacetBytes} * count == bytes.size();
}

}  // namespace

bool looks_like_stl(std::span<const std::byte> bytes) {
  return is_binary(bytes) || first_word_of(bytes) == "solid";
}

Result<TriangleMesh> read_stl(std::span<const std::byte> bytes, const ReadOptions& options,
                              Diagnostics& diagnostics) {
  // A binary file that was cut or padded may begin with "solid" too; its zero bytes tell.
  const std::span<const std::byte> start = bytes.first(std::min<std::size_t>(bytes.size(), 512));
  const bool zeros = std::find(start.begin(), start.end(), std::byte{0}) != start.end();
  const bool ascii = !is_binary(bytes) && first_word_of(bytes) == "solid" &&
                     !(zeros && bytes.size() >= kStlHeaderBytes + kStlFacetBytes);
  if (ascii) {
    const std::string_view text = text_of(bytes);
    return AsciiReader(text, options, diagnostics).read();
  }
  if (bytes.size() < kStlHeaderBytes) {
    return Error{ErrorCode::kInput,
                 "the file has " + std::to_string(bytes.size()) +
                     " bytes, expected 'solid' or a binary header of 84 bytes",
                 {options.file_name}};
  }
  return BinaryReader(bytes, options, diagnostics).read();
}

}  // namespace diesink
