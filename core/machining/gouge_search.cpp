// SPDX-License-Identifier: Apache-2.0
#include "core/machining/gouge_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace diesink {

namespace {

constexpr std::size_t kMovesABlock = 256;
constexpr std::size_t kSampleStep = 97;

int cell_of(double at, double from, double cell, int count) {
  return static_cast<int>(std::clamp(std::floor((at - from) / cell), 0.0, count - 1.0));
}

// The part of a move whose plan position lies within a box; false where none does.
bool clip(const SweepMove& move, double x0, double x1, double y0, double y1, double& t0,
          double& t1) {
  t0 = 0;
  t1 = 1;
  for (const int axis : {0, 1}) {
    const double from = move.from[axis], d = move.to[axis] - from;
    const double lo = axis == 0 ? x0 : y0, hi = axis == 0 ? x1 : y1;
    if (d == 0) {
      if (from < lo || from > hi) return false;
      continue;
    }
    const double a = (lo - from) / d, b = (hi - from) / d;
    t0 = std::max(t0, std::min(a, b));
    t1 = std::min(t1, std::max(a, b));
  }
  return t0 <= t1;
}

// A lower bound of the cutter's height over a plan box, from the part of the move that reaches it.
double height_bound(const CutterShape& cutter, const SweepMove& move, double x0, double x1,
                    double y0, double y1) {
  const double R = cutter.radius();
  const Vec3 d = move.to - move.from;
  Vec3 a = move.from, b = move.to;
  // Of a long move only the part near the box counts.
  if (std::abs(d.x()) + std::abs(d.y()) > R) {
    double t0, t1;
    if (!clip(move, x0 - R, x1 + R, y0 - R, y1 + R, t0, t1)) {
      return std::numeric_limits<double>::infinity();
    }
    a = move.from + t0 * d;
    b = move.from + t1 * d;
  }
  const double gap_x =
      std::max(0.0, std::max(x0 - std::max(a.x(), b.x()), std::min(a.x(), b.x()) - x1));
  const double gap_y =
      std::max(0.0, std::max(y0 - std::max(a.y(), b.y()), std::min(a.y(), b.y()) - y1));
  const double gap = std::sqrt(gap_x * gap_x + gap_y * gap_y);
  if (gap > R) return std::numeric_limits<double>::infinity();
  return std::min(a.z(), b.z()) + cutter.height(gap);
}

}  // namespace

GougeSearch::GougeSearch(const TriangleMesh& mesh, const CutterShape& cutter)
    : mesh_(&mesh), cutter_(cutter) {
  double x1 = 0, y1 = 0;
  bool first = true;
  for (const Vec3& p : mesh.positions) {
    if (first) {
      x0_ = x1 = p.x();
      y0_ = y1 = p.y();
      ceiling_ = p.z();
      first = false;
    }
    x0_ = std::min(x0_, p.x());
    x1 = std::max(x1, p.x());
    y0_ = std::min(y0_, p.y());
    y1 = std::max(y1, p.y());
    ceiling_ = std::max(ceiling_, p.z());
  }
  const double width = std::max(x1 - x0_, 1e-300), depth = std::max(y1 - y0_, 1e-300);
  const double count = std::max(1.0, static_cast<double>(mesh.triangles.size()));
  cell_ = std::max(std::min(cutter.radius() / 8, std::sqrt(8 * width * depth / count)),
                   std::max(width, depth) / 4096);
  nx_ = static_cast<int>(std::max(1.0, std::ceil(width / cell_)));
  ny_ = static_cast<int>(std::max(1.0, std::ceil(depth / cell_)));
  const auto cells = static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_);
  start_.assign(cells + 1, 0);
  tops_.assign(cells, -std::numeric_limits<float>::infinity());
  const auto each = [&](std::size_t t, const auto& visit) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3 low = mesh.positions[i].cwiseMin(mesh.positions[j]).cwiseMin(mesh.positions[k]);
    const Vec3 high = mesh.positions[i].cwiseMax(mesh.positions[j]).cwiseMax(mesh.positions[k]);
    const int ci1 = cell_of(high.x(), x0_, cell_, nx_), cj1 = cell_of(high.y(), y0_, cell_, ny_);
    for (int cj = cell_of(low.y(), y0_, cell_, ny_); cj <= cj1; ++cj) {
      for (int ci = cell_of(low.x(), x0_, cell_, nx_); ci <= ci1; ++ci) {
        visit(static_cast<std::size_t>(cj) * static_cast<std::size_t>(nx_) +
                  static_cast<std::size_t>(ci),
              high.z());
      }
    }
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    each(t, [&](std::size_t c, double top) {
      ++start_[c + 1];
      const float rounded =
          std::nextafter(static_cast<float>(top), std::numeric_limits<float>::infinity());
      tops_[c] = std::max(tops_[c], rounded);
    });
  }
  for (std::size_t c = 0; c < cells; ++c) start_[c + 1] += start_[c];
  items_.resize(start_.back());
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    each(t, [&](std::size_t c, double) { items_[next[c]++] = static_cast<std::uint32_t>(t); });
  }
}

