// Choi, Lee, Hwang and Jun (1988), "Step length": 1. evenly spaced points on the plan line, 2. edge
// detection, 3. cutting errors and midpoints.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/cc_pass.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace diesink {
namespace {

constexpr int kDeepest = 24;  // halvings of a spacing

class PassSampler {
 public:
  PassSampler(const CompoundSurface& surface, const PlanCurve& curve, double R, double intol,
              double outtol)
      : surface_(surface), curve_(curve), R_(R), intol_(intol), outtol_(outtol) {}

  std::vector<std::vector<CcSample>> take(double spacing) {
    double length = 0;
    Vec2 last = curve_(0);
    constexpr int kChords = 64;
    for (int k = 1; k <= kChords; ++k) {
      const Vec2 p = curve_(static_cast<double>(k) / kChords);
      length += (p - last).norm();
      last = p;
    }
    const double count = std::fmax(1, std::ceil(length / spacing));
    std::optional<CcSample> a = at(0);
    if (a) add(*a, false);
    for (double k = 1; k <= count; ++k) {
      const double s0 = (k - 1) / count, s1 = k / count;
      const std::optional<CcSample> b = at(s1);
      between(s0, a, s1, b);
      a = b;
    }
    close();
    return std::move(runs_);
  }

 private:
  std::optional<CcSample> at(double s) const {
    const Vec2 p = curve_(s);
    const Machining& m = surface_.program().machining;
    const double hair = 1e-12 * surface_.size();
    if (p.x() < m.x_range[0] - hair || p.x() > m.x_range[1] + hair || p.y() < m.y_range[0] - hair ||
        p.y() > m.y_range[1] + hair) {
      return std::nullopt;
    }
    const std::optional<CcDatum> d = surface_.at(p.x(), p.y());
    if (!d) return std::nullopt;
    return CcSample{s, {Vec3(p.x(), p.y(), d->z), d->n}, d->row, d->face, false};
  }

  static bool same(const std::optional<CcSample>& a, const std::optional<CcSample>& b) {
    if (!a || !b) return !a && !b;
    return a->row == b->row && a->face == b->face;
  }

  void add(CcSample sample, bool after_edge) {
    if (runs_.empty() || closed_) {
      runs_.emplace_back();
      closed_ = false;
      after_edge = false;
    }
    sample.after_edge = after_edge;
    runs_.back().push_back(sample);
  }
  void close() { closed_ = true; }

  // Adds all samples after s0 up to s1; those at s0 are there already.
  void between(double s0, std::optional<CcSample> a, double s1, const std::optional<CcSample>& b) {
    while (!same(a, b)) {
      // The first change of face after s0, to the last bits of s.
      double lo = s0, hi = s1;
      std::optional<CcSample> at_lo = a, at_hi = b;
      while (true) {
        const double middle = lo + (hi - lo) / 2;
        if (middle <= lo || middle >= hi || hi - lo < 1e-14) break;
        const std::optional<CcSample> m = at(middle);
        if (same(a, m)) {
          lo = middle;
          at_lo = m;
        } else {
          hi = middle;
          at_hi = m;
        }
      }
      if (a && lo > s0) smooth(*a, *at_lo, 0);
      if (at_hi) {
        add(*at_hi, true);
      } else {
        close();
      }
      s0 = hi;
      a = at_hi;
      if (s0 >= s1) return;
    }
    if (a && s0 < s1) smooth(*a, *b, 0);
  }

  // Within one face: midpoints until the move keeps its tolerance.
  void smooth(const CcSample& a, const CcSample& b, int depth) {
    const Vec2 d = (b.contact.p - a.contact.p).head<2>();
    const double length = d.norm();
    const double error = length > 0 ? cutting_error(a.contact, b.contact, d / length, R_) : 0;
    if (depth < kDeepest && (error > intol_ || -error > outtol_)) {
      const std::optional<CcSample> m = at(a.s + (b.s - a.s) / 2);
      if (m && m->row == a.row && m->face == a.face && m->s > a.s && m->s < b.s) {
        smooth(a, *m, depth + 1);
        smooth(*m, b, depth + 1);
        return;
      }
    }
    add(b, false);
  }

  const CompoundSurface& surface_;
  const PlanCurve& curve_;
  double R_, intol_, outtol_;
  std::vector<std::vector<CcSample>> runs_;
  bool closed_ = true;
};

}  // namespace

double cutting_error(const CcContact& a, const CcContact& b, const Vec2& direction, double R) {
  const double cosine = std::clamp(a.n.dot(b.n), -1.0, 1.0);
  const double half = std::acos(cosine) / 2;  // phi / 2, (14)
  if (!(half > 0)) return 0;
  // The normals projected on the vertical plane of the pass, and where they meet.
  const Vec2 pa(a.p.head<2>().dot(direction), a.p.z()), pb(b.p.head<2>().dot(direction), b.p.z());
  const Vec2 na(a.n.head<2>().dot(direction), a.n.z()), nb(b.n.head<2>().dot(direction), b.n.z());
  const double cross = na.x() * nb.y() - na.y() * nb.x();
  if (std::fabs(cross) < 1e-14) return 0;
  const Vec2 d = pb - pa;
  const double ta = (d.x() * nb.y() - d.y() * nb.x()) / cross;
  const double tb = (d.x() * na.y() - d.y() * na.x()) / cross;
  const double rho = (std::fabs(ta) * na.norm() + std::fabs(tb) * nb.norm()) / 2;  // (13)
  const double convex = (b.n - a.n).dot(b.p - a.p);
  const double shrink = 1 - std::cos(half);
  // (12); concave with negative R, and the sign tells which of the two it is.
  return convex >= 0 ? (rho + R) * shrink : -std::fabs(rho - R) * shrink;
}

std::vector<std::vector<CcSample>> cc_pass(const CompoundSurface& surface, const PlanCurve& curve,
                                           double R, double spacing, double intol, double outtol) {
  return PassSampler(surface, curve, R, intol, outtol).take(spacing);
}

}  // namespace diesink
