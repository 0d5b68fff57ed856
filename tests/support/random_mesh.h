// Meshes for property tests: closed, open and torn ones, and what they are made of.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh.h"

namespace diesink::testing {

// A box with outward triangles, corners at `low` and `high`.
inline TriangleMesh box_mesh(const Vec3& low, const Vec3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.emplace_back((i & 1) != 0 ? high.x() : low.x(),
                                (i & 2) != 0 ? high.y() : low.y(),
                                (i & 4) != 0 ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// A closed torus of m x n quadrilaterals, each cut in two.
inline TriangleMesh torus_mesh(std::uint32_t m, std::uint32_t n, double radius = 3,
                               double tube = 1) {
  TriangleMesh mesh;
  constexpr double kTurn = 6.283185307179586;
  for (std::uint32_t i = 0; i < m; ++i) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const double u = kTurn * i / m, v = kTurn * j / n, r = radius + tube * std::cos(v);
      mesh.positions.emplace_back(r * std::cos(u), r * std::sin(u), tube * std::sin(v));
    }
  }
  for (std::uint32_t i = 0; i < m; ++i) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * n + j, b = (i + 1) % m * n + j, c = (i + 1) % m * n + (j + 1) % n,
                          d = i * n + (j + 1) % n;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

// Appends `other`, sharing nothing.
inline void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const auto base = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const std::array<std::uint32_t, 3>& t : other.triangles) {
    mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  }
}

struct MeshTraits {
  bool elements = true, colors = true, normals = true, vertex_colors = true, curves = true,
       marks = true;
  bool float_positions = false;  // of float precision
};

// Any mesh a file could hold: vertices all over the range of doubles, triangles between them at
// random, every vertex used, elements in runs or mixed, corner normals that differ around a vertex,
// closed and open curves.
inline TriangleMesh random_mesh(unsigned seed, const MeshTraits& traits = {}) {
  std::mt19937_64 random(seed);
  const auto below = [&](std::uint64_t n) { return static_cast<std::uint32_t>(random() % n); };
  const auto real = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53);
  };
  TriangleMesh mesh;
  const std::uint32_t vertices = 3 + below(60);
  const std::array scales{1.0, 1e-3, 160.0, 1e6};
  const double scale = scales[below(scales.size())];
  for (std::uint32_t v = 0; v < vertices; ++v) {
    Vec3 p = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      switch (below(5)) {
        case 0:
          p[i] = std::round(real(-20, 20));
          break;
        case 1:
          p[i] = real(-1, 1);
          p[i] = std::ldexp(p[i], -static_cast<int>(below(60)));
          break;
        default:
          p[i] = real(-1, 1) * scale;
      }
      if (traits.float_positions) p[i] = static_cast<double>(static_cast<float>(p[i]));
      p[i] += 0.0;
    }
    mesh.positions.push_back(p);
  }
  for (std::uint32_t v = 0; v < vertices; v += 3) {
    mesh.triangles.push_back({v % vertices, (v + 1) % vertices, (v + 2) % vertices});
  }
  for (std::uint32_t t = below(80); t > 0; --t) {
    const std::uint32_t a = below(vertices), b = (a + 1 + below(vertices - 2)) % vertices;
    std::uint32_t c = below(vertices);
    while (c == a || c == b) c = (c + 1) % vertices;
    mesh.triangles.push_back({a, b, c});
  }
  if (traits.elements) {
    const std::uint32_t elements = 1 + below(5);
    for (std::uint32_t e = 0; e < elements; ++e) {
      const std::string number = std::to_string(e);
      MeshElement element;
      element.name = "S" + number + (below(2) == 0 ? ".side" : ".top face");
      if (below(4) != 0) element.solid = "S" + std::to_string(below(3));
      if (traits.colors && below(2) == 0) {
        element.color = {
            {static_cast<std::uint8_t>(below(256)), static_cast<std::uint8_t>(below(256)),
             static_cast<std::uint8_t>(below(256)), static_cast<std::uint8_t>(below(256))}};
      }
      mesh.elements.push_back(std::move(element));
    }
    // Every element has a triangle, in order of first appearance: formats number them as they come.
    if (mesh.triangles.size() < elements) mesh.elements.resize(mesh.triangles.size());
    const auto count = static_cast<std::uint32_t>(mesh.elements.size());
    if (count > 1) {
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        mesh.triangle_element.push_back(t < count ? t : below(count));
      }
    }
  }
  if (traits.normals) {
    for (std::size_t n = 3 + below(20); n > 0; --n) {
      // One after the other: arguments are evaluated in any order.
      Vec3 normal = Vec3::Zero();
      normal.x() = real(-1, 1);
      normal.y() = real(-1, 1);
      normal.z() = real(0.1, 1);
      mesh.normals.push_back(normal.normalized());
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto count = mesh.normals.size();
      mesh.corner_normals.push_back({below(count), below(count), below(count)});
    }
  }
  if (traits.vertex_colors) {
    for (std::uint32_t v = 0; v < vertices; ++v) {
      mesh.vertex_colors.push_back({static_cast<std::uint8_t>(below(256)),
                                    static_cast<std::uint8_t>(below(256)),
                                    static_cast<std::uint8_t>(below(256)), 255});
    }
  }
  if (traits.curves) {
    for (std::uint32_t c = below(4); c > 0; --c) {
      MeshCurve curve;
      curve.kind = static_cast<CurveKind>(below(4));
      curve.closed = below(2) == 0;
      const std::uint32_t first = below(vertices), length = curve.closed ? 3 : 2;
      for (std::uint32_t i = 0; i < length; ++i) curve.vertices.push_back((first + i) % vertices);
      if (mesh.elements.size() > 1 && below(3) != 0) curve.between = {0, 1};
      if (below(3) == 0) curve.name = "rim " + std::to_string(c);
      mesh.curves.push_back(std::move(curve));
    }
  }
  if (traits.marks) {
    mesh.name = "fig" + std::to_string(seed);
    mesh.unit = static_cast<LengthUnit>(below(5));
    mesh.up = static_cast<UpAxis>(below(3));
  }
  return mesh;
}

}  // namespace diesink::testing
