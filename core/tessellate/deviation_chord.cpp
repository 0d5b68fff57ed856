// The curve F = G = 0 as a graph d(s) of offsets over its chord: with M the derivatives of F and G
// across the chord, d' = -M^-1 (F_s, G_s) and d'' = -M^-1 (t'F''t, t'G''t), t = (1, d'). As d
// vanishes at both ends, |d| <= max |d''| L² / 8.
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/tessellate/deviation.h"
#include "core/tessellate/pencil_plane.h"
#include "core/tessellate/section_chord.h"

namespace diesink {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
// Forms along a chord below this, relative to the form itself, are those of a ruling.
constexpr double kStraight = 1e-12;
// Sine of the angle between two gradients that are parallel.
constexpr double kParallel = 1e-9;

// Second derivatives that are not constant are bounded this far about the chord, of its length.
constexpr double kMargin = 0.1;

// A form about a chord: F at its ends, its gradient in the middle, second derivatives about it.
struct Form {
  double at_a = 0, at_b = 0;
  Vec3 gradient = Vec3::Zero();
  HessianBound hessian;

  Form(const Implicit& f, const Vec3& a, const Vec3& b, double margin)
      : hessian(f.hessian(a, b, margin)) {
    Vec3 unused;
    at_a = f.form(a, unused);
    at_b = f.form(b, unused);
    f.form(0.5 * (a + b), gradient);
  }

  // F - part G, on which the common points of F and G lie, too.
  Form& subtract(double part, const Form& g) {
    at_a -= part * g.at_a;
    at_b -= part * g.at_b;
    gradient -= part * g.gradient;
    hessian.middle -= part * g.hessian.middle;
    hessian.spread += std::fabs(part) * g.hessian.spread;
    return *this;
  }
};

// One of the two surfaces about the middle of the chord, scaled so that its gradient there is 1.
struct Sheet {
  Vec3 gradient = Vec3::Zero();
  double residual = 0;  // largest |F| at the ends
  double along = 0;     // e'F''e, e the chord's direction
  double across = 0;    // |F''e| across the chord
  double norm = 0;      // |F''|
  double spread = 0;    // of F''

