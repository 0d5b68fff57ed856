// OBJ. Source: Alias/Wavefront's Advanced Visualizer Manual, appendix B1, "Object Files".
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <functional>
#include <optional>

#include "core/counted.h"
#include "core/large_array.h"
#include "core/parallel.h"
#include "formats/element_runs.h"
#include "formats/file_marks.h"
#include "formats/float_rows.h"
#include "formats/mesh_builder.h"
#include "formats/obj.h"
#include "formats/obj_material.h"
#include "formats/obj_parse.h"
#include "formats/text_sections.h"

namespace diesink {
namespace {

class ObjReader {
 public:
  ObjReader(std::string_view text, const ReadOptions& options, Diagnostics& diagnostics)
      : whole_(text, options.file_name, true),
        options_(options),
        diagnostics_(diagnostics),
        builder_(mesh_, options) {}

  Result<TriangleMesh> read() {
    cut_into_sections();
    if (const Status parsed = parse_sections(); !parsed) return parsed.error();
    read_marks();
    if (const Status gathered = gather_vertices(); !gathered) return gathered.error();
    const bool plain = all_plain();
    for (std::size_t s = 0; s < sections_.size(); ++s) {
      // Without a single normal in the file, its faces have none.
      if (mesh_.normals.empty()) {
        const std::vector<std::uint32_t>& named = sections_[s].face_normals;
        lost_normals_ += named.size() - static_cast<std::size_t>(std::count(
                                            named.begin(), named.end(), FaceBuilder::kNoNormal));
      }
      const Status built = plain ? take_plain_events(sections_[s]) : build_faces(s);
      if (!built) return built.error();
    }
    if (plain) take_plain_faces();
    if (const Status finished = finish(); !finished) return finished.error();
    return std::move(mesh_);
  }

 private:
  // Sections begin at a line whose predecessor's end is no continuation.
  void cut_into_sections() {
    const std::size_t size = whole_.left();
    const std::size_t wanted = section_count(size, options_);
    const char* const begin = whole_.begin();
    const char* const end = whole_.end();
    starts_.assign(1, begin);
    for (std::size_t i = 1; i < wanted; ++i) {
      const char* at = std::max(begin + size / wanted * i, starts_.back());
      while (at != end && !(*at == '\n' && at != begin && at[-1] != '\\' && at[-1] != '\r')) {
        // CRLF: what stands before the CR decides.
        if (*at == '\n' && at - begin > 1 && at[-1] == '\r' && at[-2] != '\\') break;
        ++at;
      }
      if (at != end) starts_.push_back(at + 1);
    }
    starts_.push_back(end);
    sections_.resize(starts_.size() - 1);
  }

  [[nodiscard]] TextScanner section_text(std::size_t s) const {
    return whole_.section(starts_[s], starts_[s + 1]);
  }

  // All sections at once, and those that have to know what is in front of them once more.
  Status parse_sections() {
    const int threads = thread_count(options_.threads);
    std::vector<Status> states(sections_.size(), ok());
    const auto parse = [&](std::size_t s) {
      states[s] = parse_obj(section_text(s), options_, sections_[s]);
    };
    sections_[0].counted = true;
    run_parallel(sections_.size(), threads, parse);
    // What stands behind the first mistake does not matter any more.
    const auto wrong =
        std::find_if(states.begin(), states.end(), [](const Status& s) { return !s; });
    const auto good = static_cast<std::size_t>(wrong - states.begin());
    const ProgressSpan silent;  // all has been read
    std::vector<ObjCounts> counts(good);
    run_parallel(good, threads, [&](std::size_t s) {
      const ObjSection& section = sections_[s];
      counts[s] = section.needs_counts ? count_obj(section_text(s))
                                       : ObjCounts{section.positions.size(), section.textures,
                                                   section.normals.size()};
    });
    ObjCounts before;
    std::vector<std::size_t> again;
    for (std::size_t s = 0; s < good; ++s) {
      ObjSection& section = sections_[s];
      const bool forward = section.ahead > static_cast<std::int64_t>(before.vertices);
      if (!section.counted && (section.needs_counts || forward)) {
        section = {};
        section.before = before;
        section.counted = true;
        again.push_back(s);
      }
      before.vertices += counts[s].vertices;
      before.textures += counts[s].textures;
      before.normals += counts[s].normals;
    }
    run_parallel(again.size(), threads, [&](std::size_t i) { parse(again[i]); });
    for (const Status& state : states) {
      if (!state) return state;
    }
    return ok();
  }

