// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/deviation_affine.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/tessellate/deviation_forms.h"

namespace diesink {
namespace {

// A triangle over more patches than this is too coarse for its bound to be worth sharpening.
constexpr int kMostPatches = 6;

using Terms = std::array<std::array<double, 4>, 4>;

// The same polynomial in powers of the distance from (s, t).
Terms about(const Bicubic& p, double s, double t) {
  Terms a = p.c;
  for (int pass = 0; pass < 3; ++pass) {
    for (std::size_t k = 2; k + 1 > static_cast<std::size_t>(pass); --k) {
      for (std::size_t l = 0; l < 4; ++l) a[k][l] += s * a[k + 1][l];
    }
  }
  for (int pass = 0; pass < 3; ++pass) {
    for (std::size_t l = 2; l + 1 > static_cast<std::size_t>(pass); --l) {
      for (std::size_t k = 0; k < 4; ++k) a[k][l] += t * a[k][l + 1];
    }
  }
  return a;
}

// Bounds of |second derivatives| over |ds| <= s, |dt| <= t.
struct Bends {
  double ss = 0, st = 0, tt = 0;

  void add(std::size_t k, std::size_t l, double coefficient, const std::array<double, 4>& s,
           const std::array<double, 4>& t) {
    const double size = std::fabs(coefficient);
    const auto dk = static_cast<double>(k), dl = static_cast<double>(l);
    if (k >= 2) ss += size * dk * (dk - 1) * s[k - 2] * t[l];
    if (k >= 1 && l >= 1) st += size * dk * dl * s[k - 1] * t[l - 1];
    if (l >= 2) tt += size * dl * (dl - 1) * s[k] * t[l - 2];
  }
};

// How other patches differ from the one in the middle.
struct Jump {
  double ss_up = 0, ss_down = 0, tt_up = 0, tt_down = 0;  // most above and below zero
  double st = 0;
  double height_up = 0, height_down = 0;  // largest differences of height from the middle patch

  // ss, tt: the second derivatives where the patches are nearest; columns, rows: how far apart.
  void add(const Bends& bends, double ss, double tt, const Vec2& reach, int columns, int rows) {
    const double ss_more = bends.ss - std::fabs(ss), tt_more = bends.tt - std::fabs(tt);
    const double up_s = std::fmax(0, ss + ss_more), down_s = std::fmax(0, ss_more - ss);
    const double up_t = std::fmax(0, tt + tt_more), down_t = std::fmax(0, tt_more - tt);
    ss_up = std::fmax(ss_up, up_s);
    ss_down = std::fmax(ss_down, down_s);
    tt_up = std::fmax(tt_up, up_t);
    tt_down = std::fmax(tt_down, down_t);
    st = std::fmax(st, bends.st);
    // Across a border height and slope agree all along it; at a corner only there.
    double square_s = 0, square_t = 0, product = 0;
    if (columns == 1) square_s = 0.5 * reach.x() * reach.x();
    if (rows == 1) square_t = 0.5 * reach.y() * reach.y();
    if (columns == 1 && rows == 1) product = bends.st * reach.x() * reach.y();
    if (columns > 1 || rows > 1) product = HUGE_VAL;
    height_up = std::fmax(height_up, up_s * square_s + up_t * square_t + product);
    height_down = std::fmax(height_down, down_s * square_s + down_t * square_t + product);
  }
};

std::array<double, 4> powers(double x) { return {1, x, x * x, x * x * x}; }

// A polynomial of third order without linear part, by its polar forms.
struct Cubic {
  const Terms& a;

