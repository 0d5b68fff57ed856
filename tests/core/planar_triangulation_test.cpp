// Planar triangulation against brute force, on regular and on degenerate input.
// SPDX-License-Identifier: Apache-2.0
#include "tests/core/planar_checks.h"

namespace diesink {
namespace {

// Whole coordinates: everything below is exact.
std::int64_t turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  const auto whole = [](double v) { return static_cast<std::int64_t>(v); };
  const std::int64_t det = (whole(b.x()) - whole(a.x())) * (whole(c.y()) - whole(a.y())) -
                           (whole(b.y()) - whole(a.y())) * (whole(c.x()) - whole(a.x()));
  return det > 0 ? 1 : (det < 0 ? -1 : 0);
}

bool is_within(const Vec2& a, const Vec2& b, const Vec2& p) {
  return p != a && p != b && turn(a, b, p) == 0 && (p - a).dot(p - b) < 0;
}

bool cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

TEST(PlanarTriangulation, SquareWithHole) {
  Region region;
  region.add_loop(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 4}, {0, 4}});
  region.add_loop(std::vector<Vec2>{{1, 1}, {1, 2}, {2, 2}, {2, 1}});
  PlanarTriangulation mesh;
  ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
  EXPECT_EQ(mesh.triangles().size(), 8U);
  check_region(mesh.points(), region.segments, mesh.triangles(), 4);
  EXPECT_TRUE(mesh.insert({3, 3}));
  EXPECT_FALSE(mesh.insert({3, 3}));      // on a vertex
  EXPECT_FALSE(mesh.insert({1.5, 1.5}));  // in the hole
  EXPECT_FALSE(mesh.insert({2, 1.5}));    // on a segment
  EXPECT_FALSE(mesh.insert({5, 5}));
  EXPECT_FALSE(mesh.insert({1e300, std::nan("")}));
  EXPECT_EQ(mesh.triangles().size(), 10U);
  check_region(mesh.points(), region.segments, mesh.triangles(), 4);
}

TEST(PlanarTriangulation, EmptyCirclesByBruteForce) {
  std::mt19937_64 random(5);
  for (int round = 0; round < 2000; ++round) {
    // Whole coordinates on a small board: many points in line and on one circle.
    const int board = 4 + static_cast<int>(random() % 12);
    std::set<std::pair<int, int>> places;
    const std::size_t count = 1 + random() % 24;
    for (std::size_t i = 0; i < count; ++i) {
      const int x = 1 + static_cast<int>(random() % static_cast<unsigned>(board));
      places.emplace(x, 1 + static_cast<int>(random() % static_cast<unsigned>(board)));
    }
    Region region;
    const double end = board + 1;
    region.add_loop(std::vector<Vec2>{{0, 0}, {end, 0}, {end, end}, {0, end}});
    for (const auto& [x, y] : places) region.points.emplace_back(x, y);
    PlanarTriangulation mesh;
    ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
    const std::vector<Corners> triangles = mesh.triangles();
    ASSERT_EQ(triangles.size(), 2 * region.points.size() - 6);
    check_region(mesh.points(), region.segments, triangles, end);
    for (const Corners& t : triangles) {
      const Vec2 &a = region.points[t[0]], &b = region.points[t[1]], &c = region.points[t[2]];
      ASSERT_EQ(turn(a, b, c), 1);
      for (const Vec2& p : region.points) ASSERT_LE(in_circle_value(a, b, c, p), 0);
    }
  }
}

