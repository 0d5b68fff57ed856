// OFF in its ASCII forms. Source: Geomview's manual, "OFF files".
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "formats/file_marks.h"
#include "formats/mesh_builder.h"
#include "formats/off.h"
#include "formats/text_scanner.h"

namespace diesink {
namespace {

// The letters before OFF; nothing where the word is no keyword of the format.
struct Keyword {
  bool texture = false, color = false, normal = false, four = false, many = false;
};

std::optional<Keyword> keyword_of(std::string_view word) {
  Keyword keyword;
  const auto take = [&](std::string_view prefix) {
    if (!word.starts_with(prefix)) return false;
    word.remove_prefix(prefix.size());
    return true;
  };
  keyword.texture = take("ST") || take("st");
  keyword.color = take("C") || take("c");
  keyword.normal = take("N") || take("n");
  keyword.four = take("4");
  if (word != "OFF" && word != "off") keyword.many = take("n");
  if (word != "OFF" && word != "off" && word != "Off") return std::nullopt;
  return keyword;
}

class OffReader {
 public:
  OffReader(std::string_view text, const ReadOptions& options, Diagnostics& diagnostics)
      : text_(text, options.file_name),
        options_(options),
        diagnostics_(diagnostics),
        builder_(mesh_, options) {}

  Result<TriangleMesh> read() {
    if (const Status header = read_header(); !header) return header.error();
    mesh_.positions.reserve(vertices_);
    for (std::size_t i = 0; i < vertices_; ++i) {
      if (const Status vertex = read_vertex(i); !vertex) return vertex.error();
    }
    // Rows that had none beside rows that had one.
    if (!mesh_.vertex_colors.empty())
      mesh_.vertex_colors.resize(vertices_, Color{255, 255, 255, 255});
    if (!mesh_.normals.empty()) mesh_.normals.resize(vertices_, Vec3::UnitZ());
    mesh_.triangles.reserve(faces_);
    for (std::size_t i = 0; i < faces_; ++i) {
      if (const Status face = read_face(i); !face) return face.error();
    }
    if (more()) {
      diagnostics_.warning(
          "the text after the last of " + std::to_string(faces_) + " faces is left out",
          text_.place());
    }
    builder_.finish(elements_);
    if (mesh_.triangles.empty()) diagnostics_.warning("the file has no faces", text_.place());
    few_.warn("faces with fewer than three corners are left out", text_, diagnostics_);
    crossing_.warn("polygons cross themselves or are flat", text_, diagnostics_);
    unclear_.warn(
        "rows have numbers after their coordinates that this file's keyword does not announce: "
        "left out",
        text_, diagnostics_);
    short_.warn("vertices lack the colour or normal that the file's keyword announces", text_,
                diagnostics_);
    mapped_.warn("faces have a colour by number, which is not kept", text_, diagnostics_);
    return std::move(mesh_);
  }

 private:
  // Skips comments, looking for the marks the writer makes.
  bool more() {
    while (text_.more() && *text_.at() == '#') {
      std::string_view comment = text_.rest_of_line();
      while (!comment.empty() && (comment[0] == '#' || is_blank(comment[0])))
        comment.remove_prefix(1);
      read_mark(comment, mesh_);
    }
    return !text_.at_end();
  }
  bool more_in_line() { return text_.more_in_line() && *text_.at() != '#'; }

  Error limit(std::string message, const char* at = nullptr) {
    Error error = text_.error(std::move(message), at);
    error.code = ErrorCode::kLimit;
    return error;
  }

  Status read_count(std::string_view what, std::size_t bytes_each, std::size_t& count) {
    more();
    const char* const at = text_.at();
    const std::string_view word = text_.word();
    const std::optional<std::int64_t> number = integer_of(word);
    if (!number || *number < 0) {
      return text_.error((word.empty() ? "the file ends" : "found " + quoted(word)) +
                             ", expected the number of " + std::string(what),
                         at);
    }
    count = static_cast<std::size_t>(*number);
    if (count > (text_.left() + 1) / bytes_each) {
      return text_.error(std::to_string(count) + " " + std::string(what) + " do not fit in the " +
                             std::to_string(text_.left()) + " bytes left",
                         at);
    }
    return ok();
  }

