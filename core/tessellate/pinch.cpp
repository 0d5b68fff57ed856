// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/pinch.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace diesink {

PinchedNodes::PinchedNodes(const Arrangement& arrangement) {
  std::unordered_map<std::uint32_t, int> ends;
  for (const PlanArc& arc : arrangement.arcs) {
    if (arc.closed) continue;
    ++ends[arc.nodes.front()];
    ++ends[arc.nodes.back()];
  }
  for (const auto& [node, count] : ends) {
    if (count >= 4) around_.try_emplace(node);
  }
  if (around_.empty()) return;
  for (const PlanRegion& region : arrangement.regions) {
    for (const std::vector<ArcUse>& loop : region.loops) {
      for (std::size_t k = 0; k < loop.size(); ++k) {
        const ArcUse &in = loop[k], &out = loop[(k + 1) % loop.size()];
        const PlanArc& arc = arrangement.arcs[in.arc];
        if (arc.closed) continue;
        const auto found = around_.find(in.forward ? arc.nodes.back() : arc.nodes.front());
        if (found == around_.end()) continue;
        Around& around = found->second;
        const int sector = static_cast<int>(around.sectors.size());
        around.sectors.push_back(region.label);
        for (const ArcEnd& end : {ArcEnd{in.arc, in.forward}, ArcEnd{out.arc, !out.forward}}) {
          auto spoke = std::find_if(around.spokes.begin(), around.spokes.end(),
                                    [&](const Spoke& s) { return s.end == end; });
          if (spoke == around.spokes.end()) {
            around.spokes.push_back({end, {sector, -1}});
          } else {
            spoke->sectors[1] = sector;
          }
        }
      }
    }
  }
}

PinchedNodes::Wedge PinchedNodes::wedge_of(std::uint32_t node, const ArcEnd& end, double top,
                                           const std::function<double(Label)>& height) const {
  const Around& around = around_.at(node);
  const std::size_t n = around.sectors.size();
  std::vector<std::size_t> root(n);
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t k) {
    while (root[k] != k) k = root[k];
    return k;
  };
  const auto material = [&](int sector) {
    return sector >= 0 && height(around.sectors[static_cast<std::size_t>(sector)]) >= top;
  };
  for (const Spoke& s : around.spokes) {
    if (material(s.sectors[0]) && material(s.sectors[1]))
      root[find(static_cast<std::size_t>(s.sectors[0]))] =
          find(static_cast<std::size_t>(s.sectors[1]));
  }
  std::vector<std::size_t> wedges;
  Wedge result;
  for (const Spoke& s : around.spokes) {
    const bool first = material(s.sectors[0]), second = material(s.sectors[1]);
    if (first == second) continue;
    const std::size_t wedge = find(static_cast<std::size_t>(s.sectors[first ? 0 : 1]));
    auto at = std::find(wedges.begin(), wedges.end(), wedge);
    if (at == wedges.end()) at = wedges.insert(wedges.end(), wedge);
    if (s.end == end) result.number = static_cast<int>(at - wedges.begin());
  }
  result.wedges = std::max(1, static_cast<int>(wedges.size()));
  return result;
}

void split_fans(TriangleMesh& mesh, const std::vector<std::uint32_t>& vertices) {
  if (vertices.empty()) return;
  std::vector<char> marked(mesh.positions.size(), 0);
  for (const std::uint32_t v : vertices) marked[v] = 1;
  // Corners of the marked vertices: the vertices before and behind in their triangle.
  struct Corner {
    std::uint32_t vertex, triangle, k, next, previous;
  };
  std::vector<Corner> corners;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (marked[v[k]]) corners.push_back({v[k], t, k, v[(k + 1) % 3], v[(k + 2) % 3]});
    }
  }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.vertex < b.vertex; });
  std::vector<std::array<std::uint32_t, 4>> moved;  // a vertex, the two beside it, its copy
  for (std::size_t begin = 0; begin < corners.size();) {
    std::size_t end = begin;
    while (end < corners.size() && corners[end].vertex == corners[begin].vertex) ++end;
    // Numbers of fans; corners that share a side have the same.
    std::vector<std::size_t> fan(end - begin);
    std::iota(fan.begin(), fan.end(), std::size_t{0});
    const auto find = [&](std::size_t k) {
      while (fan[k] != k) k = fan[k];
      return k;
    };
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = begin; j < end; ++j) {
        if (i == j || corners[i].next != corners[j].previous) continue;
        const std::size_t a = find(i - begin), b = find(j - begin);
        fan[std::max(a, b)] = std::min(a, b);
      }
    }
    std::vector<std::pair<std::size_t, std::uint32_t>> copies;  // fan, its vertex
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t f = find(i - begin);
      if (f == 0) continue;  // the first keeps the vertex
      auto copy =
          std::find_if(copies.begin(), copies.end(), [&](const auto& c) { return c.first == f; });
      if (copy == copies.end()) {
        copies.emplace_back(f, static_cast<std::uint32_t>(mesh.positions.size()));
        const Vec3 p = mesh.positions[corners[i].vertex];
        mesh.positions.push_back(p);
        copy = copies.end() - 1;
      }
      mesh.triangles[corners[i].triangle][corners[i].k] = copy->second;
      moved.push_back({corners[i].vertex, corners[i].next, corners[i].previous, copy->second});
    }
    begin = end;
  }
  // Curves end at the vertex of the fan that they run along.
  for (MeshCurve& curve : mesh.curves) {
    const std::vector<std::uint32_t> old = curve.vertices;
    for (std::size_t k = 0; k < old.size() && old.size() > 1; ++k) {
      if (old[k] >= marked.size() || !marked[old[k]]) continue;
      const std::uint32_t beside = old[k > 0 ? k - 1 : 1];
      for (const auto& m : moved) {
        if (m[0] == old[k] && (m[1] == beside || m[2] == beside)) curve.vertices[k] = m[3];
      }
    }
  }
}

}  // namespace diesink
