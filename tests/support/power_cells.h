// Spheres with centres at one height, whole numbers all, counted without rounding. Of two such
// spheres the higher one over a plan point is that of the lesser power, so that the plan is a power
// diagram cut to the union of discs: every sphere shows in one convex cell or not at all, every
// pair meets in one straight crease or not at all, and what is left of the plane has as many pieces
// as the nerve of the cells says. Touching, concentric and equal spheres and any number through one
// point are counted like all others.
// Source: Edelsbrunner, The union of balls and its dual shape, 1995.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <optional>
#include <vector>

#include "core/vec.h"

namespace diesink::test {

class PowerCells {
 public:
  struct Disc {
    int x = 0, y = 0;
    int square = 0;  // of the radius
  };
  struct Crease {
    int one = 0, other = 0;  // discs, the former on the left of from -> to
    Vec2 from = Vec2::Zero(), to = Vec2::Zero();
  };

  // Needs: coordinates and radii below 64, no more than 10 discs.
  explicit PowerCells(const std::vector<Disc>& discs) : discs_(discs) {
    const int n = static_cast<int>(discs.size());
    for (int i = 0; i < n; ++i) {
      // Of two equal ones the later is never seen.
      bool again = false;
      for (int j = 0; j < i; ++j) {
        again = again || (discs[at(i)].x == discs[at(j)].x && discs[at(i)].y == discs[at(j)].y &&
                          discs[at(i)].square == discs[at(j)].square);
      }
      if (!again) distinct_.push_back(i);
    }
    for (int i = 0; i < n; ++i) seen_.push_back(has_interior(i));
    for (const int i : distinct_) {
      for (const int j : distinct_) {
        if (i < j && seen(i) && seen(j)) add_crease(i, j);
      }
    }
    count_pieces();
  }

  [[nodiscard]] bool seen(int i) const { return seen_[at(i)]; }
  [[nodiscard]] const std::vector<Crease>& creases() const { return creases_; }
  // Pieces of the plan outside all discs, the unbounded one among them.
  [[nodiscard]] int outside_pieces() const { return outside_; }

  // The part of a disc's circle that borders the plane, radians; and the plan area of its cell. By
  // floating point: nothing is decided here.
  [[nodiscard]] double rim_angle(int i, double* area = nullptr) const {
    const Disc& d = discs_[at(i)];
    const double r = std::sqrt(d.square);
    std::vector<double> turns{0};
    for (const int j : distinct_) {
      const Disc& o = discs_[at(j)];
      const double gap = std::hypot(o.x - d.x, o.y - d.y);
      if (gap == 0) continue;
      const double along = (gap * gap + d.square - o.square) / (2 * gap);
      if (std::fabs(along) >= r) continue;
      const double to = std::atan2(o.y - d.y, o.x - d.x), half = std::acos(along / r);
      for (const double t : {to - half, to + half})
        turns.push_back(t - 2 * kPi * std::floor(t / (2 * kPi)));
    }
    std::sort(turns.begin(), turns.end());
    turns.push_back(2 * kPi);
    double sum = 0, twice = 0;
    for (std::size_t k = 0; k + 1 < turns.size(); ++k) {
      const double a = turns[k], b = turns[k + 1], m = 0.5 * (a + b);
      if (b - a < 1e-9) continue;
      const Vec2 p(d.x + r * std::cos(m), d.y + r * std::sin(m));
      bool own = true;
      for (const int j : distinct_) {
        const Disc& o = discs_[at(j)];
        if (j != i && (p - Vec2(o.x, o.y)).squaredNorm() < o.square) own = false;
      }
      if (!own) continue;
      sum += b - a;
      twice += d.square * (b - a) +
               r * (d.x * (std::sin(b) - std::sin(a)) - d.y * (std::cos(b) - std::cos(a)));
    }
    for (const Crease& c : creases_) {
      if (c.one != i && c.other != i) continue;
      const double cross = c.from.x() * c.to.y() - c.from.y() * c.to.x();
      twice += c.one == i ? cross : -cross;
    }
    if (area != nullptr) *area = 0.5 * twice;
    return sum;
  }