// Every crossing, every point on a segment and every doubled segment is named, and nothing else.
TEST(PlanarTriangulation, NamesAllCrossings) {
  using Name = std::array<std::uint32_t, 3>;  // a, b, point
  std::mt19937_64 random(11);
  int clean = 0;
  for (int round = 0; round < 6000; ++round) {
    const std::size_t board = 2 + random() % 10;
    Region region;
    for (std::size_t i = 0; i < board * board; ++i) {
      if (random() % 3 != 0) continue;
      region.points.emplace_back(static_cast<double>(i % board), static_cast<double>(i / board));
    }
    const auto count = static_cast<std::uint32_t>(region.points.size());
    if (count < 2) continue;
    for (std::size_t i = 1 + random() % 8; i > 0; --i) {
      region.segments.push_back({static_cast<std::uint32_t>(random() % count),
                                 static_cast<std::uint32_t>(random() % count)});
    }
    const auto& p = region.points;
    const auto& s = region.segments;
    const auto first_alike = [&](std::uint32_t i) {
      std::uint32_t k = 0;
      while (s[k] != s[i] && s[k] != Segment{s[i][1], s[i][0]}) ++k;
      return k;
    };
    std::set<Name> expected;
    for (std::uint32_t i = 0; i < s.size(); ++i) {
      if (s[i][0] == s[i][1]) {
        expected.insert({i, kNoSegment, s[i][0]});
        continue;
      }
      for (std::uint32_t k = 0; k < count; ++k) {
        if (is_within(p[s[i][0]], p[s[i][1]], p[k])) expected.insert({i, kNoSegment, k});
      }
      const auto same = static_cast<std::uint32_t>(std::find(s.begin(), s.end(), s[i]) - s.begin());
      if (same < i) expected.insert({same, i, kNoPoint});
      for (std::uint32_t k = 0; k < i; ++k) {
        if (!cross(p[s[i][0]], p[s[i][1]], p[s[k][0]], p[s[k][1]])) continue;
        const std::uint32_t a = first_alike(i), b = first_alike(k);
        expected.insert({std::min(a, b), std::max(a, b), kNoPoint});
      }
    }
    std::set<Name> named;
    bool unbounded = false;
    PlanarTriangulation mesh;
    for (const SegmentCrossing& w : mesh.build(p, s)) {
      if (w.segment_b != kNoSegment && s[w.segment_a] != s[w.segment_b]) {
        const std::uint32_t a = first_alike(w.segment_a), b = first_alike(w.segment_b);
        named.insert({std::min(a, b), std::max(a, b), kNoPoint});
      } else if (w.segment_b == kNoSegment && w.point == kNoPoint) {
        unbounded = true;
      } else {
        named.insert({w.segment_a, w.segment_b, w.point});
      }
    }
    ASSERT_EQ(named, expected) << "round " << round;
    if (expected.empty()) ++clean;
    // A few open segments bound nothing, unless they are there both ways.
    ASSERT_TRUE(!unbounded || expected.empty());
  }
  EXPECT_GT(clean, 500);
}

TEST(PlanarTriangulation, NamesDoubledPoints) {
  Region region;
  region.add_loop(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {4, 0}});
  region.points.emplace_back(0, 4);
  PlanarTriangulation mesh;
  std::set<std::pair<std::uint32_t, std::uint32_t>> named;
  for (const SegmentCrossing& w : mesh.build(region.points, region.segments)) {
    named.insert(std::minmax(w.point, w.other_point));
    EXPECT_NE(w.segment_a, kNoSegment);
  }
  EXPECT_EQ(named, (std::set<std::pair<std::uint32_t, std::uint32_t>>{{1, 4}, {3, 5}}));
  EXPECT_TRUE(mesh.triangles().empty());
  EXPECT_FALSE(mesh.insert({1, 1}));

  region.points[2] = {std::numeric_limits<double>::infinity(), 0};
  const std::vector<SegmentCrossing> wrong = mesh.build(region.points, region.segments);
  ASSERT_EQ(wrong.size(), 1U);
  EXPECT_EQ(wrong[0].point, 2U);
}

TEST(PlanarTriangulation, NamesOpenAndTurnedLoops) {
  const std::vector<Vec2> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  Region region;
  region.add_loop(square);
  PlanarTriangulation mesh;
  region.segments.pop_back();
  EXPECT_EQ(mesh.build(region.points, region.segments).size(), 3U);
  region.segments = {{0, 3}, {3, 2}, {2, 1}, {1, 0}};
  EXPECT_EQ(mesh.build(region.points, region.segments).size(), 1U);
  EXPECT_TRUE(mesh.build({}, {}).empty());
  EXPECT_TRUE(mesh.triangles().empty());
}

// A segment given both ways has the region on both sides.
TEST(PlanarTriangulation, SlitsAndPinches) {
  Region region;
  region.add_loop(std::vector<Vec2>{{0, 0}, {8, 0}, {8, 8}, {0, 8}});
  region.add_loop(std::vector<Vec2>{{4, 4}, {5, 6}, {6, 4}, {5, 2}});
  region.points.emplace_back(2, 4);
  region.points.emplace_back(1, 7);
  for (const Segment s : {Segment{4, 8}, Segment{8, 9}, Segment{8, 0}}) {
    region.segments.push_back(s);
    region.segments.push_back({s[1], s[0]});
  }
  // A second hole that touches the first in one point.
  region.points.emplace_back(7, 5);
  region.points.emplace_back(7, 3);
  for (const Segment s : {Segment{6, 10}, Segment{10, 11}, Segment{11, 6}}) {
    region.segments.push_back(s);
  }
  PlanarTriangulation mesh;
  ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
  check_region(mesh.points(), region.segments, mesh.triangles(), 8);
  for (int x = 1; x < 8; ++x) {
    for (int y = 1; y < 8; ++y) mesh.insert(Vec2(x, y) + Vec2(0.25, 0.125));
  }
  check_region(mesh.points(), region.segments, mesh.triangles(), 8);
}

