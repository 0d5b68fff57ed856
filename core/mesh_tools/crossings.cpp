// SPDX-License-Identifier: Apache-2.0
//
// A tree of boxes gives the pairs whose boxes meet; filters in doubles part most of them; signs of
// exact determinants decide the rest.
#include "core/mesh_tools/crossings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "core/base/exact_plan.h"
#include "core/mesh_tools/exact_space.h"
#include "core/mesh_tools/weld.h"
#include "core/parallel.h"

namespace diesink {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Corners = std::array<Vec3, 3>;

int turn_along(int axis, const Vec3& a, const Vec3& b, const Vec3& c) {
  const int x = (axis + 1) % 3, y = (axis + 2) % 3;
  return turn(a[x], a[y], b[x], b[y], c[x], c[y]);
}

// The axis along which the triangle can be looked at; -1 where it has no area.
int axis_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int axis = 2; axis >= 0; --axis) {
    if (turn_along(axis, a, b, c) != 0) return axis;
  }
  return -1;
}

// Whether two segments of a plane meet, ends included.
bool segments_meet(int axis, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const int abc = turn_along(axis, a, b, c), abd = turn_along(axis, a, b, d);
  const int cda = turn_along(axis, c, d, a), cdb = turn_along(axis, c, d, b);
  if (abc * abd > 0 || cda * cdb > 0) return false;
  if (abc != 0 || abd != 0 || cda != 0 || cdb != 0) return true;
  // In one line: where their boxes meet.
  for (int k = 0; k < 3; ++k) {
    if (std::fmax(a[k], b[k]) < std::fmin(c[k], d[k]) ||
        std::fmax(c[k], d[k]) < std::fmin(a[k], b[k])) {
      return false;
    }
  }
  return true;
}

bool is_inside(int axis, const Corners& t, const Vec3& p) {
  const int way = turn_along(axis, t[0], t[1], t[2]);
  for (std::size_t k = 0; k < 3; ++k) {
    if (turn_along(axis, t[k], t[(k + 1) % 3], p) * way < 0) return false;
  }
  return true;
}

// Whether a segment and a triangle of some area have a point in common.
bool segment_meets(const Vec3& a, const Vec3& b, const Corners& t) {
  const int of_a = side(t[0], t[1], t[2], a), of_b = side(t[0], t[1], t[2], b);
  if (of_a * of_b > 0) return false;
  if (of_a == 0 && of_b == 0) {
    const int axis = axis_of(t[0], t[1], t[2]);
    if (is_inside(axis, t, a) || is_inside(axis, t, b)) return true;
    return segments_meet(axis, a, b, t[0], t[1]) || segments_meet(axis, a, b, t[1], t[2]) ||
           segments_meet(axis, a, b, t[2], t[0]);
  }
  // The line meets the plane once; within the triangle it passes all edges on one side.
  const int s0 = side(a, b, t[0], t[1]), s1 = side(a, b, t[1], t[2]), s2 = side(a, b, t[2], t[0]);
  return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
}

// Whether s . (p - o) is surely positive; rounding takes five parts in 2^53 of the sum at most.
bool surely_ahead(const Vec3& s, const Vec3& o, const Vec3& p) {
  const Vec3 d = p - o;
  const Vec3 parts = s.cwiseProduct(d);
  return parts.sum() > 0x1p-49 * parts.cwiseAbs().sum();
}

Vec3 direction(const Vec3& from, const Vec3& to) {
  const Vec3 d = to - from;
  const double length = d.norm();
  return length > 0 ? Vec3(d / length) : Vec3(Vec3::Zero());
}