 private:
  __extension__ typedef __int128 Whole;  // products of four coordinates
  static constexpr double kPi = std::numbers::pi;
  static constexpr int kFar = 1000;  // beyond all discs
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  struct Line {  // a x + b y + c >= 0
    Whole a = 0, b = 0, c = 0;
  };
  struct Point {  // (x / w, y / w), w > 0
    Whole x = 0, y = 0, w = 1;
  };
  static int sign(Whole v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }
  static int side(const Line& l, const Point& p) { return sign(l.a * p.x + l.b * p.y + l.c * p.w); }
  // Where disc i has no more power than disc j.
  [[nodiscard]] Line bisector(int i, int j) const {
    const Disc &d = discs_[at(i)], &o = discs_[at(j)];
    return {-2 * (o.x - d.x), -2 * (o.y - d.y),
            o.x * o.x + o.y * o.y - o.square - d.x * d.x - d.y * d.y + d.square};
  }
  static std::optional<Point> meet(const Line& l, const Line& m) {
    const Whole w = l.a * m.b - l.b * m.a;
    if (w == 0) return std::nullopt;
    const Point p{l.b * m.c - l.c * m.b, l.c * m.a - l.a * m.c, w};
    return w > 0 ? p : Point{-p.x, -p.y, -p.w};
  }
  // Sign of the power of disc i at p.
  [[nodiscard]] int power(int i, const Point& p) const {
    const Disc& d = discs_[at(i)];
    const Whole u = p.x - d.x * p.w, v = p.y - d.y * p.w;
    return sign(u * u + v * v - d.square * p.w * p.w);
  }
  // The point of a line nearest to a disc's centre.
  [[nodiscard]] Point foot(const Line& l, int i) const {
    const Disc& d = discs_[at(i)];
    const Whole w = l.a * l.a + l.b * l.b, v = l.a * d.x + l.b * d.y + l.c;
    return {d.x * w - l.a * v, d.y * w - l.b * v, w};
  }
  // Lines round the cell of disc i, and round everything.
  [[nodiscard]] std::vector<Line> lines_of(int i) const {
    std::vector<Line> lines{{1, 0, kFar}, {-1, 0, kFar}, {0, 1, kFar}, {0, -1, kFar}};
    for (const int j : distinct_) {
      if (j != i) lines.push_back(bisector(i, j));
    }
    return lines;
  }
  // Points of disc i's polygon among which the nearest to its centre is: the centre itself, feet
  // on the lines, vertices.
  [[nodiscard]] std::vector<Point> candidates(int i, std::vector<Point>* vertices = nullptr) const {
    const std::vector<Line> lines = lines_of(i);
    const auto inside = [&](const Point& p) {
      return std::all_of(lines.begin(), lines.end(),
                         [&](const Line& l) { return side(l, p) >= 0; });
    };
    std::vector<Point> out;
    const Point centre{discs_[at(i)].x, discs_[at(i)].y, 1};
    if (inside(centre)) out.push_back(centre);
    for (std::size_t k = 0; k < lines.size(); ++k) {
      if (lines[k].a != 0 || lines[k].b != 0) {
        const Point f = foot(lines[k], i);
        if (inside(f)) out.push_back(f);
      }
      for (std::size_t m = 0; m < k; ++m) {
        const std::optional<Point> p = meet(lines[k], lines[m]);
        if (!p || !inside(*p)) continue;
        out.push_back(*p);
        if (vertices != nullptr) vertices->push_back(*p);
      }
    }
    return out;
  }
  [[nodiscard]] bool has_interior(int i) const {
    if (std::find(distinct_.begin(), distinct_.end(), i) == distinct_.end()) return false;
    std::vector<Point> corners;
    const std::vector<Point> near = candidates(i, &corners);
    // The polygon has an inside where its vertices do not lie on one line; the open disc reaches
    // into it where it holds a point of it.
    bool wide = false;
    for (const Point& p : corners) {
      for (const Point& q : corners) {
        const Line l{p.y * q.w - p.w * q.y, p.w * q.x - p.x * q.w, p.x * q.y - p.y * q.x};
        if (l.a == 0 && l.b == 0) continue;
        for (const Point& r : corners) wide = wide || side(l, r) != 0;
        if (wide) break;
      }
      if (wide) break;
    }
    return wide &&
           std::any_of(near.begin(), near.end(), [&](const Point& p) { return power(i, p) < 0; });
  }

  // The stretch of the bisector of i and j that no other disc has: from one point to another along
  // (-b, a), or nothing.
  struct Stretch {
    Point from, to, near;  // near: of it, the nearest to the centres
    bool point = false;    // from and to are one
  };
  [[nodiscard]] std::optional<Stretch> stretch(int i, int j) const {
    const Line l = bisector(i, j);
    if (l.a == 0 && l.b == 0) return std::nullopt;
    const auto before = [&](const Point& p, const Point& q) {  // sign of q - p along the line
      return sign((q.x * p.w - p.x * q.w) * -l.b + (q.y * p.w - p.y * q.w) * l.a);
    };
    std::optional<Point> low, high;
    std::vector<Line> lines = lines_of(i);
    for (const Line& m : lines) {
      const std::optional<Point> p = meet(l, m);
      if (!p) {
        // Beside the line: on one side of it all over.
        if (side(m, foot(l, i)) < 0) return std::nullopt;
        continue;
      }
      if (m.a * -l.b + m.b * l.a > 0) {
        if (!low || before(*low, *p) > 0) low = p;
      } else if (!high || before(*p, *high) > 0) {
        high = p;
      }
    }
    if (!low || !high || before(*low, *high) < 0) return std::nullopt;
    Stretch out{*low, *high, foot(l, i), before(*low, *high) == 0};
    if (before(out.near, out.from) > 0) out.near = out.from;
    if (before(out.near, out.to) < 0) out.near = out.to;
    return out;
  }

