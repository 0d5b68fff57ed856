// SPDX-License-Identifier: Apache-2.0
#include "core/base/scan_cracks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh_tools/topology.h"
#include "core/mesh_tools/weld.h"

namespace diesink {
namespace {

// Makes vertices of open edges one: of those that one facet alone has. Returns how far one has
// moved at most; `loose` tells whether most facets shared no edge with another.
double close(TriangleMesh& mesh, const PlanBox& domain, double width, bool& loose) {
  std::vector<std::uint32_t> border;
  std::vector<char> open(mesh.triangles.size(), 0);  // edges of each
  const std::vector<EdgeUse> uses = edge_uses(mesh.triangles, mesh.positions.size());
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 1) return;
    border.insert(border.end(), {edge[0].low, edge[0].high});
    ++open[edge[0].corner / 3];
  });
  loose = 2 * std::ranges::count(open, 3) > static_cast<std::ptrdiff_t>(open.size());
  std::sort(border.begin(), border.end());
  border.erase(std::unique(border.begin(), border.end()), border.end());
  std::vector<Vec3> places;
  places.reserve(border.size());
  for (const std::uint32_t v : border) places.push_back(mesh.positions[v]);
  const WeldMap near = weld_map(places, width);
  const auto onto = [&](double& at, double side) {
    if (std::fabs(at - side) <= width) at = side;
  };
  double moved = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    Vec3 p = places[near.kept[near.of_vertex[k]]];
    for (const double side : {domain.x0, domain.x1}) onto(p.x(), side);
    for (const double side : {domain.y0, domain.y1}) onto(p.y(), side);
    mesh.positions[border[k]] = p;
    moved = std::fmax(moved, (p - places[k]).norm());
  }
  if (moved == 0) return 0;
  weld(mesh);
  std::erase_if(mesh.triangles,
                [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  return moved;
}

}  // namespace

std::optional<ClosedScan> close_cracks(const ScannedSurface& scan, const PlanBox& domain,
                                       double width, double loose_width) {
  ClosedScan closed;
  TriangleMesh& mesh = closed.mesh;
  mesh.positions.assign(scan.positions().begin(), scan.positions().end());
  mesh.triangles.assign(scan.triangles().begin(), scan.triangles().end());
  weld(mesh);
  bool loose = false, still = false;
  closed.moved = close(mesh, domain, width, loose);
  if (loose) closed.moved += close(mesh, domain, loose_width, still);
  if (closed.moved == 0) return std::nullopt;
  return closed;
}

}  // namespace diesink
