// The upper envelope of spheres over a plane or over nothing, counted by itself: every visible arc,
// vertex and face of its plan with their lengths, places and areas. All its curves are circles in
// space (rims, circles of two spheres, circles of a sphere and the plane); what happens along one
// is a root of a trigonometric polynomial of degree two. Roots are isolated by bounds of the first
// and second derivative, and every sign that decides something must keep a margin far above
// rounding: where one does not, the scene is refused and another is drawn. Nothing of core is used.
// Source: Halperin and Sharir, the combinatorics of envelopes; the planar map is walked as in
// de Berg et al., Computational Geometry, chapter 2.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include "core/mesh.h"
#include "core/vec.h"

namespace diesink::test {

struct SceneSphere {
  Vec3 centre = Vec3::Zero();
  double radius = 1;
};

struct SphereScene {
  std::vector<SceneSphere> spheres;
  bool plane = true;  // z = 0; else nothing lies under the spheres
  double side = 40;   // the domain is [0, side] x [0, side]
};

// Who is seen: k the k-th sphere from 1, 0 the plane.
inline constexpr int kNobody = -1, kOutside = -2;

struct EnvelopeArc {
  CurveKind kind = CurveKind::kCrease;
  int left = kNobody, right = kNobody;
  int from = -1, to = -1;  // vertices; -1: a closed circle
  double length = 0;       // of the longer one of its lifted sides
  double plan_length = 0;
  double radius = 0;    // of the circle in space
  bool border = false;  // a stretch of the domain's border, the domain on its left
};

struct EnvelopeVertex {
  Vec2 at = Vec2::Zero();
  std::vector<double> heights;  // the different ones of the arcs' sides that end here
  bool border = false;
};

struct Envelope {
  std::vector<EnvelopeArc> arcs;
  std::vector<EnvelopeVertex> vertices;  // where arcs end; corners of the domain are none
  std::map<int, int> faces;              // connected pieces of each
  std::map<int, double> area;            // in plan
  std::map<int, double> perimeter;       // in plan, of the arcs beside it
};

class EnvelopeCounter {
 public:
  explicit EnvelopeCounter(const SphereScene& scene) : scene_(scene) {}

  // Empty where a sign does not keep its margin.
  std::optional<Envelope> count() {
    make_circles();
    for (std::size_t c = 0; c < circles_.size() && !refused_; ++c) cut(circles_[c]);
    if (!refused_) find_vertices();
    if (!refused_) add_border();
    if (!refused_) walk_faces();
    if (refused_) return std::nullopt;
    return std::move(out_);
  }

 private:
  static constexpr double kPi = std::numbers::pi;
  static constexpr double kMargin = 1e-8;  // of values of the size of one squared length
  struct Circle {
    Vec3 q, e1, e2;
    int one = 0, other = 0;  // a rim: of one, other is itself
    [[nodiscard]] Vec3 at(double t) const { return q + std::cos(t) * e1 + std::sin(t) * e2; }
    [[nodiscard]] Vec3 along(double t) const { return std::cos(t) * e2 - std::sin(t) * e1; }
    [[nodiscard]] bool rim() const { return one == other; }
  };
  struct Piece {  // a visible arc of a circle, t0 < t1 <= t0 + 2 pi
    const Circle* circle = nullptr;
    double t0 = 0, t1 = 0;
    std::size_t arc = 0;
  };

  [[nodiscard]] const SceneSphere& sphere(int k) const {
    return scene_.spheres[static_cast<std::size_t>(k - 1)];
  }
  [[nodiscard]] int count_of() const { return static_cast<int>(scene_.spheres.size()); }

  // True where v > 0; refuses where that is not sure.
  bool positive(double v, double scale = 1) {
    if (!(std::fabs(v) > kMargin * scale)) refused_ = true;
    return v > 0;
  }

