// Binary STL. The two colour layouts are those of VisCAM/SolidView and Materialise Magics.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <mutex>
#include <span>
#include <vector>

#include "core/counted.h"
#include "core/parallel.h"
#include "formats/element_table.h"
#include "formats/file_marks.h"
#include "formats/mesh_builder.h"
#include "formats/stl.h"
#include "formats/stl_facets.h"
#include "formats/text_number.h"

namespace diesink {
namespace {

class BinaryReader {
 public:
  BinaryReader(const ByteSource& bytes, const ReadOptions& options, Diagnostics& diagnostics)
      : bytes_(bytes), options_(options), diagnostics_(diagnostics) {}

  Result<TriangleMesh> read() {
    std::array<std::byte, kStlHeaderBytes> room;
    const std::byte* const header = bytes_.at(0, room);
    if (header == nullptr) return unreadable(0);
    std::uint32_t claimed = 0;
    std::memcpy(&claimed, header + 80, 4);
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
    if (options_.weld && claimed > CornerWeld::kMostVertices / 3) {
      Error over = error(std::to_string(claimed) + " facets are more than can be welded, " +
                             std::to_string(CornerWeld::kMostVertices / 3),
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
      diagnostics_.warning(counted(bytes_.size() - end, "byte|bytes| after the last of ") +
                               counted(claimed, "facet|facets| left out"),
                           at(end));
    }
    if (claimed == 0) diagnostics_.warning("the file has no facets", at(80));
    TriangleMesh mesh;
    read_header({static_cast<const char*>(static_cast<const void*>(header)), 80}, mesh);
    FacetGatherer gatherer(claimed, options_.weld, options_.threads);
    attributes_of_wave_.resize(std::min<std::size_t>(claimed, gatherer.wave()));
    for (std::size_t first = 0; first < claimed; first += gatherer.wave()) {
      if (options_.done_with) options_.done_with(kStlHeaderBytes + kStlFacetBytes * first);
      const std::size_t count = std::min(claimed - first, gatherer.wave());
      Odd attributed;
      gatherer.add(count, [&](std::size_t low, std::size_t high, Vec3* to) {
        const Survey found =
            read_facets(first + low, first + high, to, attributes_of_wave_.data() + low);
        const std::scoped_lock lock(surveying_);
        unreadable_.add(found.unreadable);
        bad_.add(found.bad);
        not_finite_.add(found.not_finite);
        opposed_.add(found.opposed);
        attributed.add(found.attributed);
      });
      tell_progress(static_cast<double>(first + count) / static_cast<double>(claimed));
      if (unreadable_.count > 0) return unreadable(offset_of(unreadable_.first));
      if (bad_.count > 0) return bad_coordinate(bad_.first);
      if (attributed.count > 0) attributes_.resize(claimed);
      if (!attributes_.empty()) {
        std::copy_n(attributes_of_wave_.begin(), count,
                    attributes_.begin() + static_cast<std::ptrdiff_t>(first));
      }
    }
    gatherer.move_into(mesh);
    read_colors(mesh);
    warn(not_finite_, kNotFiniteNormals);
    warn(opposed_, kOpposedNormals);
    return mesh;
  }

 private:
  // Facets of a kind, and the first of them.
  struct Odd {
    std::size_t count = 0, first = 0;
    void hit(std::size_t facet) {
      if (count++ == 0) first = facet;
    }
    void add(const Odd& other) {
      if (other.count > 0 && (count == 0 || other.first < first)) first = other.first;
      count += other.count;
    }
  };
  struct Survey {
    Odd unreadable, bad, not_finite, opposed, attributed;
  };

  [[nodiscard]] static std::size_t offset_of(std::size_t facet) {
    return kStlHeaderBytes + kStlFacetBytes * facet;
  }

  // Several threads do this at once, for facets of their own.
  Survey read_facets(std::size_t begin, std::size_t end, Vec3* to,
                     std::uint16_t* attributes) const {
    Survey survey;
    constexpr std::size_t kPiece = 512;  // facets, which stay in the nearest cache
    std::array<std::byte, kPiece * kStlFacetBytes> room;
    for (std::size_t i = begin; i < end; i += kPiece) {
      const std::size_t count = std::min(end - i, kPiece);
      const std::byte* const from =
          bytes_.at(offset_of(i), std::span(room).first(count * kStlFacetBytes));
      if (from == nullptr) {
        survey.unreadable.hit(i);
        std::fill_n(to, 3 * count, Vec3::Zero());
      } else {
        read_piece(from, i, count, to, attributes, survey);
      }
      to += 3 * count;
      attributes += count;
    }
    return survey;
  }

  void read_piece(const std::byte* from, std::size_t first, std::size_t count, Vec3* to,
                  std::uint16_t* attributes, Survey& survey) const {
    for (std::size_t i = first; i < first + count; ++i, to += 3, from += kStlFacetBytes) {
      std::array<float, 12> numbers;
      std::memcpy(numbers.data(), from, sizeof numbers);
      std::uint16_t attribute = 0;
      std::memcpy(&attribute, from + 48, 2);
      *attributes++ = attribute;
      if (attribute != 0) survey.attributed.hit(i);
      const std::span<Vec3, 3> corners(to, 3);
      bool fits = true;
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t k = 0; k < 3; ++k) {
          const auto x = static_cast<double>(numbers[3 + 3 * c + k]);
          corners[c][static_cast<int>(k)] = x;
          fits &= std::abs(x) <= options_.max_coordinate;
        }
      }
      if (!fits) [[unlikely]] {
        survey.bad.hit(i);
        for (Vec3& corner : corners) corner.setZero();  // only numbers can be welded
        continue;
      }
      const Vec3 normal(static_cast<double>(numbers[0]), static_cast<double>(numbers[1]),
                        static_cast<double>(numbers[2]));
      const NormalVerdict verdict = judge_normal(normal, corners);
      if (verdict != NormalVerdict::kFine) [[unlikely]] {
        (verdict == NormalVerdict::kNotFinite ? survey.not_finite : survey.opposed).hit(i);
      }
    }
  }