// Rings within rings, touching none: Euler's count and the area.
TEST(PlanarTriangulation, NestedLoops) {
  for (const int corners : {4, 7, 40, 1000}) {
    Region region;
    std::size_t holes = 0, rings = 0;
    for (int x = 0; x < 4; ++x) {
      for (int y = 0; y < 4; ++y) {
        for (int k = 0; k < 6; ++k) {
          region.add_loop(
              circle({3.0 * x, 3.0 * y}, 1.4 * std::pow(0.7, k), corners, k % 2 == 1, 0.3 * k));
          k % 2 == 1 ? ++holes : ++rings;
        }
      }
    }
    PlanarTriangulation mesh;
    ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
    const std::vector<Corners> triangles = mesh.triangles();
    EXPECT_EQ(triangles.size(), region.points.size() - 2 * rings + 2 * holes);
    check_region(mesh.points(), region.segments, triangles, 10);
  }
}

// Shifting by and scaling with numbers that change no digit changes nothing.
TEST(PlanarTriangulation, FarAndTinyCoordinates) {
  std::mt19937_64 random(3);
  Region region;
  region.add_loop(std::vector<Vec2>{{0, 0}, {64, 0}, {64, 64}, {0, 64}});
  for (int x = 1; x < 64; x += 3) {
    for (int y = 1; y < 64; y += 3) {
      region.points.emplace_back(x + static_cast<double>(random() % 3), y);
    }
  }
  PlanarTriangulation mesh;
  ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
  const std::vector<Corners> plain = mesh.triangles();
  check_region(mesh.points(), region.segments, plain, 64);
  for (const double scale : {0x1p-30, 0x1p-300, 0x1p100}) {
    for (const double shift : {0.0, 0x1p20, -0x1p22}) {
      std::vector<Vec2> moved;
      for (const Vec2& p : region.points) moved.push_back(scale * (p + Vec2(shift, -3 * shift)));
      ASSERT_TRUE(mesh.build(moved, region.segments).empty());
      EXPECT_EQ(mesh.triangles(), plain) << scale << ' ' << shift;
    }
  }
  // One part in 10^9 beside 10^6, all on a circle but for rounding.
  for (const double radius : {1e-3, 1.0, 1e3, 1e9}) {
    Region far;
    far.add_loop(circle({1e6, -1e6}, radius, 300));
    far.points.emplace_back(1e6, -1e6);
    ASSERT_TRUE(mesh.build(far.points, far.segments).empty()) << radius;
    EXPECT_EQ(mesh.triangles().size(), 300U);
  }
}

TEST(PlanarTriangulation, ThinSlivers) {
  // A comb whose teeth are a millionth wide, and a fan of a thousand needles.
  Region region;
  std::vector<Vec2> comb{{0, 0}, {1, 0}};
  for (int i = 200; i > 0; --i) {
    comb.emplace_back(0.005 * i, 1);
    comb.emplace_back(0.005 * i - 1e-6, 0.5);
    comb.emplace_back(0.005 * i - 2e-6, 1e-6 * i);
  }
  region.add_loop(comb);
  PlanarTriangulation mesh;
  ASSERT_TRUE(mesh.build(region.points, region.segments).empty());
  EXPECT_EQ(mesh.triangles().size(), comb.size() - 2);
  check_region(mesh.points(), region.segments, mesh.triangles());

  std::vector<Vec2> fan{{0, 0}};
  for (int i = 0; i <= 1000; ++i) {
    fan.emplace_back(i % 2 == 0 ? 1.0 : 1e-7, (i % 2 == 0 ? 1.0 : 1e-7) * 1e-3 * i);
  }
  Region needles;
  needles.add_loop(fan);
  ASSERT_TRUE(mesh.build(needles.points, needles.segments).empty());
  EXPECT_EQ(mesh.triangles().size(), fan.size() - 2);
  check_region(mesh.points(), needles.segments, mesh.triangles());
}

// ---- splits and insertions in any order, each held against what must come of it ----

class Play {
 public:
  explicit Play(std::uint64_t seed) : random_(seed) {}

