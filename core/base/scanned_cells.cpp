// The scan's extent, and the plan grid that points, rows and boxes look into.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/base/row_bins.h"
#include "core/base/scanned.h"

namespace diesink {
namespace {

// Triangles in random order find their vertices all over: memory is asked for some ahead.
constexpr std::size_t kAhead = 16;
constexpr std::size_t kBlock = 1 << 16;

}  // namespace

// Of the triangles that have an area in plan; the sums of box sizes tell how fine cells can be.
struct ScannedSurface::Extent {
  PlanBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  double z_low = HUGE_VAL, z_high = -HUGE_VAL, width = 0, height = 0, area = 0;
  std::size_t upright = 0;
  void add(const Vec3& p) {
    box = {std::min(box.x0, p.x()), std::max(box.x1, p.x()), std::min(box.y0, p.y()),
           std::max(box.y1, p.y())};
    z_low = std::min(z_low, p.z());
    z_high = std::max(z_high, p.z());
  }
  void add(const Extent& e) {
    box = {std::min(box.x0, e.box.x0), std::max(box.x1, e.box.x1), std::min(box.y0, e.box.y0),
           std::max(box.y1, e.box.y1)};
    z_low = std::min(z_low, e.z_low);
    z_high = std::max(z_high, e.z_high);
    width += e.width;
    height += e.height;
    area += e.area;
    upright += e.upright;
  }
  [[nodiscard]] bool same_place(const Extent& e) const {
    return box.x0 == e.box.x0 && box.x1 == e.box.x1 && box.y0 == e.box.y0 && box.y1 == e.box.y1 &&
           z_low == e.z_low && z_high == e.z_high;
  }
};

ScannedSurface::Extent ScannedSurface::measure() const {
  const std::size_t count = triangles_.size();
  // Each block's apart, added in their order: the same sums for any number of threads.
  std::vector<Extent> extents((count + kBlock - 1) / kBlock);
  parallel_blocks(count, kBlock, threads_, [&](std::size_t begin, std::size_t end, int) {
    Extent& e = extents[begin / kBlock];
    for (std::size_t i = begin; i < end; ++i) {
      if (i + kAhead < count) ask_for(i + kAhead);
      const auto [v0, v1, v2] = triangles_[i];
      const Vec3 &a = positions_[v0], &b = positions_[v1], &c = positions_[v2];
      if (turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y()) == 0) {
        ++e.upright;
        continue;
      }
      for (const Vec3* p : {&a, &b, &c}) e.add(*p);
      const PlanBox box = box_of(static_cast<std::uint32_t>(i));
      const double width = box.x1 - box.x0, height = box.y1 - box.y0;
      e.width += width;
      e.height += height;
      e.area += width * height;
    }
  });
  Extent all;
  for (const Extent& e : extents) all.add(e);
  return all;
}

bool ScannedSurface::find_extent() {
  // The box of all vertices is that of the triangles where one with an area reaches each of its
  // sides. Only those at the outermost vertices are looked at for that.
  Extent all, found;
  const std::size_t vertices = positions_.size(), count = triangles_.size();
  {
    std::vector<Extent> extents((vertices + kBlock - 1) / kBlock);
    parallel_blocks(vertices, kBlock, threads_, [&](std::size_t begin, std::size_t end, int) {
      Extent e;
      for (std::size_t v = begin; v < end; ++v) e.add(positions_[v]);
      extents[begin / kBlock] = e;
    });
    for (const Extent& e : extents) all.add(e);
  }
  {
    std::vector<std::uint64_t> outermost(vertices / 64 + 1, 0);
    parallel_blocks(vertices, kBlock, threads_, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t v = begin; v < end; ++v) {
        const Vec3& p = positions_[v];
        const bool out = p.x() == all.box.x0 || p.x() == all.box.x1 || p.y() == all.box.y0 ||
                         p.y() == all.box.y1 || p.z() == all.z_low || p.z() == all.z_high;
        outermost[v / 64] |= std::uint64_t{out ? 1U : 0U} << v % 64;
      }
    });
    std::vector<Extent> extents((count + kBlock - 1) / kBlock);
    parallel_blocks(count, kBlock, threads_, [&](std::size_t begin, std::size_t end, int) {
      const auto out = [&](std::uint32_t v) { return outermost[v / 64] >> v % 64 & 1; };
      Extent e;
      for (std::size_t i = begin; i < end; ++i) {
        const auto [v0, v1, v2] = triangles_[i];
        if ((out(v0) | out(v1) | out(v2)) == 0) continue;
        const Vec3 &a = positions_[v0], &b = positions_[v1], &c = positions_[v2];
        if (turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y()) == 0) continue;
        for (const Vec3* p : {&a, &b, &c}) e.add(*p);
      }
      extents[begin / kBlock] = e;
    });
    for (const Extent& e : extents) found.add(e);
  }
  if (count == 0) return false;
  if (!found.same_place(all)) found = measure();
  plan_box_ = found.box;
  z_low_ = found.z_low;
  z_high_ = found.z_high;
  return found.upright < count;
}

