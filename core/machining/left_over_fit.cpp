// Where a cutter fits over a place of the surface, touching it or from beside.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/machining/interference.h"
#include "core/machining/left_over.h"
#include "core/machining/tool_path_plan.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Of the limit, what the mesh may lie beside the surface where the lattice knows that.
constexpr double kMeshPart = 0.15;
// Ways from a point in which a cutter is tried beside it.
constexpr std::size_t kHeadings = 24;

// How deep a point lies in the cutter, at the distance rho from the axis and so high over the tip;
// negative outside.
double depth_in(const CutterShape& cutter, double rho, double height) {
  const double side = rho - cutter.flat(), under = cutter.corner() - height;
  if (side <= 0 || under <= 0) return cutter.corner() - std::max(side, under);
  return cutter.corner() - std::sqrt(side * side + under * under);
}

// How high over the tip a point must lie to be deeper in the cutter; infinity where none is.
double height_of_depth(const CutterShape& cutter, double rho, double depth) {
  const double side = rho - cutter.flat(), inner = cutter.corner() - depth;
  if (side <= 0) return depth;
  if (side >= inner) return kInfinity;
  return cutter.corner() - std::sqrt(inner * inner - side * side);
}

const Vec2& heading_of(std::size_t heading) {
  static const std::array<Vec2, kHeadings> headings = [] {
    std::array<Vec2, kHeadings> out;
    for (std::size_t h = 0; h < kHeadings; ++h) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(h) / kHeadings;
      out[h] = Vec2(std::cos(angle), std::sin(angle));
    }
    return out;
  }();
  return headings[heading];
}

}  // namespace

Vec3 LeftOver::tip(const Points& points, std::size_t k, const Vec2& at) const {
  const Vec3 n(static_cast<double>(points.nx[k]), static_cast<double>(points.ny[k]),
               static_cast<double>(points.nz[k]));
  Vec3 tip = tip_of(offset_->cutter(), {{at.x(), at.y(), points.z[k]}, n});
  // At the end of the surface, whose point would lie on the cutter's very rim: so far within it
  // that neighbours on a line along the end are met as well.
  tip.head<2>() += rim_ * (at - tip.head<2>());
  return tip;
}

bool LeftOver::keeps_above(const Vec2& at, double tip, const Vec2& point, std::size_t& k) const {
  k = nearest_point(point);
  // The mesh may lie beside the surface.
  const double high = lattice_.z[k] - kMeshPart * limits_.limit - tip;
  if (!(high >= 0)) return false;
  const CutterShape& cutter = offset_->cutter();
  const double off2 = (at_lattice(k) - at).squaredNorm();
  return off2 <= cutter.radius() * cutter.radius() && high >= cutter.height(std::sqrt(off2));
}

bool LeftOver::kept_above(const Vec2& at, double tip) const {
  std::size_t k = 0;
  if (keeps_above(at, tip, at, k)) return true;
  const Vec2 n(static_cast<double>(lattice_.nx[k]), static_cast<double>(lattice_.ny[k]));
  const double flat = n.norm();
  if (!(flat > 0)) return false;
  const CutterShape& cutter = offset_->cutter();
  return keeps_above(at, tip, at - (cutter.corner() + cutter.flat() / flat) * n, k);
}

bool LeftOver::kept_above_all_round(const Vec2& at, double tip) const {
  std::size_t k = 0;
  for (const double part : {0.5, 0.9}) {
    for (std::size_t heading = 0; heading < kHeadings; heading += 2) {
      const Vec2 point = at + part * offset_->cutter().radius() * heading_of(heading);
      if (keeps_above(at, tip, point, k)) return true;
    }
  }
  return false;
}

bool LeftOver::fits(Points& points, std::size_t k, const Vec2& over) const {
  if (points.fit[k] == Fit::kUnknown) {
    const Vec3 at = tip(points, k, over);
    const Span inside = domain_.pass(at.y());
    // Up the axis: along the normal a steep surface leaves less than that.
    const double nz = std::max(static_cast<double>(points.nz[k]), kLeastCosine);
    const double allowed = at.z() + limits_.fits / nz;
    bool yes = at.y() >= domain_.low() && at.y() <= domain_.high() && at.x() >= inside.x0 - hair_ &&
               at.x() <= inside.x1 + hair_;
    if (yes && kept_above_all_round(at.head<2>(), allowed)) yes = false;
    if (yes) {
      // Beside a wall over a hole the cutter may pass the mesh by and meet nothing.
      const double z = drop_->at(at.x(), at.y(), std::nextafter(allowed, kInfinity));
      yes = z != kNoContact && z <= allowed;
    }
    points.fit[k] = yes ? Fit::kYes : Fit::kNo;
  }
  return points.fit[k] == Fit::kYes || points.fit[k] == Fit::kCut;
}

bool LeftOver::in_domain(const Vec2& at) const {
  const std::array<Vec2, 4>& c = domain_.corners();
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec2 side = c[(k + 1) % 4] - c[k], off = at - c[k];
    const double left = side.x() * off.y() - side.y() * off.x();
    if (left < 0 && left < -hair_ * side.norm()) return false;
  }
  return true;
}

