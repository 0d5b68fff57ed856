// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/outline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace diesink {
namespace {

// Parameters nearer than this to a side of the grid are on it: spans are one long.
constexpr double kOnSide = 1e-6;

// Parameters of a point of the border, or of one beside it by rounding: corners of the domain move
// their points by ties.
std::optional<Vec2> parameters(const FergusonSurface& base, double size, const Vec2& p) {
  std::optional<Vec2> found = base.invert(p.x(), p.y());
  for (double reach = 1e-12 * size; !found && reach < 1e-9 * size; reach *= 8) {
    for (const Vec2& way : {Vec2(1, 0), Vec2(0, 1), Vec2(-1, 0), Vec2(0, -1), Vec2(1, 1),
                            Vec2(-1, 1), Vec2(-1, -1), Vec2(1, -1)}) {
      if (!found) found = base.invert(p.x() + reach * way.x(), p.y() + reach * way.y());
    }
  }
  return found;
}

}  // namespace

int outline_side(const CompoundSurface::Impl& surface, const Vec2& p) {
  const FergusonSurface* base = std::get_if<FergusonSurface>(&surface.base);
  if (base == nullptr) return 0;
  const std::optional<Vec2> at = parameters(*base, surface.size, p);
  if (!at) return 0;
  const double off[4] = {at->y(), base->columns() - 1.0 - at->x(), base->rows() - 1.0 - at->y(),
                         at->x()};
  return static_cast<int>(std::min_element(off, off + 4) - off);
}

bool outline_vertex(const CompoundSurface::Impl& surface, int one, int two, Vec3& at) {
  const FergusonSurface* base = std::get_if<FergusonSurface>(&surface.base);
  if (base == nullptr || (one + 1) % 4 == (two + 3) % 4 || one == two) return false;
  const auto has = [&](int side) { return one == side || two == side; };
  at = base->point(has(1) ? base->columns() - 1.0 : 0, has(2) ? base->rows() - 1.0 : 0).r;
  return true;
}

bool outline_on_line(const CompoundSurface::Impl& surface, const Vec2& p, const Vec2& d, double& t,
                     double& z) {
  BaseHit hit;
  const auto there = [&](double at) {
    return surface.base_at(p.x() + at * d.x(), p.y() + at * d.y(), hit);
  };
  double in = 0, out = 0;
  bool parted = false;
  for (double reach = 1e-7; reach < 1 && !parted; reach *= 4) {
    const bool low = there(-reach), high = there(reach);
    parted = low != high;
    in = low ? -reach : reach;
    out = -in;
  }
  if (!parted) return false;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (in + out);
    if (middle == in || middle == out) break;
    (there(middle) ? in : out) = middle;
  }
  t = in;
  if (!there(t)) return false;
  z = hit.z;
  return true;
}

double outline_chord_deviation(const CompoundSurface::Impl& surface, const Vec2& a, const Vec2& b) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const FergusonSurface* base = std::get_if<FergusonSurface>(&surface.base);
  if (base == nullptr) return kUnknown;
  const std::optional<Vec2> pa = parameters(*base, surface.size, a);
  const std::optional<Vec2> pb = parameters(*base, surface.size, b);
  if (!pa || !pb) return kUnknown;
  // Axis 0: a row of the grid, v at one end of its range, w = u; axis 1 the other way round.
  const double ends[2] = {base->columns() - 1.0, base->rows() - 1.0};
  double best = kUnknown;
  for (int axis = 0; axis < 2; ++axis) {
    const int across = 1 - axis;
    for (const double side : {0.0, ends[across]}) {
      if (std::fabs((*pa)[across] - side) > kOnSide || std::fabs((*pb)[across] - side) > kOnSide)
        continue;
      const auto at = [&](double w) {
        return axis == 0 ? base->point(w, side) : base->point(side, w);
      };
      const auto along = [&](const FergusonSurface::Point& p) { return axis == 0 ? p.ru : p.rv; };
      const double w0 = std::fmin((*pa)[axis], (*pb)[axis]);
      const double w1 = std::fmax((*pa)[axis], (*pb)[axis]);
      double bend = 0;
      for (double knot = std::floor(w0); knot < w1 || knot == std::floor(w0); ++knot) {
        // The second derivative of a cubic is linear: largest at an end of the span.
        const double k0 = std::clamp(knot, 0.0, ends[axis] - 1), k1 = k0 + 1;
        const FergusonSurface::Point p = at(k0), q = at(k1);
        const Vec3 step = q.r - p.r, tp = along(p), tq = along(q);
        const Vec3 first = 6 * step - 4 * tp - 2 * tq, last = -6 * step + 2 * tp + 4 * tq;
        const auto inside = [&](double w) {
          const double s = std::clamp(w - k0, 0.0, 1.0);
          return ((1 - s) * first + s * last).norm();
        };
        bend = std::fmax(bend, std::fmax(inside(w0), inside(w1)));
      }
      const double off = std::fmax((at((*pa)[axis]).r.head<2>() - a).norm(),
                                   (at((*pb)[axis]).r.head<2>() - b).norm());
      best = std::fmin(best, 0.125 * bend * (w1 - w0) * (w1 - w0) + off);
    }
  }
  return best;
}

