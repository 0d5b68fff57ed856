// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/line_pairs.h"

#include <algorithm>
#include <cmath>

namespace diesink {
namespace {

// The zero lines of two functions have no common point in the box: lines side by side.
bool run_apart(const PlanFunction& f, const PlanFunction& g, const CellBox& box) {
  const double nf = std::hypot(f.cgx, f.cgy), ng = std::hypot(g.cgx, g.cgy);
  if (!(nf > 0) || !(ng > 0)) return false;
  const double s = f.cgx * g.cgx + f.cgy * g.cgy >= 0 ? 1 / ng : -1 / ng;
  const double reach = std::fabs(f.cgx / nf - g.cgx * s) * box.hx +
                       std::fabs(f.cgy / nf - g.cgy * s) * box.hy + f.bend / nf + g.bend / ng;
  return std::fabs(f.v / nf - g.v * s) > reach;  // false for NaN and unbounded bends
}

bool is_straight(const PlanFunction& f) {
  return f.exact && f.hxx == 0 && f.hxy == 0 && f.hyy == 0 && (f.cgx != 0 || f.cgy != 0);
}

// A conic on the stretch of a straight line that is in the box: a polynomial of degree two.
struct OnLine {
  bool inside = false;                     // the line runs through the box
  double first = 0, middle = 0, last = 0;  // Bernstein coefficients
  double slope_first = 0, slope_last = 0;  // along the line
};

OnLine restrict_to(const PlanFunction& line, const PlanFunction& conic, const CellBox& box) {
  OnLine r;
  const double n = std::hypot(line.cgx, line.cgy);
  const Vec2 across(line.cgx / n, line.cgy / n), along(-across.y(), across.x());
  const Vec2 foot = -line.v / n * across;
  double from = -1e300, to = 1e300;
  const double half[2] = {box.hx, box.hy};
  for (int k = 0; k < 2; ++k) {
    if (along[k] == 0) {
      if (std::fabs(foot[k]) > half[k]) return r;
      continue;
    }
    const double a = (-half[k] - foot[k]) / along[k], b = (half[k] - foot[k]) / along[k];
    from = std::fmax(from, std::fmin(a, b));
    to = std::fmin(to, std::fmax(a, b));
  }
  if (!(from <= to)) return r;
  const auto value = [&](const Vec2& p) {
    return conic.v + (conic.cgx + 0.5 * conic.hxx * p.x() + conic.hxy * p.y()) * p.x() +
           (conic.cgy + 0.5 * conic.hyy * p.y()) * p.y();
  };
  const auto slope = [&](const Vec2& p) {
    return (conic.cgx + conic.hxx * p.x() + conic.hxy * p.y()) * along.x() +
           (conic.cgy + conic.hxy * p.x() + conic.hyy * p.y()) * along.y();
  };
  const Vec2 p = foot + from * along, q = foot + to * along;
  r.inside = true;
  r.first = value(p);
  r.last = value(q);
  r.slope_first = slope(p);
  r.slope_last = slope(q);
  r.middle = r.first + 0.5 * (to - from) * r.slope_first;
  return r;
}

// A conic whose value along a straight line is what its gradient makes of a few ties: regular as it
// is, its own line is nowhere farther from that one.
bool follows(const PlanFunction& line, const PlanFunction& conic, const CellBox& box, double tie) {
  if (!is_straight(line) || !conic.exact || !conic.regular()) return false;
  const auto least = [](const Range& g) { return std::fmax(0.0, std::fmax(g.lo, -g.hi)); };
  const OnLine r = restrict_to(line, conic, box);
  return r.inside &&
         std::fmax(std::fmax(std::fabs(r.first), std::fabs(r.middle)), std::fabs(r.last)) <=
             kLineSlack * tie * std::fmax(least(conic.gx), least(conic.gy));
}

}  // namespace

bool same_line(const PlanFunction& f, const PlanFunction& g, const CellBox& box, double tie) {
  if (!(f.bend < 1e300) || !(g.bend < 1e300)) return false;
  const double nf = std::hypot(f.cgx, f.cgy), ng = std::hypot(g.cgx, g.cgy);
  if (!(nf > 0) || !(ng > 0)) return false;
  const double s = f.cgx * g.cgx + f.cgy * g.cgy >= 0 ? 1 / ng : -1 / ng;
  const double gap = std::fabs(f.v / nf - g.v * s) + std::fabs(f.cgx / nf - g.cgx * s) * box.hx +
                     std::fabs(f.cgy / nf - g.cgy * s) * box.hy;
  // Equal second-order parts cannot be told from their bounds; equal value and gradient of two
  // conics that bend by the same bound is taken for the same conic, which the vertices of the arcs
  // then prove or not.
  const double bend = std::fabs(f.bend / nf - g.bend / ng);
  return gap + bend <= kLineSlack * tie || follows(f, g, box, tie) || follows(g, f, box, tie);
}

bool is_transverse(const PlanFunction& f, const PlanFunction& g) {
  // 0 not in fx gy - fy gx.
  const auto product = [](const Range& a, const Range& b, double& lo, double& hi) {
    const double p[4] = {a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi};
    lo = std::min({p[0], p[1], p[2], p[3]});
    hi = std::max({p[0], p[1], p[2], p[3]});
  };
  double l1, h1, l2, h2;
  product(f.gx, g.gy, l1, h1);
  product(f.gy, g.gx, l2, h2);
  return l1 - h2 > 0 || h1 - l2 < 0;  // false for NaN
}

LinePairs::Meeting LinePairs::on_line(const PlanFunction& line, const PlanFunction& conic) const {
  if (!conic.exact || (line.cgx == 0 && line.cgy == 0)) return Meeting::kUnknown;
  // How far a line that is all but straight, as where a face that leans by last digits ends at a
  // bar, is from its straight part.
  const bool straight = is_straight(line);
  const double aside = straight ? 0 : line.bend / std::hypot(line.cgx, line.cgy);
  if (!(aside <= std::fmax(box_.hx, box_.hy))) return Meeting::kUnknown;
  // (What meets beyond the box by ties may do so in it as it is evaluated.)
  const double beyond = kLineSlack * tie_ + aside;
  const OnLine r = restrict_to(line, conic, {box_.x, box_.y, box_.hx + beyond, box_.hy + beyond});
  if (!r.inside) return Meeting::kNever;
  const double steep = std::fmax(std::fabs(conic.gx.lo), std::fabs(conic.gx.hi)) +
                       std::fmax(std::fabs(conic.gy.lo), std::fabs(conic.gy.hi));
  const double close = beyond * steep;
  if (std::fmin(std::fmin(r.first, r.middle), r.last) > close ||
      std::fmax(std::fmax(r.first, r.middle), r.last) < -close)
    return Meeting::kNever;
  if (!straight) return Meeting::kUnknown;
  // What rounding leaves of a slope along the line.
  const double level = 0x1p-40 * steep;
  if (std::fmin(r.slope_first, r.slope_last) > level ||
      std::fmax(r.slope_first, r.slope_last) < -level)
    return Meeting::kOnceAtMost;
  return Meeting::kUnknown;
}

LinePairs::Meeting LinePairs::alone(const PlanFunction& f, const PlanFunction& g) const {
  if (run_apart(f, g, box_)) return Meeting::kNever;
  const Meeting m = std::max(on_line(f, g), on_line(g, f));
  if (m != Meeting::kUnknown) return m;
  return is_transverse(f, g) ? Meeting::kOnceAtMost : Meeting::kUnknown;
}

LinePairs::Meeting LinePairs::of(int i, int j) const {
  const PlanFunction &f = verdict_.functions[i], &g = verdict_.functions[j];
  Meeting most = alone(f, g);
  if (most == Meeting::kNever || f.a == kNoLabel || g.a == kNoLabel) return most;
  // Two that part one face from two others meet where those two meet.
  const bool shares_a = f.a == g.a || f.a == g.b, shares_b = f.b == g.a || f.b == g.b;
  if (shares_a == shares_b) return most;
  const Label own = shares_a ? f.b : f.a, other = (shares_a ? f.a : f.b) == g.a ? g.b : g.a;
  for (const PlanFunction& third : verdict_.functions) {
    if (!((third.a == own && third.b == other) || (third.a == other && third.b == own))) continue;
    return std::max({most, alone(third, f), alone(third, g)});
  }
  const FaceOver *one = nullptr, *two = nullptr;
  for (const FaceOver& c : verdict_.candidates) {
    if (c.label == own) one = &c;
    if (c.label == other) two = &c;
  }
  if (one != nullptr && two != nullptr) {
    const Range d = difference_over(*one, *two, box_);
    if (d.lo > tie_ || d.hi < -tie_) return Meeting::kNever;
  }
  return most;
}

}  // namespace diesink
