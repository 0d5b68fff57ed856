// SPDX-License-Identifier: Apache-2.0
#include "core/mesh_tools/topology.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

#include "core/mesh_tools/weld.h"
#include "core/parallel.h"

namespace diesink {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

bool is_degenerate(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

std::string counted(std::size_t count, std::string_view one, std::string_view many) {
  return std::to_string(count) + " " + std::string(count == 1 ? one : many);
}

void join_reason(std::string& text, std::string reason) {
  if (!text.empty()) text += ", ";
  text += reason;
}

void measure(const TriangleMesh& mesh, MeshTopology& topology) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  const auto see = [&](std::uint32_t v) {
    low = low.cwiseMin(mesh.positions[v]);
    high = high.cwiseMax(mesh.positions[v]);
  };
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) see(v);
  }
  for (const MeshCurve& curve : mesh.curves) {
    for (const std::uint32_t v : curve.vertices) see(v);
    if (curve.vertices.size() > 1) topology.lines += curve.vertices.size() - (curve.closed ? 0 : 1);
  }
  if (low.x() > high.x()) return;
  topology.bounds = {low, high};
  // About the middle: far from the origin the tetrahedra's volumes would drown the difference.
  const Vec3 middle = 0.5 * (low + high);
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.positions[t[0]] - middle, b = mesh.positions[t[1]] - middle,
               c = mesh.positions[t[2]] - middle;
    const double twice = (b - a).cross(c - a).norm();
    topology.area += twice / 2;
    topology.volume += a.dot(b.cross(c)) / 6;
    if (twice == 0) ++topology.flat;
  }
}

}  // namespace

DisjointSets::DisjointSets(std::size_t count) : parent_(count) {
  std::iota(parent_.begin(), parent_.end(), 0U);
}

std::uint32_t DisjointSets::find(std::uint32_t member) {
  while (parent_[member] != member) {
    parent_[member] = parent_[parent_[member]];
    member = parent_[member];
  }
  return member;
}

void DisjointSets::join(std::uint32_t a, std::uint32_t b) {
  a = find(a);
  b = find(b);
  if (a < b) parent_[b] = a;
  if (b < a) parent_[a] = b;
}

std::vector<EdgeUse> edge_uses(std::span<const Triangle> triangles, std::size_t vertices) {
  // Bucket by the low vertex, then order each small bucket.
  std::vector<std::size_t> first(vertices + 1, 0);
  const auto for_each_side = [&](auto see) {
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      if (is_degenerate(triangles[t])) continue;
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
        see(EdgeUse{std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(3 * t + k), a < b});
      }
    }
  };
  for_each_side([&](const EdgeUse& use) { ++first[use.low + 1]; });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<EdgeUse> uses(first.back());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for_each_side([&](const EdgeUse& use) { uses[next[use.low]++] = use; });
  for (std::size_t v = 0; v < vertices; ++v) {
    std::sort(uses.begin() + static_cast<std::ptrdiff_t>(first[v]),
              uses.begin() + static_cast<std::ptrdiff_t>(first[v + 1]),
              [](const EdgeUse& a, const EdgeUse& b) {
                return a.high != b.high ? a.high < b.high : a.corner < b.corner;
              });
  }
  return uses;
}

std::vector<bool> find_duplicates(std::span<const Triangle> triangles, std::size_t vertices) {
  struct Key {
    std::uint32_t middle, high, triangle;
  };
  std::vector<std::size_t> first(vertices + 1, 0);
  for (const Triangle& t : triangles) ++first[std::min({t[0], t[1], t[2]}) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Key> keys(triangles.size());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    Triangle t = triangles[i];
    std::sort(t.begin(), t.end());
    keys[next[t[0]]++] = {t[1], t[2], static_cast<std::uint32_t>(i)};
  }
  std::vector<bool> again(triangles.size(), false);
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto begin = keys.begin() + static_cast<std::ptrdiff_t>(first[v]);
    const auto end = keys.begin() + static_cast<std::ptrdiff_t>(first[v + 1]);
    if (end - begin < 2) continue;
    std::sort(begin, end, [](const Key& a, const Key& b) {
      if (a.middle != b.middle) return a.middle < b.middle;
      return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
    });
    for (auto key = begin + 1; key < end; ++key) {
      if (key->middle == key[-1].middle && key->high == key[-1].high) again[key->triangle] = true;
    }
  }
  return again;
}