std::array<Vec3, 3> GougeSearch::corners(std::uint32_t triangle) const {
  const auto& ids = mesh_->triangles[triangle];
  return {mesh_->positions[ids[0]], mesh_->positions[ids[1]], mesh_->positions[ids[2]]};
}

// False where the triangle is certainly no deeper than that, by its box.
bool GougeSearch::may_reach(const std::array<Vec3, 3>& triangle, const SweepMove& move,
                            double depth) const {
  const Vec3 low = triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]);
  const Vec3 high = triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]);
  return high.z() - height_bound(cutter_, move, low.x(), high.x(), low.y(), high.y()) > depth;
}

// A height for the shank's end, above everything.
double GougeSearch::ceiling_over(const SweepMove& move) const {
  return std::max(ceiling_, std::max(move.from.z(), move.to.z())) + 4 * cutter_.radius();
}

template <class Visit>
void GougeSearch::each_near(const SweepMove& move, const double& depth, const Visit& visit) const {
  const double R = cutter_.radius();
  // Nothing of the part is higher: most rapid moves end here.
  if (std::min(move.from.z(), move.to.z()) >= ceiling_) return;
  const double low_x = std::min(move.from.x(), move.to.x()) - R;
  const double high_x = std::max(move.from.x(), move.to.x()) + R;
  const double low_y = std::min(move.from.y(), move.to.y()) - R;
  const double high_y = std::max(move.from.y(), move.to.y()) + R;
  if (high_x < x0_ || high_y < y0_ || low_x > x0_ + nx_ * cell_ || low_y > y0_ + ny_ * cell_)
    return;
  const int cj1 = cell_of(high_y, y0_, cell_, ny_);
  for (int cj = cell_of(low_y, y0_, cell_, ny_); cj <= cj1; ++cj) {
    // The columns that the move reaches from this row of cells.
    const double cell_y = y0_ + cj * cell_;
    double t0, t1;
    if (!clip(move, -1e300, 1e300, cell_y - R, cell_y + cell_ + R, t0, t1)) continue;
    const double xa = move.from.x() + t0 * (move.to.x() - move.from.x());
    const double xb = move.from.x() + t1 * (move.to.x() - move.from.x());
    const int ci1 = cell_of(std::max(xa, xb) + R, x0_, cell_, nx_);
    for (int ci = cell_of(std::min(xa, xb) - R, x0_, cell_, nx_); ci <= ci1; ++ci) {
      const auto c = static_cast<std::size_t>(cj) * static_cast<std::size_t>(nx_) +
                     static_cast<std::size_t>(ci);
      const double cell_x = x0_ + ci * cell_;
      const double top = static_cast<double>(tops_[c]);
      // Vertically no deeper than the worst so far, hence not deeper at all; the first test is
      // without the cutter's shape.
      if (start_[c] == start_[c + 1] || top - std::min(move.from.z(), move.to.z()) <= depth)
        continue;
      if (top - height_bound(cutter_, move, cell_x, cell_x + cell_, cell_y, cell_y + cell_) <=
          depth)
        continue;
      for (std::uint32_t k = start_[c]; k < start_[c + 1]; ++k) {
        if (!visit(items_[k])) return;
      }
    }
  }
}

