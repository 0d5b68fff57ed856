// The compound surface by main force, for comparison: a body is where all its inequalities hold,
// its ends on a vertical line are found by bisection in long double, a Ferguson base by the
// textbook form. Slow and plain on purpose; nothing of the evaluator is used but the part program
// it reads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "core/part_program/part_program.h"

namespace diesink::test {

// A Ferguson composite surface by blending functions, its slopes from a dense solution of the
// spline equations.
class PlainFerguson {
 public:
  explicit PlainFerguson(const FergusonBase& base) : base_(base) {
    const int m = base.columns, n = base.rows;
    ru_.resize(base.points.size());
    rv_.resize(base.points.size());
    for (int j = 0; j < n; ++j) {
      std::vector<Vec3> p;
      for (int i = 0; i < m; ++i) p.push_back(base.points[at(i, j)]);
      const std::vector<Vec3> d = slopes(p);
      for (int i = 0; i < m; ++i) ru_[at(i, j)] = d[static_cast<std::size_t>(i)];
    }
    for (int i = 0; i < m; ++i) {
      std::vector<Vec3> p;
      for (int j = 0; j < n; ++j) p.push_back(base.points[at(i, j)]);
      const std::vector<Vec3> d = slopes(p);
      for (int j = 0; j < n; ++j) rv_[at(i, j)] = d[static_cast<std::size_t>(j)];
    }
  }

  // Beyond the grid the outer patches go on.
  [[nodiscard]] Vec3 point(double u, double v) const {
    const int i = std::clamp(static_cast<int>(std::floor(u)), 0, base_.columns - 2);
    const int j = std::clamp(static_cast<int>(std::floor(v)), 0, base_.rows - 2);
    const double s = u - i, t = v - j;
    const auto f = [](int k, double w) {
      switch (k) {
        case 0:
          return (1 + 2 * w) * (1 - w) * (1 - w);
        case 1:
          return w * w * (3 - 2 * w);
        case 2:
          return w * (1 - w) * (1 - w);
        default:
          return w * w * (w - 1);
      }
    };
    Vec3 sum = Vec3::Zero();
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) {
        const std::size_t k = at(i + a, j + b);
        sum += f(a, s) * f(b, t) * base_.points[k] + f(a + 2, s) * f(b, t) * ru_[k] +
               f(a, s) * f(b + 2, t) * rv_[k];
      }
    }
    return sum;
  }

  // Parameters over a plan point, perhaps outside the grid: from the nearest of many samples by
  // Newton's method with differences. Empty where that fails.
  [[nodiscard]] std::optional<Vec2> invert(double x, double y) const {
    Vec2 best(0, 0);
    double least = HUGE_VAL;
    for (int i = 0; i <= 4 * (base_.columns - 1); ++i) {
      for (int j = 0; j <= 4 * (base_.rows - 1); ++j) {
        const Vec3 p = point(0.25 * i, 0.25 * j);
        const double d = std::hypot(p.x() - x, p.y() - y);
        if (d < least) {
          least = d;
          best = Vec2(0.25 * i, 0.25 * j);
        }
      }
    }
    for (int k = 0; k < 40; ++k) {
      const double h = 1e-6;
      const Vec3 p = point(best.x(), best.y());
      const Vec3 pu = (point(best.x() + h, best.y()) - point(best.x() - h, best.y())) / (2 * h);
      const Vec3 pv = (point(best.x(), best.y() + h) - point(best.x(), best.y() - h)) / (2 * h);
      const double det = pu.x() * pv.y() - pv.x() * pu.y();
      const double rx = x - p.x(), ry = y - p.y();
      const Vec2 step((rx * pv.y() - ry * pv.x()) / det, (pu.x() * ry - pu.y() * rx) / det);
      best += step;
      if (!(best.norm() < 1e4)) return std::nullopt;
      if (step.norm() < 1e-15 * (1 + best.norm())) break;
    }
    const Vec3 p = point(best.x(), best.y());
    if (std::hypot(p.x() - x, p.y() - y) > 1e-9 * (1 + std::fabs(x) + std::fabs(y)))
      return std::nullopt;
    return best;
  }

 private:
  [[nodiscard]] std::size_t at(int i, int j) const {
    return static_cast<std::size_t>(j * base_.columns + i);
  }

  // Gauss-Jordan on the full matrix of the natural spline.
  static std::vector<Vec3> slopes(const std::vector<Vec3>& p) {
    const std::size_t n = p.size();
    std::vector<std::vector<double>> a(n, std::vector<double>(n, 0));
    std::vector<Vec3> b(n);
    for (std::size_t i = 0; i < n; ++i) {
      const bool first = i == 0, last = i + 1 == n;
      a[i][i] = first || last ? 2 : 4;
      if (!first) a[i][i - 1] = 1;
      if (!last) a[i][i + 1] = 1;
      b[i] = 3 * (p[last ? i : i + 1] - p[first ? i : i - 1]);
    }
    for (std::size_t c = 0; c < n; ++c) {
      for (std::size_t r = 0; r < n; ++r) {
        if (r == c) continue;
        const double k = a[r][c] / a[c][c];
        for (std::size_t x = 0; x < n; ++x) a[r][x] -= k * a[c][x];
        b[r] -= k * b[c];
      }
    }
    for (std::size_t i = 0; i < n; ++i) b[i] /= a[i][i];
    return b;
  }

  FergusonBase base_;
  std::vector<Vec3> ru_, rv_;
};

