// One triangle of a scan as vertical lines meet it: closed coverage with exact signs, the height.
// Points, rows and grids all ask here, so that they give the same digits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/exact_plan.h"
#include "core/line_search.h"
#include "core/vec.h"

namespace diesink {

struct ScannedTriangle {
  std::array<double, 3> x, y;  // in plan, anticlockwise; the first is the triangle's own first
  double z0 = 0, zx = 0, zy = 0;
  double z_low = 0, z_high = 0;

  // False where the triangle has no area in plan: it stands upright or is degenerate. Such a
  // triangle has no part of its own in the surface; its edges belong to its neighbours too.
  bool set(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double bx = b.x() - a.x(), by = b.y() - a.y();
    const double cx = c.x() - a.x(), cy = c.y() - a.y();
    const double left = bx * cy, right = by * cx;
    double area = left - right;
    const double whole = std::fabs(left) + std::fabs(right);
    x = {a.x(), b.x(), c.x()};
    y = {a.y(), b.y(), c.y()};
    z0 = a.z();
    z_low = std::min(a.z(), std::min(b.z(), c.z()));
    z_high = std::max(a.z(), std::max(b.z(), c.z()));
    // Below this the gradient would lose more than a few digits.
    constexpr double kSliver = 0x1p-7;
    if (std::fabs(area) < kSliver * whole || whole == 0) {
      const int sign = turn(x[0], y[0], x[1], y[1], x[2], y[2]);
      if (sign == 0) return false;
      area = sign;
      sliver_slopes(a, b, c);
    } else {
      const double bz = b.z() - a.z(), cz = c.z() - a.z(), inverse = 1 / area;
      zx = (bz * cy - cz * by) * inverse;
      zy = (bx * cz - cx * bz) * inverse;
    }
    if (area < 0) {
      std::swap(x[1], x[2]);
      std::swap(y[1], y[2]);
    }
    return true;
  }

  // Closed: a point on an edge or a vertex is covered. Exact.
  [[nodiscard]] bool covers(double px, double py) const {
    return turn(x[0], y[0], x[1], y[1], px, py) >= 0 && turn(x[1], y[1], x[2], y[2], px, py) >= 0 &&
           turn(x[2], y[2], x[0], y[0], px, py) >= 0;
  }

  [[nodiscard]] double along_row(double py) const { return z0 + zy * (py - y[0]); }
  // Never beyond the triangle's own heights.
  [[nodiscard]] double height(double along, double px) const {
    return std::min(std::max(along + zx * (px - x[0]), z_low), z_high);
  }

  [[nodiscard]] double x_low() const { return std::min(x[0], std::min(x[1], x[2])); }
  [[nodiscard]] double x_high() const { return std::max(x[0], std::max(x[1], x[2])); }
  [[nodiscard]] double y_low() const { return std::min(y[0], std::min(y[1], y[2])); }
  [[nodiscard]] double y_high() const { return std::max(y[0], std::max(y[1], y[2])); }

  // Narrows the run [begin, end) of lines to those covered at py. Exact.
  // Needs: y_low() <= py <= y_high().
  void narrow(double py, const LineSearch& lines, std::size_t& begin, std::size_t& end) const {
    const std::span<const double> xs = lines.lines();
    // Beside a few points their own tests are quicker than the crossings.
    constexpr std::size_t kFew = 2;
    if (end - begin > kFew) crossings(py, lines, begin, end);
    while (begin < end && !covers(xs[begin], py)) ++begin;
    while (begin < end && !covers(xs[end - 1], py)) --end;
  }

 private:
  // Leaves out lines that lie beyond an edge's crossing by more than its rounding.
  void crossings(double py, const LineSearch& lines, std::size_t& begin, std::size_t& end) const {
    double low = lines.lines()[begin], high = lines.lines()[end - 1];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = k == 2 ? 0 : k + 1;
      const double rise = y[next] - y[k];
      if (rise == 0) continue;
      const double run = (py - y[k]) * ((x[next] - x[k]) / rise);
      const double at = x[k] + run, slack = 0x1p-49 * (std::fabs(x[k]) + std::fabs(run));
      // An edge so level that its slope overflows bounds nothing here.
      if (!(slack < HUGE_VAL)) continue;
      if (rise > 0) {
        high = std::min(high, at + slack);
      } else {
        low = std::max(low, at - slack);
      }
    }
    begin = std::max(begin, lines.first_from(low));
    end = std::max(begin, std::min(end, lines.first_above(high)));
  }

  void sliver_slopes(const Vec3& a, const Vec3& b, const Vec3& c) {
    const TwoWords bx = two_difference(b.x(), a.x()), by = two_difference(b.y(), a.y()),
                   bz = two_difference(b.z(), a.z()), cx = two_difference(c.x(), a.x()),
                   cy = two_difference(c.y(), a.y()), cz = two_difference(c.z(), a.z());
    const TwoWords area = bx * cy - by * cx;
    zx = quotient(bz * cy - cz * by, area);
    zy = quotient(bx * cz - cx * bz, area);
    if (std::isfinite(zx) && std::isfinite(zy)) return;
    // Upright but for the last digits: its top counts.
    zx = zy = 0;
    z0 = z_high;
  }
};

}  // namespace diesink