  [[nodiscard]] Place at(std::size_t offset) const {
    return {options_.file_name, 0, 0, static_cast<std::int64_t>(offset)};
  }
  [[nodiscard]] Error error(std::string message, std::size_t offset) const {
    return {ErrorCode::kInput, std::move(message), at(offset)};
  }
  [[nodiscard]] Error unreadable(std::size_t offset) const {
    return error("cannot read: the file ends here all of a sudden, or its disk fails", offset);
  }
  void warn(const Odd& odd, std::string_view what) {
    if (odd.count > 0) diagnostics_.warning(counted(odd.count, what), at(offset_of(odd.first)));
  }

  [[nodiscard]] Error bad_coordinate(std::size_t facet) const {
    std::array<std::byte, sizeof(float) * 12> room;
    const std::byte* const from = bytes_.at(offset_of(facet), room);
    if (from == nullptr) return unreadable(offset_of(facet));
    std::array<float, 12> numbers;
    std::memcpy(numbers.data(), from, sizeof numbers);
    for (std::size_t k = 3; k < numbers.size(); ++k) {
      const auto x = static_cast<double>(numbers[k]);
      const std::size_t place = offset_of(facet) + 4 * k;
      if (!std::isfinite(x)) return error("a coordinate that is no finite number", place);
      if (std::abs(x) > options_.max_coordinate) {
        Error over = error("coordinate " + to_text(x) + " is beyond the limit of " +
                               to_text(options_.max_coordinate),
                           place);
        over.code = ErrorCode::kLimit;
        return over;
      }
    }
    return error("a coordinate that cannot be read", offset_of(facet));
  }

  void read_header(std::string_view header, TriangleMesh& mesh) {
    if (const std::size_t color = header.find("COLOR=");
        color != std::string_view::npos && color + 10 <= 80) {
      Color of_object{};
      std::memcpy(of_object.data(), header.data() + color + 6, 4);
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
      return attributes_.empty() ? std::uint16_t{0} : attributes_[facet];
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
      diagnostics_.warning(
          counted(foreign,
                  "facet has|facets have| an attribute word that is no colour: it is left out"),
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

  const ByteSource& bytes_;
  const ReadOptions& options_;
  Diagnostics& diagnostics_;
  std::optional<Color> magics_;
  std::vector<std::uint16_t> attributes_;  // of every facet; empty where all are zero
  std::vector<std::uint16_t> attributes_of_wave_;
  std::mutex surveying_;
  Odd unreadable_, bad_, not_finite_, opposed_;
};

}  // namespace

Result<TriangleMesh> read_binary_stl(const ByteSource& bytes, const ReadOptions& options,
                                     Diagnostics& diagnostics) {
  return BinaryReader(bytes, options, diagnostics).read();
}

}  // namespace diesink
