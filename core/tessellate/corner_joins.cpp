// Corners that coordinates hardly tell apart become one.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/tessellate/tidier.h"

namespace diesink::cells {

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

// All along the path there is a crease, and no peak within it.
bool Tidier::stays_low(std::uint32_t n, const Path& path) const {
  Vec2 middle = at(n);
  for (const std::uint32_t m : path.between) {
    const std::vector<LabelHeight>& heights = graph_.nodes[m].heights;
    if (!((at(m) - at(n)).norm() <= low_) ||
        !std::ranges::all_of(heights, [&](const LabelHeight& h) {
          return std::fabs(h.z - heights.front().z) <= near_;
        }))
      return false;
    middle += at(m);
  }
  middle /= static_cast<double>(path.between.size() + 1);
  const LineState there = surface_.evaluate_face(middle.x(), middle.y());
  return there.label != kNoLabel && !graph_.nodes[n].heights.empty() &&
         std::fabs(there.z - graph_.nodes[n].heights.front().z) <= low_;
}

// Cells beside one another that have found the same corner, each a little beyond its border: the
// ways out and back between them go.
void Tidier::join_doubled_corners() {
  for (std::uint32_t n = 0; n < graph_.nodes.size(); ++n) {
    for (std::size_t k = 0; is_corner(n) && k < graph_.nodes[n].links.size(); ++k) {
      const Path path = path_from(n, graph_.nodes[n].links[k], low_);
      if (path.end == n || !graph_.nodes[path.end].corner ||
          (at(path.end) - at(n)).norm() > near_ || !(stays_beside(n, path) || stays_low(n, path))) {
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

}  // namespace diesink::cells
