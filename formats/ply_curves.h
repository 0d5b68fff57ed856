// The edges of a PLY file as curves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/mesh.h"

namespace diesink {

struct PlyEdge {
  std::uint32_t a, b;
  std::int64_t curve;  // the number of its label, negative without
};

// Appends the curves to `mesh`: edges that follow each other, with one label, make one. Labels are
// those of curve_label(). Errors: false where an edge's vertex is not there.
bool make_ply_curves(std::span<const PlyEdge> edges, std::span<const std::string_view> labels,
                     TriangleMesh& mesh);

}  // namespace diesink
