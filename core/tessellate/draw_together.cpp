// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/draw_together.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// Cells' widths over which neighbours may have found one corner, and over which the corner where a
// sliver opens may lie from where the cells saw it open.
constexpr double kReach = 16, kLongReach = 4096;

PlanNode plan_node_of(const GraphNode& n) {
  PlanNode node;
  node.x = n.x;
  node.y = n.y;
  node.heights = n.heights;
  return node;
}

class Tidier {
 public:
  Tidier(const Impl& surface, const ArrangementOptions& options, CellGraph& graph)
      : surface_(surface),
        options_(options),
        graph_(graph),
        solver_(surface),
        near_(1e-9 * surface.size) {}

  void run() {
    join_close();
    join_doubled_corners();
    for (bool changed = true; changed;) {
      changed = false;
      for (std::uint32_t n = 0; n < graph_.nodes.size(); ++n) {
        // (What is no sliver before the one that goes is none after it.)
        for (std::size_t k = 0; is_corner(n) && remove_sliver_at(n, k); k -= k > 0 ? 1 : 0)
          changed = true;
      }
      for (std::uint32_t n = 0; n < graph_.nodes.size(); ++n) {
        if (is_corner(n) && straighten(n)) changed = true;
      }
    }
    for (std::uint32_t n = 0; n < graph_.nodes.size(); ++n) {
      if (is_corner(n) && !graph_.nodes[n].solved) settle(n);
    }
    // A corner that has only now turned out to be none, or where it is, no longer hides another.
    join_doubled_corners();
    join_double_roots();
    join_close();
    join_coincident_corners();
  }

 private:
  // From a corner through changes to the next node that is none.
  struct Path {
    std::vector<std::uint32_t> links, between;
    std::uint32_t end = 0;
  };

  // Of a stretch of curve, and what it was found from: both of its corners ask for it, with either
  // neighbour, in every round.
  struct Middle {
    bool known = false, found = false;
    PlanNode from, to;
    Label left = kNoLabel, right = kNoLabel;
    Vec2 at = Vec2::Zero();
  };

  [[nodiscard]] bool is_corner(std::uint32_t n) const {
    return graph_.nodes[n].corner && !graph_.nodes[n].links.empty();
  }
  [[nodiscard]] std::uint32_t other_end(std::uint32_t l, std::uint32_t n) const {
    return graph_.links[l].from == n ? graph_.links[l].to : graph_.links[l].from;
  }
  [[nodiscard]] Vec2 at(std::uint32_t n) const { return {graph_.nodes[n].x, graph_.nodes[n].y}; }
  // The label on the left of a link, leaving n.
  Label& left_of(std::uint32_t l, std::uint32_t n) {
    return graph_.links[l].from == n ? graph_.links[l].left : graph_.links[l].right;
  }
  Label& right_of(std::uint32_t l, std::uint32_t n) {
    return graph_.links[l].from == n ? graph_.links[l].right : graph_.links[l].left;
  }

  bool contract(std::uint32_t l);
  const Middle& middle_of(std::uint32_t l, std::uint32_t n);
  void join_close();
  void join_doubled_corners();
  void join_double_roots();
  void join_coincident_corners();
  [[nodiscard]] std::size_t gap_for(std::uint32_t corner, std::uint32_t other) const;
  bool join_at_gap(std::uint32_t kept, std::uint32_t dropped);
  void take_heights(GraphNode& into, const GraphNode& from) const;
  [[nodiscard]] bool has_curves_of(std::uint32_t corner, std::uint32_t other) const;
  // (No farther than to the first node more than `reach` from n, where that is given.)
  [[nodiscard]] Path path_from(std::uint32_t n, std::uint32_t l, double reach = HUGE_VAL) const;
  [[nodiscard]] bool stays_beside(std::uint32_t n, const Path& path) const;
  std::vector<Vec2> points_of(std::uint32_t start, const Path& path);
  bool is_thin(std::uint32_t start, const Path& a, const Path& b);
  void drop(std::uint32_t start, const Path& path);
  void relabel(std::uint32_t start, const Path& kept, const Path& dropped, bool left, Label label);
  bool remove_sliver_at(std::uint32_t corner, std::size_t& k);
  bool straighten(std::uint32_t corner);
  void settle(std::uint32_t corner);
  bool move_along(std::uint32_t corner, const Vec2& to);

  const Impl& surface_;
  const ArrangementOptions& options_;
  CellGraph& graph_;
  CurveSolver solver_;
  double near_;  // 1e-9 of the size: what vertices of curves are held to
  std::vector<std::array<Middle, 2>> middles_;  // of each link, from its either end
};