bool LeftOver::falls_off(const Points& points, std::size_t k, const Vec2& over) const {
  const double down = points.left[k] - 2 * std::max(limits_.limit, step_);
  const std::size_t nearest = nearest_point(over);
  const std::size_t i = nearest % columns_, j = nearest / columns_;
  for (std::size_t b = j - std::min<std::size_t>(j, 1); b <= std::min(j + 1, rows_ - 1); ++b) {
    for (std::size_t a = i - std::min<std::size_t>(i, 1); a <= std::min(i + 1, columns_ - 1); ++a) {
      const std::size_t at = b * columns_ + a;
      // What needs no more cutting may have been cut down to the surface.
      const bool done =
          !(lattice_.left[at] - lattice_.z[at] > static_cast<double>(lattice_.most[at]));
      if ((done ? lattice_.z[at] : lattice_.left[at]) < down) return true;
    }
  }
  return false;
}

LeftOver::Place LeftOver::beside(Points& points, std::size_t k, const Vec2& over,
                                 double least) const {
  Place best{least, Vec3::Zero()};
  const double R = cutter_.radius();
  // All that stands over the point, deep in a slot as well; where nothing was cut, a radius of it.
  const double top = points.left[k] < kInfinity ? points.left[k] : points.z[k] + R;
  const double grown = offset_->cutter().corner() - cutter_.corner();
  // The cutter comes over the point only from as near as its radius.
  const bool inside = in_domain(over + Vec2(-R, -R)) && in_domain(over + Vec2(R, -R)) &&
                      in_domain(over + Vec2(-R, R)) && in_domain(over + Vec2(R, R));
  bool found = false;
  // Deep in the cutter first: what is cut far from its rim needs the fewest runs.
  for (double depth = R / 2; !found; depth = std::max(depth / 2, limits_.call)) {
    const double rho = R - std::max(depth, limits_.call);
    const double enough = top - grown - height_of_depth(cutter_, rho, best.height);
    for (std::size_t heading = 0; heading < kHeadings; ++heading) {
      const Vec2 at = over + rho * heading_of(heading);
      if (!inside && !in_domain(at)) continue;
      // Most often the part itself keeps a cutter from it.
      if (kept_above(at, enough)) continue;
      const double z = drop_->at(at.x(), at.y(), top - best.height);
      if (z == kNoContact) continue;
      const double held = depth_in(cutter_, rho, top - z - grown);
      if (!(held > best.height)) continue;
      best = {held, Vec3(at.x(), at.y(), z)};
      found = true;
    }
    if (!(depth > limits_.call)) break;
  }
  // What no cutter held deep enough is held no deeper once there is less of it.
  if (!found && least <= limits_.call) points.fit[k] = Fit::kNowhere;
  return found ? best : Place{0, Vec3::Zero()};
}

LeftOver::Place LeftOver::place(Points& points, std::size_t k, const Vec2& over,
                                double least) const {
  const Place none{0, Vec3::Zero()};
  // The quick answers first: what stays is no more than what stands straight up, and the distance
  // to the surface beside walls takes longest.
  const double above = points.left[k] - points.z[k];
  if (!(above > std::max(least, static_cast<double>(points.most[k])))) return none;
  if (points.fit[k] == Fit::kDone) return none;
  if (!fits(points, k, over)) {
    const bool tried = k % points.beside_step == 0;
    if (!tried || points.fit[k] == Fit::kNowhere || !falls_off(points, k, over)) return none;
    return stays(points, k, over) > least ? beside(points, k, over, least) : none;
  }
  const double height = stays(points, k, over);
  if (!(height > call(points, k))) points.fit[k] = Fit::kDone;
  if (!(height > least)) return none;
  Vec3 at = tip(points, k, over);
  at.z() = kNoContact;  // lowered when it is used
  return {height, at};
}

LeftOver::Points LeftOver::one(const CcContact& at, double top) const {
  Points point;
  point.resize(1);
  take(point, 0, at.p.head<2>(), at.p.z(), offset_->from_frame(at.n));
  point.left[0] = top;
  return point;
}

bool LeftOver::lowers(const Vec3& tip, const Vec2& at, double top) const {
  constexpr double kWorth = 1e-3;  // of what may stay
  const double grown = offset_->cutter().radius() - cutter_.radius();
  const double rho = (tip.head<2>() - at).norm();
  return rho <= cutter_.radius() &&
         tip.z() + grown + cutter_.height(rho) < top - kWorth * limits_.call;
}

bool LeftOver::fits_at(const CcContact& at, double top) const {
  Points point = one(at, top);
  const Vec2 over = at.p.head<2>();
  if (!fits(point, 0, over)) return false;
  // On a slope a cutter that comes as near as that along the normal may be far up.
  Vec3 there = tip(point, 0, over);
  there.z() = drop_->at(there.x(), there.y());
  return lowers(there, over, top);
}

bool LeftOver::falls_off_at(const Vec2& at) const {
  const std::size_t k = nearest_point(at);
  return falls_off(lattice_, k, at);
}

LeftOver::Seen LeftOver::see(const CcContact& at, double top) const {
  Points point = one(at, top);
  const Vec2 over = at.p.head<2>();
  const Place found = place(point, 0, over, limits_.call);
  if (!(found.height > 0)) return {};
  Seen seen{found.height, found.tip};
  if (seen.tip.z() == kNoContact) seen.tip.z() = drop_->at(seen.tip.x(), seen.tip.y());
  return lowers(seen.tip, over, top) ? seen : Seen{};
}

}  // namespace diesink
