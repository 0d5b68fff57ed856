// A mesh as lines of text that do not depend on how vertices are numbered or triangles ordered.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace diesink::testing {

// What of a mesh is compared.
struct Compared {
  bool names = true, solids = true, colors = true, normals = true, vertex_colors = true,
       curves = true, marks = true;
  bool as_float = false;          // positions rounded to float
  bool normals_as_float = false;  // normals too
  bool five_bits = false;         // element colours rounded to five bits, without alpha
  bool opaque = false;            // vertex colours without alpha
};

inline Compared both(const Compared& a, const Compared& b) {
  return {a.names && b.names,
          a.solids && b.solids,
          a.colors && b.colors,
          a.normals && b.normals,
          a.vertex_colors && b.vertex_colors,
          a.curves && b.curves,
          a.marks && b.marks,
          a.as_float || b.as_float,
          a.normals_as_float || b.normals_as_float,
          a.five_bits || b.five_bits,
          a.opaque || b.opaque};
}

// One line a triangle, curve and mark, sorted. Every number to the bit.
inline std::vector<std::string> signature(const TriangleMesh& mesh, const Compared& compared) {
  const auto exact = [&](const Vec3& v, bool position) {
    char text[128];
    Vec3 p = v;
    const bool rounded = position ? compared.as_float : compared.normals_as_float;
    for (int i = 0; i < 3 && rounded; ++i) {
      p[i] = static_cast<double>(static_cast<float>(p[i]));
    }
    std::snprintf(text, sizeof text, "(%a %a %a)", p.x() + 0.0, p.y() + 0.0, p.z() + 0.0);
    return std::string(text);
  };
  const auto color = [](const std::array<std::uint8_t, 4>& c) {
    char text[16];
    std::snprintf(text, sizeof text, "#%02x%02x%02x%02x", c[0], c[1], c[2], c[3]);
    return std::string(text);
  };
  std::vector<std::string> lines;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::string line;
    const std::size_t e = mesh.triangle_element.empty() ? 0 : mesh.triangle_element[t];
    if (e < mesh.elements.size()) {
      const MeshElement& element = mesh.elements[e];
      if (compared.names) line += element.name + " ";
      if (compared.solids) line += "of " + element.solid + " ";
      if (compared.colors && element.color) {
        std::array<std::uint8_t, 4> c = *element.color;
        for (std::uint8_t& part : c) {
          if (compared.five_bits) part = static_cast<std::uint8_t>((part * 31 + 127) / 255);
        }
        if (compared.five_bits) c[3] = 255;
        line += color(c) + " ";
      }
    }
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t v = mesh.triangles[t][corner];
      line += exact(mesh.positions[v], true);
      if (compared.normals && !mesh.corner_normals.empty()) {
        line += "n" + exact(mesh.normals[mesh.corner_normals[t][corner]], false);
      }
      if (compared.vertex_colors && !mesh.vertex_colors.empty()) {
        std::array<std::uint8_t, 4> c = mesh.vertex_colors[v];
        if (compared.opaque) c[3] = 255;
        line += color(c);
      }
    }
    lines.push_back(std::move(line));
  }
  if (compared.curves) {
    for (const MeshCurve& curve : mesh.curves) {
      std::string line =
          "curve " + std::to_string(static_cast<int>(curve.kind)) + (curve.closed ? " closed" : "");
      for (const std::uint32_t e : curve.between) {
        line += " " + (e < mesh.elements.size() ? mesh.elements[e].name : std::string("-"));
      }
      line += " " + curve.name;
      for (const std::uint32_t v : curve.vertices) line += exact(mesh.positions[v], true);
      lines.push_back(std::move(line));
    }
  }
  if (compared.marks) {
    lines.push_back("name " + mesh.name + " unit " + std::string(name_of(mesh.unit)) + " up " +
                    std::to_string(static_cast<int>(mesh.up)));
  }
  std::sort(lines.begin(), lines.end());
  return lines;
}

// The first line of either that the other does not have, for a message; empty where they are the
// same.
inline std::string difference(const std::vector<std::string>& a,
                              const std::vector<std::string>& b) {
  for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    const std::string left = i < a.size() ? a[i] : "(nothing)",
                      right = i < b.size() ? b[i] : "(nothing)";
    if (left != right) return left + "\n  against\n" + right;
  }
  return {};
}

}  // namespace diesink::testing