OddFaces odd_faces(const TriangleMesh& mesh) {
  OddFaces odd;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    if (a == b || b == c || c == a) ++odd.degenerate;
  }
  tell_progress(0.3);
  const std::vector<bool> again = find_duplicates(mesh.triangles, mesh.positions.size());
  odd.duplicates = static_cast<std::size_t>(std::count(again.begin(), again.end(), true));
  return odd;
}

MeshTopology topology_of(const TriangleMesh& mesh, bool as_shared) {
  MeshTopology topology;
  topology.triangles = mesh.triangles.size();
  measure(mesh, topology);
  tell_progress(0.05);

  std::vector<Triangle> triangles = mesh.triangles;
  topology.vertices = mesh.positions.size();
  if (!as_shared) {
    const WeldMap map = weld_map(mesh.positions);
    topology.vertices = map.kept.size();
    for (Triangle& t : triangles) {
      for (std::uint32_t& v : t) v = map.of_vertex[v];
    }
  }
  topology.degenerate =
      static_cast<std::size_t>(std::count_if(triangles.begin(), triangles.end(), is_degenerate));
  topology.flat -= topology.degenerate;
  const std::vector<bool> again = find_duplicates(triangles, topology.vertices);
  topology.duplicates = static_cast<std::size_t>(std::count(again.begin(), again.end(), true));

  tell_progress(0.5);
  const std::vector<EdgeUse> uses = edge_uses(triangles, topology.vertices);
  tell_progress(0.75);
  DisjointSets shells(triangles.size());
  DisjointSets fans(3 * triangles.size());  // corners of one vertex that hang together
  std::vector<bool> on_bad_edge(topology.vertices, false);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    ++topology.edges;
    for (const EdgeUse& use : edge.subspan(1)) shells.join(use.corner / 3, edge[0].corner / 3);
    if (edge.size() == 1) {
      ++topology.boundary_edges;
    } else if (edge.size() > 2) {
      ++topology.nonmanifold_edges;
      on_bad_edge[edge[0].low] = on_bad_edge[edge[0].high] = true;
    } else {
      if (edge[0].forward == edge[1].forward) ++topology.misoriented_edges;
      fans.join(corner_at_low(edge[0]), corner_at_low(edge[1]));
      fans.join(corner_at_high(edge[0]), corner_at_high(edge[1]));
    }
  });

  std::vector<std::uint8_t> fans_at(topology.vertices, 0);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (is_degenerate(triangles[t])) continue;
    if (shells.find(t) == t) ++topology.shells;
    for (std::uint32_t k = 0; k < 3; ++k) {
      std::uint8_t& count = fans_at[triangles[t][k]];
      if (fans.find(3 * t + k) == 3 * t + k && count < 2) ++count;
    }
  }
  for (std::size_t v = 0; v < topology.vertices; ++v) {
    if (fans_at[v] > 1 && !on_bad_edge[v]) ++topology.nonmanifold_vertices;
  }

  // A boundary runs on through the fan at its edges' ends.
  std::vector<std::uint32_t> ends;
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 1) return;
    ends.push_back(fans.find(corner_at_low(edge[0])));
    ends.push_back(fans.find(corner_at_high(edge[0])));
  });
  for (std::size_t i = 0; i < ends.size(); i += 2) fans.join(ends[i], ends[i + 1]);
  for (std::uint32_t& end : ends) end = fans.find(end);
  std::sort(ends.begin(), ends.end());
  topology.boundary_loops =
      static_cast<std::size_t>(std::unique(ends.begin(), ends.end()) - ends.begin());

  if (topology.edges == 0) join_reason(topology.why_not, "it has no triangles");
  if (topology.boundary_edges > 0) {
    join_reason(topology.why_not,
                counted(topology.boundary_edges, "boundary edge", "boundary edges") + " in " +
                    counted(topology.boundary_loops, "loop", "loops"));
  }
  if (topology.nonmanifold_edges > 0) {
    join_reason(topology.why_not, counted(topology.nonmanifold_edges, "edge", "edges") +
                                      " of more than two triangles");
  }
  if (topology.misoriented_edges > 0) {
    join_reason(topology.why_not, counted(topology.misoriented_edges, "edge", "edges") +
                                      " between triangles that turn opposite ways");
  }
  topology.watertight = topology.why_not.empty();
  return topology;
}

}  // namespace diesink