bool outline_corner(const CompoundSurface::Impl& surface, const Implicit& f, const Implicit& g,
                    Vec2& at, double& z, double& z_base) {
  const FergusonSurface* base = std::get_if<FergusonSurface>(&surface.base);
  if (base == nullptr) return false;
  // The nearest of many points of the border, and from there on.
  int side = 0;
  double w = 0, nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 4; ++k) {
    const int points = 16 * static_cast<int>(std::ceil(base->border_length(k)));
    for (int i = 0; i <= points; ++i) {
      const double wi = base->border_length(k) * i / points;
      const double distance = (base->border(k, wi).at - at).squaredNorm();
      if (distance < nearest) nearest = distance, side = k, w = wi;
    }
  }
  const double length = base->border_length(side);
  for (int k = 0; k < 8; ++k) {
    const FergusonSurface::BorderPoint p = base->border(side, w);
    const double step = (at - p.at).dot(p.along) / p.along.squaredNorm();
    w = std::clamp(w + step, 0.0, length);
  }
  const double done = std::ldexp(surface.size, -48);
  constexpr int kSteps = 24;
  for (int k = 0; k < kSteps; ++k) {
    const FergusonSurface::BorderPoint p = base->border(side, w);
    BaseHit hit;
    if (!surface.base_at(p.at.x(), p.at.y(), hit)) return false;
    // By w and z. The base's own equation is z = z_base(w).
    double value[2], by_w[2], by_z[2];
    const Implicit* both[2] = {&f, &g};
    for (int i = 0; i < 2; ++i) {
      if (both[i]->kind == Implicit::Kind::kBase) {
        value[i] = z - hit.z;
        by_w[i] = -(hit.zx * p.along.x() + hit.zy * p.along.y());
        by_z[i] = 1;
        continue;
      }
      Vec3 gradient;
      value[i] = both[i]->evaluate(Vec3(p.at.x(), p.at.y(), z), gradient);
      by_w[i] = gradient.head<2>().dot(p.along);
      by_z[i] = gradient.z();
    }
    const double det = by_w[0] * by_z[1] - by_w[1] * by_z[0];
    const double dw = -(value[0] * by_z[1] - value[1] * by_z[0]) / det;
    const double dz = -(by_w[0] * value[1] - by_w[1] * value[0]) / det;
    if (!std::isfinite(dw) || !std::isfinite(dz)) return false;
    w += dw;
    z += dz;
    if (w < -kOnSide || w > length + kOnSide) return false;
    w = std::clamp(w, 0.0, length);
    if (std::fabs(dw) * p.along.norm() + std::fabs(dz) > done) continue;
    at = base->border(side, w).at;
    if (!surface.base_at(at.x(), at.y(), hit)) return false;
    z_base = hit.z;
    return true;
  }
  return false;
}

}  // namespace diesink
