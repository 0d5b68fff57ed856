// SPDX-License-Identifier: Apache-2.0
#include "formats/obj_parse.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/mesh_builder.h"
#include "formats/plain_lines.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = FaceBuilder::kNoNormal;

bool ends_word(const char* at, const char* end) {
  return at == end || is_blank(*at) || is_line_end(*at) || *at == '\\';
}

// Statements that say nothing this program keeps, and nothing that would be missed.
bool is_harmless(std::string_view word) {
  constexpr std::array<std::string_view, 6> kWords{"s",         "vp",  "shadow_obj",
                                                   "trace_obj", "lod", "mg"};
  return std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

class SectionParser {
 public:
  SectionParser(TextScanner text, const ReadOptions& options, ObjSection& section)
      : text_(std::move(text)), options_(options), section_(section) {}

  Status parse() {
    while (text_.more()) {
      const char* const start = text_.at();
      if (const Status statement = parse_statement(start); !statement) return statement;
      if (section_.needs_counts) return ok();
      if (static_cast<std::size_t>(text_.at() - start) > kMaxLineBytes) {
        return Error{ErrorCode::kLimit, "a line of more than 1 MiB", text_.place(start)};
      }
    }
    return ok();
  }

 private:
  Status parse_statement(const char* start) {
    // The two statements that make up nearly all of a file first.
    const std::size_t left = text_.left();
    if (left > 1 && *start == 'v' && is_blank(start[1])) {
      text_.move_to(start + 1);
      return parse_vertex(start);
    }
    if (left > 1 && *start == 'f' && is_blank(start[1])) {
      text_.move_to(start + 1);
      return parse_face(start);
    }
    if (*start == '#') {
      if (section_.positions.empty() && section_.comments.size() < kMaxObjComments) {
        section_.comments.push_back(text_.rest_of_line());
      }
      text_.skip_line(true);
      return ok();
    }
    const std::string_view word = text_.word();
    if (word == "vn") return parse_normal(start);
    if (word == "vt") {
      ++section_.textures;
    } else if (word == "g" || word == "o") {
      add_event(word == "g" ? ObjEvent::Kind::kGroup : ObjEvent::Kind::kObject);
    } else if (word == "usemtl") {
      add_event(ObjEvent::Kind::kMaterial);
    } else if (word == "mtllib") {
      add_event(ObjEvent::Kind::kLibrary);
    } else if (word == "l") {
      return parse_line(start);
    } else if (word == "v" || word == "f") {
      return word == "v" ? parse_vertex(start) : parse_face(start);
    } else if (word == "p") {
      section_.points.hit(start);
    } else if (!is_harmless(word)) {
      const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
               (c >= '0' && c <= '9');
      });
      if (!plain)
        return text_.error("found " + quoted(word) + ", expected a statement such as v, vn, f, g",
                           start);
      if (section_.unknown.count() == 0) section_.first_unknown = word;
      section_.unknown.hit(start);
    }
    text_.skip_line();
    return ok();
  }

  void add_event(ObjEvent::Kind kind) {
    section_.events.push_back({kind, section_.faces, text_.rest_of_line(), 0, 0});
  }

  Status parse_vertex(const char* start) {
    std::array<double, 8> numbers{};
    std::size_t count = 0;
    while (text_.more_in_line() && *text_.at() != '#') {
      if (count == 7) return text_.error("more than seven numbers of a vertex");
      const NumberState state = text_.number(numbers[count]);
      if (state != NumberState::kOk) return text_.number_error(state, "a coordinate");
      ++count;
    }
    if (count < 3) {
      return text_.error(
          "the vertex has " + std::to_string(count) + " numbers, expected at least 3", start);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      if (std::abs(numbers[i]) > options_.max_coordinate) {
        return Error{ErrorCode::kLimit,
                     "coordinate " + to_text(numbers[i]) + " is beyond the limit of " +
                         to_text(options_.max_coordinate),
                     text_.place(start)};
      }
    }
    if ((count == 4 || count == 7) && numbers[3] != 1) section_.odd_weights.hit(start);
    if (count >= 6) {
      section_.colors.resize(section_.positions.size(), Color{255, 255, 255, 255});
      Color color{0, 0, 0, 255};
      for (std::size_t i = 0; i < 3; ++i) color[i] = color_part(numbers[count - 3 + i], false);
      section_.colors.push_back(color);
    } else if (count == 5) {
      return text_.error("five numbers of a vertex, expected 3, 4, 6 or 7", start);
    } else {
      section_.uncolored.hit(start);
      if (!section_.colors.empty()) section_.colors.push_back({255, 255, 255, 255});
    }
    section_.positions.emplace_back(numbers[0], numbers[1], numbers[2]);
    return end_of_line();
  }

  Status parse_normal(const char* start) {
    Vec3 n = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      const NumberState state = text_.number(n[i]);
      if (state != NumberState::kOk) return text_.number_error(state, "three numbers of a normal");
    }
    const double length = n.norm();
    if (!(length > 0) || !std::isfinite(length)) {
      section_.no_direction.hit(start);
      n = Vec3::UnitZ();
    } else if (std::abs(length - 1) > 1e-3) {
      n /= length;
    }
    section_.normals.push_back(n);
    text_.skip_line();
    return ok();
  }

  Status end_of_line() {
    if (text_.more_in_line()) text_.skip_line();
    return ok();
  }

  // A number of a face's corner, from 1, or backwards from the last with a minus. Leaves `at`
  // behind it.
  enum class Index : std::uint8_t { kFine, kAbsent, kBad, kZero, kBeforeFirst };
  Index read_index(const char*& at, const char* end, std::size_t so_far, std::uint64_t& number) {
    const bool back = at != end && *at == '-';
    section_.needs_counts |= back && !section_.counted;
    const char* const first = back ? at + 1 : at;
    const char* c = first;
    std::uint64_t value = 0;
    for (; c != end && *c >= '0' && *c <= '9' && value < 100'000'000'000; ++c) {
      value = value * 10 + static_cast<std::uint64_t>(*c - '0');
    }
    if (c == first) return back ? Index::kBad : Index::kAbsent;
    at = c;
    if (value == 0) return Index::kZero;
    if (back && value > so_far) return Index::kBeforeFirst;
    number = back ? so_far - value + 1 : value;
    return number < kNone ? Index::kFine : Index::kBad;
  }

  Error bad_index(Index why, const char* at) {
    text_.move_to(at);
    const std::string word = quoted(text_.word());
    switch (why) {
      case Index::kZero:
        return text_.error("found " + word + ", but numbers begin at 1", at);
      case Index::kBeforeFirst:
        return text_.error(word + " counts back past the first", at);
      case Index::kFine:
      case Index::kAbsent:
      case Index::kBad:
        break;
    }
    return text_.error("found " + word + ", expected a vertex as v, v/vt, v//vn or v/vt/vn", at);
  }

  // The face after 'f' where it is as most are, three plain numbers, blanks between, with or
  // without `//` and a normal's, and, in a section that is counted, of vertices that are there
  // already. False where it is anything else, and nothing has been done then.
  bool parse_plain_face() {
    const char* at = text_.at();
    const char* const end = text_.end();
    const auto number = [&](std::size_t most, std::uint32_t& value) {
      const char* const first = at;
      std::uint64_t read = 0;
      for (; at != end && static_cast<unsigned char>(*at - '0') < 10; ++at) {
        read = read * 10 + static_cast<std::uint64_t>(*at - '0');
      }
      value = static_cast<std::uint32_t>(read - 1);
      return at - first <= 10 && read - 1 < most;  // more than none, from 1
    };
    const std::size_t vertices =
        section_.counted
            ? std::min<std::size_t>(section_.before.vertices + section_.positions.size(), kNone - 1)
            : kNone - 1;
    const bool with_normals = !section_.face_normals.empty();
    std::array<std::uint32_t, 3> v{}, n{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (at == end || *at != ' ') return false;
      while (at != end && *at == ' ') ++at;
      if (!number(vertices, v[k])) return false;
      if (!with_normals) continue;
      if (end - at < 3 || at[0] != '/' || at[1] != '/') return false;
      at += 2;
      if (!number(kNone - 1, n[k])) return false;
    }
    if (at != end && *at != '\n' && *at != '\r') return false;
    see_vertex(std::max({v[0], v[1], v[2]}));
    section_.face_vertices.insert(section_.face_vertices.end(), v.begin(), v.end());
    if (with_normals) section_.face_normals.insert(section_.face_normals.end(), n.begin(), n.end());
    if (!section_.face_sizes.empty()) section_.face_sizes.push_back(3);
    ++section_.faces;
    text_.move_to(at);
    return true;
  }

  // A face names this vertex, numbered from 0. (A line may name any.)
  void see_vertex(std::uint32_t vertex) {
    section_.ahead =
        std::max(section_.ahead,
                 std::int64_t{vertex} + 1 - static_cast<std::int64_t>(section_.positions.size()));
  }

  Status parse_face(const char* start) {
    if (parse_plain_face()) return ok();
    const std::size_t vertices = section_.before.vertices + section_.positions.size();
    const std::size_t first = section_.face_vertices.size();
    std::size_t corners = 0;
    while (text_.more_in_line() && *text_.at() != '#') {
      const char* const word = text_.at();
      const char* at = word;
      std::uint64_t vertex = 0, texture = 0, normal = 0;
      const Index v = read_index(at, text_.end(), vertices, vertex);
      if (section_.needs_counts) return ok();
      if (v != Index::kFine) return bad_index(v, word);
      if (section_.counted && vertex > vertices) section_.forward.hit(start);
      see_vertex(static_cast<std::uint32_t>(vertex - 1));
      bool has_normal = false;
      if (at != text_.end() && *at == '/') {
        ++at;
        const Index vt =
            read_index(at, text_.end(), section_.before.textures + section_.textures, texture);
        if (section_.needs_counts) return ok();
        if (vt == Index::kBad) return bad_index(vt, word);
        if (vt == Index::kZero || vt == Index::kBeforeFirst) section_.bad_texture.hit(start);
        section_.last_texture = std::max(section_.last_texture, texture);
        if (at != text_.end() && *at == '/') {
          ++at;
          const Index vn = read_index(at, text_.end(),
                                      section_.before.normals + section_.normals.size(), normal);
          if (section_.needs_counts) return ok();
          if (vn != Index::kFine && vn != Index::kAbsent) return bad_index(vn, word);
          has_normal = vn == Index::kFine;
        }
      }
      if (!ends_word(at, text_.end())) return bad_index(Index::kBad, word);
      text_.move_to(at);
      section_.face_vertices.push_back(static_cast<std::uint32_t>(vertex - 1));
      if (has_normal && section_.face_normals.empty())
        section_.face_normals.assign(section_.face_vertices.size() - 1, kNone);
      if (has_normal || !section_.face_normals.empty()) {
        section_.face_normals.push_back(has_normal ? static_cast<std::uint32_t>(normal - 1)
                                                   : kNone);
      }
      ++corners;
    }
    if (corners != 3 && section_.face_sizes.empty()) section_.face_sizes.assign(section_.faces, 3);
    if (corners != 3 || !section_.face_sizes.empty()) {
      section_.face_sizes.push_back(
          static_cast<std::uint32_t>(section_.face_vertices.size() - first));
    }
    ++section_.faces;
    return end_of_line();
  }

  Status parse_line(const char* start) {
    const std::size_t first = section_.line_vertices.size();
    while (text_.more_in_line() && *text_.at() != '#') {
      const char* const word = text_.at();
      const char* at = word;
      std::uint64_t vertex = 0;
      const std::size_t vertices = section_.before.vertices + section_.positions.size();
      const Index v = read_index(at, text_.end(), vertices, vertex);
      if (section_.needs_counts) return ok();
      if (v != Index::kFine) return bad_index(v, word);
      // Texture coordinates of a line mean nothing here.
      while (!ends_word(at, text_.end())) ++at;
      text_.move_to(at);
      section_.line_vertices.push_back(static_cast<std::uint32_t>(vertex - 1));
    }
    const std::size_t count = section_.line_vertices.size() - first;
    if (count < 2) return text_.error("a line of fewer than two vertices", start);
    section_.events.push_back({ObjEvent::Kind::kLine, section_.faces, {start, 1}, first, count});
    return end_of_line();
  }

  TextScanner text_;
  const ReadOptions& options_;
  ObjSection& section_;
};

