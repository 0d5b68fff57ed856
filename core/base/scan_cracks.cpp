// SPDX-License-Identifier: Apache-2.0
#include "core/base/scan_cracks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
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
  const WeldMap one = weld_map(mesh.positions);
  std::size_t whole = 0;
  for (const auto& t : mesh.triangles) {
    const std::array<std::uint32_t, 3> c{one.of_vertex[t[0]], one.of_vertex[t[1]],
                                         one.of_vertex[t[2]]};
    if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) mesh.triangles[whole++] = c;
  }
  mesh.triangles.resize(whole);
  std::vector<Vec3> kept;
  kept.reserve(one.kept.size());
  for (const std::uint32_t v : one.kept) kept.push_back(mesh.positions[v]);
  mesh.positions = std::move(kept);
  return moved;
}

}  // namespace

std::optional<ClosedScan> close_cracks(const ScannedSurface& scan, const PlanBox& domain,
                                       double width, double loose_width) {
  const WeldMap same = weld_map(scan.positions());
  ClosedScan closed;
  TriangleMesh& mesh = closed.mesh;
  mesh.positions.reserve(same.kept.size());
  for (const std::uint32_t v : same.kept) mesh.positions.push_back(scan.positions()[v]);
  mesh.triangles.reserve(scan.triangles().size());
  for (const auto& t : scan.triangles())
    mesh.triangles.push_back({same.of_vertex[t[0]], same.of_vertex[t[1]], same.of_vertex[t[2]]});
  bool loose = false, still = false;
  closed.moved = close(mesh, domain, width, loose);
  if (loose) closed.moved += close(mesh, domain, loose_width, still);
  if (closed.moved == 0) return std::nullopt;
  return closed;
}

}  // namespace diesink