  bool prepare(const Form& f, const Vec3& e) {
    const double steep = f.gradient.norm();
    residual = std::fmax(std::fabs(f.at_a), std::fabs(f.at_b));
    if (!(steep > 0) || !std::isfinite(residual) || !std::isfinite(f.hessian.spread)) return false;
    const Vec3 he = f.hessian.middle * e;
    gradient = f.gradient / steep;
    residual /= steep;
    along = e.dot(he) / steep;
    across = (he - e * e.dot(he)).norm() / steep;
    norm = f.hessian.middle.norm() / steep;
    spread = f.hessian.spread / steep;
    return true;
  }
  // Bounds of what changes between the middle and points within `width` of the chord.
  [[nodiscard]] double across_change(double reach, double width) const {
    return across * reach + norm * width + spread * (reach + width);
  }
  [[nodiscard]] double along_change(double reach, double width) const {
    return std::fabs(along) * reach + across * width + spread * (reach + width);
  }
  // |t'F''t - e'F''e| for t = e + d', |d'| <= slope; d' is across the chord.
  [[nodiscard]] double form_change(double slope) const {
    return 2 * across * slope + norm * slope * slope + spread * (1 + slope * slope);
  }
};

bool parallel_at(const CurvePair& curve, const Vec3& p) {
  Vec3 f, g;
  curve.f.form(p, f);
  curve.g.form(p, g);
  return f.norm() > 0 && g.norm() > 0 && f.cross(g).norm() <= kParallel * f.norm() * g.norm();
}

// Where the two surfaces are all but parallel, each of their gradients turns as far along the chord
// as the angle between them is wide. `parted`: in place of G the surface through the same curve
// whose gradient is square to that of F in the middle, which near a point where quadrics touch is
// all but a cone with its apex there.
double deviation_of(const CurvePair& curve, const Vec3& a, const Vec3& b, bool parted = false) {
  const Vec3 chord = b - a;
  const double length = chord.norm();
  const double rounding = 1e-15 * std::fmax(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
  if (!(length > 4 * rounding)) return length + rounding;  // one point to rounding
  const Vec3 e = chord / length;
  const Form form_f(curve.f, a, b, kMargin * length);
  Form form_g(curve.g, a, b, kMargin * length);
  if (parted)
    form_g.subtract(form_g.gradient.dot(form_f.gradient) / form_f.gradient.squaredNorm(), form_f);
  Sheet f, g;
  if (!f.prepare(form_f, e) || !g.prepare(form_g, e)) return kInf;

  // M at the middle, in a basis across the chord, and its inverse.
  const Vec3 p =
      (std::fabs(e.z()) < 0.7 ? Vec3::UnitZ().cross(e) : Vec3::UnitX().cross(e)).normalized();
  const Vec3 q = e.cross(p);
  const double fp = f.gradient.dot(p), fq = f.gradient.dot(q);
  const double gp = g.gradient.dot(p), gq = g.gradient.dot(q);
  const double det = fp * gq - fq * gp;
  // In both surfaces, to their residuals: rulings, lines of planes.
  const bool straight = std::fabs(f.along) <= kStraight * (f.norm + f.spread) && f.spread == 0 &&
                        std::fabs(g.along) <= kStraight * (g.norm + g.spread) && g.spread == 0;
  // Where surfaces touch all along the chord, as cylinders side by side do, nothing across it tells
  // the curve; it is the ruling they share.
  if (straight && parallel_at(curve, a) && parallel_at(curve, 0.5 * (a + b)) &&
      parallel_at(curve, b)) {
    return 2 * std::fmax(f.residual, g.residual) + rounding;
  }
  if (det == 0) return kInf;
  const auto solve = [&](double rf, double rg) {
    return std::hypot(gq * rf - fq * rg, fp * rg - gp * rf) / std::fabs(det);
  };
  // Largest singular value of the inverse.
  const double sum = fp * fp + fq * fq + gp * gp + gq * gq;
  const double inverse =
      std::sqrt(0.5 * (sum + std::sqrt(std::fmax(0, sum * sum - 4 * det * det)))) / std::fabs(det);

  const double off = inverse * std::hypot(f.residual, g.residual) + rounding;
  if (straight) return 2 * off;

  // A tube about the chord that the curve cannot leave on its way from either end to the middle.
  const double reach = 0.5 * length;
  const double middle_slope = solve(f.gradient.dot(e), g.gradient.dot(e));
  const bool constant = f.spread == 0 && g.spread == 0;
  double width = 2 * off, slope = 0, loss = 0;
  bool held = false;
  for (int k = 0; k < 6 && !held; ++k) {
    loss = inverse * std::hypot(f.across_change(reach, width), g.across_change(reach, width));
    if (!(loss < 0.9)) return kInf;
    slope = (middle_slope +
             inverse * std::hypot(f.along_change(reach, width), g.along_change(reach, width))) /
            (1 - loss);
    const double needed = slope * reach + 2 * off;
    held = needed <= width;
    if (!held) width = 1.25 * needed;
    if (!(width < (constant ? 0.5 : kMargin) * length)) return kInf;
  }
  if (!held) return kInf;

  // The curvature over the chord; what it says of the slopes sharpens it, twice.
  double deviation = kInf;
  for (int k = 0; k < 3; ++k) {
    const double bend = (solve(f.along, g.along) +
                         inverse * std::hypot(f.form_change(slope), g.form_change(slope))) /
                        (1 - loss);
    deviation = std::fmin(deviation, bend * length * length / 8);
    slope = std::fmin(slope, bend * reach + 2 * off / length);
    width = std::fmin(width, deviation + 2 * off);
    loss = inverse * std::hypot(f.across_change(reach, width), g.across_change(reach, width));
  }
  return deviation + 2 * off;
}

}  // namespace

double chord_deviation(const CurvePair& curve, const Vec3& a, const Vec3& b) {
  const double deviation = deviation_of(curve, a, b);
  if (deviation < kInf) return deviation;
  const double section = section_chord_deviation(curve, a, b);
  if (section < kInf) return section;
  // Near where two quadrics touch, the plane that a branch of their curve lies in tells it, or the
  // cone that they all but make there.
  if (const std::optional<Implicit> plane = pencil_plane(curve.f, curve.g, a, b)) {
    const double in_plane =
        std::fmin(deviation_of({curve.f, *plane}, a, b), deviation_of({curve.g, *plane}, a, b));
    if (in_plane < kInf) return in_plane;
  }
  return deviation_of(curve, a, b, true);
}

}  // namespace diesink