  void make_circles() {
    for (int i = 1; i <= count_of(); ++i) {
      const SceneSphere& s = sphere(i);
      circles_.push_back({s.centre, {s.radius, 0, 0}, {0, s.radius, 0}, i, i});
      if (scene_.plane) {
        if (!positive(s.centre.z())) {
          const double square = s.radius * s.radius - s.centre.z() * s.centre.z();
          if (positive(square)) {
            const double r = std::sqrt(square);
            circles_.push_back({{s.centre.x(), s.centre.y(), 0}, {r, 0, 0}, {0, r, 0}, i, 0});
          }
        }
      }
      for (int j = 1; j < i; ++j) {
        const SceneSphere& o = sphere(j);
        const Vec3 n = o.centre - s.centre;
        const double d2 = n.squaredNorm();
        if (!positive(d2)) return;
        const double f = (d2 + s.radius * s.radius - o.radius * o.radius) / (2 * d2);
        const double square = s.radius * s.radius - f * f * d2;
        if (!positive(square)) continue;
        Vec3 e1 = n.cross(Vec3::UnitZ());
        if (!(e1.norm() > 1e-6)) e1 = Vec3::UnitX();
        e1.normalize();
        const Vec3 e2 = n.normalized().cross(e1);
        const double r = std::sqrt(square);
        circles_.push_back({s.centre + f * n, r * e1, r * e2, i, j});
      }
    }
  }

  // Roots in [start, start + 2 pi) of what is a trigonometric polynomial of degree two in t.
  template <class F>
  void roots(const F& f, std::vector<double>& out) {
    double v[5], a[3], b[3] = {0, 0, 0};
    for (int k = 0; k < 5; ++k) v[k] = f(2 * kPi * k / 5);
    for (int m = 0; m < 3; ++m) {
      double ca = 0, sa = 0;
      for (int k = 0; k < 5; ++k) {
        ca += v[k] * std::cos(2 * kPi * m * k / 5);
        sa += v[k] * std::sin(2 * kPi * m * k / 5);
      }
      a[m] = (m == 0 ? 0.2 : 0.4) * ca;
      b[m] = m == 0 ? 0 : 0.4 * sa;
    }
    const double one = std::hypot(a[1], b[1]), two = std::hypot(a[2], b[2]);
    const double scale = std::fabs(a[0]) + one + two;
    if (!(scale > 1e-3)) {
      refused_ = true;
      return;
    }
    const auto value = [&](double t) {
      return a[0] + a[1] * std::cos(t) + b[1] * std::sin(t) + a[2] * std::cos(2 * t) +
             b[2] * std::sin(2 * t);
    };
    const auto slope = [&](double t) {
      return -a[1] * std::sin(t) + b[1] * std::cos(t) - 2 * a[2] * std::sin(2 * t) +
             2 * b[2] * std::cos(2 * t);
    };
    const double first = one + 2 * two, second = one + 4 * two;
    const auto search = [&](const auto& self, double l, double h, int depth) -> void {
      const double m = 0.5 * (l + h), w = 0.5 * (h - l);
      if (refused_ || std::fabs(value(m)) > first * w + 1e-9 * scale) return;
      if (std::fabs(slope(m)) > second * w) {  // monotone: one root at most
        double vl = value(l), vh = value(h);
        if (std::fabs(vl) < 1e-12 * scale || std::fabs(vh) < 1e-12 * scale) refused_ = true;
        if ((vl > 0) == (vh > 0)) return;
        for (int k = 0; k < 60; ++k) {
          const double c = 0.5 * (l + h);
          ((value(c) > 0) == (vl > 0) ? l : h) = c;
        }
        if (std::fabs(slope(l)) < 1e-3 * scale) refused_ = true;  // its place would not be sure
        out.push_back(l);
        return;
      }
      if (depth > 14) {
        refused_ = true;
        return;
      }
      self(self, l, m, depth + 1);
      self(self, m, h, depth + 1);
    };
    constexpr double kStart = 0.123456789;
    search(search, kStart, kStart + kPi * 0.7, 0);
    search(search, kStart + kPi * 0.7, kStart + kPi * 1.4, 0);
    search(search, kStart + kPi * 1.4, kStart + kPi * 2, 0);
  }

