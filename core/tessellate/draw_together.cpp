// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/draw_together.h"

#include <algorithm>
#include <cmath>

#include "core/tessellate/tidier.h"

namespace diesink {
namespace cells {
namespace {

PlanNode plan_node_of(const GraphNode& n) {
  PlanNode node;
  node.x = n.x;
  node.y = n.y;
  node.heights = n.heights;
  return node;
}

}  // namespace

bool Tidier::stays_beside(std::uint32_t n, const Path& path) const {
  return std::all_of(path.between.begin(), path.between.end(), [&](std::uint32_t m) {
    return (at(m) - at(n)).norm() <= kReach * options_.least;
  });
}

Tidier::Path Tidier::path_from(std::uint32_t n, std::uint32_t l, double reach) const {
  Path path;
  path.links.push_back(l);
  path.end = other_end(l, n);
  while (!graph_.nodes[path.end].corner && !graph_.nodes[path.end].border &&
         graph_.nodes[path.end].links.size() == 2) {
    const std::vector<std::uint32_t>& links = graph_.nodes[path.end].links;
    path.between.push_back(path.end);
    if (!((at(path.end) - at(n)).norm() <= reach)) break;
    l = links[0] == path.links.back() ? links[1] : links[0];
    path.links.push_back(l);
    path.end = other_end(l, path.end);
  }
  return path;
}

// Of link l, from node n on.
const Tidier::Middle& Tidier::middle_of(std::uint32_t l, std::uint32_t n) {
  const GraphLink& link = graph_.links[l];
  const bool along = link.from == n;
  const GraphNode &from = graph_.nodes[n], &to = graph_.nodes[other_end(l, n)];
  const Label left = along ? link.left : link.right, right = along ? link.right : link.left;
  const auto is_as_it_was = [](const PlanNode& was, const GraphNode& is) {
    return was.x == is.x && was.y == is.y &&
           std::ranges::equal(was.heights, is.heights,
                              [](const LabelHeight& g, const LabelHeight& h) {
                                return g.label == h.label && g.z == h.z;
                              });
  };
  if (middles_.size() < graph_.links.size()) middles_.resize(graph_.links.size());
  Middle& middle = middles_[l][along ? 0 : 1];
  if (middle.known && middle.left == left && middle.right == right &&
      is_as_it_was(middle.from, from) && is_as_it_was(middle.to, to)) {
    return middle;
  }
  middle = {true, false, plan_node_of(from), plan_node_of(to), left, right, Vec2::Zero()};
  PlanNode found;
  if (link.curve.type != CurveType::kUnsolved && (at(n) - Vec2(to.x, to.y)).norm() > near_ &&
      point_on_stretch(surface_, solver_, link.curve, left, right, middle.from, middle.to, 0.5,
                       found)) {
    middle.found = true;
    middle.at = {found.x, found.y};
  }
  return middle;
}

// The path's nodes and the middles of its stretches, on their curves.
std::vector<Vec2> Tidier::points_of(std::uint32_t start, const Path& path) {
  std::vector<Vec2> points{at(start)};
  std::uint32_t n = start;
  for (std::size_t k = 0; k < path.links.size(); ++k) {
    const Middle& middle = middle_of(path.links[k], n);
    if (middle.found) points.push_back(middle.at);
    n = k < path.between.size() ? path.between[k] : path.end;
    points.push_back(at(n));
  }
  return points;
}

bool Tidier::is_thin(std::uint32_t start, const Path& a, const Path& b) {
  const std::vector<Vec2> one = points_of(start, a), two = points_of(start, b);
  const auto is_along = [&](const std::vector<Vec2>& points, const std::vector<Vec2>& chain) {
    // Both run the same way: the stretch that holds a point is hardly ever far from the last one's.
    std::size_t last = 0;
    const std::size_t stretches = chain.size() - 1;
    return std::all_of(points.begin(), points.end(), [&](const Vec2& r) {
      for (std::size_t tried = 0; tried < stretches; ++tried) {
        const std::size_t k = (last + tried) % stretches;
        const Vec2 d = chain[k + 1] - chain[k], e = r - chain[k];
        const double s = std::clamp(d.dot(e) / std::fmax(d.squaredNorm(), 1e-300), 0.0, 1.0);
        if ((e - s * d).norm() > near_) continue;
        last = k;
        return true;
      }
      return false;
    });
  };
  return is_along(one, two) && is_along(two, one);
}

void Tidier::drop(std::uint32_t start, const Path& path) {
  for (const std::uint32_t l : path.links) graph_.links[l].gone = true;
  for (const std::uint32_t n : path.between) graph_.nodes[n] = GraphNode{};
  std::erase(graph_.nodes[start].links, path.links.front());
  std::erase(graph_.nodes[path.end].links, path.links.back());
}

// The label on one side of a path, seen from its start, is now another; what the dropped path knows
// of its height stands in where the face itself does not reach.
void Tidier::relabel(std::uint32_t start, const Path& kept, const Path& dropped, bool left,
                     Label label) {
  std::uint32_t n = start;
  for (std::size_t k = 0; k < kept.links.size(); ++k) {
    (left ? left_of(kept.links[k], n) : right_of(kept.links[k], n)) = label;
    if (k == kept.between.size()) break;
    n = kept.between[k];
    if (label == kNoLabel) continue;
    GraphNode& node = graph_.nodes[n];
    LabelHeight own{label, 0};
    if (!solver_.height(label, node.x, node.y, own.z)) {
      double nearest = 1e300;
      const auto look = [&](std::uint32_t m) {
        const double away = (at(m) - at(n)).norm();
        for (const LabelHeight& h : graph_.nodes[m].heights) {
          if (h.label != label || away >= nearest) continue;
          nearest = away;
          own.z = h.z;
        }
      };
      look(start);
      look(dropped.end);
      for (const std::uint32_t m : dropped.between) look(m);
    }
    for (const LabelHeight& h : node.heights) {
      if (std::fabs(h.z - own.z) <= near_) own.z = h.z;  // one height is one number
    }
    std::erase_if(node.heights, [&](const LabelHeight& h) { return h.label == label; });
    node.heights.push_back(own);
  }
}

// From the k-th link on, which becomes that of the sliver that has gone.
bool Tidier::remove_sliver_at(std::uint32_t corner, std::size_t& k) {
  const std::vector<std::uint32_t> links = graph_.nodes[corner].links;
  for (; k < links.size() && links.size() > 1; ++k) {
    const Path a = path_from(corner, links[k]);
    if (a.end == corner && a.links.back() == links[(k + 1) % links.size()]) {
      // Out and back: of no width, or among least cells beside what is left.
      if (!(stays_beside(corner, a) || stays_low(corner, a)) ||
          (a.between.size() > 1 && links.size() == 2))
        continue;
      drop(corner, a);
      return true;
    }
    const Path b = path_from(corner, links[(k + 1) % links.size()]);
    if (a.end != b.end || a.end == corner || !graph_.nodes[a.end].corner) continue;
    // Between them nothing else leaves the other end.
    const std::vector<std::uint32_t>& there = graph_.nodes[a.end].links;
    const auto place = std::find(there.begin(), there.end(), a.links.back());
    const std::uint32_t before = place == there.begin() ? there.back() : *(place - 1);
    if (before != b.links.back() || !is_thin(corner, a, b)) continue;
    const Label beyond_a = right_of(a.links.front(), corner),
                beyond_b = left_of(b.links.front(), corner);
    if (beyond_a == beyond_b) {
      drop(corner, a);
      drop(corner, b);
      return true;
    }
    const auto rank = [&](const Path& p) {
      int least = 2;
      for (const std::uint32_t l : p.links) {
        const CurveType type = graph_.links[l].curve.type;
        least = std::min(least, type == CurveType::kUnsolved ? 0
                                : type == CurveType::kMeet   ? 1
                                                             : 2);
      }
      return least;
    };
    // Where the one that stays is outside the other, the face it gets may end a hair before it: no
    // chord along it would have a bound.
    const auto reaches = [&](const Path& p, Label label) {
      return label == kNoLabel ||
             std::all_of(p.between.begin(), p.between.end(), [&](std::uint32_t n) {
               double z = 0;
               return solver_.height(label, graph_.nodes[n].x, graph_.nodes[n].y, z);
             });
    };
    const bool a_reaches = reaches(a, beyond_b), b_reaches = reaches(b, beyond_a);
    if (a_reaches == b_reaches ? rank(a) >= rank(b) : a_reaches) {
      relabel(corner, a, b, true, beyond_b);
      drop(corner, b);
    } else {
      relabel(corner, b, a, false, beyond_a);
      drop(corner, a);
    }
    return true;
  }
  return false;
}

// A corner that no more than one arc runs through is a point of that arc, unless two curves do meet
// there.
bool Tidier::straighten(std::uint32_t corner) {
  GraphNode& node = graph_.nodes[corner];
  if (node.border || node.links.size() != 2 || node.links[0] == node.links[1]) return false;
  if (!graph_.links[node.links[0]].curve.same_as(graph_.links[node.links[1]].curve)) {
    if (!node.solved) settle(corner);
    if (node.links.empty()) return true;  // gone into another corner
    if (node.solved || node.links.size() != 2) return false;
  }
  const std::uint32_t before = other_end(node.links[0], corner),
                      behind = other_end(node.links[1], corner);
  if (before == corner || behind == corner) return false;
  const Vec2 p = at(before), d = at(behind) - p;
  if (!(d.norm() > 0)) return false;
  const double s = std::clamp(d.dot(at(corner) - p) / d.squaredNorm(), 0.0, 1.0);
  for (const std::uint32_t l : node.links) {
    // Along the way from the node before to the one behind.
    const Label left = right_of(node.links[0], corner), right = left_of(node.links[0], corner);
    const PlanCurve& curve = graph_.links[l].curve;
    PlanNode found;
    if (curve.type == CurveType::kUnsolved ||
        !point_on_stretch(surface_, solver_, curve, left, right, plan_node_of(graph_.nodes[before]),
                          plan_node_of(graph_.nodes[behind]), s, found) ||
        std::hypot(found.x - node.x, found.y - node.y) > kReach * options_.least) {
      continue;
    }
    node.x = found.x;
    node.y = found.y;
    node.heights = found.heights;
    node.corner = false;
    node.solved = true;
    return true;
  }
  return false;
}

// Takes what lies on the way from a corner to a point of one of its paths into the corner.
bool Tidier::move_along(std::uint32_t corner, const Vec2& to) {
  const double far = (to - at(corner)).norm();
  if (far <= near_) return true;
  const std::vector<std::uint32_t> links = graph_.nodes[corner].links;
  for (const std::uint32_t l : links) {
    const Path path = path_from(corner, l);
    if (path.end == corner) continue;
    Vec2 p = at(corner);
    for (std::size_t k = 0; k < path.links.size(); ++k) {
      const Vec2 q = at(k < path.between.size() ? path.between[k] : path.end), d = q - p;
      const double s = std::clamp(d.dot(to - p) / std::fmax(d.squaredNorm(), 1e-300), 0.0, 1.0);
      if ((to - p - s * d).norm() <= near_) {
        const bool takes_end = (to - q).norm() <= near_;
        for (std::size_t i = 0; i < k + (takes_end ? 1u : 0u); ++i) {
          if (!contract(path.links[i])) return false;
        }
        return true;
      }
      if ((q - at(corner)).norm() > 2 * far) break;  // the long way round
      p = q;
    }
  }
  return false;
}

// Puts a corner that cells have only enclosed where two of its curves meet.
void Tidier::settle(std::uint32_t corner) {
  const std::vector<std::uint32_t> links = graph_.nodes[corner].links;
  const auto height_on = [&](const PlanCurve& curve) {
    for (const LabelHeight& h : graph_.nodes[corner].heights) {
      if (solver_.ref_of(h.label) == curve.first) return h.z;
    }
    return curve.type == CurveType::kShadow
               ? solver_.shadow_height(curve, graph_.nodes[corner].x, graph_.nodes[corner].y)
               : 0.0;
  };
  const double reach = std::fmin(kLongReach * options_.least, 0.05 * options_.tolerance);
  for (std::size_t i = 0; i < links.size(); ++i) {
    for (std::size_t j = i + 1; j < links.size(); ++j) {
      const PlanCurve one = graph_.links[links[i]].curve, two = graph_.links[links[j]].curve;
      if (one.same_as(two)) continue;
      Vec2 p = at(corner);
      double z1 = height_on(one), z2 = height_on(two);
      if (!solver_.corner(one, two, p, z1, z2) || (p - at(corner)).norm() > reach) continue;
      std::vector<LabelHeight> heights = graph_.nodes[corner].heights;
      bool seen = true;
      for (LabelHeight& h : heights) {
        const SurfaceRef ref = solver_.ref_of(h.label);
        double z = 0;
        if (one.is_height_of(ref)) {
          h.z = z1;
        } else if (two.is_height_of(ref)) {
          h.z = z2;
        } else if (solver_.height(h.label, p.x(), p.y(), z)) {
          h.z = z;
        }
        seen = seen && solver_.on_sheet(h.label, p, h.z);
      }
      if (!seen || !move_along(corner, p)) continue;
      GraphNode& node = graph_.nodes[corner];
      if (node.links.empty()) return;  // gone into a surer one
      join_heights(heights, near_);
      node.x = p.x();
      node.y = p.y();
      node.heights = std::move(heights);
      node.solved = true;
      return;
    }
  }
}

}  // namespace cells

void draw_together(const CompoundSurface::Impl& surface, const ArrangementOptions& options,
                   CellGraph& graph) {
  cells::Tidier(surface, options, graph).run();
}

}  // namespace diesink