void ScannedSurface::make_plan() const {
  std::call_once(plan_->once, [&] {
    PlanGrid& plan = *plan_;
    const std::size_t count = triangles_.size();
    const Extent all = measure();
    plan.upright = all.upright;
    const double width = std::max(all.box.x1 - all.box.x0, 1e-300),
                 height = std::max(all.box.y1 - all.box.y0, 1e-300);
    Cells& cells = plan.cells;
    const auto live = static_cast<double>(count - plan.upright);
    cells.x0 = all.box.x0;
    cells.y0 = all.box.y0;
    // Two triangles a cell, fewer cells where large triangles would stand in too many of them.
    for (double wanted = std::max(1.0, 0.5 * live);; wanted *= 0.25) {
      constexpr double kMostAcross = 1 << 15;  // 16 bits hold a number of them
      const double side = std::sqrt(width * height / wanted);
      cells.nx = static_cast<int>(std::clamp(width / side, 1.0, kMostAcross));
      cells.ny = static_cast<int>(std::clamp(height / side, 1.0, kMostAcross));
      cells.per_x = cells.nx / width;
      cells.per_y = cells.ny / height;
      const double entries = live + all.width * cells.per_x + all.height * cells.per_y +
                             all.area * cells.per_x * cells.per_y;
      constexpr double kEntriesPerTriangle = 7;
      if (entries <= kEntriesPerTriangle * live || wanted <= 1) break;
    }

    const auto lines = static_cast<std::size_t>(cells.ny);
    const auto columns = static_cast<std::size_t>(cells.nx);
    const RowBins bins(count, lines, threads_, [&](std::size_t i) {
      if (i + kAhead < count) ask_for(i + kAhead);
      const auto [v0, v1, v2] = triangles_[i];
      const Vec3 &a = positions_[v0], &b = positions_[v1], &c = positions_[v2];
      if (turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y()) == 0) return CellRange{};
      const PlanBox box = box_of(static_cast<std::uint32_t>(i));
      const auto cell = [](int at) { return static_cast<std::uint16_t>(at); };
      return CellRange{cell(cells.column(box.x0)), cell(cells.column(box.x1)),
                       cell(cells.line(box.y0)), cell(cells.line(box.y1))};
    });
    // Counts line by line, then places line by line.
    plan.start.assign(lines * columns + 1, 0);
    constexpr std::size_t kLines = 4;
    parallel_blocks(lines, kLines, threads_, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t line = begin; line < end; ++line) {
        std::uint32_t* const after = plan.start.data() + line * columns + 1;
        for (const RowBins::Entry& e : bins.row(line)) {
          for (std::size_t k = e.x0; k <= e.x1; ++k) ++after[k];
        }
      }
    });
    for (std::size_t c = 1; c < plan.start.size(); ++c) plan.start[c] += plan.start[c - 1];
    plan.items = LargeArray<std::uint32_t>(plan.start.back());
    parallel_blocks(lines, kLines, threads_, [&](std::size_t begin, std::size_t end, int) {
      std::vector<std::uint32_t> next(columns);
      for (std::size_t line = begin; line < end; ++line) {
        std::copy_n(plan.start.begin() + static_cast<std::ptrdiff_t>(line * columns), columns,
                    next.begin());
        for (const RowBins::Entry& e : bins.row(line)) {
          for (std::size_t k = e.x0; k <= e.x1; ++k) plan.items.data()[next[k]++] = e.item;
        }
        for (std::size_t cell = line * columns; cell < (line + 1) * columns; ++cell) {
          if (plan.start[cell + 1] - plan.start[cell] <= PlanGrid::kDeep) continue;
          std::sort(plan.items.data() + plan.start[cell], plan.items.data() + plan.start[cell + 1],
                    [&](std::uint32_t f, std::uint32_t g) {
                      const double zf = top_of(f), zg = top_of(g);
                      return zf != zg ? zf > zg : f < g;
                    });
        }
      }
    });
    plan.made.store(true, std::memory_order_release);
  });
}

}  // namespace diesink
