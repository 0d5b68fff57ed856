// SPDX-License-Identifier: Apache-2.0
#include "formats/ply_curves.h"

#include <utility>

#include "formats/element_runs.h"

namespace diesink {

bool make_ply_curves(std::span<const PlyEdge> edges, std::span<const std::string_view> labels,
                     TriangleMesh& mesh) {
  std::int64_t current = -2;
  for (const PlyEdge& edge : edges) {
    if (edge.a >= mesh.positions.size() || edge.b >= mesh.positions.size()) return false;
    const bool goes_on = !mesh.curves.empty() && edge.curve == current &&
                         !mesh.curves.back().closed && mesh.curves.back().vertices.back() == edge.a;
    if (!goes_on) {
      MeshCurve curve;
      if (edge.curve >= 0 && edge.curve < static_cast<std::int64_t>(labels.size())) {
        read_curve_label(labels[static_cast<std::size_t>(edge.curve)], mesh, curve);
      }
      curve.vertices.push_back(edge.a);
      mesh.curves.push_back(std::move(curve));
      current = edge.curve;
    }
    MeshCurve& curve = mesh.curves.back();
    if (edge.b == curve.vertices.front() && curve.vertices.size() > 1) {
      curve.closed = true;
    } else {
      curve.vertices.push_back(edge.b);
    }
  }
  return true;
}

}  // namespace diesink
