// SPDX-License-Identifier: Apache-2.0
#include "core/compound/side_contacts.h"

#include <algorithm>
#include <cmath>

#include "core/compound/pencil.h"

namespace diesink {
namespace {

// The form of a side on (r - origin) / length, scaled so that its coefficients are about one.
Mat4 form_about(const SideQuadratic& s, const Vec3& origin, double length) {
  Mat4 m;
  m << s.cxx, 0.5 * s.cxy, s.bx, 0.5 * s.cx1,  //
      0.5 * s.cxy, s.cyy, s.by, 0.5 * s.cy1,   //
      s.bx, s.by, s.q2, s.b0,                  //
      0.5 * s.cx1, 0.5 * s.cy1, s.b0, s.c0;
  Mat4 t = Mat4::Identity() * length;
  t.topRightCorner<3, 1>() = origin - Vec3(s.cx, s.cy, s.cz);
  t(3, 3) = 1;
  const Mat4 moved = t.transpose() * m * t;
  return moved / moved.cwiseAbs().maxCoeff();
}

// F - k G is a square, up or down, near one of the two k for which its principal minors of order
// two add up to nothing.
struct Square {
  bool found = false;
  double sign = 0;  // of the square
};

Square square_in_pencil(const Mat4& f, const Mat4& g, double slack) {
  const auto minors = [](const Mat4& a, const Mat4& b) {
    return a.trace() * b.trace() - (a * b).trace();
  };
  const double c2 = minors(g, g), c1 = minors(f, g), c0 = minors(f, f);
  const double root = std::sqrt(std::fmax(c1 * c1 - c2 * c0, 0));
  const double big = c1 + std::copysign(root, c1);  // without cancelling
  for (double k : {big / c2, c0 / big}) {
    if (!(k > 0)) continue;
    // Where F - k G is nearly a square, so near that Newton's method on what is left of it ends
    // there.
    constexpr double kNear = 1e-3;
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds && std::isfinite(k); ++round) {
      const Mat4 e = f - k * g;
      // What is left of it beside the square of its heaviest row: cheap, and enough for most pairs.
      int heavy = 0;
      for (int i = 1; i < 4; ++i) {
        if (std::fabs(e(i, i)) > std::fabs(e(heavy, heavy))) heavy = i;
      }
      const double weight = std::fabs(e(heavy, heavy));
      if (!(weight > 0)) break;
      const Mat4 left = e - e.col(heavy) * e.row(heavy) / e(heavy, heavy);
      if (left.cwiseAbs().maxCoeff() > kNear * weight) break;
      const Eigen::SelfAdjointEigenSolver<Mat4> solver(e);
      const Vec4& values = solver.eigenvalues();  // ascending: the largest at one of the ends
      const bool is_up = std::fabs(values[3]) > std::fabs(values[0]);
      const int first = is_up ? 0 : 1, last = is_up ? 2 : 3;
      // Points within the length: (x, y, z, 1) is no longer than 2.
      const double rest = std::fmax(std::fabs(values[first]), std::fabs(values[last]));
      if (4 * rest <= slack) return {true, is_up ? 1.0 : -1.0};
      k += step_in_pencil(solver, g, first, last);
    }
  }
  return {};
}

}  // namespace

void SideContacts::build(const std::vector<BodyLine>& bodies, double slack) {
  nested_.clear();
  touches_.assign(bodies.size(), 0);
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].has_side()) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    const double x = bodies[i].plan_box().x0, y = bodies[j].plan_box().x0;
    return x != y ? x < y : i < j;
  });
  const auto key = [](std::uint32_t inner, std::uint32_t outer) {
    return static_cast<std::uint64_t>(inner) << 32 | outer;
  };
  for (std::size_t n = 0; n < order.size(); ++n) {
    const BodyLine& a = bodies[order[n]];
    const PlanBox& p = a.plan_box();
    for (std::size_t m = n + 1; m < order.size(); ++m) {
      const BodyLine& b = bodies[order[m]];
      const PlanBox& q = b.plan_box();
      if (q.x0 > p.x1 + slack) break;
      if (q.y0 > p.y1 + slack || p.y0 > q.y1 + slack) continue;
      // About the middle of what both cover, as far as that reaches.
      const double x0 = std::fmax(p.x0, q.x0), x1 = std::fmin(p.x1, q.x1),
                   y0 = std::fmax(p.y0, q.y0), y1 = std::fmin(p.y1, q.y1),
                   z0 = std::fmin(a.z_low(), b.z_low()), z1 = std::fmax(a.z_high(), b.z_high());
      const Vec3 origin(0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.5 * (z0 + z1));
      const double length = 0.5 * std::max({x1 - x0, y1 - y0, z1 - z0});
      const Square square = square_in_pencil(form_about(a.side(), origin, length),
                                             form_about(b.side(), origin, length), slack / length);
      if (!square.found) continue;
      // A square added to G is F: outside of G's surface or on it; so F's surface is inside G.
      const std::uint32_t inner = square.sign > 0 ? order[n] : order[m],
                          outer = square.sign > 0 ? order[m] : order[n];
      nested_.push_back(key(inner, outer));
      touches_[inner] = 1;
    }
  }
  std::sort(nested_.begin(), nested_.end());
}

