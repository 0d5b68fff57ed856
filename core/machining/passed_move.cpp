// SPDX-License-Identifier: Apache-2.0
#include "core/machining/passed_move.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Steps of the search below, what of the corner's radius, squared, is its rim, and the step, in
// radii, at which it ends: no height is off by more than 1e-5 of the radius then, by far less
// mostly.
constexpr int kMostSteps = 20;
constexpr double kNearRim = 0.01, kStill = 1e-5;

}  // namespace

double lowest_over(const CutterShape& cutter, double z, double slope, double length, double u,
                   double w2) {
  const double R = cutter.radius(), half = std::sqrt(std::max(0.0, R * R - w2));
  const double first = std::max(0.0, u - half), last = std::min(length, u + half);
  if (first > last) return kInfinity;
  const auto at = [&](double s) {
    const double rho = std::sqrt(w2 + (s - u) * (s - u));
    return z + slope * s + cutter.height(std::min(rho, R));
  };
  if (slope == 0) return at(std::clamp(u, first, last));
  if (cutter.corner() <= 0) return at(slope > 0 ? first : last);
  if (cutter.flat() <= 0) {
    return at(std::clamp(u - slope / std::sqrt(1 + slope * slope) * half, first, last));
  }
  // The height is convex along the move: Newton's method on its rise, kept between ends where that
  // falls and grows, from where the corner's circle has the move's slope. Near the cutter's rim the
  // rise bends too much for its steps: halves there.
  const double F = cutter.flat(), r = cutter.corner();
  const double touch = F + r * std::fabs(slope) / std::sqrt(1 + slope * slope);
  const double behind = std::sqrt(std::max(0.0, touch * touch - w2));
  double low = first, high = last;
  double s = std::clamp(slope > 0 ? u - behind : u + behind, first, last);
  for (int k = 0; k < kMostSteps; ++k) {
    const double off = s - u, rho = std::sqrt(w2 + off * off), beyond = rho - F;
    const double square = r * r - beyond * beyond;
    double rise = slope, next = (low + high) / 2;
    if (beyond > 0 && square > kNearRim * r * r) {
      const double depth = std::sqrt(square), steep = beyond / depth, way = off / rho;
      rise += steep * way;
      const double bend = r * r / (square * depth) * way * way + steep * w2 / (rho * rho * rho);
      (rise > 0 ? high : low) = s;
      next = s - rise / bend;
      if (!(next > low && next < high)) next = (low + high) / 2;
    } else {
      if (beyond > 0) rise += beyond / std::sqrt(std::max(square, 1e-300)) * off / rho;
      (rise > 0 ? high : low) = s;
      next = (low + high) / 2;
    }
    const double step = std::fabs(next - s);
    s = next;
    if (step < kStill * R) break;
  }
  return std::min({at(first), at(last), at(s)});
}

PassedMove::PassedMove(const Vec3& begin, const Vec3& end)
    : from(begin.head<2>()), d((end - begin).head<2>()), length(d.norm()) {
  low = std::min(begin.z(), end.z());
  if (length > 0) along = d / length;
  if (length > 0) slope = (end.z() - begin.z()) / length;
  z = length > 0 ? begin.z() : low;
  y0 = std::min(begin.y(), end.y());
  y1 = std::max(begin.y(), end.y());
}

std::array<double, 2> PassedMove::over(double low_y, double high_y) const {
  double t0 = 0, t1 = 1;
  if (d.y() != 0) {
    const double ta = (low_y - from.y()) / d.y(), tb = (high_y - from.y()) / d.y();
    t0 = std::clamp(std::min(ta, tb), 0.0, 1.0);
    t1 = std::clamp(std::max(ta, tb), 0.0, 1.0);
  }
  const double xa = from.x() + t0 * d.x(), xb = from.x() + t1 * d.x();
  return {std::min(xa, xb), std::max(xa, xb)};
}

double PassedMove::gap(const PlanBox& box) const {
  const double x1 = from.x() + d.x();
  const double gap_x =
      std::max({0.0, box.x0 - std::max(from.x(), x1), std::min(from.x(), x1) - box.x1});
  const double gap_y = std::max({0.0, box.y0 - y1, y0 - box.y1});
  const double ox = (box.x0 + box.x1) / 2 - from.x(), oy = (box.y0 + box.y1) / 2 - from.y();
  const double square =
      std::fabs(oy * along.x() - ox * along.y()) -
      (std::fabs(along.y()) * (box.x1 - box.x0) + std::fabs(along.x()) * (box.y1 - box.y0)) / 2;
  return std::max(length > 0 ? square : 0, std::sqrt(gap_x * gap_x + gap_y * gap_y));
}

}  // namespace diesink
