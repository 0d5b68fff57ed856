// OFF in its ASCII forms. Source: Geomview's manual, "OFF files".
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/counted.h"
#include "formats/file_marks.h"
#include "formats/mesh_builder.h"
#include "formats/off.h"
#include "formats/off_rows.h"
#include "formats/plain_lines.h"
#include "formats/text_scanner.h"
#include "formats/text_sections.h"

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
    if (const Status rows = read_rows(); !rows) return rows.error();
    // Rows that had none beside rows that had one.
    if (!mesh_.vertex_colors.empty())
      mesh_.vertex_colors.resize(vertices_, Color{255, 255, 255, 255});
    if (!mesh_.normals.empty()) mesh_.normals.resize(vertices_, Vec3::UnitZ());
    if (more()) {
      diagnostics_.warning(
          "the text after the last of " + counted(faces_, "face is|faces is| left out"),
          text_.place());
    }
    builder_.finish(elements_);
    if (mesh_.triangles.empty()) diagnostics_.warning("the file has no faces", text_.place());
    few_.warn("face|faces| with fewer than three corners, left out", text_, diagnostics_);
    crossing_.warn("polygon crosses itself or is flat|polygons cross themselves or are flat|",
                   text_, diagnostics_);
    unclear_.warn(
        "row has numbers after its|rows have numbers after their| coordinates that this file's "
        "keyword does not announce: "
        "left out",
        text_, diagnostics_);
    short_.warn(
        "vertex lacks|vertices lack| the colour or normal that the file's keyword announces", text_,
        diagnostics_);
    mapped_.warn("face has|faces have| a colour by number, which is not kept", text_, diagnostics_);
    return std::move(mesh_);
  }

 private:
  // Skips comments, looking for the marks the writer makes.
  bool more() {
    while (text_.more() && *text_.at() == '#') read_mark(off_comment(text_), mesh_);
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

  // All rows: a section a thread where the text is large and every row is a line.
  Status read_rows() {
    const std::size_t count = vertices_ + faces_;
    if (section_count(text_.left(), options_) > 1 && count > 0) {
      const char* const begin = text_.at();
      const TriangleMesh marks = mesh_;
      if (read_sections(count)) return ok();
      // One thread tells what is wrong, or reads what the sections could not.
      text_.move_to(begin);
      mesh_ = marks;
      elements_ = {};
      few_ = crossing_ = unclear_ = short_ = mapped_ = {};
    }
    mesh_.positions.reserve(vertices_);
    OffRowReader reader(text_, options_, vertices_, faces_);
    OffRows rows;
    for (std::size_t i = 0; i < count; ++i) {
      rows.clear();
      if (Status read = reader.read(i, rows); !read) return read;
      if (Status taken = take(i, rows); !taken) return taken;
    }
    return ok();
  }

  bool read_sections(std::size_t count) {
    SectionQueue<OffRows> sections(
        text_, options_,
        [](TextScanner section) {
          if (const auto plain = plain_row_count({section.at(), section.left()})) return *plain;
          std::size_t rows = 0;
          for (; section.more(); section.skip_line()) rows += *section.at() == '#' ? 0 : 1;
          return rows;
        },
        [&](TextScanner section, std::size_t row, std::size_t lines, OffRows& rows) {
          const char* const end = section.end();
          const std::size_t last = std::min(count, row + lines);
          rows.clear();
          OffRowReader reader(section, options_, vertices_, faces_);
          for (; row < count && reader.more(rows); ++row) {
            // A row that goes on in the next line, or a line with more than its row, is not for
            // this way of reading: lines were counted. Where every row takes whole lines and there
            // are as many of them as lines, none takes two.
            if (!reader.read(row, rows)) return false;
            if (section.more_in_line() && *section.at() != '#') return false;
          }
          return row == last && (row >= count || section.at() == end);
        });
    mesh_.positions.reserve(vertices_);
    std::size_t number = 0;
    while (number < count) {
      const OffRows* const rows = sections.next();
      if (rows == nullptr) return false;
      if (!take(number, *rows)) return false;
      number += rows->rows.size();
      if (rows->end != nullptr) text_.move_to(rows->end);
    }
    return true;
  }

  // Puts rows into the mesh, the first of them with this number.
  Status take(std::size_t number, const OffRows& rows) {
    for (const std::string_view comment : rows.comments) read_mark(comment, mesh_);
    for (const OffRows::Row& row : rows.rows) {
      if (number == vertices_) mesh_.triangles.reserve(faces_);
      if (number < vertices_) {
        take_vertex(rows, row);
      } else if (Status taken = take_face(rows, row); !taken) {
        return taken;
      }
      ++number;
    }
    return ok();
  }

  // Of the numbers after the row's own. Whole numbers are 0..255, others 0..1.
  static Color color_from(const OffRows& rows, const OffRows::Row& row, std::size_t first,
                          std::size_t count) {
    Color color{0, 0, 0, 255};
    const std::uint32_t all = ((1U << count) - 1) << first;
    const bool all_whole = (row.whole & all) == all;
    for (std::size_t i = 0; i < count; ++i) {
      color[i] = color_part(rows.rest(row)[first + i], all_whole);
    }
    return color;
  }

  void take_vertex(const OffRows& rows, const OffRows::Row& row) {
    const std::span<const double> own = rows.own(row), rest = rows.rest(row);
    mesh_.positions.emplace_back(own[0], own[1], own[2]);
    if (rest.empty()) {
      if (keyword_.normal || keyword_.color) short_.hit(row.start);
      return;
    }
    const std::size_t at = keyword_.normal ? 3 : 0;
    const std::size_t after =
        rest.size() - std::min(rest.size(), at + (keyword_.texture ? 2U : 0U));
    if (keyword_.color && (after == 3 || after == 4)) {
      mesh_.vertex_colors.resize(mesh_.positions.size(), Color{255, 255, 255, 255});
      mesh_.vertex_colors.back() = color_from(rows, row, at, after);
    } else if (after != 0) {
      unclear_.hit(row.start);
    }
    if (keyword_.normal && rest.size() >= 3) {
      const Vec3 n(rest[0], rest[1], rest[2]);
      const double length = n.norm();
      mesh_.normals.resize(mesh_.positions.size(), Vec3::UnitZ());
      if (length > 0) mesh_.normals.back() = std::abs(length - 1) < 1e-3 ? n : Vec3(n / length);
    }
  }

  Status take_face(const OffRows& rows, const OffRows::Row& row) {
    face_.clear();
    for (const double v : rows.own(row)) face_.push_back(static_cast<std::uint32_t>(v));
    const std::size_t rest = row.end - row.rest;
    std::uint32_t element = 0;
    if (rest == 3 || rest == 4) {
      if (elements_.size() == 0 && !mesh_.triangles.empty()) elements_.named("", "");
      element = elements_.colored(color_from(rows, row, 0, rest));
    } else {
      if (rest > 0) mapped_.hit(row.start);
      if (elements_.size() > 0) element = elements_.named("", "");
    }
    normals_ = mesh_.normals.empty() ? std::span<const std::uint32_t>{}
                                     : std::span<const std::uint32_t>(face_);
    switch (builder_.add(face_, normals_, element)) {
      case FaceVerdict::kTooFew:
        few_.hit(row.start);
        break;
      case FaceVerdict::kCrossing:
        crossing_.hit(row.start);
        break;
      case FaceVerdict::kTooMany:
        return limit("more triangles than the limit of " + std::to_string(options_.max_triangles),
                     row.start);
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