  [[nodiscard]] double square(const Vec2& d) const {
    return a[2][0] * d.x() * d.x() + a[1][1] * d.x() * d.y() + a[0][2] * d.y() * d.y();
  }
  [[nodiscard]] double cube(const Vec2& p, const Vec2& q, const Vec2& r) const {
    return a[3][0] * p.x() * q.x() * r.x() +
           a[2][1] / 3 * (p.x() * q.x() * r.y() + p.x() * q.y() * r.x() + p.y() * q.x() * r.x()) +
           a[1][2] / 3 * (p.x() * q.y() * r.y() + p.y() * q.x() * r.y() + p.y() * q.y() * r.x()) +
           a[0][3] * p.y() * q.y() * r.y();
  }
};

}  // namespace

AffineBase::AffineBase(const FergusonSurface& surface)
    : plan_(*surface.affine()), columns_(surface.columns() - 1), rows_(surface.rows() - 1) {
  patches_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (int j = 0; j < rows_; ++j) {
    for (int i = 0; i < columns_; ++i) {
      double p[2][2], ps[2][2], pt[2][2];
      for (int k = 0; k < 2; ++k) {
        for (int l = 0; l < 2; ++l) {
          const FergusonSurface::Point corner = surface.point(i + k, j + l);
          p[k][l] = corner.r.z();
          ps[k][l] = corner.ru.z();
          pt[k][l] = corner.rv.z();
        }
      }
      patches_.push_back(Bicubic::hermite(p, ps, pt));
    }
  }
}

bool AffineBase::over(const Vec3& a, const Vec3& b, const Vec3& c, double margin,
                      BaseGap& out) const {
  const auto parameters = [this](const Vec3& p) {
    const double x = p.x() - plan_.x0, y = p.y() - plan_.y0;
    return Vec2(plan_.ux * x + plan_.uy * y, plan_.vx * x + plan_.vy * y);
  };
  std::array<Vec2, 3> d{parameters(a), parameters(b), parameters(c)};
  const Vec2 more(margin * (std::fabs(plan_.ux) + std::fabs(plan_.uy)),
                  margin * (std::fabs(plan_.vx) + std::fabs(plan_.vy)));
  const Vec2 low = d[0].cwiseMin(d[1]).cwiseMin(d[2]) - more;
  const Vec2 high = d[0].cwiseMax(d[1]).cwiseMax(d[2]) + more;
  const auto span = [](double w, int spans) {
    return static_cast<int>(std::clamp(std::floor(w), 0.0, spans - 1.0));
  };
  const int i0 = span(low.x(), columns_), i1 = span(high.x(), columns_);
  const int j0 = span(low.y(), rows_), j1 = span(high.y(), rows_);
  if ((i1 - i0 + 1) * (j1 - j0 + 1) > kMostPatches) return false;

  const Vec2 middle = (d[0] + d[1] + d[2]) / 3;
  const int home_i = span(middle.x(), columns_), home_j = span(middle.y(), rows_);
  const auto terms = [&](int i, int j, const Vec2& at) {
    return about(patches_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
                          static_cast<std::size_t>(i)],
                 at.x() - i, at.y() - j);
  };
  const Terms home = terms(home_i, home_j, middle);
  for (Vec2& corner : d) corner -= middle;
  const double s = std::fmax(high.x() - middle.x(), middle.x() - low.x()),
               t = std::fmax(high.y() - middle.y(), middle.y() - low.y());
  const std::array<double, 4> sp = powers(s), tp = powers(t);

