// The plain exchange struct between the tessellator, the mesh readers and the mesh writers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/units.h"
#include "core/vec.h"

namespace diesink {

// A named group of triangles: a surface element such as "S2.side", "S2.wall", "B", "skirt", "floor",
// or a group, object or solid of somebody's file.
struct MeshElement {
  std::string name;                                  // unique within the mesh; may be empty in read files
  std::string solid;                                 // "S2", "B"; the material's name
  std::optional<std::array<std::uint8_t, 4>> color;  // RGBA
};

enum class CurveKind : std::uint8_t { kCrease, kEdge, kJump, kOther };

// A polyline over mesh vertices: where two surface elements meet (crease), where the surface ends (edge),
// or one side of a wall (jump).
struct MeshCurve {
  CurveKind kind = CurveKind::kOther;
  std::array<std::uint32_t, 2> between{kNoElement, kNoElement};  // indices into elements
  std::vector<std::uint32_t> vertices;                           // indices into positions; closed repeats none
  bool closed = false;
  std::string name;

  static constexpr std::uint32_t kNoElement = 0xFFFFFFFFu;
};

// Units: `unit`, Z up unless `up` says otherwise.
// Shape: triangles index positions, anticlockwise seen from outside (from above for an open sheet).
//        triangle_element is empty (everything in elements[0], or nothing named) or one entry a triangle.
//        normals is empty, or holds unit vectors that corner_normals indexes, three a triangle: corners of
//        one vertex share a normal index exactly where the surface is smooth across it.
//        Positions are shared between triangles that meet; equal positions at two indices are a topological split.
struct TriangleMesh {
  std::vector<Vec3> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> triangle_element;
  std::vector<MeshElement> elements;
  std::vector<Vec3> normals;
  std::vector<std::array<std::uint32_t, 3>> corner_normals;
  std::vector<std::array<std::uint8_t, 4>> vertex_colors;  // empty or one a vertex (RGBA)
  std::vector<MeshCurve> curves;
  std::string name;  // of the part program or the file's own title
  LengthUnit unit = LengthUnit::kUnknown;
  UpAxis up = UpAxis::kUnknown;
};

}  // namespace diesink