  static double over_disc(const SceneSphere& s, const Vec3& p) {  // > 0 inside
    return s.radius * s.radius - (p - s.centre).head<2>().squaredNorm();
  }
  static double power(const SceneSphere& s, const Vec3& p) {
    return (p - s.centre).squaredNorm() - s.radius * s.radius;
  }
  // Upper height; needs a point over the disc, perhaps its rim, where rounding would show.
  double height(int k, const Vec2& p) {
    if (k == 0) return 0;
    const SceneSphere& s = sphere(k);
    const double inside = over_disc(s, {p.x(), p.y(), 0}) / (s.radius * s.radius);
    if (inside < 1e-10) return s.centre.z();
    if (inside < 1e-6) refused_ = true;
    return s.centre.z() + s.radius * std::sqrt(inside);
  }

  // The one seen over p but for two, with margins.
  int seen(const Vec3& p, int but, int but_too) {
    int best = kNobody;
    double top = -1e300;
    if (scene_.plane && but != 0 && but_too != 0) {
      best = 0;
      top = 0;
    }
    for (int k = 1; k <= count_of(); ++k) {
      if (k == but || k == but_too || !positive(over_disc(sphere(k), p))) continue;
      const double h = height(k, p.head<2>());
      if (best == kNobody || positive(h - top)) {
        best = k;
        top = h;
      }
    }
    return best;
  }

  // All visible pieces of a circle, between the points where anything may change along it.
  void cut(const Circle& c) {
    std::vector<double> events;
    const auto each = [&](const auto& value) {
      roots([&](double t) { return value(c.at(t)); }, events);
    };
    // (The plan circle of a rim never leaves its own, nor its own height; lines are skipped where
    // they are constant.)
    const auto level = [&](double z) {
      if (std::hypot(c.e1.z(), c.e2.z()) > 1e-9) {
        each([&](const Vec3& p) { return p.z() - z; });
      }
    };
    if (!c.rim()) {
      level(sphere(c.one).centre.z());
      if (c.other > 0) level(sphere(c.other).centre.z());
    }
    if (scene_.plane && c.other != 0) level(0);
    for (const double v : {0.0, scene_.side}) {
      each([&](const Vec3& p) { return p.x() - v; });
      each([&](const Vec3& p) { return p.y() - v; });
    }
    for (int k = 1; k <= count_of(); ++k) {
      if (k == c.one || k == c.other) continue;
      each([&](const Vec3& p) { return power(sphere(k), p); });
      each([&](const Vec3& p) { return over_disc(sphere(k), p); });
    }
    if (c.rim()) below_rim(c, each);
    if (refused_) return;
    std::sort(events.begin(), events.end());
    if (events.empty()) events.push_back(0.123);
    const std::size_t n = events.size();
    std::vector<Piece> pieces;
    std::vector<EnvelopeArc> arcs;
    for (std::size_t k = 0; k < n; ++k) {
      const double t0 = events[k], t1 = k + 1 < n ? events[k + 1] : events[0] + 2 * kPi;
      if (t1 - t0 < 1e-6) {
        refused_ = refused_ || n > 1;
        if (refused_) return;
      }
      EnvelopeArc arc;
      if (!labels(c, 0.5 * (t0 + t1), arc)) continue;
      if (refused_) return;
      if (!pieces.empty() && pieces.back().t1 == t0 && same(arcs.back(), arc)) {
        pieces.back().t1 = t1;
      } else {
        pieces.push_back({&c, t0, t1, 0});
        arcs.push_back(arc);
      }
    }
    // The last and the first piece may be one over the start.
    if (pieces.size() > 1 && pieces.back().t1 == pieces.front().t0 + 2 * kPi &&
        same(arcs.back(), arcs.front())) {
      pieces.front().t0 = pieces.back().t0 - 2 * kPi;
      pieces.pop_back();
      arcs.pop_back();
    }
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      pieces[k].arc = out_.arcs.size();
      measure(pieces[k], arcs[k]);
      pieces_.push_back(pieces[k]);
      out_.arcs.push_back(arcs[k]);
    }
  }

