// Facets on their way from an STL file of either kind into a mesh.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "core/large_array.h"
#include "core/mesh.h"
#include "core/mesh_tools/vertex_table.h"

namespace diesink {

// Facets as they come, three corners each, given to the weld in batches.
class FacetGatherer {
 public:
  FacetGatherer(std::size_t expected, bool weld)
      : weld_(weld), table_(weld ? expected / 2 + 4 : 0) {
    reserve_large(triangles_, expected);
    if (!weld) reserve_large(positions_, 3 * expected);
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

// What a facet's normal says against its corners.
enum class NormalVerdict : std::uint8_t { kFine, kNotFinite, kOpposed };

inline NormalVerdict judge_normal(const Vec3& normal, const std::array<Vec3, 3>& corners) {
  const double against = normal.dot((corners[1] - corners[0]).cross(corners[2] - corners[0]));
  if (against >= 0) return NormalVerdict::kFine;
  return std::isnan(against) || !normal.allFinite() ? NormalVerdict::kNotFinite
                                                    : NormalVerdict::kOpposed;
}

inline constexpr std::string_view kNotFiniteNormals =
    "facets have a normal that is not finite: it is left out, the vertices tell it";
inline constexpr std::string_view kOpposedNormals =
    "facets have a normal against the turn of their vertices: the vertices are believed";

}  // namespace diesink