class BruteForce {
 public:
  using Real = long double;

  struct Value {
    bool defined = false;
    Real z = 0;
    int row = 0;
    int face = 0;
    bool sure_face = true;  // no second face passes close by
  };
  struct Answer {
    Value value;
    bool sure = true;         // no body is only grazed, no border of the base is near
    Real margin = HUGE_VALL;  // least difference of two heights that were compared
  };

  explicit BruteForce(const PartProgram& program) : program_(program) {
    if (const FergusonBase* base = std::get_if<FergusonBase>(&program.base))
      ferguson_.emplace(*base);
    for (const Solid& solid : program.solids) bodies_.push_back(body_of(solid.body));
  }

  [[nodiscard]] Answer at(double x, double y) const {
    Answer answer;
    std::size_t step = 0;
    answer.value = expression(step, x, y, answer);
    return answer;
  }

 private:
  // Inside where every constraint is <= 0; each is convex along a vertical line.
  struct Constraint {
    int face;
    std::function<Real(Real, Real, Real)> value;
  };
  struct SlowBody {
    std::vector<Constraint> constraints;
    Real cx = 0, cy = 0, cz = 0, radius = 0;  // a ball that holds the body
  };
  struct Ends {
    bool met = false;
    Real lower = 0, upper = 0;
    std::pair<int, bool> lower_face, upper_face;  // number, whether no other is near
  };

  static SlowBody body_of(const Body& body) {
    SlowBody out;
    if (const Polyhedron* polyhedron = std::get_if<Polyhedron>(&body)) {
      Vec3 middle = Vec3::Zero();
      for (const Vec3& v : polyhedron->vertices)
        middle += v / static_cast<double>(polyhedron->vertices.size());
      for (const Vec3& v : polyhedron->vertices)
        out.radius = std::max<Real>(out.radius, (v - middle).norm() * 1.001);
      out.cx = middle.x();
      out.cy = middle.y();
      out.cz = middle.z();
      for (const PolyhedronFace& face : polyhedron->faces) {
        // The plane of the largest triangle of the loop, away from the middle.
        Vec3 n = Vec3::Zero(), on = Vec3::Zero();
        for (const std::uint8_t a : face.loop) {
          for (const std::uint8_t b : face.loop) {
            const Vec3 o = polyhedron->vertices[face.loop[0]];
            const Vec3 c = (polyhedron->vertices[a] - o).cross(polyhedron->vertices[b] - o);
            if (c.norm() > n.norm() * 1.0001) {
              n = c;
              on = o;
            }
          }
        }
        n.normalize();
        if (n.dot(middle - on) > 0) n = -n;
        const Real nx = n.x(), ny = n.y(), nz = n.z(), px = on.x(), py = on.y(), pz = on.z();
        out.constraints.push_back({face.number, [=](Real x, Real y, Real z) {
                                     return nx * (x - px) + ny * (y - py) + nz * (z - pz);
                                   }});
      }
      return out;
    }
    const QuadricBody q = std::get<QuadricBody>(body);
    const auto local = [q](int k, Real x, Real y, Real z) {
      return static_cast<Real>(q.frame(k, 0)) * (x - static_cast<Real>(q.p.x())) +
             static_cast<Real>(q.frame(k, 1)) * (y - static_cast<Real>(q.p.y())) +
             static_cast<Real>(q.frame(k, 2)) * (z - static_cast<Real>(q.p.z()));
    };
    const Real A = q.A, B = q.B, C = q.C;
    const auto radial = [=](Real x, Real y, Real z) {
      return std::hypot(local(0, x, y, z) / A, local(1, x, y, z) / B);
    };
    const auto along = [=](Real x, Real y, Real z) { return local(2, x, y, z) / C; };
    out.cx = q.p.x();
    out.cy = q.p.y();
    out.cz = q.p.z();
    out.radius = (A + B + C) * 1.1L;
    switch (q.shape) {
      case QuadricShape::kEllipsoid:
        out.constraints = {{1, [=](Real x, Real y, Real z) {
                              return std::hypot(radial(x, y, z), along(x, y, z)) - 1;
                            }}};
        break;
      case QuadricShape::kCylinder:
        out.constraints = {{1, [=](Real x, Real y, Real z) { return radial(x, y, z) - 1; }},
                           {2, [=](Real x, Real y, Real z) { return -along(x, y, z); }},
                           {3, [=](Real x, Real y, Real z) { return along(x, y, z) - 1; }}};
        break;
      case QuadricShape::kCone:
        out.constraints = {
            {1, [=](Real x, Real y, Real z) { return radial(x, y, z) - 1 + along(x, y, z); }},
            {2, [=](Real x, Real y, Real z) { return -along(x, y, z); }}};
        break;
      case QuadricShape::kParaboloid:
        out.radius = C + A * std::sqrt(C) * 1.1L;
        out.constraints = {{1,
                            [=](Real x, Real y, Real z) {
                              const Real u = local(0, x, y, z) / A, v = local(1, x, y, z) / A;
                              return (u * u + v * v - local(2, x, y, z)) / C;
                            }},
                           {3, [=](Real x, Real y, Real z) { return along(x, y, z) - 1; }}};
        break;
    }
    return out;
  }