void GougeSearch::search(const SweepMove& move, Scratch& scratch, Gouge& worst) const {
  if (scratch.seen.size() != mesh_->triangles.size() || scratch.mark > 0xF0000000u) {
    scratch.seen.assign(mesh_->triangles.size(), 0);
    scratch.mark = 0;
  }
  ++scratch.mark;
  const double ceiling = ceiling_over(move);
  each_near(move, worst.depth, [&](std::uint32_t t) {
    if (scratch.seen[t] == scratch.mark) return true;
    scratch.seen[t] = scratch.mark;
    const std::array<Vec3, 3> triangle = corners(t);
    if (!may_reach(triangle, move, worst.depth)) return true;
    const SweepDepth depth = sweep_depth(cutter_, move, triangle, worst.depth, ceiling);
    worst.bound = std::max(worst.bound, depth.bound);
    if (depth.found > worst.depth) {
      worst.depth = depth.found;
      worst.move = move;
      worst.triangle = t;
    }
    return true;
  });
}

bool GougeSearch::stands_free(const Vec3& tip, double depth) const {
  const SweepMove still{tip, tip};
  const double ceiling = ceiling_over(still);
  bool free = true;
  each_near(still, depth, [&](std::uint32_t t) {
    const std::array<Vec3, 3> triangle = corners(t);
    if (!may_reach(triangle, still, depth)) return true;
    free = !(sweep_depth(cutter_, still, triangle, depth, ceiling).found > depth);
    return free;
  });
  return free;
}

void GougeSearch::add(std::span<const SweepMove> moves, int threads) {
  scratch_.resize(static_cast<std::size_t>(thread_count(threads)));
  // The worst of a sample first: whatever cannot be deeper than that is passed over quickly.
  for (std::size_t k = 0; k < moves.size(); k += kSampleStep) {
    search(moves[k], scratch_[0], worst_);
  }
  const std::size_t blocks = (moves.size() + kMovesABlock - 1) / kMovesABlock;
  std::vector<Gouge> worst(blocks, worst_);
  parallel_blocks(
      moves.size(), kMovesABlock, threads, [&](std::size_t begin, std::size_t end, int worker) {
        for (std::size_t k = begin; k < end; ++k) {
          search(moves[k], scratch_[static_cast<std::size_t>(worker)], worst[begin / kMovesABlock]);
        }
      });
  // Each block's own worst, so that the answer does not hang on who was first.
  for (const Gouge& w : worst) {
    const double bound = std::max(worst_.bound, w.bound);
    if (w.depth > worst_.depth) worst_ = w;
    worst_.bound = bound;
  }
}

Gouge GougeSearch::deepest() const {
  Gouge all = worst_;
  all.bound = std::max(all.bound, all.depth);
  if (all.depth > 0) all.at = deepest_point(all.move, all.triangle);
  return all;
}

// Quarters the triangle around its deepest part.
Vec3 GougeSearch::deepest_point(const SweepMove& move, std::uint32_t triangle) const {
  std::array<Vec3, 3> t = corners(triangle);
  const double ceiling = ceiling_over(move);
  for (int level = 0; level < 24; ++level) {
    const Vec3 ab = (t[0] + t[1]) / 2, bc = (t[1] + t[2]) / 2, ca = (t[2] + t[0]) / 2;
    const std::array<std::array<Vec3, 3>, 4> parts{
        {{ab, bc, ca}, {t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}}};
    double deepest = -1;
    for (const std::array<Vec3, 3>& part : parts) {
      const double depth = sweep_depth(cutter_, move, part, 0, ceiling).found;
      if (depth <= deepest) continue;
      deepest = depth;
      t = part;
    }
  }
  return (t[0] + t[1] + t[2]) / 3;
}

}  // namespace diesink
