// SPDX-License-Identifier: Apache-2.0
#include "core/base/scan_cracks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh_tools/topology.h"
#include "core/mesh_tools/weld.h"

namespace diesink {

std::optional<ClosedScan> close_cracks(const ScannedSurface& scan, const PlanBox& domain,
                                       double width) {
  const std::vector<Vec3>& positions = scan.positions();
  const WeldMap same = weld_map(positions);
  TriangleMesh mesh;
  for (const std::uint32_t v : same.kept) mesh.positions.push_back(positions[v]);
  for (const auto& t : scan.triangles())
    mesh.triangles.push_back({same.of_vertex[t[0]], same.of_vertex[t[1]], same.of_vertex[t[2]]});
  std::vector<std::uint32_t> border;
  const std::vector<EdgeUse> uses = edge_uses(mesh.triangles, mesh.positions.size());
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (edge.size() == 1) border.insert(border.end(), {edge[0].low, edge[0].high});
  });
  std::sort(border.begin(), border.end());
  border.erase(std::unique(border.begin(), border.end()), border.end());
  std::vector<Vec3> places;
  places.reserve(border.size());
  for (const std::uint32_t v : border) places.push_back(mesh.positions[v]);
  const WeldMap near = weld_map(places, width);
  const auto onto = [&](double& at, double side) {
    if (std::fabs(at - side) <= width) at = side;
  };
  const auto moved_to = [&](std::size_t k) {
    Vec3 p = places[near.kept[near.of_vertex[k]]];
    for (const double side : {domain.x0, domain.x1}) onto(p.x(), side);
    for (const double side : {domain.y0, domain.y1}) onto(p.y(), side);
    return p;
  };
  ClosedScan closed;
  for (std::size_t k = 0; k < places.size(); ++k) {
    mesh.positions[border[k]] = moved_to(k);
    closed.moved = std::fmax(closed.moved, (mesh.positions[border[k]] - places[k]).norm());
  }
  if (closed.moved == 0) return std::nullopt;
  const WeldMap one = weld_map(mesh.positions);
  std::size_t whole = 0;
  for (const auto& t : mesh.triangles) {
    const std::array<std::uint32_t, 3> c{one.of_vertex[t[0]], one.of_vertex[t[1]],
                                         one.of_vertex[t[2]]};
    if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) mesh.triangles[whole++] = c;
  }
  mesh.triangles.resize(whole);
  std::vector<Vec3> kept;
  for (const std::uint32_t v : one.kept) kept.push_back(mesh.positions[v]);
  mesh.positions = std::move(kept);
  closed.mesh = std::move(mesh);
  return closed;
}

}  // namespace diesink