  void run() {
    make_region();
    ASSERT_TRUE(mesh_.build(region_.points, region_.segments).empty());
    is_fixed_.assign(region_.points.size(), true);
    for (int step = 0; step < 40; ++step) {
      if (random_() % 2 == 0) {
        insert();
      } else {
        split();
      }
      if (testing::Test::HasFatalFailure()) return;
      check_region(mesh_.points(), region_.segments, mesh_.triangles(), kBoard);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  int splits = 0, refusals = 0, insertions = 0;

 private:
  static constexpr int kBoard = 24;

  int number(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }

  void make_region() {
    region_.add_loop(std::vector<Vec2>{{0, 0}, {kBoard, 0}, {kBoard, kBoard}, {0, kBoard}});
    if (random_() % 2 == 0) {  // a square hole
      const double x = number(5, 9), y = number(5, 9), w = number(1, 9);
      region_.add_loop(std::vector<Vec2>{{x, y}, {x, y + w}, {x + w, y + w}, {x + w, y}});
    }
    if (random_() % 2 == 0) {  // a slit
      const auto k = static_cast<std::uint32_t>(region_.points.size());
      region_.points.emplace_back(number(1, 4), number(1, kBoard - 1));
      region_.points.emplace_back(number(1, 4), number(1, kBoard - 1));
      if (region_.points[k] == region_.points[k + 1]) {
        region_.points.pop_back();
      } else {
        region_.segments.push_back({k, k + 1});
        region_.segments.push_back({k + 1, k});
      }
    }
  }

  void insert() {
    const Vec2 p(number(-2, kBoard + 2), number(-2, kBoard + 2));
    int winding = 0;
    bool touches = false;
    for (const Vec2& v : mesh_.points()) touches = touches || v == p;
    for (const Segment& s : region_.segments) {
      const Vec2 &a = mesh_.points()[s[0]], &b = mesh_.points()[s[1]];
      touches = touches || is_within(a, b, p);
      if (a.y() <= p.y() && b.y() > p.y() && turn(a, b, p) > 0) ++winding;
      if (a.y() > p.y() && b.y() <= p.y() && turn(a, b, p) < 0) --winding;
    }
    const bool expected = !touches && winding == 1;
    ASSERT_EQ(mesh_.insert(p), expected);
    if (!expected) return;
    ++insertions;
    is_fixed_.push_back(false);
    ASSERT_EQ(mesh_.points().back(), p);
  }

  bool can_split(const Segment& s, const Vec2& p) {
    const Vec2 a = mesh_.points()[s[0]], b = mesh_.points()[s[1]];
    const std::int64_t side = turn(a, b, p);
    if (side == 0) return is_within(a, b, p);
    for (std::uint32_t v = 0; v < mesh_.points().size(); ++v) {
      const Vec2& q = mesh_.points()[v];
      if (v == s[0] || v == s[1]) continue;
      if (q == p) return false;
      const std::int64_t ab = side * turn(a, b, q), bp = side * turn(b, p, q),
                         pa = side * turn(p, a, q);
      if (ab < 0 || bp < 0 || pa < 0) continue;
      if (is_fixed_[v] || bp == 0 || pa == 0) return false;
    }
    for (const Segment& t : region_.segments) {
      const Vec2 &c = mesh_.points()[t[0]], &d = mesh_.points()[t[1]];
      if (t == s || t == Segment{s[1], s[0]}) continue;
      if (is_within(c, d, p) || cross(c, d, a, p) || cross(c, d, b, p)) return false;
    }
    return true;
  }

  void split() {
    const Segment s = region_.segments[random_() % region_.segments.size()];
    const Vec2 middle = 0.5 * (mesh_.points()[s[0]] + mesh_.points()[s[1]]);
    const Vec2 p(std::floor(middle.x()) + number(-4, 4), std::floor(middle.y()) + number(-4, 4));
    const bool expected = can_split(s, p);
    const std::vector<Corners> before = mesh_.triangles();
    const auto vertex = static_cast<std::uint32_t>(mesh_.points().size());
    ASSERT_EQ(mesh_.split_segment(s[0], s[1], p), expected);
    if (!expected) {
      ++refusals;
      ASSERT_EQ(mesh_.triangles(), before);
      return;
    }
    ++splits;
    is_fixed_.push_back(true);
    ASSERT_EQ(mesh_.points().back(), p);
    std::vector<Segment> halves;
    for (Segment& t : region_.segments) {
      if (t != s && t != Segment{s[1], s[0]}) continue;
      halves.push_back({vertex, t[1]});
      t[1] = vertex;
    }
    region_.segments.insert(region_.segments.end(), halves.begin(), halves.end());
  }

  std::mt19937_64 random_;
  Region region_;
  PlanarTriangulation mesh_;
  std::vector<bool> is_fixed_;
};

TEST(PlanarTriangulation, SplitsAndInsertionsByBruteForce) {
  int splits = 0, refusals = 0, insertions = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    Play play(seed);
    play.run();
    if (HasFatalFailure()) return;
    splits += play.splits;
    refusals += play.refusals;
    insertions += play.insertions;
  }
  EXPECT_GT(splits, 1000);
  EXPECT_GT(refusals, 1000);
  EXPECT_GT(insertions, 1000);
}

}  // namespace
}  // namespace diesink
