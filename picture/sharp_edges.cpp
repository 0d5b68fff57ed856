// SPDX-License-Identifier: Apache-2.0
#include "picture/sharp_edges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace diesink {
namespace {

// For each vertex the first of those at its place.
std::vector<std::uint32_t> first_at_place(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.positions.size()), first(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&](std::uint32_t v) {
    const Vec3& p = mesh.positions[v];
    return std::array{p.x() + 0.0, p.y() + 0.0, p.z() + 0.0};
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const auto ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a < b;
  });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && key(order[k]) == key(order[k - 1]);
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  return first;
}

struct Side {
  std::uint32_t low, high, triangle;
  friend bool operator<(const Side& a, const Side& b) {
    return a.low != b.low     ? a.low < b.low
           : a.high != b.high ? a.high < b.high
                              : a.triangle < b.triangle;
  }
};

std::vector<Side> sides_of(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> first = first_at_place(mesh);
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = first[mesh.triangles[t][k]],
                          b = first[mesh.triangles[t][(k + 1) % 3]];
      if (a != b) sides.push_back({std::min(a, b), std::max(a, b), t});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

Vec3 normal_of(const TriangleMesh& mesh, std::uint32_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  const Vec3 across =
      (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]);
  const double length = across.norm();
  return length > 0 ? Vec3(across / length) : Vec3(Vec3::Zero());
}

}  // namespace

std::vector<MeshCurve> sharp_edges(const TriangleMesh& mesh, double degrees) {
  const std::vector<Side> sides = sides_of(mesh);
  const double least = std::cos(degrees * std::numbers::pi / 180);
  const auto element = [&](std::uint32_t t) {
    return mesh.triangle_element.empty() ? 0U : mesh.triangle_element[t];
  };
  std::vector<MeshCurve> curves;
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].low == sides[begin].low &&
           sides[end].high == sides[begin].high) {
      ++end;
    }
    const std::uint32_t a = sides[begin].triangle, b = sides[end - 1].triangle;
    const bool ends = end - begin == 1;
    if (!ends && element(a) == element(b)) {
      const Vec3 na = normal_of(mesh, a), nb = normal_of(mesh, b);
      // A triangle without area says nothing about the surface beside it.
      if (na.isZero() || nb.isZero() || na.dot(nb) >= least) continue;
    }
    MeshCurve curve;
    curve.kind = ends ? CurveKind::kEdge : CurveKind::kCrease;
    curve.vertices = {sides[begin].low, sides[begin].high};
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace diesink