  // Where two of those under a rim change places.
  template <class Each>
  void below_rim(const Circle& c, const Each& each) {
    for (int j = 1; j <= count_of(); ++j) {
      if (j == c.one) continue;
      const SceneSphere& s = sphere(j);
      const double z = s.centre.z();
      if (scene_.plane && z < 0 && s.radius > -z) {
        each([&](const Vec3& p) { return over_disc(s, p) - z * z; });
      }
      for (int k = 1; k < j; ++k) {
        if (k == c.one) continue;
        const SceneSphere& o = sphere(k);
        // The plane in which both meet: n p = w.
        const Vec3 n = 2 * (o.centre - s.centre);
        const double w = o.centre.squaredNorm() - o.radius * o.radius - s.centre.squaredNorm() +
                         s.radius * s.radius;
        if (std::fabs(n.z()) < 1e-9) {
          each([&](const Vec3& p) { return n.head<2>().dot(p.head<2>()) - w; });
          continue;
        }
        each([&](const Vec3& p) {
          const double h = (w - n.head<2>().dot(p.head<2>())) / n.z() - z;
          return (h * h - over_disc(s, p)) * std::min(1.0, n.z() * n.z());
        });
      }
    }
  }

  static bool same(const EnvelopeArc& a, const EnvelopeArc& b) {
    return a.kind == b.kind && a.left == b.left && a.right == b.right;
  }

  // Whether a circle is seen at t, and what is seen beside it.
  bool labels(const Circle& c, double t, EnvelopeArc& arc) {
    const Vec3 p = c.at(t);
    for (const double v : {p.x(), p.y()}) {
      if (!positive(v) || !positive(scene_.side - v)) return false;
    }
    if (c.rim()) {
      const int under = seen(p, c.one, c.one);
      if (refused_ || (under != kNobody && !positive(p.z() - height(under, p.head<2>()))))
        return false;
      arc.kind = under == kNobody ? CurveKind::kEdge : CurveKind::kJump;
      arc.left = c.one;
      arc.right = under;
      return true;
    }
    const double own = c.other == 0
                           ? sphere(c.one).centre.z()
                           : std::max(sphere(c.one).centre.z(), sphere(c.other).centre.z());
    if (!positive(p.z() - own)) return false;
    const int third = seen(p, c.one, c.other);
    if (refused_ || (third != kNobody && positive(height(third, p.head<2>()) - p.z())))
      return false;
    // Higher to the left of the direction of travel is who is seen there.
    const auto gradient = [&](int k) -> Vec2 {
      if (k == 0) return Vec2::Zero();
      const Vec3 d = p - sphere(k).centre;
      return -d.head<2>() / d.z();
    };
    const Vec3 way = c.along(t);
    const Vec2 left(-way.y(), way.x());
    const bool one_left = positive((gradient(c.one) - gradient(c.other)).dot(left));
    arc.left = one_left ? c.one : c.other;
    arc.right = one_left ? c.other : c.one;
    return true;
  }

