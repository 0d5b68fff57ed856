// SPDX-License-Identifier: Apache-2.0
#include "core/machining/lattice_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/machining/plan_clip.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// The lattice carried on by the cutter's diameter: material outside the domain holds it off too.
PlanLattice wide(const PlanLattice& lattice, const CutterShape& cutter) {
  PlanLattice out = lattice;
  const auto more = [&](double step) {
    return static_cast<std::size_t>(std::ceil(2 * cutter.radius() / step));
  };
  const std::size_t i = more(lattice.dx), j = more(lattice.dy);
  out.x0 -= static_cast<double>(i) * lattice.dx;
  out.y0 -= static_cast<double>(j) * lattice.dy;
  out.columns += 2 * i;
  out.rows += 2 * j;
  return out;
}

// The lower of the two ways to span four corners by triangles, so that its difference to a plane is
// largest at corners.
double spanned(double z00, double z10, double z01, double z11, double u, double v) {
  if (z00 + z11 >= z10 + z01) {  // folded up along the other diagonal
    return u + v <= 1 ? z00 + u * (z10 - z00) + v * (z01 - z00)
                      : z11 + (1 - u) * (z01 - z11) + (1 - v) * (z10 - z11);
  }
  return u >= v ? z00 + u * (z10 - z00) + v * (z11 - z10) : z00 + v * (z01 - z00) + u * (z11 - z01);
}

std::size_t index_of(double at, double from, double step, std::size_t cells) {
  return static_cast<std::size_t>(
      std::clamp(std::floor((at - from) / step), 0.0, static_cast<double>(cells) - 1));
}

}  // namespace

LatticeHeights heights_over(const CompoundSurface& surface, const PlanLattice& lattice,
                            int threads) {
  LatticeHeights out;
  const std::size_t count = lattice.columns * lattice.rows;
  out.z.resize(count);
  out.nx.resize(count);
  out.ny.resize(count);
  out.nz.resize(count);
  std::vector<double> xs(lattice.columns);
  for (std::size_t i = 0; i < xs.size(); ++i) xs[i] = lattice.x(i);
  parallel_blocks(lattice.rows, 8, threads, [&](std::size_t begin, std::size_t end, int) {
    std::vector<double> nx(xs.size()), ny(xs.size()), nz(xs.size());
    std::vector<Label> label(xs.size());
    for (std::size_t j = begin; j < end; ++j) {
      const std::size_t at = j * xs.size();
      surface.row(lattice.y(j), xs,
                  {out.z.data() + at, nx.data(), ny.data(), nz.data(), label.data()});
      for (std::size_t i = 0; i < xs.size(); ++i) {
        out.nx[at + i] = static_cast<float>(nx[i]);
        out.ny[at + i] = static_cast<float>(ny[i]);
        out.nz[at + i] = static_cast<float>(nz[i]);
        if (label[i] == kNoLabel) out.z[at + i] = kNaN;
      }
    }
  });
  return out;
}

