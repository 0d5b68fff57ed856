// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/cell_tree.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace diesink {
namespace {

// Where a cell is cut: off the middle, so that cell borders do not fall on the round coordinates of
// drawings, and not alike in x and y, so that cells' corners do not fall on diagonals. Powers of
// them keep cells within 1 : 2 over 22 levels.
constexpr double kCutX = 0.4931, kCutY = 0.5083;
// Cells with more steps than this are divided at once, up to so many cells: what is below them is
// grown in parallel.
constexpr std::size_t kManySteps = 12, kMostSeeds = 4096;
// Seeds that keep all cores busy to the end, and levels gone down by one cell at a time for them.
constexpr std::size_t kEnoughSeeds = 64;
constexpr int kOpenLevels = 5;
// What a variant adds to the one and takes off the other.
constexpr double kOtherCut = 0.0021;
constexpr double kWider = 16;  // least cells of what is grown anew (SearchBudget::cells)
constexpr double kWidest = 1 << 20;

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
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      roots.push_back(static_cast<std::int32_t>(cells.size()));
      cells.push_back({{line(box.x0, box.x1, i, columns), line(box.x0, box.x1, i + 1, columns),
                        line(box.y0, box.y1, j, rows), line(box.y0, box.y1, j + 1, rows)}});
    }
  }
  // Cells that cannot but be divided, where there is enough to share out: over many bodies.
  std::vector<std::int32_t> open = roots;
  std::vector<Seed> seeds;
  while (!open.empty()) {
    std::vector<std::int32_t> next;
    for (const std::int32_t c : open) {
      Seed seed;
      seed.cell = c;
      surface_.index.over(cells[static_cast<std::size_t>(c)].box, seed.steps);
      if (seed.steps.size() <= kManySteps) {
        seeds.push_back(std::move(seed));
        continue;
      }
      divide(cells, c);
      for (std::int32_t k = 0; k < 4; ++k)
        next.push_back(cells[static_cast<std::size_t>(c)].child + k);
    }
    // Bodies that all lie over one another are not told apart this way.
    const double side = open.empty() ? 0
                                     : cells[static_cast<std::size_t>(open[0])].box.x1 -
                                           cells[static_cast<std::size_t>(open[0])].box.x0;
    if (!next.empty() && (next.size() + seeds.size() > kMostSeeds || side < 16 * limits_.least)) {
      for (const std::int32_t c : next) {
        Seed seed;
        seed.cell = c;
        surface_.index.over(cells[static_cast<std::size_t>(c)].box, seed.steps);
        seeds.push_back(std::move(seed));
      }
      next.clear();
    }
    open = std::move(next);
  }
  open_up(seeds);
  grow_all(seeds);
}

// Goes down from few seeds level by level, so that there are many to share out.
void CellTree::open_up(std::vector<Seed>& seeds) {
  if (limits_.most_cells > 0) return;  // they are grown one after another
  for (int level = 0; level < kOpenLevels && seeds.size() < kEnoughSeeds; ++level) {
    std::vector<Sprout> sprouts(seeds.size());
    std::vector<char> divided(seeds.size());
    parallel_blocks(seeds.size(), 1, limits_.threads, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) {
        sprouts[k].cells.push_back(cells[static_cast<std::size_t>(seeds[k].cell)]);
        divided[k] = decide(sprouts[k], 0, seeds[k].steps) ? 1 : 0;
      }
    });
    std::vector<Seed> next;
    for (std::size_t k = 0; k < seeds.size(); ++k) {
      const std::int32_t cell = seeds[k].cell;
      take(std::move(sprouts[k]), cell);
      if (divided[k] == 0) continue;
      const std::int32_t child = cells[static_cast<std::size_t>(cell)].child;
      for (std::int32_t c = child; c < child + 4; ++c) next.push_back({c, seeds[k].steps, false});
    }
    seeds = std::move(next);
  }
}

void CellTree::divide(std::vector<TreeCell>& all, std::int32_t cell) const {
  const TreeCell parent = all[static_cast<std::size_t>(cell)];
  const PlanBox& b = parent.box;
  const double other = kOtherCut * limits_.variant;
  const double x = b.x0 + (kCutX + other) * (b.x1 - b.x0);
  const double y = b.y0 + (kCutY - other) * (b.y1 - b.y0);
  all[static_cast<std::size_t>(cell)].child = static_cast<std::int32_t>(all.size());
  const PlanBox parts[4] = {
      {b.x0, x, b.y0, y}, {x, b.x1, b.y0, y}, {b.x0, x, y, b.y1}, {x, b.x1, y, b.y1}};
  for (const PlanBox& part : parts) {
    TreeCell child;
    child.box = part;
    child.level = static_cast<std::uint8_t>(parent.level + 1);
    all.push_back(child);
  }
}

void CellTree::grow(Sprout& sprout, std::int32_t cell,
                    const std::vector<std::uint32_t>& steps) const {
  if (sprout.cells.size() > limits_.most_of_a_seed) return;  // to be grown anew
  std::vector<std::uint32_t> here = steps;
  if (!decide(sprout, cell, here)) return;
  const std::int32_t child = sprout.cells[static_cast<std::size_t>(cell)].child;
  for (std::int32_t k = 0; k < 4; ++k) grow(sprout, child + k, here);
}

