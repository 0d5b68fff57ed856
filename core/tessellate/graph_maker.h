// The maker of the graph of cells: cell_graph.cpp walks and splits the tree, cell_join.cpp joins
// what the borders of one cell show.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/tessellate/cell_graph.h"

namespace diesink::cells {

using Impl = CompoundSurface::Impl;

// Where a change lies on a cell's border: side 0 bottom, 1 right, 2 top, 3 left.
struct OnBorder {
  std::int32_t info = 0;
  std::uint8_t side = 0;
  std::uint32_t node = 0;
};

// A label change as a cell sees it, going round it anticlockwise.
struct Item {
  double position = 0;  // along the way round
  std::uint8_t side = 0;
  std::uint32_t node = 0;
  Label before = kNoLabel, after = kNoLabel;
};

class GraphMaker {
 public:
  GraphMaker(const Impl& surface, CellTree& tree, const ArrangementOptions& options)
      : surface_(surface),
        tree_(tree),
        options_(options),
        solver_(surface),
        vertices_(body_vertices(surface)),
        line_(surface, vertices_,
              {options.flat, options.least, kUnseen * options.tolerance, 0.25 * options.tolerance,
               options.budget.pieces}) {}

  CellGraph make();

 private:
  [[nodiscard]] TreeCell& cell(std::int32_t i) { return tree_.cells[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const TreeCell& cell(std::int32_t i) const {
    return tree_.cells[static_cast<std::size_t>(i)];
  }

  void inside(std::int32_t c);
  void beside(std::int32_t a, std::int32_t b, bool upright);
  void on_border(std::int32_t c, std::uint8_t side);
  void segment(std::int32_t a, std::int32_t b, bool upright);
  // A stretch of border between two leaves, or of one on the domain's border.
  struct Stretch {
    std::uint64_t key = 0;
    std::int32_t info = 0;  // whose steps decide it
    Vec2 from, to;
  };
  [[nodiscard]] Stretch border_stretch(std::int32_t c, std::uint8_t side) const;
  [[nodiscard]] Stretch stretch_between(std::int32_t a, std::int32_t b, bool upright) const;
  [[nodiscard]] LineFinding search(const Stretch& stretch) const;
  const std::vector<LineChange>& changes_on(const Stretch& stretch);
  void tell(double area, const Vec2& place);
  void add_node(const LineChange& change);
  void take_seam(std::int32_t c, std::uint8_t side);
  static std::uint64_t pair_key(std::int32_t a, std::int32_t b) {
    return std::uint64_t{static_cast<std::uint32_t>(a)} << 32 | static_cast<std::uint32_t>(b);
  }

  // Leaves with something in them beside a cell, side by side.
  template <class Take>
  void around(std::int32_t c, const Take& take) const;
  template <class Take>
  void leaves_on(std::int32_t in, std::uint8_t side, const PlanBox& box, const Take& take) const;
  void settle_cells();
  bool joins(std::int32_t info, const GraphMaker& known);
  bool split_failed(bool last);
  [[nodiscard]] bool may_be_split(const TreeCell& c, const std::vector<Item>& items,
                                  double deepest) const;
  [[nodiscard]] bool parts_corners(const TreeCell& c, const std::vector<Item>& items) const;
  [[nodiscard]] bool goes_deeper(const CellInfo& info, const TreeCell& c,
                                 const std::vector<Item>& items) const;

  void join(std::int32_t info, const std::vector<OnBorder>& found);
  void link(std::uint32_t from, std::uint32_t to, Label left, Label right, const PlanCurve& curve);
  [[nodiscard]] std::vector<int> branches(const CellInfo& info,
                                          const std::vector<Item>& items) const;
  bool join_pairs(const CellInfo& info, const std::vector<Item>& items, bool by_curve);
  [[nodiscard]] bool runs_inside(const PlanBox& box, const Item& in, const Item& out) const;
  bool join_corner(const CellInfo& info, const TreeCell& cell, const std::vector<Item>& items);
  [[nodiscard]] bool is_star_centre(const CellInfo& info, const TreeCell& cell,
                                    const Vec2& p) const;
  std::uint32_t add_corner(const std::vector<Item>& items, const Vec2& at, const PlanCurve* one,
                           const PlanCurve* two, double z1, double z2, const Vec3* vertex);

  const Impl& surface_;
  CellTree& tree_;
  const ArrangementOptions& options_;
  CurveSolver solver_;
  std::vector<BodyVertices> vertices_;
  ChangeSearch line_;
  CellGraph graph_;
  std::vector<OnBorder> found_;
  std::vector<std::int32_t> to_split_;
  std::uint32_t first_new_ = 0;
  std::size_t seam_changes_ = 0;  // taken into the graph
  bool last_ = false;             // cells are joined as they are
  bool deeper_ = true;            // least cells may be split
  // What stretches of border between leaves have shown: it does not change as other cells are
  // split.
  std::unordered_map<std::uint64_t, LineFinding> known_;
};

}  // namespace diesink::cells