  Status gather_vertices() {
    const bool colored =
        std::any_of(sections_.begin(), sections_.end(),
                    [](const ObjSection& section) { return !section.colors.empty(); });
    const bool with_normals =
        std::any_of(sections_.begin(), sections_.end(),
                    [](const ObjSection& section) { return !section.face_normals.empty(); });
    std::size_t vertices = 0, faces = 0, normals = 0;
    std::vector<ObjCounts> before;
    for (const ObjSection& section : sections_) {
      before.push_back({vertices, 0, normals});
      vertices += section.positions.size();
      normals += section.normals.size();
      faces += section.faces;
    }
    if (vertices >= FaceBuilder::kNoNormal) {
      return Error{ErrorCode::kLimit, "more vertices than 32 bits can count", whole_.place()};
    }
    if (Status fits = mesh_fits(vertices, faces, options_, whole_.place()); !fits) return fits;
    const std::size_t triangles = std::min(faces, options_.max_triangles);
    reserve_cleared(mesh_.triangles, triangles, options_.threads);
    if (with_normals && normals > 0)
      reserve_cleared(mesh_.corner_normals, triangles, options_.threads);
    if (sections_.size() == 1) {
      mesh_.positions = std::move(sections_[0].positions);
      mesh_.normals = std::move(sections_[0].normals);
      mesh_.vertex_colors = std::move(sections_[0].colors);
      return ok();
    }
    reserve_cleared(mesh_.positions, vertices, options_.threads);
    reserve_cleared(mesh_.normals, normals, options_.threads);
    mesh_.positions.resize(vertices);
    mesh_.normals.resize(normals);
    if (colored) mesh_.vertex_colors.assign(vertices, Color{255, 255, 255, 255});
    run_parallel(sections_.size(), thread_count(options_.threads), [&](std::size_t s) {
      ObjSection& section = sections_[s];
      const auto move = [](auto& from, auto& to, std::size_t at) {
        if (from.empty()) return;  // as colours mostly are, of the mesh, too
        std::copy(from.begin(), from.end(), to.begin() + static_cast<std::ptrdiff_t>(at));
        from = {};
      };
      move(section.positions, mesh_.positions, before[s].vertices);
      move(section.normals, mesh_.normals, before[s].normals);
      move(section.colors, mesh_.vertex_colors, before[s].vertices);
    });
    return ok();
  }

  Error error_at_face(std::size_t s, std::size_t face, std::string message,
                      ErrorCode code = ErrorCode::kInput) const {
    return {code, std::move(message), whole_.place(find_obj_face(section_text(s), face))};
  }

  // Whether all faces are triangles of vertices, and normals, that are there.
  bool all_plain() {
    std::size_t faces = 0;
    for (const ObjSection& section : sections_) {
      faces += section.faces;
      const bool with_normals = !mesh_.normals.empty();
      if (!section.face_sizes.empty()) return false;
      if (with_normals && section.faces > 0 && section.face_normals.empty()) return false;
    }
    if (faces > options_.max_triangles) return false;
    std::atomic<bool> all = true;
    run_parallel(sections_.size(), thread_count(options_.threads), [&](std::size_t s) {
      const ObjSection& section = sections_[s];
      if (section.faces == 0) return;
      const bool there =
          range_of(section.face_vertices)[1] < mesh_.positions.size() &&
          (mesh_.normals.empty() || range_of(section.face_normals)[1] < mesh_.normals.size());
      if (!there) all = false;
    });
    return all;
  }

  // Where all_plain(): the elements of a section's faces.
  Status take_plain_events(const ObjSection& section) {
    auto event = section.events.begin();
    for (std::size_t face = 0; face < section.faces || event != section.events.end();) {
      for (; event != section.events.end() && event->face == face; ++event) {
        if (const Status taken = take_event(section, *event); !taken) return taken;
      }
      const std::size_t next = event == section.events.end() ? section.faces : event->face;
      if (next == face) continue;
      if (!element_) element_ = elements_.named(group_, material_, ours_);
      plain_faces_ += next - face;
      // A file of one element, the first, is spared the array.
      if (*element_ != 0 || !mesh_.triangle_element.empty()) {
        mesh_.triangle_element.resize(plain_faces_ - (next - face), 0);
        mesh_.triangle_element.resize(plain_faces_, *element_);
      }
      face = next;
    }
    return ok();
  }

  // The faces of all sections, where all_plain(): as they are.
  void take_plain_faces() {
    const bool with_normals = !mesh_.normals.empty();
    mesh_.triangles.resize(plain_faces_);
    if (with_normals) mesh_.corner_normals.resize(plain_faces_);
    std::vector<std::size_t> before;
    std::size_t faces = 0;
    for (const ObjSection& section : sections_) {
      before.push_back(faces);
      faces += section.faces;
    }
    run_parallel(sections_.size(), thread_count(options_.threads), [&](std::size_t s) {
      const auto move = [first = before[s]](std::vector<std::uint32_t>& from, auto& to) {
        if (!from.empty()) {
          std::memcpy(to.data() + first, from.data(), from.size() * sizeof(std::uint32_t));
        }
        from = {};
      };
      move(sections_[s].face_vertices, mesh_.triangles);
      if (with_normals) move(sections_[s].face_normals, mesh_.corner_normals);
    });
  }

