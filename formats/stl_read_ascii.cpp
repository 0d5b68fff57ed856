// ASCII STL. Source: 3D Systems' StereoLithography Interface Specification.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "formats/element_table.h"
#include "formats/mesh_builder.h"
#include "formats/stl.h"
#include "formats/stl_facets.h"
#include "formats/text_sections.h"

namespace diesink {
namespace {

bool is_word(std::string_view word, std::string_view lower) {
  if (word.size() != lower.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if ((word[i] | 0x20) != lower[i]) return false;
  }
  return true;
}

// The facets of a part of the file, and where solids begin and end between them.
struct alignas(kOwnLines) AsciiSection {
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
  // `inside`: the section begins within a solid. `before`: how many facets the file has in front
  // of it.
  SectionReader(const TextScanner& text, const ReadOptions& options, bool inside,
                std::size_t before, AsciiSection& section)
      : text_(text), options_(options), section_(section), before_(before), inside_(inside) {}

  Status read() {
    // A facet takes about 150 bytes with short numbers.
    reserve_large(section_.facets, std::min(text_.left() / 150 + 1, options_.max_triangles));
    while (text_.more()) {
      const char* const at = text_.at();
      if (inside_ && skip("facet")) {
        if (before_ + section_.facets.size() == options_.max_triangles) return too_many(at);
        if (const Status facet = read_facet(); !facet) return facet;
        continue;
      }
      const std::string_view word = text_.word();
      if (inside_ && is_word(word, "facet")) {
        if (before_ + section_.facets.size() == options_.max_triangles) return too_many(at);
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

 private:
  Error too_many(const char* at) {
    Error over =
        text_.error("more facets than the limit of " + std::to_string(options_.max_triangles), at);
    over.code = ErrorCode::kLimit;
    return over;
  }

  // Goes behind the word where it is spelt as usual.
  bool skip(std::string_view word) {
    if (!text_.more() || text_.left() <= word.size()) return false;
    const char* const behind = text_.at() + word.size();
    if (std::memcmp(text_.at(), word.data(), word.size()) != 0) return false;
    if (!is_blank(*behind) && !is_line_end(*behind)) return false;
    text_.move_to(behind);
    return true;
  }

  Status expect(std::string_view word) {
    if (skip(word)) return ok();
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
      if (!skip("vertex")) {
        if (const Status word = expect("vertex"); !word) return word;
      }
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
  std::size_t before_;
  bool inside_;
};

class AsciiReader {
 public:
  AsciiReader(std::string_view text, const ReadOptions& options, Diagnostics& diagnostics)
      : text_(text, options.file_name), options_(options), diagnostics_(diagnostics) {}

  Result<TriangleMesh> read() {
    cut_into_sections();
    std::vector<Status> states(sections_.size(), ok());
    run_parallel(sections_.size(), thread_count(options_.threads),
                 [&](std::size_t i) { states[i] = read_section(i, 0, sections_[i]); });
    std::size_t facets = 0;
    for (std::size_t i = 0; i < sections_.size(); ++i) {
      // What is wrong first in the file is told: where the facets are too many all together, or
      // something behind the first of these.
      if (facets + sections_[i].facets.size() > options_.max_triangles) {
        AsciiSection again;
        return read_section(i, facets, again).error();
      }
      if (!states[i]) return states[i].error();
      facets += sections_[i].facets.size();
    }
    if (const Status fits = mesh_fits(3 * facets, facets, options_, text_.place()); !fits) {
      return fits.error();
    }
    TriangleMesh mesh;
    FacetGatherer gatherer(facets, options_.weld, options_.threads);
    triangle_element_.reserve(facets);
    for (AsciiSection& section : sections_) take(section, gatherer);
    if (solids_ == 0) return text_.error("no 'solid' in the file", text_.end());
    if (inside_) end_solid(false);
    if (elements_.size() == 0)
      diagnostics_.warning("the file has no facets", text_.place(text_.end()));
    empty_.warn("solid|solids| without facets", text_, diagnostics_);
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
    const std::size_t wanted = section_count(size, options_);
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

  Status read_section(std::size_t i, std::size_t before, AsciiSection& section) const {
    return SectionReader(text_.section(starts_[i], starts_[i + 1]), options_, i > 0, before,
                         section)
        .read();
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
    }
    for (std::size_t first = 0; first < section.facets.size(); first += gatherer.wave()) {
      const std::span<const std::array<Vec3, 3>> facets = std::span(section.facets).subspan(first);
      gatherer.add(std::min(facets.size(), gatherer.wave()),
                   [&](std::size_t begin, std::size_t end, Vec3* to) {
                     for (std::size_t i = begin; i < end; ++i, to += 3) {
                       std::copy_n(facets[i].begin(), 3, to);
                     }
                   });
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

}  // namespace

Result<TriangleMesh> read_ascii_stl(std::string_view text, const ReadOptions& options,
                                    Diagnostics& diagnostics) {
  return AsciiReader(text, options, diagnostics).read();
}

}  // namespace diesink
