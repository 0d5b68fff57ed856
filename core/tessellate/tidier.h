// What draws the graph of cells together: corner_joins.cpp makes corners at one place one,
// draw_together.cpp takes slivers away and puts corners where the equations say.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/tessellate/cell_graph.h"
#include "core/tessellate/draw_together.h"

namespace diesink::cells {

using Impl = CompoundSurface::Impl;

// Cells' widths over which neighbours may have found one corner, and over which the corner where a
// sliver opens may lie from where the cells saw it open.
inline constexpr double kReach = 16, kLongReach = 4096;
// Part of the tolerance, and cells' widths, over which creases may lead from one find of a corner
// to another.
inline constexpr double kLowReach = 0.1, kLowCells = 256;

class Tidier {
 public:
  Tidier(const Impl& surface, const ArrangementOptions& options, CellGraph& graph)
      : surface_(surface),
        options_(options),
        graph_(graph),
        solver_(surface),
        near_(1e-9 * surface.size),
        low_(std::fmax(kReach * options.least,
                       std::fmin(kLowReach * options.tolerance, kLowCells * options.least))) {}

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
  [[nodiscard]] bool stays_low(std::uint32_t n, const Path& path) const;
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
  double low_;   // how far cells reach in which a crease is too low to matter
  std::vector<std::array<Middle, 2>> middles_;  // of each link, from its either end
};

}  // namespace diesink::cells