// A statement whose name is the rest of its line: a backslash at the end is the name's last letter.
bool is_named(std::string_view word) {
  return word == "g" || word == "o" || word == "usemtl" || word == "mtllib";
}

// Calls `see` with the first character and the place of every statement. Statements end where
// SectionParser ends them.
template <class See>
void walk_statements(TextScanner& text, See see) {
  while (text.more()) {
    const char* const start = text.at();
    if (!see(start)) return;
    const bool maybe_named = *start == 'g' || *start == 'o' || *start == 'u' || *start == 'm';
    if (maybe_named && is_named(text.word())) text.rest_of_line();
    text.skip_line(*start == '#');
  }
}

}  // namespace

ObjCounts count_obj(TextScanner section) {
  if (const auto plain = plain_obj_counts({section.at(), section.left()})) return *plain;
  ObjCounts counts;
  walk_statements(section, [&](const char* start) {
    const char* const end = section.end();
    if (*start != 'v' || end - start < 2) return true;
    if (ends_word(start + 1, end)) {
      ++counts.vertices;
    } else if (start[1] == 't' && ends_word(start + 2, end)) {
      ++counts.textures;
    } else if (start[1] == 'n' && ends_word(start + 2, end)) {
      ++counts.normals;
    }
    return true;
  });
  return counts;
}

Status parse_obj(TextScanner text, const ReadOptions& options, ObjSection& section) {
  return SectionParser(std::move(text), options, section).parse();
}

const char* find_obj_face(TextScanner text, std::size_t face) {
  const char* found = text.at();
  std::size_t faces = 0;
  walk_statements(text, [&](const char* start) {
    if (*start != 'f' || !ends_word(start + 1, text.end())) return true;
    found = start;
    return faces++ != face;
  });
  return found;
}

}  // namespace diesink