  Status read_header() {
    more();
    const char* const at = text_.at();
    const std::string_view word = text_.word();
    const std::optional<Keyword> keyword = keyword_of(word);
    if (!keyword) return text_.error("found " + quoted(word) + ", expected the keyword 'OFF'", at);
    keyword_ = *keyword;
    if (keyword_.four || keyword_.many) {
      return Error{ErrorCode::kUnsupported, quoted(word) + " has more than three dimensions",
                   text_.place(at)};
    }
    more();
    TextScanner ahead = text_;
    if (const std::string_view next = ahead.word(); next == "BINARY" || next == "binary") {
      return Error{ErrorCode::kUnsupported, "binary OFF is not read, only ASCII", text_.place()};
    }
    if (const Status count = read_count("vertices", 6, vertices_); !count) return count;
    if (const Status count = read_count("faces", 2, faces_); !count) return count;
    // The number of edges is often wrong and never needed; some files leave it out.
    if (more_in_line()) {
      const char* const edges = text_.at();
      if (!integer_of(text_.word())) return text_.error("expected the number of edges", edges);
    }
    if (vertices_ > 0xFFFFFFFEU) return limit("more vertices than 32 bits can count");
    if (faces_ > options_.max_triangles) {
      return limit(std::to_string(faces_) + " faces are more than the limit of " +
                   std::to_string(options_.max_triangles));
    }
    return mesh_fits(vertices_, faces_, options_, text_.place());
  }

  // All numbers of the rest of the line.
  Status read_rest(std::vector<double>& numbers, std::vector<bool>& whole) {
    numbers.clear();
    whole.clear();
    while (more_in_line() && numbers.size() < 16) {
      const char* const at = text_.at();
      double value = 0;
      if (const NumberState state = text_.number(value); state != NumberState::kOk) {
        return text_.number_error(state, "a number");
      }
      numbers.push_back(value);
      whole.push_back(integer_of({at, static_cast<std::size_t>(text_.at() - at)}).has_value());
    }
    return ok();
  }

  // Whole numbers are 0..255, others 0..1.
  static Color color_from(const std::vector<double>& numbers, const std::vector<bool>& whole,
                          std::size_t first, std::size_t count) {
    Color color{0, 0, 0, 255};
    bool all_whole = true;
    for (std::size_t i = 0; i < count; ++i) all_whole = all_whole && whole[first + i];
    for (std::size_t i = 0; i < count; ++i) color[i] = color_part(numbers[first + i], all_whole);
    return color;
  }

  Status read_vertex(std::size_t number) {
    if (!more()) {
      return text_.error("the file ends after " + std::to_string(number) + " of " +
                         std::to_string(vertices_) + " vertices");
    }
    const char* const start = text_.at();
    Vec3 p = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      if (k > 0 && !more_in_line())
        return text_.number_error(NumberState::kNotANumber, "three coordinates");
      const NumberState state = text_.number(p[k]);
      if (state != NumberState::kOk) return text_.number_error(state, "a coordinate");
      if (std::abs(p[k]) > options_.max_coordinate) {
        return limit("coordinate " + to_text(p[k]) + " is beyond the limit of " +
                     to_text(options_.max_coordinate));
      }
    }
    mesh_.positions.push_back(p);
    if (!more_in_line()) {
      if (keyword_.normal || keyword_.color) short_.hit(start);
      return ok();
    }
    if (const Status rest = read_rest(rest_, whole_); !rest) return rest;
    std::size_t at = keyword_.normal ? 3 : 0;
    const std::size_t after =
        rest_.size() - std::min(rest_.size(), at + (keyword_.texture ? 2U : 0U));
    if (keyword_.color && (after == 3 || after == 4)) {
      mesh_.vertex_colors.resize(mesh_.positions.size(), Color{255, 255, 255, 255});
      mesh_.vertex_colors.back() = color_from(rest_, whole_, at, after);
    } else if (after != 0) {
      unclear_.hit(start);
    }
    if (keyword_.normal && rest_.size() >= 3) {
      const Vec3 n(rest_[0], rest_[1], rest_[2]);
      const double length = n.norm();
      mesh_.normals.resize(mesh_.positions.size(), Vec3::UnitZ());
      if (length > 0) mesh_.normals.back() = std::abs(length - 1) < 1e-3 ? n : Vec3(n / length);
    }
    return ok();
  }

