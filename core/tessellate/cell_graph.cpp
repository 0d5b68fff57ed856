// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/cell_graph.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <unordered_map>

#include "core/parallel.h"
#include "core/tessellate/border_stops.h"
#include "core/tessellate/draw_together.h"
#include "core/tessellate/graph_maker.h"

namespace diesink {
namespace cells {
namespace {

// Rounds of splitting after which cells that go on and on spoiling each other are joined as they
// are.
constexpr int kPasses = 200;

// Part of the least cell down to which corners of several heights are parted, and part of the size
// down to which other corners are: what vertices of curves are held to.
constexpr double kDeeper = 0x1p-6, kDeepest = 1e-9;
// Least cells split in one round: some corners' worth; a line of them is given up.
constexpr std::ptrdiff_t kMostDeeper = 1000;

}  // namespace

const std::vector<LineChange>& GraphMaker::changes_on(const Stretch& stretch) {
  const auto [known, fresh] = known_.try_emplace(stretch.key);
  if (fresh) known->second = search(stretch);
  tell(known->second.unsettled_area, known->second.unsettled_place);
  return known->second.changes;
}

// Counts what is not certified.
void GraphMaker::tell(double area, const Vec2& place) {
  if (!(area > 0)) return;
  if (graph_.uncertified_area == 0) graph_.uncertified_place = place;
  graph_.uncertified_area += area;
}

// Both leaves of every stretch of common border, by descent; a plain leaf has no change on its
// border.
void GraphMaker::inside(std::int32_t c) {
  const std::int32_t child = cell(c).child;
  if (child < 0) return;
  for (std::int32_t k = 0; k < 4; ++k) inside(child + k);
  beside(child, child + 1, true);
  beside(child + 2, child + 3, true);
  beside(child, child + 2, false);
  beside(child + 1, child + 3, false);
}

void GraphMaker::beside(std::int32_t a, std::int32_t b, bool upright) {
  const std::int32_t ca = cell(a).child, cb = cell(b).child;
  if ((ca < 0 && cell(a).info < 0) || (cb < 0 && cell(b).info < 0)) return;
  if (ca < 0 && cb < 0) {
    segment(a, b, upright);
    return;
  }
  // Children of a on the common border, and of b.
  const std::int32_t a0 = ca < 0 ? a : upright ? ca + 1 : ca + 2, a1 = ca < 0 ? a : ca + 3;
  const std::int32_t b0 = cb < 0 ? b : cb, b1 = cb < 0 ? b : upright ? cb + 2 : cb + 1;
  beside(a0, b0, upright);
  beside(a1, b1, upright);
}

void GraphMaker::on_border(std::int32_t c, std::uint8_t side) {
  const std::int32_t child = cell(c).child;
  if (child >= 0) {
    static constexpr std::int32_t kOnSide[4][2] = {{0, 1}, {1, 3}, {2, 3}, {0, 2}};
    on_border(child + kOnSide[side][0], side);
    on_border(child + kOnSide[side][1], side);
    return;
  }
  if (cell(c).info < 0) return;
  first_new_ = static_cast<std::uint32_t>(graph_.nodes.size());
  if (options_.seams[side] != nullptr) {
    take_seam(c, side);
  } else {
    for (const LineChange& change : changes_on(border_stretch(c, side))) add_node(change);
  }
  for (std::uint32_t n = first_new_; n < graph_.nodes.size(); ++n) {
    graph_.nodes[n].border = true;
    graph_.nodes[n].side = static_cast<std::int8_t>(side);
    found_.push_back({cell(c).info, side, n});
  }
}

// What changes on a cut between tiles is the seam's to say; each of its points is one cell's.
void GraphMaker::take_seam(std::int32_t c, std::uint8_t side) {
  const Seam& seam = *options_.seams[side];
  const PlanBox& b = cell(c).box;
  const bool upright = side == 1 || side == 3;
  const double low = upright ? b.y0 : b.x0, high = upright ? b.y1 : b.x1;
  const bool last = high >= seam.to;
  auto point = std::lower_bound(seam.points.begin(), seam.points.end(), low,
                                [](const SeamPoint& p, double at) { return p.along < at; });
  for (; point != seam.points.end(); ++point) {
    if (last ? point->along > high : point->along >= high) break;
    if (!point->change) continue;
    add_node({upright ? seam.at : point->along, upright ? point->along : seam.at, point->low,
              point->high, point->curve, point->heights});
    ++seam_changes_;
  }
}

GraphMaker::Stretch GraphMaker::border_stretch(std::int32_t c, std::uint8_t side) const {
  const PlanBox& b = cell(c).box;
  return {pair_key(c, -1 - static_cast<std::int32_t>(side)), cell(c).info,
          Vec2(side == 1 ? b.x1 : b.x0, side == 2 ? b.y1 : b.y0),
          Vec2(side == 3 ? b.x0 : b.x1, side == 0 ? b.y0 : b.y1)};
}

// Between two leaves, the first to the left of or below the other: the smaller one's side; its own
// steps are the fewer.
GraphMaker::Stretch GraphMaker::stretch_between(std::int32_t a, std::int32_t b,
                                                bool upright) const {
  const bool a_smaller = cell(a).level >= cell(b).level;
  const PlanBox& box = cell(a_smaller ? a : b).box;
  Stretch stretch{pair_key(a, b), cell(a_smaller ? a : b).info, Vec2::Zero(), Vec2::Zero()};
  if (upright) {
    const double x = a_smaller ? box.x1 : box.x0;
    stretch.from = Vec2(x, box.y0);
    stretch.to = Vec2(x, box.y1);
  } else {
    const double y = a_smaller ? box.y1 : box.y0;
    stretch.from = Vec2(box.x0, y);
    stretch.to = Vec2(box.x1, y);
  }
  return stretch;
}

void GraphMaker::segment(std::int32_t a, std::int32_t b, bool upright) {
  const std::int32_t ia = cell(a).info, ib = cell(b).info;
  first_new_ = static_cast<std::uint32_t>(graph_.nodes.size());
  for (const LineChange& change : changes_on(stretch_between(a, b, upright))) add_node(change);
  for (std::uint32_t n = first_new_; n < graph_.nodes.size(); ++n) {
    found_.push_back({ia, static_cast<std::uint8_t>(upright ? 1 : 2), n});
    found_.push_back({ib, static_cast<std::uint8_t>(upright ? 3 : 0), n});
  }
}

LineFinding GraphMaker::search(const Stretch& stretch) const {
  return line_.find(stretch.from, stretch.to,
                    tree_.infos[static_cast<std::size_t>(stretch.info)].steps);
}

void GraphMaker::add_node(const LineChange& change) {
  GraphNode node;
  node.x = change.x;
  node.y = change.y;
  node.low = change.low;
  node.high = change.high;
  node.curve = change.curve;
  node.solved = change.curve.type != CurveType::kUnsolved;
  node.heights = change.heights;
  graph_.nodes.push_back(std::move(node));
}

template <class Take>
void GraphMaker::leaves_on(std::int32_t in, std::uint8_t side, const PlanBox& box,
                           const Take& take) const {
  // Cells that end on the line where the box's side is, on its other side, along the box. Borders
  // that are one line have one coordinate, to the bit.
  const PlanBox& b = cell(in).box;
  const bool upright = side == 1 || side == 3;
  const double line = side == 0 ? box.y0 : side == 1 ? box.x1 : side == 2 ? box.y1 : box.x0;
  const double low = upright ? b.x0 : b.y0, high = upright ? b.x1 : b.y1;
  const bool beyond = side == 1 || side == 2;
  if (beyond ? !(low <= line && line < high) : !(low < line && line <= high)) return;
  const double from = upright ? b.y0 : b.x0, to = upright ? b.y1 : b.x1;
  const double at = upright ? box.y0 : box.x0, end = upright ? box.y1 : box.x1;
  if (to <= at || from >= end) return;
  const std::int32_t child = cell(in).child;
  if (child < 0) {
    if (cell(in).info >= 0) take(in);
    return;
  }
  for (std::int32_t k = 0; k < 4; ++k) leaves_on(child + k, side, box, take);
}

// take(leaf, side): the other leaf, or -1 for the domain's border.
template <class Take>
void GraphMaker::around(std::int32_t c, const Take& take) const {
  const PlanBox& box = cell(c).box;
  const PlanBox& first = cell(tree_.roots.front()).box;
  const PlanBox& last = cell(tree_.roots.back()).box;
  const bool border[4] = {box.y0 == first.y0, box.x1 == last.x1, box.y1 == last.y1,
                          box.x0 == first.x0};
  for (std::uint8_t side = 0; side < 4; ++side) {
    if (border[side]) {
      take(-1, side);
      continue;
    }
    for (const std::int32_t root : tree_.roots)
      leaves_on(root, side, box, [&](std::int32_t leaf) { take(leaf, side); });
  }
}

// Whether a least cell may be split. Not where there are many: what lies along a whole line is no
// clearer deeper down, nor what was found by halving alone. (Cells of a part of the tree that has
// been given up are wider.)
bool GraphMaker::may_be_split(const TreeCell& c, const std::vector<Item>& items,
                              double deepest) const {
  const double width = std::fmax(c.box.x1 - c.box.x0, c.box.y1 - c.box.y0);
  return !last_ && deeper_ && width <= 2 * options_.least && width > deepest &&
         std::ranges::none_of(items, [&](const Item& item) {
           return graph_.nodes[item.node].curve.type == CurveType::kUnsolved;
         });
}

// Two corners a hair apart are seen one by one in cells as small as what vertices are held to.
// (Those of a part that lies far away round to what they are apart.)
bool GraphMaker::parts_corners(const TreeCell& c, const std::vector<Item>& items) const {
  return options_.largest_coordinate == 0 && may_be_split(c, items, kDeepest * surface_.size);
}

// Beside a silhouette heights differ by more than the tolerance sees between points of the plan
// that are 1e-7 of the size apart: what a least cell would make one corner there is looked for a
// little longer.
bool GraphMaker::goes_deeper(const CellInfo& info, const TreeCell& c,
                             const std::vector<Item>& items) const {
  return info.depth > 0.25 * options_.tolerance && may_be_split(c, items, kDeeper * options_.least);
}

// Splits the cells that did not join, or has them joined as they are in the last pass; false where
// there are none.
bool GraphMaker::split_failed(bool last) {
  if (to_split_.empty()) return false;
  std::vector<std::int32_t> split;
  last_ = last;
  const auto is_least = [&](std::int32_t c) { return cell(c).kind == CellKind::kLeast; };
  deeper_ = deeper_ && std::ranges::count_if(to_split_, is_least) <= kMostDeeper;
  for (const std::int32_t c : to_split_) {
    if (is_least(c) && !deeper_) continue;
    const PlanBox b = cell(c).box;
    if (last || (cell(c).kind != CellKind::kLeast &&
                 std::fmax(b.x1 - b.x0, b.y1 - b.y0) <= 2 * options_.least)) {
      cell(c).kind = CellKind::kLeast;
    } else {
      split.push_back(c);
    }
  }
  tree_.split_leaves(split);
  return true;
}

// Whether a cell's changes join, all by itself; `known` has what its borders show.
bool GraphMaker::joins(std::int32_t info, const GraphMaker& known) {
  graph_ = {};
  found_.clear();
  to_split_.clear();
  last_ = known.last_;
  deeper_ = known.deeper_;
  const std::int32_t c = tree_.infos[static_cast<std::size_t>(info)].cell;
  around(c, [&](std::int32_t leaf, std::uint8_t side) {
    const auto first = static_cast<std::uint32_t>(graph_.nodes.size());
    if (leaf < 0 && options_.seams[side] != nullptr) {
      take_seam(c, side);
    } else {
      const bool before = side == 0 || side == 3;  // the other leaf is the lower
      const std::uint64_t key = leaf < 0 ? pair_key(c, -1 - static_cast<std::int32_t>(side))
                                : before ? pair_key(leaf, c)
                                         : pair_key(c, leaf);
      for (const LineChange& change : known.known_.at(key).changes) add_node(change);
    }
    for (std::uint32_t n = first; n < graph_.nodes.size(); ++n) found_.push_back({info, side, n});
  });
  join(info, found_);
  return to_split_.empty();
}

// Splits cells until each joins by itself: in rounds, of the cells whose borders are new. What a
// round finds depends on no other cell of it, so that threads share it out.
void GraphMaker::settle_cells() {
  std::vector<std::int32_t> open(tree_.infos.size());
  for (std::size_t i = 0; i < open.size(); ++i) open[i] = static_cast<std::int32_t>(i);
  std::vector<std::unique_ptr<GraphMaker>> workers;
  for (int t = 0; t < thread_count(options_.threads); ++t)
    workers.push_back(std::make_unique<GraphMaker>(surface_, tree_, options_));
  const std::size_t most_cells = tree_.cells.size() + options_.budget.added;
  for (int round = 0; !open.empty() && !tree_.stopped; ++round) {
    std::vector<Stretch> fresh;
    for (const std::int32_t i : open) {
      const std::int32_t c = tree_.infos[static_cast<std::size_t>(i)].cell;
      around(c, [&](std::int32_t leaf, std::uint8_t side) {
        if (leaf < 0 && options_.seams[side] != nullptr) return;
        const bool before = side == 0 || side == 3, upright = side == 1 || side == 3;
        const Stretch stretch = leaf < 0 ? border_stretch(c, side)
                                : before ? stretch_between(leaf, c, upright)
                                         : stretch_between(c, leaf, upright);
        if (known_.try_emplace(stretch.key).second) fresh.push_back(stretch);
      });
    }
    std::vector<LineFinding> found(fresh.size());
    parallel_blocks(fresh.size(), 64, options_.threads,
                    [&](std::size_t begin, std::size_t end, int) {
                      for (std::size_t k = begin; k < end; ++k) found[k] = search(fresh[k]);
                    });
    for (std::size_t k = 0; k < fresh.size(); ++k) known_[fresh[k].key] = std::move(found[k]);
    std::vector<char> joined(open.size());
    parallel_blocks(open.size(), 64, options_.threads,
                    [&](std::size_t begin, std::size_t end, int worker) {
                      GraphMaker& mine = *workers[static_cast<std::size_t>(worker)];
                      for (std::size_t k = begin; k < end; ++k)
                        joined[k] = mine.joins(open[k], *this) ? 1 : 0;
                    });
    to_split_.clear();
    for (std::size_t k = 0; k < open.size(); ++k) {
      if (!joined[k]) to_split_.push_back(tree_.infos[static_cast<std::size_t>(open[k])].cell);
    }
    const auto infos = static_cast<std::int32_t>(tree_.infos.size());
    std::vector<std::int32_t> next;
    const std::vector<std::int32_t> failed = to_split_;
    if (!split_failed(round >= kPasses || tree_.cells.size() > most_cells)) break;
    // What has no leaf of its own any more is not looked at again.
    for (const std::int32_t c : failed) {
      if (cell(c).info >= 0) next.push_back(cell(c).info);  // least now, joined whatever it holds
      around(c, [&](std::int32_t leaf, std::uint8_t) {
        if (leaf >= 0) next.push_back(cell(leaf).info);
      });
    }
    for (auto i = infos; i < static_cast<std::int32_t>(tree_.infos.size()); ++i) next.push_back(i);
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    open = std::move(next);
  }
}

CellGraph GraphMaker::make() {
  settle_cells();
  // Each round the cells that did not join are split; the least cells always join, so it ends.
  for (int pass = 0; !tree_.stopped; ++pass) {
    graph_ = {};
    seam_changes_ = 0;
    found_.clear();
    to_split_.clear();
    for (const std::int32_t root : tree_.roots) inside(root);
    const int nx = tree_.columns, ny = tree_.rows;
    const auto root = [&](int i, int j) {
      return tree_.roots[static_cast<std::size_t>(j * nx + i)];
    };
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        if (i + 1 < nx) beside(root(i, j), root(i + 1, j), true);
        if (j + 1 < ny) beside(root(i, j), root(i, j + 1), false);
        if (j == 0) on_border(root(i, j), 0);
        if (i + 1 == nx) on_border(root(i, j), 1);
        if (j + 1 == ny) on_border(root(i, j), 2);
        if (i == 0) on_border(root(i, j), 3);
      }
    }
    std::stable_sort(found_.begin(), found_.end(),
                     [](const OnBorder& a, const OnBorder& b) { return a.info < b.info; });
    std::vector<OnBorder> own;
    std::size_t k = 0;
    for (std::size_t i = 0; i < tree_.infos.size(); ++i) {
      own.clear();
      while (k < found_.size() && found_[k].info == static_cast<std::int32_t>(i))
        own.push_back(found_[k++]);
      if (tree_.infos[i].cell >= 0) join(static_cast<std::int32_t>(i), own);
    }
    if (!split_failed(pass >= kPasses)) break;
  }
  std::size_t on_seams = 0;
  for (const Seam* seam : options_.seams) {
    if (seam == nullptr) continue;
    on_seams += seam->changes();
    tell(seam->unsettled_area, seam->unsettled_place);
  }
  graph_.keeps_seams = tree_.stopped || seam_changes_ == on_seams;
  pull_to_border(surface_, options_, graph_);
  draw_together(surface_, options_, graph_);
  pull_to_border(surface_, options_, graph_);  // corners that have come to lie on it
  return std::move(graph_);
}

}  // namespace cells

CellGraph make_graph(const CompoundSurface::Impl& surface, CellTree& tree,
                     const ArrangementOptions& options) {
  return cells::GraphMaker(surface, tree, options).make();
}

}  // namespace diesink
