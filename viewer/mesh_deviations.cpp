// SPDX-License-Identifier: Apache-2.0
#include "viewer/mesh_deviations.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <unordered_map>

#include "core/parallel.h"

namespace diesink {
namespace {

// The middle, where a chord's sag is largest, near the middles of the sides, and near the corners.
constexpr double kNear = 0.96, kSide = 0.48, kOff = 0.04;
constexpr std::array<std::array<double, 3>, 7> kSamples{{{1.0 / 3, 1.0 / 3, 1.0 / 3},
                                                         {kSide, kSide, kOff},
                                                         {kOff, kSide, kSide},
                                                         {kSide, kOff, kSide},
                                                         {kNear, kOff / 2, kOff / 2},
                                                         {kOff / 2, kNear, kOff / 2},
                                                         {kOff / 2, kOff / 2, kNear}}};
// Corners of the surface's own mesh lie on it.
constexpr std::size_t kOwnSamples = 4;
constexpr std::size_t kBlock = 1024;
constexpr double kUpright = 1e-3;  // of the normal's z

}  // namespace

std::vector<float> mesh_deviations(const TriangleMesh& mesh, const CompoundSurface& surface,
                                   bool own, int threads) {
  std::vector<float> deviations(mesh.triangles.size(), std::numeric_limits<float>::quiet_NaN());
  const auto sample = [&](std::size_t t) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3 &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
    const Vec3 across = (b - a).cross(c - a);
    if (!(std::abs(across.z()) > kUpright * across.norm())) return;
    for (std::size_t s = 0; s < (own ? kOwnSamples : kSamples.size()); ++s) {
      const auto& [u, v, w] = kSamples[s];
      const Vec3 p = u * a + v * b + w * c;
      const std::optional<CcDatum> datum = surface.at(p.x(), p.y());
      if (!datum) continue;
      if (own && !mesh.triangle_element.empty()) {
        const Label label = make_label(datum->row, static_cast<std::uint32_t>(datum->face));
        if (surface.element_name(label) != mesh.elements[mesh.triangle_element[t]].name) continue;
      }
      const auto off = static_cast<float>((p.z() - datum->z) * datum->n.z());
      if (!(std::abs(off) <= std::abs(deviations[t]))) deviations[t] = off;
    }
  };
  parallel_blocks(mesh.triangles.size(), kBlock, threads,
                  [&](std::size_t begin, std::size_t end, int) {
                    for (std::size_t t = begin; t < end; ++t) sample(t);
                  });
  return deviations;
}

}  // namespace diesink