  void add_crease(int i, int j) {
    const std::optional<Stretch> s = stretch(i, j);
    if (!s || s->point || power(i, s->near) >= 0) return;
    const Line l = bisector(i, j);
    const Disc& d = discs_[at(i)];
    const long double a = static_cast<long double>(l.a), b = static_cast<long double>(l.b),
                      size = std::hypot(a, b);
    const auto number = [](Whole v) { return static_cast<long double>(v); };
    const Point f = foot(l, i);
    const long double fx = number(f.x) / number(f.w), fy = number(f.y) / number(f.w);
    const long double gap2 = (fx - d.x) * (fx - d.x) + (fy - d.y) * (fy - d.y);
    const long double half = std::sqrt(std::max(d.square - gap2, 0.0L));
    const auto place = [&](const Point& p) {
      return ((number(p.x) / number(p.w) - fx) * -b + (number(p.y) / number(p.w) - fy) * a) / size;
    };
    const long double s0 = std::max(place(s->from), -half), s1 = std::min(place(s->to), half);
    // Along (-b, a) the side a x + b y + c >= 0, which is i's, lies to the right.
    Crease crease{i, j, {}, {}};
    crease.to =
        Vec2(static_cast<double>(fx - b / size * s0), static_cast<double>(fy + a / size * s0));
    crease.from =
        Vec2(static_cast<double>(fx - b / size * s1), static_cast<double>(fy + a / size * s1));
    creases_.push_back(crease);
  }

  // Whether cells of a set of discs have a common point, closed as they are.
  [[nodiscard]] bool meet_all(const std::vector<int>& set) const {
    const int i = set[0];
    if (set.size() == 1) {
      const std::vector<Point> near = candidates(i);
      return std::any_of(near.begin(), near.end(),
                         [&](const Point& p) { return power(i, p) <= 0; });
    }
    // All bisectors one line, or one point.
    const Line first = bisector(i, set[1]);
    if (first.a == 0 && first.b == 0) return false;  // concentric: one has all
    for (std::size_t k = 2; k < set.size(); ++k) {
      const Line l = bisector(i, set[k]);
      const std::optional<Point> p = meet(first, l);
      if (!p) {
        if (side(l, foot(first, i)) != 0) return false;
        continue;
      }
      for (const int j : set) {
        if (j != i && side(bisector(i, j), *p) != 0) return false;
      }
      for (const Line& m : lines_of(i)) {
        if (side(m, *p) < 0) return false;
      }
      return power(i, *p) <= 0;
    }
    const std::optional<Stretch> s = stretch(i, set[1]);
    return s && power(i, s->near) <= 0;
  }

  // Pieces and holes of the union: the alternating sum of the nerve is pieces less holes.
  void count_pieces() {
    const std::size_t n = distinct_.size();
    std::vector<std::size_t> root(n);
    std::iota(root.begin(), root.end(), std::size_t{0});
    const auto find = [&](std::size_t k) {
      while (root[k] != k) k = root[k];
      return k;
    };
    int sum = 0;
    std::vector<char> there(n, 0);
    for (std::size_t mask = 1; mask < (std::size_t{1} << n); ++mask) {
      std::vector<int> set;
      std::vector<std::size_t> place;
      for (std::size_t k = 0; k < n; ++k) {
        if ((mask >> k & 1) == 0) continue;
        set.push_back(distinct_[k]);
        place.push_back(k);
      }
      if (!meet_all(set)) continue;
      sum += set.size() % 2 == 1 ? 1 : -1;
      for (const std::size_t k : place) {
        there[k] = 1;
        root[find(k)] = find(place[0]);
      }
    }
    int pieces = 0;
    for (std::size_t k = 0; k < n; ++k) pieces += there[k] && find(k) == k ? 1 : 0;
    outside_ = 1 + pieces - sum;
  }

  std::vector<Disc> discs_;
  std::vector<int> distinct_;
  std::vector<char> seen_;
  std::vector<Crease> creases_;
  int outside_ = 1;
};

}  // namespace diesink::test