// Makes the two ends of a link one node, the surer of them; what was a loop between them goes.
bool Tidier::contract(std::uint32_t l) {
  GraphLink& short_link = graph_.links[l];
  std::uint32_t kept = short_link.from, dropped = short_link.to;
  if (kept == dropped) return false;
  const auto rank = [](const GraphNode& n) {
    return n.border ? 3 : n.corner && n.solved ? 2 : n.corner ? 1 : 0;
  };
  if (rank(graph_.nodes[dropped]) > rank(graph_.nodes[kept])) std::swap(kept, dropped);
  GraphNode &into = graph_.nodes[kept], &from = graph_.nodes[dropped];
  if (into.border && rank(from) > 0) return false;
  // The links round both, one after another, each from the short one on.
  const auto place = std::find(into.links.begin(), into.links.end(), l);
  const auto gap = std::find(from.links.begin(), from.links.end(), l);
  if (place == into.links.end() || gap == from.links.end()) return false;
  std::vector<std::uint32_t> round(into.links.begin(), place);
  round.insert(round.end(), gap + 1, from.links.end());
  round.insert(round.end(), from.links.begin(), gap);
  round.insert(round.end(), place + 1, into.links.end());
  for (const std::uint32_t k : from.links) {
    GraphLink& moved = graph_.links[k];
    if (moved.from == dropped) moved.from = kept;
    if (moved.to == dropped) moved.to = kept;
  }
  short_link.gone = true;
  for (const std::uint32_t k : round) {
    if (graph_.links[k].from == graph_.links[k].to) graph_.links[k].gone = true;
  }
  std::erase_if(round, [&](std::uint32_t k) { return graph_.links[k].gone; });
  into.links = std::move(round);
  into.corner = into.corner || from.corner;
  take_heights(into, from);
  from = GraphNode{};
  return true;
}

// What one node knows of heights and the other does not, at its own place: the two may lie as far
// apart as double roots, and a face slopes.
void Tidier::take_heights(GraphNode& into, const GraphNode& from) const {
  for (LabelHeight h : from.heights) {
    const bool known = std::any_of(into.heights.begin(), into.heights.end(),
                                   [&](const LabelHeight& o) { return o.label == h.label; });
    if (known) continue;
    const Implicit face = solver_.implicit(solver_.ref_of(h.label));
    const Vec2 p(into.x, into.y);
    const auto off = [&](double z) { return std::fabs(face.value({p.x(), p.y(), z})); };
    // A point of another face that is one of this, too, is better than any root: beside a
    // silhouette that is half-precise, and beyond it there is none.
    const auto shared = std::ranges::find_if(into.heights, [&](const LabelHeight& o) {
      return off(o.z) <= surface_.tie && solver_.on_sheet(h.label, p, o.z);
    });
    double z = 0;
    if (shared != into.heights.end()) {
      h.z = shared->z;
    } else if (off(h.z) > surface_.tie &&
               (solver_.height(h.label, p.x(), p.y(), z) ||
                (solver_.silhouette_height(h.label, p.x(), p.y(), z) && off(z) < off(h.z)))) {
      h.z = z;
    }
    into.heights.push_back(h);
  }
  join_heights(into.heights, near_);
}

// Nodes that coordinates hardly tell apart, where cell borders pass beside corners.
void Tidier::join_close() {
  for (std::uint32_t l = 0; l < graph_.links.size(); ++l) {
    const GraphLink& link = graph_.links[l];
    if (!link.gone && (at(link.from) - at(link.to)).norm() <= near_) contract(l);
  }
}

// Cells beside one another that have found the same corner, each a little beyond its border: the
// ways out and back between them go.
void Tidier::join_doubled_corners() {
  for (std::uint32_t n = 0; n < graph_.nodes.size(); ++n) {
    for (std::size_t k = 0; is_corner(n) && k < graph_.nodes[n].links.size(); ++k) {
      const Path path = path_from(n, graph_.nodes[n].links[k], kReach * options_.least);
      if (path.end == n || !graph_.nodes[path.end].corner ||
          (at(path.end) - at(n)).norm() > near_ || !stays_beside(n, path)) {
        continue;
      }
      bool any = false;
      for (const std::uint32_t l : path.links) {
        if (!graph_.links[l].gone && contract(l)) any = true;
      }
      if (any) k = static_cast<std::size_t>(-1);  // its links are others now: from the first again
    }
  }
}

// Whether every curve that runs into the other corner runs into this one, too.
bool Tidier::has_curves_of(std::uint32_t corner, std::uint32_t other) const {
  const std::vector<std::uint32_t>& mine = graph_.nodes[corner].links;
  return std::ranges::all_of(graph_.nodes[other].links, [&](std::uint32_t l) {
    return graph_.links[l].curve.type != CurveType::kUnsolved &&
           std::ranges::any_of(mine, [&](std::uint32_t k) {
             return graph_.links[k].curve.same_as(graph_.links[l].curve);
           });
  });
}