  // Sums f(t) dt over a piece: Gauss's rule of five points on short stretches.
  template <class F>
  static double integral(const Piece& piece, const F& f) {
    constexpr double kX[] = {0, 0.5384693101056831, 0.9061798459386640},
                     kW[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
    constexpr int kParts = 64;
    double sum = 0;
    const double half = (piece.t1 - piece.t0) / (2 * kParts);
    for (int k = 0; k < kParts; ++k) {
      const double m = piece.t0 + (2 * k + 1) * half;
      sum += kW[0] * f(m);
      for (int i = 1; i < 3; ++i) sum += kW[i] * (f(m - kX[i] * half) + f(m + kX[i] * half));
    }
    return half * sum;
  }

  void measure(const Piece& piece, EnvelopeArc& arc) {
    const Circle& c = *piece.circle;
    arc.radius = c.e1.norm();
    arc.length = arc.radius * (piece.t1 - piece.t0);
    arc.plan_length = integral(piece, [&](double t) { return c.along(t).head<2>().norm(); });
    if (arc.kind != CurveKind::kJump) return;
    // The foot of the wall, by chords: it may be steep where the lower one ends as well.
    constexpr int kChords = 20000;
    double foot = 0;
    Vec3 last;
    for (int k = 0; k <= kChords; ++k) {
      // Denser to both ends, where it may be steepest.
      const double s = 0.5 - 0.5 * std::cos(kPi * k / kChords);
      Vec3 p = c.at(piece.t0 + (piece.t1 - piece.t0) * s);
      if (arc.right == 0) {
        p.z() = 0;
      } else {
        const SceneSphere& low = sphere(arc.right);
        p.z() = low.centre.z() + std::sqrt(std::max(over_disc(low, p), 0.0));
      }
      if (k > 0) foot += (p - last).norm();
      last = p;
    }
    arc.length = std::max(arc.length, foot);
  }

  int vertex_at(const Vec2& p) {
    for (std::size_t k = 0; k < out_.vertices.size(); ++k) {
      const double d = (out_.vertices[k].at - p).norm();
      if (d < 1e-8) return static_cast<int>(k);
      if (d < 1e-4) refused_ = true;  // neither one nor two for sure
    }
    EnvelopeVertex v;
    v.at = p;
    for (const double w : {p.x(), p.y()}) {
      v.border = v.border || std::fabs(w) < 1e-8 || std::fabs(w - scene_.side) < 1e-8;
    }
    out_.vertices.push_back(v);
    return static_cast<int>(out_.vertices.size() - 1);
  }

  void find_vertices() {
    for (const Piece& piece : pieces_) {
      EnvelopeArc& arc = out_.arcs[piece.arc];
      if (piece.t1 - piece.t0 > 2 * kPi - 1e-9) {
        // A whole circle; one that others end at would have been parted there.
        continue;
      }
      for (const bool last : {false, true}) {
        const Vec3 p = piece.circle->at(last ? piece.t1 : piece.t0);
        const int v = vertex_at(p.head<2>());
        (last ? arc.to : arc.from) = v;
        std::vector<double>& heights = out_.vertices[static_cast<std::size_t>(v)].heights;
        for (const bool left : {true, false}) {
          const int label = left ? arc.left : arc.right;
          if (label == kNobody) continue;
          const double z = left || !piece.circle->rim() ? p.z() : height(label, p.head<2>());
          bool known = false;
          for (const double other : heights) {
            const double d = std::fabs(z - other);
            known = known || d < 1e-8;
            if (d >= 1e-8 && d < 1e-5) refused_ = true;
          }
          if (!known) heights.push_back(z);
        }
      }
    }
  }

  // Plan directions and areas of arcs, for the walk.
  struct HalfEdge {
    std::size_t arc = 0;
    bool forward = true;
    double angle = 0;  // of its plan direction at its start
    double area2 = 0;  // twice the area of the sector to the origin
  };

  void add_border() {
    // Anticlockwise; the vertices on it in order, with the domain's corners between.
    const double s = scene_.side;
    const auto place = [&](const Vec2& p) {  // along the border from the origin
      if (std::fabs(p.y()) < 1e-8) return p.x();
      if (std::fabs(p.x() - s) < 1e-8) return s + p.y();
      if (std::fabs(p.y() - s) < 1e-8) return 3 * s - p.x();
      return 4 * s - p.y();
    };
    std::vector<std::pair<double, int>> stops;
    for (std::size_t v = 0; v < out_.vertices.size(); ++v) {
      if (out_.vertices[v].border)
        stops.emplace_back(place(out_.vertices[v].at), static_cast<int>(v));
    }
    corners_ = out_.vertices.size();
    for (int k = 0; k < 4; ++k) {
      EnvelopeVertex corner;
      corner.at = Vec2(k == 1 || k == 2 ? s : 0, k >= 2 ? s : 0);
      corner.border = true;
      stops.emplace_back(k * s, static_cast<int>(out_.vertices.size()));
      out_.vertices.push_back(corner);
    }
    std::sort(stops.begin(), stops.end());
    for (std::size_t k = 0; k < stops.size(); ++k) {
      EnvelopeArc arc;
      arc.border = true;
      arc.from = stops[k].second;
      arc.to = stops[(k + 1) % stops.size()].second;
      const Vec2 a = out_.vertices[static_cast<std::size_t>(arc.from)].at,
                 b = out_.vertices[static_cast<std::size_t>(arc.to)].at;
      if ((b - a).norm() < 1e-5) refused_ = true;
      const Vec2 m = 0.5 * (a + b);
      arc.left = seen({m.x(), m.y(), 0}, kOutside, kOutside);
      arc.right = kOutside;
      arc.plan_length = 0;  // straight: no chord is off it
      out_.arcs.push_back(arc);
    }
  }

  void walk_faces() {
    std::vector<HalfEdge> edges(2 * out_.arcs.size());
    std::vector<const Piece*> piece_of(out_.arcs.size(), nullptr);
    for (const Piece& p : pieces_) piece_of[p.arc] = &p;
    std::vector<std::vector<std::size_t>> leaving(out_.vertices.size());
    for (std::size_t a = 0; a < out_.arcs.size(); ++a) {
      const EnvelopeArc& arc = out_.arcs[a];
      double area2 = 0;
      Vec2 start, end;  // directions of travel
      if (const Piece* p = piece_of[a]) {
        area2 = integral(*p, [&](double t) {
          const Vec3 q = p->circle->at(t), d = p->circle->along(t);
          return q.x() * d.y() - q.y() * d.x();
        });
        start = p->circle->along(p->t0).head<2>();
        end = p->circle->along(p->t1).head<2>();
      } else {
        const Vec2 u = out_.vertices[static_cast<std::size_t>(arc.from)].at,
                   v = out_.vertices[static_cast<std::size_t>(arc.to)].at;
        area2 = u.x() * v.y() - u.y() * v.x();
        start = end = v - u;
      }
      if (arc.from >= 0 && (start.norm() < 1e-6 || end.norm() < 1e-6)) refused_ = true;
      edges[2 * a] = {a, true, std::atan2(start.y(), start.x()), area2};
      edges[2 * a + 1] = {a, false, std::atan2(-end.y(), -end.x()), -area2};
      if (arc.from < 0) continue;
      leaving[static_cast<std::size_t>(arc.from)].push_back(2 * a);
      leaving[static_cast<std::size_t>(arc.to)].push_back(2 * a + 1);
    }
    for (std::vector<std::size_t>& fan : leaving) {
      std::sort(fan.begin(), fan.end(),
                [&](std::size_t a, std::size_t b) { return edges[a].angle < edges[b].angle; });
      for (std::size_t k = 0; fan.size() > 2 && k < fan.size(); ++k) {
        const double next =
            k + 1 < fan.size() ? edges[fan[k + 1]].angle : edges[fan[0]].angle + 2 * kPi;
        if (next - edges[fan[k]].angle < 1e-6) refused_ = true;
      }
      if (fan.size() == 1) refused_ = true;  // an arc that ends in nothing: an event was lost
    }
    if (refused_) return;
    const auto label_of = [&](std::size_t e) {
      const EnvelopeArc& arc = out_.arcs[edges[e].arc];
      return edges[e].forward ? arc.left : arc.right;
    };
    std::vector<char> done(edges.size(), 0);
    for (std::size_t first = 0; first < edges.size(); ++first) {
      if (done[first]) continue;
      const int label = label_of(first);
      double area2 = 0;
      for (std::size_t e = first; !done[e];) {
        done[e] = 1;
        area2 += edges[e].area2;
        if (label_of(e) != label) refused_ = true;  // the map is not one
        const EnvelopeArc& arc = out_.arcs[edges[e].arc];
        if (label >= kNobody) out_.perimeter[label] += arc.plan_length;
        if (arc.from < 0) break;
        // The next one to the right of the way back keeps the face on the left.
        const std::vector<std::size_t>& fan =
            leaving[static_cast<std::size_t>(edges[e].forward ? arc.to : arc.from)];
        const std::size_t back =
            static_cast<std::size_t>(std::find(fan.begin(), fan.end(), e ^ 1U) - fan.begin());
        e = fan[(back + fan.size() - 1) % fan.size()];
      }
      if (label == kOutside) continue;
      if (positive(area2)) ++out_.faces[label];
      out_.area[label] += 0.5 * area2;
    }
    out_.vertices.resize(corners_);
    std::erase_if(out_.arcs, [](const EnvelopeArc& arc) { return arc.border; });
  }

  const SphereScene& scene_;
  std::vector<Circle> circles_;
  std::vector<Piece> pieces_;
  Envelope out_;
  std::size_t corners_ = 0;
  bool refused_ = false;
};

inline std::optional<Envelope> count_envelope(const SphereScene& scene) {
  return EnvelopeCounter(scene).count();
}

}  // namespace diesink::test