bool CellTree::decide(Sprout& sprout, std::int32_t cell, std::vector<std::uint32_t>& here) const {
  const CellBox box = CellBox::of(sprout.cells[static_cast<std::size_t>(cell)].box);
  CellVerdict verdict;
  classify(surface_, vertices_, box, here, limits_.flat, verdict);
  if (verdict.kind == CellKind::kArc || verdict.kind == CellKind::kCorner) {
    const bool straight = std::all_of(verdict.functions.begin(), verdict.functions.end(),
                                      [](const PlanFunction& f) { return f.is_nearly_straight(); });
    if (!straight) {
      verdict.kind = is_shallow(verdict, box, limits_.flat) ? CellKind::kLeast : CellKind::kUnknown;
    }
  }
  sprout.stopped =
      sprout.stopped || (sprout.most_cells > 0 && sprout.cells.size() > sprout.most_cells);
  const bool least =
      sprout.stopped || 2 * std::fmax(box.hx, box.hy) <= sprout.wider * limits_.least;
  if (verdict.kind == CellKind::kUnknown && least) verdict.kind = CellKind::kLeast;
  if (verdict.kind == CellKind::kUnknown) {
    divide(sprout.cells, cell);
    return true;
  }
  TreeCell& leaf = sprout.cells[static_cast<std::size_t>(cell)];
  leaf.kind = verdict.kind;
  if (verdict.kind == CellKind::kPlain) {
    leaf.label = verdict.candidates.count > 0 ? verdict.candidates[0].label : kNoLabel;
    return false;
  }
  leaf.info = static_cast<std::int32_t>(sprout.infos.size());
  CellInfo info;
  info.cell = cell;
  info.has_vertex = verdict.has_vertex;
  info.star = verdict.star;
  info.branched = verdict.branched;
  info.vertex = verdict.vertex;
  info.depth = verdict.depth;
  info.sorted_by_y = verdict.functions.count > 0 && verdict.functions[0].regular_x();
  info.steps = std::move(here);
  sprout.infos.push_back(std::move(info));
  return false;
}

// Numbers what has grown below a cell after everything that is there.
void CellTree::take(Sprout&& sprout, std::int32_t cell) {
  const auto first_cell = static_cast<std::int32_t>(cells.size()) - 1;
  const auto first_info = static_cast<std::int32_t>(infos.size());
  for (TreeCell& c : sprout.cells) {
    if (c.child >= 0) c.child += first_cell;
    if (c.info >= 0) c.info += first_info;
  }
  for (CellInfo& info : sprout.infos) {
    info.cell = info.cell == 0 ? cell : info.cell + first_cell;
    infos.push_back(std::move(info));
  }
  cells[static_cast<std::size_t>(cell)] = sprout.cells[0];
  cells.insert(cells.end(), sprout.cells.begin() + 1, sprout.cells.end());
  stopped = stopped || sprout.stopped;
}

void CellTree::grow_all(const std::vector<Seed>& seeds) {
  const auto run = [&](const Seed& seed, Sprout& sprout) {
    for (;; sprout.wider *= kWider) {
      sprout.cells.assign(1, cells[static_cast<std::size_t>(seed.cell)]);
      sprout.infos.clear();
      if (!seed.divide) {
        grow(sprout, 0, seed.steps);
      } else {
        divide(sprout.cells, 0);
        for (std::int32_t k = 0; k < 4; ++k) grow(sprout, 1 + k, seed.steps);
      }
      if (sprout.stopped && !stopped && limits_.may_widen && sprout.wider < kWidest) {
        sprout.stopped = false;
        widened = true;  // seeds are grown one after another here
        continue;
      }
      if (sprout.cells.size() <= limits_.most_of_a_seed || sprout.stopped) return;
    }
  };
  if (limits_.most_cells > 0) {
    // One after another: how much is left depends on those before.
    for (const Seed& seed : seeds) {
      Sprout sprout;
      sprout.most_cells = limits_.most_cells > cells.size() ? limits_.most_cells - cells.size() : 1;
      if (limits_.may_widen) {
        // Those after a greedy one get something, too; what joining adds has a budget of its own.
        sprout.most_cells = std::max(sprout.most_cells, limits_.most_cells / (8 * seeds.size()));
        if (seed.divide) sprout.most_cells = limits_.most_of_a_seed;
      }
      sprout.stopped = stopped;
      run(seed, sprout);
      take(std::move(sprout), seed.cell);
    }
    return;
  }
  std::vector<Sprout> sprouts(seeds.size());
  parallel_blocks(seeds.size(), 1, limits_.threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) run(seeds[k], sprouts[k]);
  });
  for (std::size_t k = 0; k < seeds.size(); ++k) take(std::move(sprouts[k]), seeds[k].cell);
}

void CellTree::split_leaves(const std::vector<std::int32_t>& leaves) {
  std::vector<Seed> seeds;
  for (const std::int32_t cell : leaves) {
    Seed seed;
    seed.cell = cell;
    seed.divide = true;
    surface_.index.over(cells[static_cast<std::size_t>(cell)].box, seed.steps);
    const std::int32_t info = cells[static_cast<std::size_t>(cell)].info;
    if (info >= 0) infos[static_cast<std::size_t>(info)].cell = -1;  // no leaf any more
    cells[static_cast<std::size_t>(cell)].info = -1;
    seeds.push_back(std::move(seed));
  }
  grow_all(seeds);
}

}  // namespace diesink
