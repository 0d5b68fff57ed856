// Facets on their way from an STL file of either kind into a mesh.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/large_array.h"
#include "core/mesh.h"
#include "core/mesh_tools/corner_weld.h"

namespace diesink {

// Facets as they come, three corners each, in waves that all threads work on.
class FacetGatherer {
 public:
  // Needs: fewer facets than CornerWeld::kMostVertices / 3 all together.
  FacetGatherer(std::size_t expected, bool weld, int threads)
      : weld_(weld), table_(weld ? expected / 2 + 4 : 0, threads) {
    reserve_cleared(triangles_, expected, threads);
    if (!weld) reserve_large(positions_, 3 * expected);
  }

  [[nodiscard]] std::size_t wave() const { return table_.wave() / 3; }  // facets

  // The next facets, wave() of them at most: fill(begin, end, to) writes the corners of facets
  // begin .. end - 1 of the wave to `to`. Called by several threads, for parts of their own.
  template <class Fill>
  void add(std::size_t count, Fill fill) {
    const std::size_t first = triangles_.size();
    triangles_.resize(first + count);
    const auto put = [&](std::size_t begin, std::size_t end, Vec3* to) {
      fill(begin / 3, end / 3, to);
    };
    if (count > 0 && weld_) {
      table_.add(put, {triangles_[first].data(), 3 * count});
    } else if (count > 0) {
      positions_.resize(3 * (first + count));
      put(0, 3 * count, positions_.data() + 3 * first);
      for (std::size_t i = first; i < triangles_.size(); ++i) {
        const auto corner = static_cast<std::uint32_t>(3 * i);
        for (std::size_t k = 0; k < 3; ++k) positions_[3 * i + k] += Vec3::Zero();  // no -0
        triangles_[i] = {corner, corner + 1, corner + 2};
      }
    }
  }

  void move_into(TriangleMesh& mesh) {
    mesh.positions = weld_ ? table_.take() : std::move(positions_);
    mesh.triangles = std::move(triangles_);
  }

 private:
  bool weld_;
  CornerWeld table_;
  std::vector<Vec3> positions_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
};

// What a facet's normal says against its corners.
enum class NormalVerdict : std::uint8_t { kFine, kNotFinite, kOpposed };

inline NormalVerdict judge_normal(const Vec3& normal, std::span<const Vec3, 3> corners) {
  const double against = normal.dot((corners[1] - corners[0]).cross(corners[2] - corners[0]));
  if (against >= 0) return NormalVerdict::kFine;
  return std::isnan(against) || !normal.allFinite() ? NormalVerdict::kNotFinite
                                                    : NormalVerdict::kOpposed;
}

inline constexpr std::string_view kNotFiniteNormals =
    "facet has|facets have| a normal that is not finite: it is left out, the vertices tell it";
inline constexpr std::string_view kOpposedNormals =
    "facet has|facets have| a normal against the turn of its vertices: the vertices are believed";

}  // namespace diesink