std::vector<float> cell_dips(const TriangleMesh& mesh, double deviation, const PlanLattice& lattice,
                             const std::vector<double>& z, double wall, int threads) {
  constexpr std::size_t kRowsABlock = 32;
  std::vector<float> dips(z.size(), -std::numeric_limits<float>::infinity());
  if (lattice.columns < 2 || lattice.rows < 2) return dips;
  const std::size_t columns = lattice.columns - 1, rows = lattice.rows - 1;
  const auto raise = [&](std::size_t k, double dip) {
    dips[k] = std::max(dips[k], static_cast<float>(dip * (1 + 1e-6)));
  };
  parallel_blocks(rows, kRowsABlock, threads, [&](std::size_t begin, std::size_t end, int) {
    const double low_y = lattice.y(begin), high_y = lattice.y(end);
    for (const auto& ids : mesh.triangles) {
      const std::array<Vec3, 3> v{mesh.positions[ids[0]], mesh.positions[ids[1]],
                                  mesh.positions[ids[2]]};
      const double y0 = std::min({v[0].y(), v[1].y(), v[2].y()});
      const double y1 = std::max({v[0].y(), v[1].y(), v[2].y()});
      if (y1 < low_y || y0 > high_y) continue;
      const Vec3 n = (v[1] - v[0]).cross(v[2] - v[0]);
      const double size = n.norm();
      const bool up = size > 0 && n.z() > 1e-7 * size;
      if (!up &&
          std::max({v[0].z(), v[1].z(), v[2].z()}) - std::min({v[0].z(), v[1].z(), v[2].z()}) <=
              wall)
        continue;
      // The true surface lies no more than this lower on a vertical line.
      const double slack = up ? deviation * size / n.z() : kInfinity;
      PlanPolygon triangle;
      for (const Vec3& p : v) triangle.add(p);
      const std::size_t j1 = std::min(index_of(y1, lattice.y0, lattice.dy, rows), end - 1);
      for (std::size_t j = std::max(index_of(y0, lattice.y0, lattice.dy, rows), begin); j <= j1;
           ++j) {
        const PlanPolygon band = cut(cut(triangle, 1, lattice.y(j), 1), 1, lattice.y(j + 1), -1);
        if (band.size == 0) continue;
        double x0 = kInfinity, x1 = -kInfinity;
        for (std::size_t k = 0; k < band.size; ++k) {
          x0 = std::min(x0, band.p[k].x());
          x1 = std::max(x1, band.p[k].x());
        }
        if (x1 < lattice.x0 || x0 > lattice.x(columns)) continue;
        const std::size_t i1 = index_of(x1, lattice.x0, lattice.dx, columns);
        for (std::size_t i = index_of(x0, lattice.x0, lattice.dx, columns); i <= i1; ++i) {
          const std::size_t k = j * lattice.columns + i;
          if (!up) {
            raise(k, kInfinity);
            continue;
          }
          const PlanPolygon part = cut(cut(band, 0, lattice.x(i), 1), 0, lattice.x(i + 1), -1);
          for (std::size_t q = 0; q < part.size; ++q) {
            const double u = std::clamp((part.p[q].x() - lattice.x(i)) / lattice.dx, 0.0, 1.0);
            const double w = std::clamp((part.p[q].y() - lattice.y(j)) / lattice.dy, 0.0, 1.0);
            const double straight =
                spanned(z[k], z[k + 1], z[k + lattice.columns], z[k + lattice.columns + 1], u, w);
            raise(k, std::isnan(straight) ? kInfinity : straight - part.p[q].z() + slack);
          }
        }
      }
    }
  });
  return dips;
}

LatticeCheck::LatticeCheck(const CompoundSurface& surface, const CutterShape& cutter,
                           const PlanLattice& lattice, const LatticeHeights& heights,
                           const GougeSearch& mesh, double deviation, const VerifyOptions& options)
    : surface_(&surface),
      cutter_(cutter),
      lattice_(lattice),
      limit_(options.outtol + options.cusp.value_or(0)),
      slack_(options.outtol),
      z_(&heights),
      mesh_(&mesh),
      least_touch_(2 * deviation),
      touch_(2 * deviation + limit_ / 16),
      pyramid_(wide(lattice, cutter),
               heights_over(surface, wide(lattice, cutter), options.threads).z) {}

bool LatticeCheck::in_domain(const Vec2& p) const {
  const double hair = 1e-9 * cutter_.radius();
  return p.x() >= lattice_.x0 - hair && p.y() >= lattice_.y0 - hair &&
         p.x() <= lattice_.x(lattice_.columns - 1) + hair &&
         p.y() <= lattice_.y(lattice_.rows - 1) + hair;
}

