// SPDX-License-Identifier: Apache-2.0
#include "core/machining/interference.h"

#include <Eigen/Geometry>
#include <cmath>

namespace diesink {
namespace {

constexpr int kMostHalvings = 40;

// Contacts at one point while the normal turns from `from` to `to`.
void turn(const CutterShape& cutter, const Vec3& p, const Vec3& from, const Vec3& to, double intol,
          std::vector<Vec3>& out) {
  const double angle = std::acos(std::clamp(from.dot(to), -1.0, 1.0));
  if (!(angle > 1e-9)) return;
  // (12) about a point: R (1 - cos of half the step).
  const double R = std::fmax(cutter.radius(), 1e-300);
  const double step = 2 * std::acos(std::fmax(0.5, 1 - intol / R));
  const double count = std::ceil(angle / std::fmax(step, 1e-3));
  for (double k = 0; k <= count; ++k) {
    const double t = k / count, s = std::sin(angle);
    const Vec3 n = s > 1e-9
                       ? Vec3((std::sin((1 - t) * angle) * from + std::sin(t * angle) * to) / s)
                       : Vec3((from + t * (to - from)).normalized());
    out.push_back(tip_of(cutter, {p, n}));
  }
}

// Where two polylines of tips cross in the vertical plane through a and b; the first crossing along
// `ahead`. The lateral place is the mean of the two.
struct Crossing {
  Vec3 at = Vec3::Zero();
  bool found = false;
};

Crossing crossing_of(const std::vector<Vec3>& tips, std::size_t a, std::size_t b) {
  Vec2 direction = (tips[b] - tips[a]).head<2>();
  if (!(direction.norm() > 0)) return {};
  direction.normalize();
  const auto flat = [&](const Vec3& p) { return Vec2(p.head<2>().dot(direction), p.z()); };
  for (std::size_t i = a; i < b; ++i) {
    for (std::size_t j = b; j-- > i + 2;) {
      // Segment i, i+1 against j, j+1.
      const Vec2 p = flat(tips[i]), d = flat(tips[i + 1]) - p;
      const Vec2 q = flat(tips[j]), e = flat(tips[j + 1]) - q;
      const double cross = d.x() * e.y() - d.y() * e.x();
      if (std::fabs(cross) < 1e-300) continue;
      const double s = ((q - p).x() * e.y() - (q - p).y() * e.x()) / cross;
      const double t = ((q - p).x() * d.y() - (q - p).y() * d.x()) / cross;
      if (s < 0 || s > 1 || t < 0 || t > 1) continue;
      return {
          ((tips[i] + s * (tips[i + 1] - tips[i])) + (tips[j] + t * (tips[j + 1] - tips[j]))) / 2,
          true};
    }
  }
  return {};
}

void halved_move(const Vec3& a, const Vec3& b, SegmentProfile& profile, double tolerance, int depth,
                 double& worst, std::vector<Vec3>& out) {
  Vec3 at;
  const double deepest = profile.deepest(a, b, 0, at);
  if (deepest > tolerance && depth > 0 && at != a && at != b) {
    halved_move(a, at, profile, tolerance, depth - 1, worst, out);
    halved_move(at, b, profile, tolerance, depth - 1, worst, out);
    return;
  }
  worst = std::fmax(worst, deepest);
  out.push_back(b);
}

}  // namespace

double safe_move(const Vec3& a, const Vec3& b, SegmentProfile& profile, double tolerance,
                 std::vector<Vec3>& out) {
  double worst = 0;
  halved_move(a, b, profile, tolerance, kMostHalvings, worst, out);
  return worst;
}

Vec3 tip_of(const CutterShape& cutter, const CcContact& contact) {
  Vec3 tip = contact.p + cutter.corner() * contact.n;
  const double flat = contact.n.head<2>().norm();
  if (flat > kLevel) tip.head<2>() += cutter.flat() / flat * contact.n.head<2>();
  tip.z() -= cutter.corner();
  return tip;
}

std::vector<Vec3> tips_of(const CutterShape& cutter, const std::vector<CcSample>& stretch,
                          double intol) {
  std::vector<Vec3> out;
  for (std::size_t k = 0; k < stretch.size(); ++k) {
    const CcContact& b = stretch[k].contact;
    if (k > 0 && stretch[k].after_edge) {
      const CcContact& a = stretch[k - 1].contact;
      // The direction of the pass here, from a neighbour far enough away.
      Vec2 d = (b.p - a.p).head<2>();
      if (k >= 2) d = (b.p - stretch[k - 2].contact.p).head<2>();
      if (k + 1 < stretch.size()) d = (stretch[k + 1].contact.p - a.p).head<2>();
      const double length = d.norm();
      if (length > 0) {
        d /= length;
        const Vec3 forward(d.x(), d.y(), 0);
        const double drop = a.p.z() - b.p.z();
        if (std::fabs(drop) > intol) {
          if (drop > 0)
            turn(cutter, a.p, a.n, forward, intol, out);
          else
            turn(cutter, b.p, -forward, b.n, intol, out);
        } else if ((b.n - a.n).dot(forward) > 0) {
          turn(cutter, a.p, a.n, b.n, intol, out);
        }
      }
    }
    out.push_back(tip_of(cutter, b));
  }
  return out;
}

double without_interference(std::vector<Vec3>& tips, const PointDrop& drop, SegmentProfile& profile,
                            double tolerance, InterferenceCounts& counts) {
  std::vector<Vec3> kept;
  std::size_t last = tips.size();  // index of the last point kept; none yet
  double worst = 0;
  const auto lift = [&](Vec3 p) {
    p.z() = std::fmax(p.z(), drop.at(p.x(), p.y()));
    return p;
  };
  const auto move_to = [&](const Vec3& to) {
    const Vec3 from = kept.back();
    worst = std::fmax(worst, safe_move(from, to, profile, tolerance, kept));
  };
  for (std::size_t k = 0; k < tips.size(); ++k) {
    // Half the tolerance is for the points, the rest for what the moves between them dip under.
    if (drop.at(tips[k].x(), tips[k].y()) - tips[k].z() > tolerance / 2) continue;
    if (last == tips.size()) {
      kept.push_back(tips[k]);
    } else {
      if (k > last + 1) {
        ++counts.loops;
        if (const Crossing c = crossing_of(tips, last, k); c.found) {
          ++counts.crossings;
          move_to(lift(c.at));
        }
      }
      const std::size_t before = kept.size();
      move_to(tips[k]);
      if (k == last + 1 && kept.size() > before + 1) ++counts.crossings;
    }
    last = k;
  }
  tips = std::move(kept);
  return worst;
}

}  // namespace diesink