  // What the third order leaves out: its own higher terms.
  Bends rest;
  for (std::size_t k = 1; k < 4; ++k) {
    for (std::size_t l = 4 - k; l < 4; ++l) rest.add(k, l, home[k][l], sp, tp);
  }
  // And what other patches, which meet this one with equal slopes, differ by from it: second
  // derivatives of either sign, and a height that grows from nothing at the border.
  Jump jump;
  for (int j = j0; j <= j1; ++j) {
    for (int i = i0; i <= i1; ++i) {
      if (i == home_i && j == home_j) continue;
      // About the nearest point of the other patch.
      const Vec2 first = low.cwiseMax(Vec2(i, j)), last = high.cwiseMin(Vec2(i + 1, j + 1));
      const Vec2 meeting = middle.cwiseMax(first).cwiseMin(last);
      const Vec2 reach = (last - meeting).cwiseMax(meeting - first);
      const std::array<double, 4> sr = powers(reach.x()), tr = powers(reach.y());
      const Terms other = terms(i, j, meeting), here = terms(home_i, home_j, meeting);
      Bends own;
      for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t l = 0; l < 4; ++l) own.add(k, l, other[k][l] - here[k][l], sr, tr);
      }
      jump.add(own, 2 * (other[2][0] - here[2][0]), 2 * (other[0][2] - here[0][2]), reach,
               std::abs(i - home_i), std::abs(j - home_j));
    }
  }

  // Bernstein form of the third order less its interpolant: on edge ij b_iij and b_ijj, inside
  // b_111; as sum l_i l_j q_ij with q_ij linear, 3 b_iij at i, 3 b_ijj at j, 3 b_k at k.
  const Cubic f{home};
  const std::array<double, 3> own{f.cube(d[0], d[0], d[0]), f.cube(d[1], d[1], d[1]),
                                  f.cube(d[2], d[2], d[2])};
  EdgeForms near_first, near_last, opposite, above, below;
  double squares = 0, opposite_sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    const double square = f.square(d[j] - d[i]);
    squares += square;
    near_first[k] = -square + 3 * f.cube(d[i], d[i], d[j]) - (2 * own[i] + own[j]);
    near_last[k] = -square + 3 * f.cube(d[i], d[j], d[j]) - (own[i] + 2 * own[j]);
    opposite[k] = 0.5 * (near_first[k] + near_last[k]);
    opposite_sum += opposite[k];
  }
  const double inside =
      -0.5 * squares + 3 * f.cube(d[0], d[1], d[2]) - (own[0] + own[1] + own[2]);  // 3 b_111
  const double correction = (2 * inside - opposite_sum) / 3;
  const double weight = s > 0 && t > 0 ? t / s : 1;
  // Cross terms of either sign are shared out to the squares.
  const auto form = [&](const Vec2& e, double ss, double st, double tt) {
    return 0.5 * ((ss + st * weight) * e.x() * e.x() + (tt + st / weight) * e.y() * e.y());
  };
  EdgeForms above_all, below_all;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 e = d[(k + 2) % 3] - d[(k + 1) % 3];
    const double more_form = form(e, rest.ss, rest.st, rest.tt);
    const double third = opposite[k] + correction;
    above[k] = std::max({near_first[k], near_last[k], third}) + more_form;
    below[k] = -std::min({near_first[k], near_last[k], third}) + more_form;
    above_all[k] = above[k] + form(e, jump.ss_down, jump.st, jump.tt_down);
    below_all[k] = below[k] + form(e, jump.ss_up, jump.st, jump.tt_up);
  }
  out.gap = std::fmin(std::fmax(largest_between(above_all), largest_between(below_all)),
                      std::fmax(largest_between(above), largest_between(below)) + jump.height_up +
                          jump.height_down);
  rest.ss += std::fmax(jump.ss_up, jump.ss_down);
  rest.st += jump.st;
  rest.tt += std::fmax(jump.tt_up, jump.tt_down);

  // Slopes and second derivatives, turned into the plan's.
  const Terms& h = home;
  const double ss =
      2 * std::fabs(h[2][0]) + 6 * std::fabs(h[3][0]) * s + 2 * std::fabs(h[2][1]) * t + rest.ss;
  const double st =
      std::fabs(h[1][1]) + 2 * std::fabs(h[2][1]) * s + 2 * std::fabs(h[1][2]) * t + rest.st;
  const double tt =
      2 * std::fabs(h[0][2]) + 6 * std::fabs(h[0][3]) * t + 2 * std::fabs(h[1][2]) * s + rest.tt;
  const double ux = std::fabs(plan_.ux), uy = std::fabs(plan_.uy), vx = std::fabs(plan_.vx),
               vy = std::fabs(plan_.vy);
  const double xx = ux * ux * ss + 2 * ux * vx * st + vx * vx * tt;
  const double yy = uy * uy * ss + 2 * uy * vy * st + vy * vy * tt;
  const double xy = ux * uy * ss + (ux * vy + uy * vx) * st + vx * vy * tt;
  out.bend = std::sqrt(xx * xx + 2 * xy * xy + yy * yy);
  out.slope =
      Vec2(h[1][0] * plan_.ux + h[0][1] * plan_.vx, h[1][0] * plan_.uy + h[0][1] * plan_.vy);
  const double es = ss * s + st * t, et = st * s + tt * t;
  out.slope_spread = std::hypot(ux * es + vx * et, uy * es + vy * et);
  return true;
}

}  // namespace diesink
