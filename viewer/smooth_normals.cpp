// SPDX-License-Identifier: Apache-2.0
#include "viewer/smooth_normals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <unordered_map>

namespace diesink {
namespace {

struct PlaceHash {
  std::size_t operator()(const std::array<double, 3>& p) const {
    std::uint64_t sum = 0;
    for (const double each : p) {
      sum = (sum ^ std::bit_cast<std::uint64_t>(each)) * 0x9E3779B97F4A7C15ULL;
      sum ^= sum >> 29;
    }
    return sum;
  }
};

// For each vertex the first of those at its place.
std::vector<std::uint32_t> first_at_place(const TriangleMesh& mesh) {
  std::unordered_map<std::array<double, 3>, std::uint32_t, PlaceHash> places;
  places.reserve(mesh.positions.size());
  std::vector<std::uint32_t> first;
  first.reserve(mesh.positions.size());
  for (const Vec3& p : mesh.positions) {
    const auto next = static_cast<std::uint32_t>(first.size());
    // -0 and 0 are one place.
    first.push_back(
        places.try_emplace({p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, next).first->second);
  }
  return first;
}

// Around a vertex of more corners each keeps its own triangle's normal: the work is their square.
constexpr std::uint32_t kMostAround = 256;

double angle_at(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& triangle,
                std::size_t k) {
  const Vec3& p = mesh.positions[triangle[k]];
  const Vec3 a = mesh.positions[triangle[(k + 1) % 3]] - p;
  const Vec3 b = mesh.positions[triangle[(k + 2) % 3]] - p;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

void smooth_normals(TriangleMesh& mesh, double degrees) {
  const std::size_t count = mesh.triangles.size();
  const std::vector<std::uint32_t> first = first_at_place(mesh);
  std::vector<Vec3> flat(count, Vec3::Zero());
  std::vector<std::uint32_t> start(mesh.positions.size() + 1, 0);
  for (std::size_t t = 0; t < count; ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 across =
        (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]);
    const double length = across.norm();
    if (length > 0) flat[t] = across / length;
    for (const std::uint32_t v : mesh.triangles[t]) ++start[first[v] + 1];
  }
  for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
  std::vector<std::uint32_t> next(start.begin(), start.end() - 1), corners(3 * count);
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      corners[next[first[mesh.triangles[t][k]]]++] = static_cast<std::uint32_t>(3 * t + k);
    }
  }
  const double least = std::cos(degrees * std::numbers::pi / 180);
  const auto element = [&](std::size_t t) {
    return mesh.triangle_element.empty() ? 0U : mesh.triangle_element[t];
  };
  mesh.normals.clear();
  mesh.corner_normals.assign(count, {0, 0, 0});
  for (std::size_t v = 0; v + 1 < start.size(); ++v) {
    // Corners with one and the same mean share it.
    const std::size_t begin = mesh.normals.size();
    for (std::uint32_t i = start[v]; i < start[v + 1]; ++i) {
      const std::size_t t = corners[i] / 3;
      Vec3 sum = Vec3::Zero();
      const bool crowded = start[v + 1] - start[v] > kMostAround;
      for (std::uint32_t j = start[v]; !crowded && j < start[v + 1]; ++j) {
        const std::size_t other = corners[j] / 3;
        if (element(other) != element(t) || flat[other].dot(flat[t]) < least) continue;
        sum += angle_at(mesh, mesh.triangles[other], corners[j] % 3) * flat[other];
      }
      const double length = sum.norm();
      const Vec3 normal = length > 0 ? Vec3(sum / length) : flat[t];
      std::size_t at = crowded ? mesh.normals.size() : begin;
      while (at < mesh.normals.size() && mesh.normals[at] != normal) ++at;
      if (at == mesh.normals.size()) mesh.normals.push_back(normal);
      mesh.corner_normals[t][corners[i] % 3] = static_cast<std::uint32_t>(at);
    }
  }
}

}  // namespace diesink