bool LatticeCheck::reachable(std::size_t i, std::size_t j, double z, const Vec3& n,
                             double stays) const {
  const double flat = n.head<2>().norm();
  const double shift = cutter_.corner() + (flat > kLevel ? cutter_.flat() / flat : 0);
  const Vec3 tip(lattice_.x(i) + shift * n.x(), lattice_.y(j) + shift * n.y(),
                 z + cutter_.corner() * (n.z() - 1));
  return in_domain(tip.head<2>()) && pyramid_.clears(cutter_, tip, slack_) &&
         mesh_->stands_free(tip, std::clamp(stays - limit_, least_touch_, touch_));
}

double LatticeCheck::depth_of_free_cutter(std::size_t i, std::size_t j, double z) const {
  constexpr int kHeadings = 24;
  const auto held = [&](double depth) {
    for (int k = 0; k < kHeadings; ++k) {
      const double angle = 2 * std::numbers::pi * k / kHeadings;
      const double reach = cutter_.radius() - depth;
      const Vec2 at(lattice_.x(i) + reach * std::cos(angle),
                    lattice_.y(j) + reach * std::sin(angle));
      // The point is so deep in the cutter's body: under its side and over its end.
      const Vec3 stand(at.x(), at.y(), z - std::max(cutter_.corner(), depth));
      if (in_domain(at) && pyramid_.clears(cutter_, stand, slack_) &&
          mesh_->stands_free(stand, touch_)) {
        return true;
      }
    }
    return false;
  };
  // What is no deeper than a touch tells nothing, whatever the limit.
  double low = std::max(limit_, touch_);
  if (!(low < cutter_.radius()) || !held(low)) return 0;
  double high = std::min(2 * low, cutter_.radius());
  while (high < cutter_.radius() && held(high)) {
    low = high;
    high = std::min(2 * low, cutter_.radius());
  }
  // No more than what is found; to a sixty-fourth of it.
  while (high - low > low / 64) {
    const double middle = low + (high - low) / 2;
    (held(middle) ? low : high) = middle;
  }
  return std::max(0.0, low - touch_);  // raised by that it touches nothing
}

double LatticeCheck::distance(const Vec3& p, double above) const {
  double best = above;
  Vec2 foot = p.head<2>();
  // Goes on from a place to the foot on the surface's plane there for as long as that is nearer.
  const auto look = [&](Vec2 q) {
    constexpr int kSteps = 16;
    for (int k = 0; k < kSteps; ++k) {
      const std::optional<CcDatum> cc = surface_->at(q.x(), q.y());
      if (!cc) return;
      const Vec3 off = p - Vec3(q.x(), q.y(), cc->z);
      // All below the surface is the part: what is higher than the point is as near as its side.
      const double there = off.z() > 0 ? off.norm() : off.head<2>().norm();
      if (there < best) {
        best = there;
        foot = q;
      } else if (k > 1) {
        return;
      }
      if (!(off.z() > 0)) return;
      q = (p - off.dot(cc->n) * cc->n).head<2>();
    }
  };
  look(foot);
  constexpr double kFinest = 1.0 / 128;
  for (double step = best / 2; step > best * kFinest; step /= 2) {
    const Vec2 from = foot;
    for (int k = 0; k < 8; ++k) {
      const double angle = std::numbers::pi / 4 * k;
      look(from + step * Vec2(std::cos(angle), std::sin(angle)));
    }
  }
  return best;
}

