// A small die as a mesh: a curved sheet with a raised boss, sharp where elements meet, in several
// elements. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <string>

#include "core/mesh.h"

namespace diesink::test {

// A sheet of cells x cells quads over [0, size]², waved; the middle third of it is raised as
// element "S2.top" with walls "S2.wall" around; the rest is "B". Normals are split along all edges
// of the boss. `extra_elements` cuts the sheet into as many more elements "S3.face1".. by columns.
inline TriangleMesh die_mesh(int cells = 12, double size = 60, int extra_elements = 0,
                             const Vec3& at = Vec3::Zero()) {
  TriangleMesh mesh;
  mesh.name = "die";
  mesh.unit = LengthUnit::kMillimetre;
  mesh.up = UpAxis::kZ;
  mesh.elements = {{"B", "B", {}}, {"S2.top", "S2", {{{200, 30, 4, 255}}}}, {"S2.wall", "S2", {}}};
  for (int e = 0; e < extra_elements; ++e) {
    mesh.elements.push_back({"S3.face" + std::to_string(e + 1), "S3", {}});
  }
  const int low = cells / 3, high = cells - cells / 3;
  const auto sheet = [&](int i, int j) {
    const double x = size * i / cells, y = size * j / cells;
    return Vec3(x, y, 2 * std::sin(x / 9) * std::cos(y / 7));
  };
  const auto normal_at = [&](int i, int j) {
    const double x = size * i / cells, y = size * j / cells;
    return Vec3(-2.0 / 9 * std::cos(x / 9) * std::cos(y / 7),
                2.0 / 7 * std::sin(x / 9) * std::sin(y / 7), 1)
        .normalized();
  };
  std::map<std::array<int, 3>, std::uint32_t> vertex_of;  // i, j, raised
  const auto vertex = [&](int i, int j, int raised) {
    const auto [it, fresh] =
        vertex_of.try_emplace({i, j, raised}, static_cast<std::uint32_t>(mesh.positions.size()));
    if (fresh) mesh.positions.push_back(at + sheet(i, j) + Vec3(0, 0, raised * size / 10));
    return it->second;
  };
  std::map<std::array<int, 2>, std::uint32_t> normal_of;
  const auto smooth = [&](int i, int j) {
    const auto [it, fresh] =
        normal_of.try_emplace({i, j}, static_cast<std::uint32_t>(mesh.normals.size()));
    if (fresh) mesh.normals.push_back(normal_at(i, j));
    return it->second;
  };
  const auto quad = [&](std::array<std::uint32_t, 4> v, std::array<std::uint32_t, 4> n,
                        std::uint32_t e) {
    for (const std::array<std::size_t, 3> k : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}}) {
      mesh.triangles.push_back({v[k[0]], v[k[1]], v[k[2]]});
      mesh.corner_normals.push_back({n[k[0]], n[k[1]], n[k[2]]});
      mesh.triangle_element.push_back(e);
    }
  };
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const bool boss = i >= low && i < high && j >= low && j < high;
      const int raised = boss ? 1 : 0;
      std::uint32_t element = boss ? 1 : 0;
      if (!boss && extra_elements > 0 && i % 2 == 1) {
        element = static_cast<std::uint32_t>(3 + i % extra_elements);
      }
      quad({vertex(i, j, raised), vertex(i + 1, j, raised), vertex(i + 1, j + 1, raised),
            vertex(i, j + 1, raised)},
           {smooth(i, j), smooth(i + 1, j), smooth(i + 1, j + 1), smooth(i, j + 1)}, element);
    }
  }
  const auto flat = [&](const Vec3& n) {
    mesh.normals.push_back(n);
    return static_cast<std::uint32_t>(mesh.normals.size() - 1);
  };
  const auto wall = [&](int i0, int j0, int i1, int j1, std::uint32_t n) {
    quad({vertex(i0, j0, 0), vertex(i1, j1, 0), vertex(i1, j1, 1), vertex(i0, j0, 1)}, {n, n, n, n},
         2);
  };
  const std::uint32_t south = flat(-Vec3::UnitY()), east = flat(Vec3::UnitX()),
                      north = flat(Vec3::UnitY()), west = flat(-Vec3::UnitX());
  MeshCurve rim{CurveKind::kJump, {1, 2}, {}, true, "rim"};
  for (int k = low; k < high; ++k) {
    wall(k, low, k + 1, low, south);
    wall(high, k, high, k + 1, east);
    wall(k + 1, high, k, high, north);
    wall(low, k + 1, low, k, west);
  }
  for (int k = low; k < high; ++k) rim.vertices.push_back(vertex(k, low, 1));
  for (int k = low; k < high; ++k) rim.vertices.push_back(vertex(high, k, 1));
  for (int k = high; k > low; --k) rim.vertices.push_back(vertex(k, high, 1));
  for (int k = high; k > low; --k) rim.vertices.push_back(vertex(low, k, 1));
  mesh.curves.push_back(rim);
  MeshCurve border{CurveKind::kEdge, {0, MeshCurve::kNoElement}, {}, false, ""};
  for (int k = 0; k <= cells; ++k) border.vertices.push_back(vertex(k, 0, 0));
  mesh.curves.push_back(border);
  return mesh;
}

}  // namespace diesink::test