  Status read_face(std::size_t number) {
    if (!more()) {
      return text_.error("the file ends after " + std::to_string(number) + " of " +
                         std::to_string(faces_) + " faces");
    }
    const char* const start = text_.at();
    const std::string_view word = text_.word();
    const std::optional<std::int64_t> corners = integer_of(word);
    if (!corners || *corners < 1) {
      return text_.error("found " + quoted(word) + ", expected the number of the face's corners",
                         start);
    }
    if (static_cast<std::size_t>(*corners) > text_.left() / 2 + 1) {
      return text_.error("a face of " + std::to_string(*corners) + " corners does not fit in the " +
                             std::to_string(text_.left()) + " bytes left",
                         start);
    }
    face_.clear();
    for (std::int64_t i = 0; i < *corners; ++i) {
      more();
      const char* const at = text_.at();
      const std::string_view index_word = text_.word();
      const std::optional<std::int64_t> index = integer_of(index_word);
      if (!index || *index < 0 || *index >= static_cast<std::int64_t>(mesh_.positions.size())) {
        return text_.error(
            (index_word.empty() ? "the file ends" : "found " + quoted(index_word)) +
                ", expected the number of a vertex from 0 to " +
                std::to_string(static_cast<std::int64_t>(mesh_.positions.size()) - 1),
            at);
      }
      face_.push_back(static_cast<std::uint32_t>(*index));
    }
    std::uint32_t element = 0;
    bool colored = false;
    if (more_in_line()) {
      if (const Status rest = read_rest(rest_, whole_); !rest) return rest;
      if (rest_.size() == 3 || rest_.size() == 4) {
        colored = true;
        if (elements_.size() == 0 && !mesh_.triangles.empty()) elements_.named("", "");
        element = elements_.colored(color_from(rest_, whole_, 0, rest_.size()));
      } else {
        mapped_.hit(start);
      }
    }
    if (!colored && elements_.size() > 0) element = elements_.named("", "");
    normals_ = mesh_.normals.empty() ? std::span<const std::uint32_t>{}
                                     : std::span<const std::uint32_t>(face_);
    switch (builder_.add(face_, normals_, element)) {
      case FaceVerdict::kTooFew:
        few_.hit(start);
        break;
      case FaceVerdict::kCrossing:
        crossing_.hit(start);
        break;
      case FaceVerdict::kTooMany:
        return limit("more triangles than the limit of " + std::to_string(options_.max_triangles),
                     start);
      case FaceVerdict::kFine:
      case FaceVerdict::kOutOfRange:
        break;
    }
    return ok();
  }

  TextScanner text_;
  const ReadOptions& options_;
  Diagnostics& diagnostics_;
  TriangleMesh mesh_;
  FaceBuilder builder_;
  ElementTable elements_;
  Keyword keyword_;
  std::size_t vertices_ = 0, faces_ = 0;
  std::vector<double> rest_;
  std::vector<bool> whole_;
  std::vector<std::uint32_t> face_;
  std::span<const std::uint32_t> normals_;
  Tally few_, crossing_, unclear_, short_, mapped_;
};

}  // namespace

bool looks_like_off(std::span<const std::byte> bytes) {
  return keyword_of(first_word_of(bytes)).has_value();
}

Result<TriangleMesh> read_off(std::span<const std::byte> bytes, const ReadOptions& options,
                              Diagnostics& diagnostics) {
  return OffReader(text_of(bytes), options, diagnostics).read();
}

}  // namespace diesink