RowFindings LatticeCheck::row(std::size_t j, const SweptHeights& swept, float* height,
                              CutState* state) const {
  RowFindings out;
  const std::vector<double>& left = swept.heights();
  const auto share = [](std::size_t at, std::size_t count) {
    return at == 0 || at + 1 == count ? 0.5 : 1.0;
  };
  for (std::size_t i = 0; i < lattice_.columns; ++i) {
    const std::size_t k = j * lattice_.columns + i;
    const double cell = share(i, lattice_.columns) * share(j, lattice_.rows);
    const double z = z_->z[k];
    height[i] = 0;
    if (std::isnan(z)) {
      state[i] = CutState::kNoSurface;
      continue;
    }
    const Vec3 n(static_cast<double>(z_->nx[k]), static_cast<double>(z_->ny[k]),
                 static_cast<double>(z_->nz[k]));
    const bool cut = left[k] < kInfinity;
    const double above = left[k] - z;
    double stays = cut ? above * n.z() : 0;
    const Vec3 top(lattice_.x(i), lattice_.y(j), left[k]);
    // The normal is not the nearest way where the surface bends away or ends at an edge. Far up,
    // that is only looked at where it matters.
    bool far = above >= 8 * limit_ && stays > limit_;
    if (cut && above > limit_ && !far) stays = distance(top, above);
    if ((!cut || stays > limit_) && !reachable(i, j, z, n, cut ? stays : kInfinity)) {
      double beside = 0;
      if (cut && steep_beside(left, i, j)) beside = depth_of_free_cutter(i, j, left[k]);
      if (!(beside > limit_)) {
        state[i] = CutState::kUnreachable;
        out.unreachable += cell;
        continue;
      }
      if (far) stays = std::min(stays, distance(top, above));
      far = false;
      // Where the part itself is the nearest, the cutter came as near to it as it may.
      if (beside + 2 * touch_ < stays) out.beside.push_back(i);
      stays = std::min(stays, beside);
    }
    if (cut && far && stays > limit_) stays = std::min(stays, distance(top, above));
    if (!cut) {
      state[i] = CutState::kUncut;
      out.uncut += cell;
      continue;
    }
    state[i] = CutState::kCut;
    height[i] = static_cast<float>(stays);
    if (stays > limit_) {
      out.uncut += cell;
    } else {
      out.cusps.push_back(static_cast<float>(std::fmax(stays, 0)));
    }
    if (stays > out.excess) {
      out.excess = stays;
      out.excess_at = Vec3(lattice_.x(i), lattice_.y(j), z);
    }
  }
  return out;
}

bool LatticeCheck::steep_beside(const std::vector<double>& left, std::size_t i,
                                std::size_t j) const {
  const std::size_t k = j * lattice_.columns + i;
  const double down = left[k] - 4 * std::max(limit_, std::max(lattice_.dx, lattice_.dy));
  return (i > 0 && left[k - 1] < down) || (i + 1 < lattice_.columns && left[k + 1] < down) ||
         (j > 0 && left[k - lattice_.columns] < down) ||
         (j + 1 < lattice_.rows && left[k + lattice_.columns] < down);
}

void LatticeCheck::cells(std::size_t j, const SweptHeights& swept, const std::vector<float>& dips,
                         const VerifyReport& points, RowFindings& out,
                         const RowFindings& next) const {
  if (j + 1 >= lattice_.rows) return;
  std::vector<bool> beside(lattice_.columns);
  for (const RowFindings* row : {&static_cast<const RowFindings&>(out), &next}) {
    for (const std::size_t i : row->beside) beside[i] = true;
  }
  for (std::size_t i = 0; i + 1 < lattice_.columns; ++i) {
    const std::size_t k = j * lattice_.columns + i;
    bool cut = !beside[i] && !beside[i + 1];
    bool over = false;
    double nz = 0;
    for (const std::size_t c : {k, k + 1, k + lattice_.columns, k + lattice_.columns + 1}) {
      cut = cut && points.state[c] == CutState::kCut;
      over = over || static_cast<double>(points.height[c]) > limit_;
      nz = std::max(nz, static_cast<double>(z_->nz[c]));
    }
    if (!cut) continue;
    ++out.cells;
    const double bound =
        (static_cast<double>(swept.over_cells()[k]) + static_cast<double>(dips[k])) * nz;
    if (bound <= limit_) {
      ++out.proven_cells;
      out.bound = std::max(out.bound, bound);
    } else {
      out.open.push_back({k, bound, over});
    }
  }
}

}  // namespace diesink
