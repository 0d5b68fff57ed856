// SPDX-License-Identifier: Apache-2.0
#include "core/mesh_tools/topology.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>
#include <numeric>

#include "core/counted.h"
#include "core/mesh_tools/weld.h"
#include "core/parallel.h"

namespace diesink {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

bool is_degenerate(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

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

namespace {

struct Suspect {
  Triangle corners;  // ascending
  std::uint32_t triangle;
};

// Another hash on fewer: most that only shared a bit with a different triangle go, before the sort.
void drop_lonely(std::vector<Suspect>& suspects) {
  const std::size_t bits = std::bit_ceil(std::max<std::size_t>(16 * suspects.size(), 64));
  const auto bit_of = [bits](const Suspect& s) {
    std::uint64_t h = 0;
    for (const std::uint32_t v : s.corners) h = (h ^ v) * 0x94D049BB133111EBULL ^ h >> 31;
    return (h ^ h >> 32) & (bits - 1);
  };
  std::vector<std::uint64_t> met(bits / 64), met_again(bits / 64);
  for (const Suspect& s : suspects) {
    const std::uint64_t at = bit_of(s), bit = std::uint64_t{1} << at % 64;
    met_again[at / 64] |= met[at / 64] & bit;
    met[at / 64] |= bit;
  }
  std::erase_if(suspects, [&](const Suspect& s) {
    const std::uint64_t at = bit_of(s);
    return (met_again[at / 64] >> at % 64 & 1) == 0;
  });
}

}  // namespace

std::vector<std::uint32_t> find_duplicates(std::span<const Triangle> triangles, int threads) {
  // Every triangle sets the bit its corners' hash names; a bit met twice tells triangles worth a
  // look. That finds all duplicates, in any order of work, and few others.
  const std::size_t bits = std::bit_ceil(std::max<std::size_t>(8 * triangles.size(), 64));
  using Word = std::atomic<std::uint64_t>;
  std::vector<Word> met(bits / 64), met_again(bits / 64);
  const auto sorted = [](Triangle t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  const auto bit_of = [bits](const Triangle& t) {
    // Sums and products do not ask for the corners' order.
    std::uint64_t h = 0;
    for (const std::uint32_t v : t) {
      const std::uint64_t mixed = (v + std::uint64_t{1}) * 0x9E3779B97F4A7C15ULL;
      h += (mixed ^ mixed >> 29) * 0xBF58476D1CE4E5B9ULL;
    }
    return (h ^ h >> 32) & (bits - 1);
  };
  constexpr std::size_t kBlock = std::size_t{1} << 15, kBatch = 64;
  // take(block, triangle, bit) for all triangles, many at once, which hides the memory's latency.
  const auto for_bits = [&](const std::vector<Word>& words, const auto& take) {
    parallel_blocks(triangles.size(), kBlock, threads,
                    [&](std::size_t begin, std::size_t end, int) {
                      std::array<std::uint64_t, kBatch> at;
                      for (std::size_t first = begin; first < end; first += kBatch) {
                        const std::size_t count = std::min(end - first, kBatch);
                        for (std::size_t i = 0; i < count; ++i) {
                          at[i] = bit_of(triangles[first + i]);
                          __builtin_prefetch(&words[at[i] / 64]);
                        }
                        for (std::size_t i = 0; i < count; ++i)
                          take(begin / kBlock, first + i, at[i]);
                      }
                    });
  };
  for_bits(met, [&](std::size_t, std::size_t, std::uint64_t at) {
    const std::uint64_t bit = std::uint64_t{1} << at % 64;
    const std::uint64_t before = met[at / 64].fetch_or(bit, std::memory_order_relaxed);
    if ((before & bit) != 0) met_again[at / 64].fetch_or(bit, std::memory_order_relaxed);
  });
  std::vector<std::vector<Suspect>> found((triangles.size() + kBlock - 1) / kBlock);
  for_bits(met_again, [&](std::size_t block, std::size_t t, std::uint64_t at) {
    if ((met_again[at / 64].load(std::memory_order_relaxed) >> at % 64 & 1) == 0) return;
    found[block].push_back({sorted(triangles[t]), static_cast<std::uint32_t>(t)});
  });
  std::vector<Suspect> suspects;
  for (std::vector<Suspect>& each : found) {
    suspects.insert(suspects.end(), each.begin(), each.end());
    each = {};
  }
  drop_lonely(suspects);
  std::sort(suspects.begin(), suspects.end(), [](const Suspect& a, const Suspect& b) {
    return a.corners != b.corners ? a.corners < b.corners : a.triangle < b.triangle;
  });
  std::vector<std::uint32_t> again;
  for (std::size_t i = 1; i < suspects.size(); ++i) {
    if (suspects[i].corners == suspects[i - 1].corners) again.push_back(suspects[i].triangle);
  }
  std::sort(again.begin(), again.end());
  return again;
}

OddFaces odd_faces(const TriangleMesh& mesh, bool welded, int threads) {
  constexpr std::size_t kBlock = std::size_t{1} << 15;
  std::atomic<std::size_t> degenerate{0};
  {
    const ProgressSpan span(0, 0.3);
    parallel_blocks(mesh.triangles.size(), kBlock, threads,
                    [&](std::size_t begin, std::size_t end, int) {
                      std::size_t count = 0;
                      for (std::size_t i = begin; i < end; ++i) {
                        const Triangle& t = mesh.triangles[i];
                        bool same = is_degenerate(t);
                        if (!welded && !same) {
                          const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]],
                                     &c = mesh.positions[t[2]];
                          same = a == b || b == c || c == a;
                        }
                        count += same ? 1 : 0;
                      }
                      degenerate += count;
                    });
  }
  const ProgressSpan span(0.3, 1);
  return {degenerate, find_duplicates(mesh.triangles, threads).size()};
}

std::size_t vertices_alone(const TriangleMesh& mesh) {
  std::vector<bool> used(mesh.positions.size());
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) used[vertex] = true;
  }
  for (const MeshCurve& curve : mesh.curves) {
    for (const std::uint32_t vertex : curve.vertices) used[vertex] = true;
  }
  return static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
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
  {
    const ProgressSpan span(0.05, 0.5);
    topology.duplicates = find_duplicates(triangles).size();
  }
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
                counted(topology.boundary_edges, "boundary edge|boundary edges| in ") +
                    counted(topology.boundary_loops, "loop|loops|"));
  }
  if (topology.nonmanifold_edges > 0) {
    join_reason(topology.why_not,
                counted(topology.nonmanifold_edges, "edge|edges| of more than two triangles"));
  }
  if (topology.misoriented_edges > 0) {
    join_reason(topology.why_not, counted(topology.misoriented_edges,
                                          "edge|edges| between triangles that turn opposite ways"));
  }
  topology.watertight = topology.why_not.empty();
  return topology;
}

}  // namespace diesink