  Status build_faces(std::size_t s) {
    ObjSection& section = sections_[s];
    std::size_t corner = 0;
    auto event = section.events.begin();
    for (std::size_t face = 0; face <= section.faces; ++face) {
      for (; event != section.events.end() && event->face == face; ++event) {
        if (const Status taken = take_event(section, *event); !taken) return taken;
      }
      if (face == section.faces) break;
      const std::size_t corners = section.face_sizes.empty() ? 3 : section.face_sizes[face];
      const std::span<const std::uint32_t> vertices =
          std::span(section.face_vertices).subspan(corner, corners);
      std::span<std::uint32_t> normals;
      if (!section.face_normals.empty() && !mesh_.normals.empty())
        normals = std::span(section.face_normals).subspan(corner, corners);
      for (std::uint32_t& n : normals) {
        if (n != FaceBuilder::kNoNormal && n >= mesh_.normals.size()) {
          n = FaceBuilder::kNoNormal;
          ++lost_normals_;
        }
      }
      corner += corners;
      if (!element_) element_ = elements_.named(group_, material_, ours_);
      switch (builder_.add(vertices, normals, *element_)) {
        case FaceVerdict::kFine:
          break;
        case FaceVerdict::kTooFew:
          ++few_;
          break;
        case FaceVerdict::kCrossing:
          ++crossing_;
          break;
        case FaceVerdict::kOutOfRange: {
          const std::uint32_t largest = *std::max_element(vertices.begin(), vertices.end());
          return error_at_face(s, face,
                               "vertex " + std::to_string(std::uint64_t{largest} + 1) +
                                   ", but the file has " + std::to_string(mesh_.positions.size()));
        }
        case FaceVerdict::kTooMany:
          return error_at_face(
              s, face, "more triangles than the limit of " + std::to_string(options_.max_triangles),
              ErrorCode::kLimit);
      }
    }
    section.face_vertices = {};
    section.face_normals = {};
    return ok();
  }

  Status take_event(const ObjSection& section, const ObjEvent& event) {
    switch (event.kind) {
      case ObjEvent::Kind::kGroup:
      case ObjEvent::Kind::kObject:
        group_ = event.name;
        break;
      case ObjEvent::Kind::kMaterial:
        material_ = event.name;
        break;
      case ObjEvent::Kind::kLibrary:
        read_materials(options_.folder, event.name, whole_.place(event.name.data()), colors_,
                       diagnostics_);
        return ok();
      case ObjEvent::Kind::kLine:
        return take_line(section, event);
    }
    element_.reset();
    return ok();
  }

  Status take_line(const ObjSection& section, const ObjEvent& event) {
    MeshCurve curve;
    for (std::size_t i = 0; i < event.count; ++i) {
      const std::uint32_t v = section.line_vertices[event.first + i];
      if (v >= mesh_.positions.size()) {
        return whole_.error("vertex " + std::to_string(std::uint64_t{v} + 1) +
                                ", but the file has " + std::to_string(mesh_.positions.size()),
                            event.name.data());
      }
      curve.vertices.push_back(v);
    }
    if (curve.vertices.size() > 2 && curve.vertices.front() == curve.vertices.back()) {
      curve.vertices.pop_back();
      curve.closed = true;
    }
    mesh_.curves.push_back(std::move(curve));
    curve_groups_.push_back(group_);
    return ok();
  }

  Status finish() {
    for (MeshElement& element : elements_.elements()) {
      if (const auto color = colors_.find(element.solid); color != colors_.end()) {
        element.color = color->second;
      }
      if (ours_) element.solid = solid_of(element);
    }
    const std::size_t given = builder_.finish(elements_);
    for (std::size_t c = 0; c < mesh_.curves.size(); ++c) {
      if (!read_curve_label(curve_groups_[c], mesh_, mesh_.curves[c])) {
        mesh_.curves[c].name = std::string(curve_groups_[c]);
      }
    }
    const Place file{options_.file_name};
    const auto warn = [&](std::size_t count, std::string_view what) {
      if (count > 0) diagnostics_.warning(counted(count, what), file);
    };
    if (mesh_.positions.empty()) return Error{ErrorCode::kInput, "the file has no vertices", file};
    if (mesh_.triangles.empty()) diagnostics_.warning("the file has no faces", file);
    warn(few_, "face|faces| with fewer than three corners, left out");
    warn(crossing_, "polygon crosses itself or is flat|polygons cross themselves or are flat|");
    warn(lost_normals_, "corner names a normal that is|corners name normals that are| not there");
    if (given > 0)
      warn(given,
           "triangle has no normal: it was given its own|triangles have no normals: they were "
           "given their own|");
    warn_tallies();
    return ok();
  }

