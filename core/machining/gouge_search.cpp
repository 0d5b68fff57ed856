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
constexpr std::uint32_t kItemsATime = 64;
constexpr double kHair = 1e-6;  // of a cell's side; more than its rounding far from the origin

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

float down(double v) {
  const float f = static_cast<float>(v);
  return static_cast<double>(f) > v ? std::nextafter(f, -HUGE_VALF) : f;
}

float up(double v) { return -down(-v); }

// The box, and the height, of the part of a move from which the cutter reaches a box in plan; false
// where none does.
struct NearPart {
  Vec2 low, high;
  double z = 0;
};

bool near_part(const CutterShape& cutter, const SweepMove& move, const Vec2& box_low,
               const Vec2& box_high, NearPart& out) {
  const double R = cutter.radius();
  const Vec3 d = move.to - move.from;
  Vec3 a = move.from, b = move.to;
  // Of a long move only the part near the box counts.
  if (std::abs(d.x()) + std::abs(d.y()) > R) {
    double t0, t1;
    if (!clip(move, box_low.x() - R, box_high.x() + R, box_low.y() - R, box_high.y() + R, t0, t1)) {
      return false;
    }
    a = move.from + t0 * d;
    b = move.from + t1 * d;
  }
  out.low = a.head<2>().cwiseMin(b.head<2>());
  out.high = a.head<2>().cwiseMax(b.head<2>());
  out.z = std::min(a.z(), b.z());
  return true;
}

// A lower bound of the cutter's height over the box from there; infinity where it is too far off.
double height_bound(const CutterShape& cutter, const NearPart& part, const Vec2& box_low,
                    const Vec2& box_high) {
  const double gap_x = std::max({0.0, box_low.x() - part.high.x(), part.low.x() - box_high.x()});
  const double gap_y = std::max({0.0, box_low.y() - part.high.y(), part.low.y() - box_high.y()});
  const double gap = std::sqrt(gap_x * gap_x + gap_y * gap_y);
  if (gap > cutter.radius()) return std::numeric_limits<double>::infinity();
  return part.z + cutter.height(gap);
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
  for (std::vector<float>* side : {&low_x_, &high_x_, &low_y_, &high_y_, &high_z_}) {
    side->resize(items_.size());
  }
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = corners(t);
    const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    each(t, [&](std::size_t cell, double) {
      const std::uint32_t k = next[cell]++;
      const auto columns = static_cast<std::size_t>(nx_);
      const double x = x0_ + static_cast<double>(cell % columns) * cell_,
                   y = y0_ + static_cast<double>(cell / columns) * cell_;
      items_[k] = t;
      // Where rounding puts a border into the next cell, it is in that one as well.
      const double hair = kHair * cell_;
      low_x_[k] = down(std::max(low.x(), x - hair));
      high_x_[k] = up(std::min(high.x(), x + cell_ + hair));
      low_y_[k] = down(std::max(low.y(), y - hair));
      high_y_[k] = up(std::min(high.y(), y + cell_ + hair));
      high_z_[k] = up(high.z());
    });
  }
}

std::array<Vec3, 3> GougeSearch::corners(std::uint32_t triangle) const {
  const auto& ids = mesh_->triangles[triangle];
  return {mesh_->positions[ids[0]], mesh_->positions[ids[1]], mesh_->positions[ids[2]]};
}

void GougeSearch::mark_near(std::uint32_t begin, std::uint32_t count, const Vec2& low,
                            const Vec2& high, double limit, std::uint8_t* near) const {
  const float x0 = down(low.x()), x1 = up(high.x()), y0 = down(low.y()), y1 = up(high.y());
  const float z = down(limit);
  constexpr float kRounding = 1 + 1e-5F;  // of what follows, in single precision
  const float R = up(cutter_.radius()), r = up(cutter_.corner()), flat = R - down(cutter_.corner());
  const float *const bx0 = low_x_.data() + begin, *const bx1 = high_x_.data() + begin,
                     *const by0 = low_y_.data() + begin, *const by1 = high_y_.data() + begin,
                     *const top = high_z_.data() + begin;
  for (std::uint32_t k = 0; k < count; ++k) {
    const float gap_x = std::max(0.0F, std::max(bx0[k] - x1, x0 - bx1[k]));
    const float gap_y = std::max(0.0F, std::max(by0[k] - y1, y0 - by1[k]));
    // So far from its axis the cutter is lower than the top.
    const float over = top[k] - z, in_corner = std::min(over, r);
    const float reach =
        (flat + std::sqrt(std::max(0.0F, in_corner * (2 * r - in_corner)))) * kRounding;
    near[k] = static_cast<std::uint8_t>(
        (over > 0) & (gap_x * gap_x + gap_y * gap_y <= reach * reach * kRounding));
  }
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
      // Vertically no deeper than the worst so far, hence not deeper at all; the first test is
      // without the cutter's shape.
      const double top = static_cast<double>(tops_[c]);
      if (start_[c] == start_[c + 1] || top - std::min(move.from.z(), move.to.z()) <= depth)
        continue;
      const Vec2 low(x0_ + ci * cell_, cell_y), high(low.x() + cell_, cell_y + cell_);
      NearPart part;
      if (!near_part(cutter_, move, low, high, part) ||
          top - height_bound(cutter_, part, low, high) <= depth) {
        continue;
      }
      std::array<std::uint8_t, kItemsATime> near;
      for (std::uint32_t begin = start_[c]; begin < start_[c + 1]; begin += kItemsATime) {
        const std::uint32_t count = std::min(kItemsATime, start_[c + 1] - begin);
        mark_near(begin, count, part.low, part.high, part.z + depth, near.data());
        for (std::uint32_t k = 0; k < count; ++k) {
          if (near[k] != 0 && !visit(items_[begin + k])) return;
        }
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
    const SweepDepth depth = sweep_depth(cutter_, move, corners(t), worst.depth, ceiling);
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
    free = !(sweep_depth(cutter_, still, corners(t), depth, ceiling).found > depth);
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