// Where two curves touch, rounding gives them two crossings side by side. Each lies on both curves
// and on all the others that run into either, so that one of them is the corner.
void Tidier::join_double_roots() {
  const double reach = kDoubleRoot * surface_.size;
  for (std::uint32_t n = 0; n < graph_.nodes.size(); ++n) {
    for (std::size_t k = 0; is_corner(n) && k < graph_.nodes[n].links.size(); ++k) {
      const Path path = path_from(n, graph_.nodes[n].links[k], kReach * options_.least);
      if (path.end == n || !is_corner(path.end) || !graph_.nodes[n].solved ||
          (at(path.end) - at(n)).norm() > reach || !stays_beside(n, path) ||
          !has_curves_of(n, path.end)) {
        continue;
      }
      bool any = false;
      for (const std::uint32_t l : path.links) {
        if (!graph_.links[l].gone && contract(l)) any = true;
      }
      if (any) k = static_cast<std::size_t>(-1);  // its links are others now: from the first again
    }
  }
}

// The gap between links of a corner, by the one before it, in which all links of another corner at
// the same place go out; the corner's number of links where there is none.
std::size_t Tidier::gap_for(std::uint32_t corner, std::uint32_t other) const {
  const auto direction = [&](std::uint32_t n, std::uint32_t l) {
    const Vec2 d = at(other_end(l, n)) - at(n);
    return std::atan2(d.y(), d.x());
  };
  const auto turn = [](double from, double to) {  // anticlockwise, 0 to 2 pi
    const double angle = to - from;
    return angle < 0 ? angle + 2 * std::numbers::pi : angle;
  };
  const std::vector<std::uint32_t>& links = graph_.nodes[corner].links;
  for (std::size_t k = 0; k < links.size(); ++k) {
    const double from = direction(corner, links[k]);
    const double gap = turn(from, direction(corner, links[(k + 1) % links.size()]));
    const bool all = std::ranges::all_of(graph_.nodes[other].links, [&](std::uint32_t l) {
      const double angle = turn(from, direction(other, l));
      return angle > 0 && (angle < gap || links.size() == 1);
    });
    if (all) return k;
  }
  return links.size();
}

// Puts the links of one corner into a gap of the other, where both show the same label there.
bool Tidier::join_at_gap(std::uint32_t kept, std::uint32_t dropped) {
  GraphNode &into = graph_.nodes[kept], &from = graph_.nodes[dropped];
  const std::size_t gap = gap_for(kept, dropped), gap_there = gap_for(dropped, kept);
  if (gap == into.links.size() || gap_there == from.links.size() ||
      left_of(into.links[gap], kept) != left_of(from.links[gap_there], dropped)) {
    return false;
  }
  for (const std::uint32_t l : from.links) {
    GraphLink& moved = graph_.links[l];
    if (moved.from == dropped) moved.from = kept;
    if (moved.to == dropped) moved.to = kept;
  }
  std::rotate(from.links.begin(), from.links.begin() + static_cast<std::ptrdiff_t>(gap_there + 1),
              from.links.end());
  into.links.insert(into.links.begin() + static_cast<std::ptrdiff_t>(gap + 1), from.links.begin(),
                    from.links.end());
  take_heights(into, from);
  from = GraphNode{};
  return true;
}

// Curves that touch in a corner may be seen there from either side of a cell's border, with nothing
// between the two corners but what both have around them.
void Tidier::join_coincident_corners() {
  std::vector<std::uint32_t> corners;
  for (std::uint32_t n = 0; n < graph_.nodes.size(); ++n) {
    if (is_corner(n) && !graph_.nodes[n].border) corners.push_back(n);
  }
  std::ranges::sort(corners, [&](std::uint32_t a, std::uint32_t b) {
    return graph_.nodes[a].x != graph_.nodes[b].x ? graph_.nodes[a].x < graph_.nodes[b].x : a < b;
  });
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t j = i + 1; j < corners.size() && is_corner(corners[i]); ++j) {
      if (graph_.nodes[corners[j]].links.empty()) continue;
      if (graph_.nodes[corners[j]].x - graph_.nodes[corners[i]].x > near_) break;
      if ((at(corners[j]) - at(corners[i])).norm() <= near_) join_at_gap(corners[i], corners[j]);
    }
  }
}

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
      if (!stays_beside(corner, a) || (a.between.size() > 1 && links.size() == 2)) continue;
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

}  // namespace

void draw_together(const Impl& surface, const ArrangementOptions& options, CellGraph& graph) {
  Tidier(surface, options, graph).run();
}

}  // namespace diesink