  // What this program wrote as the element's material, back to the solid it was made from.
  static std::string solid_of(const MeshElement& element) {
    std::string solid = element.solid;
    const std::string own = kObjOwnColor + element.name;
    if (solid.ends_with(own)) solid.resize(solid.size() - own.size());
    return solid == kObjNoMaterial ? std::string() : solid;
  }

  void read_marks() {
    // The file's start may be more than one section.
    std::size_t left = kMaxObjComments;
    for (const ObjSection& section : sections_) {
      for (std::string_view comment : section.comments) {
        if (left-- == 0) return;
        while (!comment.empty() && (comment[0] == '#' || is_blank(comment[0])))
          comment.remove_prefix(1);
        if (comment.starts_with("diesink")) ours_ = true;
        read_mark(comment, mesh_);
      }
      if (!section.positions.empty()) return;
    }
  }

  void warn_tallies() {
    ObjSection sum;
    std::uint64_t textures = 0;
    for (const ObjSection& s : sections_) {
      if (sum.unknown.count() == 0) sum.first_unknown = s.first_unknown;
      sum.odd_weights.add(s.odd_weights);
      sum.uncolored.add(s.uncolored);
      sum.points.add(s.points);
      sum.unknown.add(s.unknown);
      sum.forward.add(s.forward);
      sum.no_direction.add(s.no_direction);
      sum.bad_texture.add(s.bad_texture);
      sum.last_texture = std::max(sum.last_texture, s.last_texture);
      textures += s.textures;
    }
    sum.odd_weights.warn("vertex has|vertices have| a weight other than 1, which is not kept",
                         whole_, diagnostics_);
    if (!mesh_.vertex_colors.empty())
      sum.uncolored.warn(
          "vertex has no colour where others have: it is white|vertices have no colour where "
          "others have: they are white|",
          whole_, diagnostics_);
    sum.points.warn("point statement is|point statements are| left out", whole_, diagnostics_);
    sum.unknown.warn(
        "statement that is|statements that are| not read, the first " + quoted(sum.first_unknown),
        whole_, diagnostics_);
    sum.forward.warn(
        "corner names a vertex that comes after its face|corners name vertices that come after "
        "their face|",
        whole_, diagnostics_);
    sum.no_direction.warn("normal has|normals have| no direction", whole_, diagnostics_);
    sum.bad_texture.warn(
        "corner names a texture coordinate|corners name texture coordinates| that cannot be",
        whole_, diagnostics_);
    if (sum.last_texture > textures) {
      diagnostics_.warning("faces name texture coordinate " + std::to_string(sum.last_texture) +
                               ", but the file has " + std::to_string(textures),
                           {options_.file_name});
    }
  }

  TextScanner whole_;
  const ReadOptions& options_;
  Diagnostics& diagnostics_;
  TriangleMesh mesh_;
  FaceBuilder builder_;
  ElementTable elements_;
  std::map<std::string, Color, std::less<>> colors_;
  std::vector<const char*> starts_;
  std::vector<ObjSection> sections_;
  std::string_view group_, material_;
  std::optional<std::uint32_t> element_;
  std::vector<std::string_view> curve_groups_;
  std::size_t plain_faces_ = 0;  // whose element is known
  std::size_t few_ = 0, crossing_ = 0, lost_normals_ = 0;
  bool ours_ = false;
};

}  // namespace

bool looks_like_obj(std::span<const std::byte> bytes) {
  constexpr std::array<std::string_view, 12> kWords{"v", "vn", "vt", "vp", "f",      "l",
                                                    "p", "o",  "g",  "s",  "mtllib", "usemtl"};
  const std::string word = first_word_of(bytes);
  return std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

Result<TriangleMesh> read_obj(std::span<const std::byte> bytes, const ReadOptions& options,
                              Diagnostics& diagnostics) {
  const std::string_view text = text_of(bytes);
  if (text.starts_with("\xFE\xFF") || text.starts_with("\xFF\xFE")) {
    return Error{ErrorCode::kUnsupported,
                 "UTF-16 text is not read, expected UTF-8 or ASCII",
                 {options.file_name}};
  }
  return ObjReader(text, options, diagnostics).read();
}

}  // namespace diesink
