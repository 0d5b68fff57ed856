// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/cell_tree.h"

#include <algorithm>
#include <cmath>

namespace diesink {
namespace {

// Where a cell is cut: off the middle, so that cell borders do not fall on the round coordinates of
// drawings, and not alike in x and y, so that cells' corners do not fall on diagonals. Powers of
// them keep cells within 1 : 2 over 22 levels.
constexpr double kCutX = 0.4931, kCutY = 0.5083;
// What a variant adds to the one and takes off the other.
constexpr double kOtherCut = 0.0021;

// The direction of a function's gradient turns by less than some 35 degrees over the cell: an arc
// in it is close to its chord, so that points of the chord lead to points of the arc.
bool nearly_straight(const PlanFunction& f) {
  const double mx = 0.5 * (f.gx.lo + f.gx.hi), my = 0.5 * (f.gy.lo + f.gy.hi);
  return 0.5 * (f.gx.hi - f.gx.lo) + 0.5 * (f.gy.hi - f.gy.lo) <
         0.6 * std::hypot(mx, my);  // false for NaN
}

}  // namespace

CellTree::CellTree(const CompoundSurface::Impl& surface, const PlanBox& box,
                   const TreeLimits& limits)
    : surface_(surface), limits_(limits), vertices_(body_vertices(surface)) {
  const double w = box.x1 - box.x0, h = box.y1 - box.y0;
  columns = static_cast<int>(std::clamp(std::round(w / std::fmin(w, h)), 1.0, 64.0));
  rows = static_cast<int>(std::clamp(std::round(h / std::fmin(w, h)), 1.0, 64.0));
  const auto line = [](double a, double b, int k, int n) {
    return k == 0 ? a : k == n ? b : a + (b - a) * (k + 0.0173) / n;
  };
  std::vector<std::uint32_t> steps;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      roots.push_back(static_cast<std::int32_t>(cells.size()));
      cells.push_back({{line(box.x0, box.x1, i, columns), line(box.x0, box.x1, i + 1, columns),
                        line(box.y0, box.y1, j, rows), line(box.y0, box.y1, j + 1, rows)}});
    }
  }
  for (const std::int32_t root : roots) {
    surface_.index.over(cells[static_cast<std::size_t>(root)].box, steps);
    grow(root, steps);
  }
}

void CellTree::divide(std::int32_t cell) {
  const TreeCell parent = cells[static_cast<std::size_t>(cell)];
  const PlanBox& b = parent.box;
  const double other = kOtherCut * limits_.variant;
  const double x = b.x0 + (kCutX + other) * (b.x1 - b.x0);
  const double y = b.y0 + (kCutY - other) * (b.y1 - b.y0);
  cells[static_cast<std::size_t>(cell)].child = static_cast<std::int32_t>(cells.size());
  const PlanBox parts[4] = {
      {b.x0, x, b.y0, y}, {x, b.x1, b.y0, y}, {b.x0, x, y, b.y1}, {x, b.x1, y, b.y1}};
  for (const PlanBox& part : parts) {
    TreeCell child;
    child.box = part;
    child.level = static_cast<std::uint8_t>(parent.level + 1);
    cells.push_back(child);
  }
}

void CellTree::grow(std::int32_t cell, const std::vector<std::uint32_t>& steps) {
  std::vector<std::uint32_t> here = steps;
  const CellBox box = CellBox::of(cells[static_cast<std::size_t>(cell)].box);
  CellVerdict verdict;
  classify(surface_, vertices_, box, here, limits_.flat, verdict);
  if (verdict.kind == CellKind::kArc || verdict.kind == CellKind::kCorner) {
    for (const PlanFunction& f : verdict.functions) {
      if (!nearly_straight(f)) verdict.kind = CellKind::kUnknown;
    }
  }
  stopped = stopped || (limits_.most_cells > 0 && cells.size() > limits_.most_cells);
  const bool least = stopped || 2 * std::fmax(box.hx, box.hy) <= limits_.least;
  if (verdict.kind == CellKind::kUnknown && least) verdict.kind = CellKind::kLeast;
  if (verdict.kind == CellKind::kUnknown) {
    divide(cell);
    const std::int32_t child = cells[static_cast<std::size_t>(cell)].child;
    for (std::int32_t k = 0; k < 4; ++k) grow(child + k, here);
    return;
  }
  TreeCell& leaf = cells[static_cast<std::size_t>(cell)];
  leaf.kind = verdict.kind;
  if (verdict.kind == CellKind::kPlain) {
    leaf.label = verdict.candidates.count > 0 ? verdict.candidates[0].label : kNoLabel;
    return;
  }
  leaf.info = static_cast<std::int32_t>(infos.size());
  CellInfo info;
  info.cell = cell;
  info.has_vertex = verdict.has_vertex;
  info.star = verdict.star;
  info.merged = verdict.merged;
  info.vertex = verdict.vertex;
  info.depth = verdict.depth;
  info.sorted_by_y = verdict.functions.count > 0 && verdict.functions[0].regular_x();
  info.steps = std::move(here);
  infos.push_back(std::move(info));
}

void CellTree::split_leaf(std::int32_t cell) {
  std::vector<std::uint32_t> steps;
  surface_.index.over(cells[static_cast<std::size_t>(cell)].box, steps);
  const std::int32_t info = cells[static_cast<std::size_t>(cell)].info;
  if (info >= 0) infos[static_cast<std::size_t>(info)].cell = -1;  // no leaf any more
  cells[static_cast<std::size_t>(cell)].info = -1;
  divide(cell);
  const std::int32_t child = cells[static_cast<std::size_t>(cell)].child;
  for (std::int32_t k = 0; k < 4; ++k) grow(child + k, steps);
}

}  // namespace diesink