// Two triangles without a common vertex.
bool apart_triangles_meet(const Corners& s, const Corners& t) {
  // A plane across the line between their middles often has them on either side.
  const Vec3 across = (t[0] + t[1] + t[2]) - (s[0] + s[1] + s[2]);
  const auto along = [&](const Vec3& p, const Vec3& q) { return across.dot(p) < across.dot(q); };
  const Vec3& last = *std::max_element(s.begin(), s.end(), along);
  if (std::all_of(t.begin(), t.end(),
                  [&](const Vec3& p) { return surely_ahead(across, last, p); }) &&
      std::all_of(s.begin(), s.end(),
                  [&](const Vec3& p) { return &p == &last || surely_ahead(-across, last, p); })) {
    return false;
  }
  for (const auto& [one, other] : {std::pair{&s, &t}, std::pair{&t, &s}}) {
    const Corners &p = *one, &q = *other;
    const int first = side(p[0], p[1], p[2], q[0]);
    if (first != 0 && first == side(p[0], p[1], p[2], q[1]) &&
        first == side(p[0], p[1], p[2], q[2])) {
      return false;
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (segment_meets(s[k], s[(k + 1) % 3], t) || segment_meets(t[k], t[(k + 1) % 3], s))
      return true;
  }
  return false;
}

// Two triangles o, a, b and o, c, d: what they have in common beside o goes on to one's far edge.
bool fan_meets(const Vec3& o, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 s = direction(o, a) + direction(o, b) - direction(o, c) - direction(o, d);
  if (surely_ahead(s, o, a) && surely_ahead(s, o, b) && surely_ahead(-s, o, c) &&
      surely_ahead(-s, o, d)) {
    return false;
  }
  return segment_meets(a, b, {o, c, d}) || segment_meets(c, d, {o, a, b});
}

// Two triangles with the edge p, q: one lies upon the other, or they have no more in common.
bool folded(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b) {
  const Vec3 e = q - p, u = a - p, v = b - p;
  // Across the edge they mostly go different ways: the angle between them is surely over 90
  // degrees.
  const Vec3 eu = e.cross(u), ev = e.cross(v);
  const Vec3 ea = e.cwiseAbs(), ua = u.cwiseAbs(), va = v.cwiseAbs();
  const auto most = [](const Vec3& x, const Vec3& y) {
    return Vec3(x.y() * y.z() + x.z() * y.y(), x.z() * y.x() + x.x() * y.z(),
                x.x() * y.y() + x.y() * y.x());
  };
  // Some ten roundings at each of two products of three factors: 2^-47 is more than all of them.
  if (eu.dot(ev) < -0x1p-47 * most(ea, ua).dot(most(ea, va))) return false;
  if (side(p, q, a, b) != 0) return false;
  const int axis = axis_of(p, q, a);
  return turn_along(axis, p, q, a) * turn_along(axis, p, q, b) > 0;
}

struct Box {
  Vec3 low, high;
};

bool meet(const Box& a, const Box& b) {
  return a.low.x() <= b.high.x() && b.low.x() <= a.high.x() && a.low.y() <= b.high.y() &&
         b.low.y() <= a.high.y() && a.low.z() <= b.high.z() && b.low.z() <= a.high.z();
}

class Finder {
 public:
  explicit Finder(const TriangleMesh& mesh) {
    positions_ = mesh.positions;
    for (Vec3& p : positions_) {
      for (int k = 0; k < 3; ++k) {
        if (std::abs(p[k]) < 0x1p-200) p[k] = 0;
      }
    }
    const WeldMap map = weld_map(positions_);
    triangles_ = mesh.triangles;
    for (Triangle& t : triangles_) {
      for (std::uint32_t& v : t) v = map.kept[map.of_vertex[v]];
    }
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
      const auto [a, b, c] = corners(i);
      if (axis_of(a, b, c) >= 0) order_.push_back(i);
    }
    boxes_.resize(triangles_.size());
    for (const std::uint32_t i : order_) {
      const auto [a, b, c] = corners(i);
      boxes_[i] = {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
    }
    if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()));
  }

  MeshCrossings find(int threads) {
    struct Found {
      std::size_t pairs = 0;
      std::array<std::uint32_t, 2> first{~0U, ~0U};
    };
    std::vector<Found> found(static_cast<std::size_t>(thread_count(threads)));
    std::vector<std::atomic<bool>> crosses(triangles_.size());
    constexpr std::size_t kLeaves = 64;
    parallel_blocks(leaves_.size(), kLeaves, threads,
                    [&](std::size_t begin, std::size_t end, int worker) {
                      Found& mine = found[static_cast<std::size_t>(worker)];
                      for (std::size_t leaf = begin; leaf < end; ++leaf) {
                        each_pair(nodes_[leaves_[leaf]], [&](std::uint32_t i, std::uint32_t j) {
                          if (!triangles_meet(i, j)) return;
                          ++mine.pairs;
                          crosses[i].store(true, std::memory_order_relaxed);
                          crosses[j].store(true, std::memory_order_relaxed);
                          mine.first = std::min(mine.first, {std::min(i, j), std::max(i, j)});
                        });
                      }
                    });
    MeshCrossings all;
    all.first = {~0U, ~0U};
    for (const Found& each : found) {
      all.pairs += each.pairs;
      all.first = std::min(all.first, each.first);
    }
    for (const std::atomic<bool>& each : crosses) all.triangles += each ? 1 : 0;
    if (all.pairs == 0) return {};
    all.at = place_of(all.first[0], all.first[1]);
    return all;
  }

 private:
  static constexpr std::uint32_t kLeaf = 4;  // triangles at most

  struct Node {
    Box box;
    std::uint32_t begin, end;  // in order_
    std::uint32_t right;       // 0: a leaf; the left one follows its parent
  };

  [[nodiscard]] Corners corners(std::uint32_t i) const {
    const Triangle& t = triangles_[i];
    return {positions_[t[0]], positions_[t[1]], positions_[t[2]]};
  }

  std::uint32_t build(std::uint32_t begin, std::uint32_t end) {
    const auto at = static_cast<std::uint32_t>(nodes_.size());
    Box box = boxes_[order_[begin]];
    Box middles{box.low + box.high, box.low + box.high};
    for (std::uint32_t i = begin + 1; i < end; ++i) {
      const Box& b = boxes_[order_[i]];
      const Vec3 middle = b.low + b.high;
      box = {box.low.cwiseMin(b.low), box.high.cwiseMax(b.high)};
      middles = {middles.low.cwiseMin(middle), middles.high.cwiseMax(middle)};
    }
    nodes_.push_back({box, begin, end, 0});
    if (end - begin <= kLeaf) {
      leaves_.push_back(at);
      return at;
    }
    int axis = 0;
    (middles.high - middles.low).maxCoeff(&axis);
    const std::uint32_t half = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                     [&](std::uint32_t i, std::uint32_t j) {
                       const double of_i = boxes_[i].low[axis] + boxes_[i].high[axis];
                       const double of_j = boxes_[j].low[axis] + boxes_[j].high[axis];
                       return of_i != of_j ? of_i < of_j : i < j;
                     });
    build(begin, half);
    const std::uint32_t right = build(half, end);
    nodes_[at].right = right;
    return at;
  }

  // Pairs of a triangle of the leaf and one after it in order_ whose boxes meet.
  template <class See>
  void each_pair(const Node& leaf, See see) const {
    std::array<std::uint32_t, 64> open;  // halving 2^32 triangles takes half as many
    std::size_t count = 0;
    open[count++] = 0;
    while (count > 0) {
      const std::uint32_t at = open[--count];
      const Node& node = nodes_[at];
      if (node.end <= leaf.begin || !meet(node.box, leaf.box)) continue;
      if (node.right != 0) {
        open[count++] = node.right;
        open[count++] = at + 1;
        continue;
      }
      for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
        for (std::uint32_t j = std::max(node.begin, i + 1); j < node.end; ++j) {
          if (meet(boxes_[order_[i]], boxes_[order_[j]])) see(order_[i], order_[j]);
        }
      }
    }
  }

  [[nodiscard]] bool triangles_meet(std::uint32_t i, std::uint32_t j) const {
    const Triangle &s = triangles_[i], &t = triangles_[j];
    std::array<std::size_t, 3> in_s{}, in_t{};
    std::size_t common = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t l = 0; l < 3; ++l) {
        if (s[k] != t[l]) continue;
        in_s[common] = k;
        in_t[common++] = l;
      }
    }
    const auto p = [this](const Triangle& of, std::size_t k) -> const Vec3& {
      return positions_[of[k % 3]];
    };
    if (common == 3) return false;  // told as a repeated triangle
    if (common == 0) return apart_triangles_meet(corners(i), corners(j));
    if (common == 1) {
      return fan_meets(p(s, in_s[0]), p(s, in_s[0] + 1), p(s, in_s[0] + 2), p(t, in_t[0] + 1),
                       p(t, in_t[0] + 2));
    }
    return folded(p(s, in_s[0]), p(s, in_s[1]), p(s, 3 - in_s[0] - in_s[1]),
                  p(t, 3 - in_t[0] - in_t[1]));
  }

  // A point of the first side that goes through the other triangle; else the middle of what their
  // boxes share.
  [[nodiscard]] Vec3 place_of(std::uint32_t i, std::uint32_t j) const {
    for (const auto& [one, other] : {std::pair{i, j}, std::pair{j, i}}) {
      const Corners s = corners(one), t = corners(other);
      const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &a = s[k], &b = s[(k + 1) % 3];
        const auto is_corner = [&](const Vec3& p) {
          return std::find(t.begin(), t.end(), p) != t.end();
        };
        if (is_corner(a) || is_corner(b) || !segment_meets(a, b, t)) continue;
        const double of_a = normal.dot(a - t[0]), of_b = normal.dot(b - t[0]);
        if (of_a != of_b) return a + of_a / (of_a - of_b) * (b - a);
      }
    }
    return 0.5 * (boxes_[i].low.cwiseMax(boxes_[j].low) + boxes_[i].high.cwiseMin(boxes_[j].high));
  }

  std::vector<Vec3> positions_;
  std::vector<Triangle> triangles_;  // by the first vertex of each position
  std::vector<Box> boxes_;
  std::vector<std::uint32_t> order_;  // triangles of some area, as the tree has them
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> leaves_;
};

}  // namespace

MeshCrossings find_crossings(const TriangleMesh& mesh, int threads) {
  return Finder(mesh).find(threads);
}

}  // namespace diesink
