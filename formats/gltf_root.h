// The root node between a part program's coordinates and glTF's metres with Y up.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "core/mesh.h"

namespace diesink {

// Node coordinates are program coordinates less the offset; the root matrix takes them to metres, Y
// up.
struct RootFrame {
  LengthUnit unit = LengthUnit::kUnknown;
  UpAxis up = UpAxis::kUnknown;
  Vec3 offset = Vec3::Zero();  // in `unit`, in the axes of `up`
};

// A 4 x 4 matrix by columns, as in a glTF node.
using NodeMatrix = std::array<double, 16>;
inline constexpr NodeMatrix kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

// The frame for a mesh between `low` and `high`: zero offset on every axis where the mesh is not
// far from the origin (nearer than twice its largest extent), else a multiple of a power of two
// above the extent, so that subtracting it from a float is exact and the difference is a float
// again.
RootFrame frame_for(const TriangleMesh& mesh, const Vec3& low, const Vec3& high);

NodeMatrix matrix_of(const RootFrame& frame);

// The frame whose matrix this is: unit scale and Y-up rotation to 1e-6, any translation. Where
// `claimed` agrees with the matrix to 1e-6 it is returned itself, so that its offset comes back to
// the bit. Empty where the matrix is of another kind.
std::optional<RootFrame> frame_of(const NodeMatrix& matrix,
                                  const std::optional<RootFrame>& claimed);

}  // namespace diesink