bool SideContacts::find(std::int32_t inner, std::int32_t outer) const {
  return std::binary_search(
      nested_.begin(), nested_.end(),
      static_cast<std::uint64_t>(inner) << 32 | static_cast<std::uint32_t>(outer));
}

int side_of_tangent_plane(const BodyLine& body, const Vec3& at, double zx, double zy,
                          const ContactReach& reach, double slack) {
  const SideQuadratic& s = body.side();
  const double dx = at.x() - s.cx, dy = at.y() - s.cy, t = at.z() - s.cz;
  // The form on the plane, a conic of the plan about the point.
  const double q1 = s.b0 + s.bx * dx + s.by * dy, rise = 2 * (s.q2 * t + q1);
  const double v = (s.q2 * t + 2 * q1) * t + s.c0 + dx * (s.cx1 + s.cxx * dx + s.cxy * dy) +
                   dy * (s.cy1 + s.cyy * dy);
  const double gx = s.cx1 + 2 * s.cxx * dx + s.cxy * dy + 2 * s.bx * t + rise * zx;
  const double gy = s.cy1 + 2 * s.cyy * dy + s.cxy * dx + 2 * s.by * t + rise * zy;
  const double hxx = 2 * (s.cxx + 2 * s.bx * zx + s.q2 * zx * zx);
  const double hyy = 2 * (s.cyy + 2 * s.by * zy + s.q2 * zy * zy);
  const double hxy = s.cxy + 2 * (s.bx * zy + s.by * zx) + 2 * s.q2 * zx * zy;
  // Along its axes: bent by `most` along n, by `least` across it.
  const double middle = 0.5 * (hxx + hyy), half = std::hypot(0.5 * (hxx - hyy), hxy);
  const double most = middle + half, least = middle - half;
  if (!(most > 0) || !(v < most * reach.across * reach.across)) return 0;  // enclosures tell
  const double turn = 0.5 * std::atan2(hxy, 0.5 * (hxx - hyy));
  const double nx = std::cos(turn), ny = std::sin(turn);
  const double along = gx * nx + gy * ny, across = gy * nx - gx * ny;
  // The foot of the point on the line where the conic is lowest along n.
  const double away = -along / most;
  if (std::fabs(away) > reach.across) return 0;
  const double lowest = v - 0.5 * along * along / most - std::fabs(across) * reach.along -
                        std::fmax(-least, 0) * 0.5 * reach.along * reach.along;
  const double foot_rise = rise + 2 * away * (nx * (s.q2 * zx + s.bx) + ny * (s.q2 * zy + s.by));
  // The form rises that much a length upwards: by no more than `slack` the plane is in it.
  if (!(lowest >= -slack * std::fabs(foot_rise))) return 0;
  // Seen from where the side has heights, above or below both: elsewhere the sign says nothing.
  const double foot_form = v - 0.5 * along * along / most;
  if (!(4 * s.q2 * foot_form <= foot_rise * foot_rise)) return 0;
  const QuadricBody& quadric = std::get<QuadricBody>(body.body());
  if (quadric.shape == QuadricShape::kCone) {
    // The mirrored nappe's heights are none of the body's.
    const Vec3 a = quadric.frame.row(2);
    const Vec3 inside =
        at + Vec3(away * nx, away * ny, away * (zx * nx + zy * ny) - 0.5 * foot_rise / s.q2);
    if (a.dot(inside - (quadric.p + quadric.C * a)) >= -slack) return 0;
  }
  return foot_rise > 0 ? 1 : foot_rise < 0 ? -1 : 0;
}

}  // namespace diesink