  static Ends ends_of(const SlowBody& body, double x, double y, bool& sure) {
    Ends ends;
    if (std::hypot(x - body.cx, y - body.cy) > body.radius) return ends;
    const auto worst = [&](Real z) {
      Real g = -HUGE_VALL;
      for (const Constraint& c : body.constraints) g = std::max(g, c.value(x, y, z));
      return g;
    };
    // The least of a convex function by golden section.
    Real a = body.cz - 2 * body.radius, b = body.cz + 2 * body.radius;
    const Real bottom = a, top = b;
    constexpr Real kGolden = 0.618033988749894848L;
    Real p = b - kGolden * (b - a), q = a + kGolden * (b - a), gp = worst(p), gq = worst(q);
    for (int k = 0; k < 90; ++k) {
      if (gp < gq) {
        b = q;
        q = p;
        gq = gp;
        p = b - kGolden * (b - a);
        gp = worst(p);
      } else {
        a = p;
        p = q;
        gp = gq;
        q = a + kGolden * (b - a);
        gq = worst(q);
      }
      if (std::min(gp, gq) < -1e-3L) break;  // well inside: good enough to start from
    }
    const Real inside = gp < gq ? p : q, g = std::min(gp, gq);
    if (std::fabs(g) < 1e-9L * (1 + body.radius)) sure = false;
    if (g > 0) return ends;
    const auto end = [&](Real from, Real to) {
      for (int k = 0; k < 100; ++k) {
        const Real mid = (from + to) / 2;
        if (mid == from || mid == to) break;
        (worst(mid) <= 0 ? from : to) = mid;
      }
      return from;
    };
    const auto face_at = [&](Real z) {
      int face = 0, close = 0;
      Real most = -HUGE_VALL;
      for (const Constraint& c : body.constraints) {
        const Real v = c.value(x, y, z);
        if (v > -1e-8L * (1 + body.radius)) ++close;
        if (v > most) {
          most = v;
          face = c.face;
        }
      }
      return std::pair(face, close == 1);
    };
    ends.met = true;
    ends.lower = end(inside, bottom);
    ends.upper = end(inside, top);
    ends.lower_face = face_at(ends.lower);
    ends.upper_face = face_at(ends.upper);
    return ends;
  }

  Value base_value(double x, double y, Answer& answer) const {
    Value v;
    if (const PlaneBase* plane = std::get_if<PlaneBase>(&program_.base)) {
      v.defined = true;
      v.z = plane->point.z() -
            (static_cast<Real>(plane->normal.x()) * (x - static_cast<Real>(plane->point.x())) +
             static_cast<Real>(plane->normal.y()) * (y - static_cast<Real>(plane->point.y()))) /
                plane->normal.z();
    } else if (ferguson_) {
      const std::optional<Vec2> uv = ferguson_->invert(x, y);
      if (!uv) {
        answer.sure = false;
        return v;
      }
      const FergusonBase& base = std::get<FergusonBase>(program_.base);
      const double out =
          std::max({-uv->x(), uv->x() - (base.columns - 1), -uv->y(), uv->y() - (base.rows - 1)});
      if (std::fabs(out) < 1e-7) answer.sure = false;
      v.defined = out <= 0;
      v.z = ferguson_->point(uv->x(), uv->y()).z();
    }
    return v;
  }

  // The terms from `step` up to the end or the close of the group.
  Value expression(std::size_t& step, double x, double y, Answer& answer) const {
    Value so_far;
    while (step < program_.boole.size()) {
      const BooleanStep& s = program_.boole[step++];
      Value e;
      bool plus = s.sign == Sign::kPlus;
      if (s.kind == BooleanStep::Kind::kGroupClose) return so_far;
      if (s.kind == BooleanStep::Kind::kGroupOpen) {
        e = expression(step, x, y, answer);
        plus = true;
      } else if (s.surface == 0) {
        e = base_value(x, y, answer);
        e.row = s.row;
      } else {
        const Ends ends =
            ends_of(bodies_[static_cast<std::size_t>(s.surface - 1)], x, y, answer.sure);
        const auto& [face, sure] = plus ? ends.upper_face : ends.lower_face;
        e = {ends.met, plus ? ends.upper : ends.lower, s.row, face, sure};
      }
      if (!e.defined || (!plus && !so_far.defined)) continue;
      if (so_far.defined) answer.margin = std::min(answer.margin, std::fabs(e.z - so_far.z));
      if (!so_far.defined || (plus ? e.z > so_far.z : e.z < so_far.z)) so_far = e;
    }
    return so_far;
  }

  const PartProgram& program_;
  std::vector<SlowBody> bodies_;
  std::optional<PlainFerguson> ferguson_;
};

}  // namespace diesink::test
