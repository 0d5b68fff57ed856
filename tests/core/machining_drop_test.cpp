// The drop against a search that knows nothing of contacts: nested golden sections over each
// triangle.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/drop.h"
#include "core/machining/lattice_drop.h"
#include "core/machining/segment_profile.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/height_mesh.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

using test::height_mesh;
using test::Random;

CutterShape shape(double diameter, double corner) {
  return CutterShape::make({diameter, corner}).value();
}

// Largest value of a concave f over [lo, hi].
template <class F>
double golden(const F& f, double lo, double hi) {
  const double ratio = (std::sqrt(5.0) - 1) / 2;
  double best = std::fmax(f(lo), f(hi));
  double p = hi - ratio * (hi - lo), q = lo + ratio * (hi - lo);
  double fp = f(p), fq = f(q);
  for (int k = 0; k < 60; ++k) {
    best = std::fmax(best, std::fmax(fp, fq));
    if (fp >= fq) {
      hi = q;
      q = p;
      fq = fp;
      p = hi - ratio * (hi - lo);
      fp = f(p);
    } else {
      lo = p;
      p = q;
      fp = fq;
      q = lo + ratio * (hi - lo);
      fq = f(q);
    }
  }
  return std::fmax(best, std::fmax(fp, fq));
}

// A concave stand-in outside the cutter's reach keeps the search going towards it.
double tip_over(const CutterShape& cutter, const Vec3& p, double x, double y) {
  const double rho = std::hypot(p.x() - x, p.y() - y);
  if (rho > cutter.radius()) return -1e6 * (1 + rho);
  const double d = std::fmax(0, rho - cutter.flat()), r = cutter.corner();
  return p.z() - (r > 0 ? r - std::sqrt(std::fmax(0, r * r - d * d)) : 0);
}

double brute(const TriangleMesh& mesh, const CutterShape& cutter, double x, double y) {
  double best = -1e5;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
    const auto along = [&](double s) {
      const Vec3 p = a + s * (b - a), q = a + s * (c - a);
      return golden([&](double v) { return tip_over(cutter, p + v * (q - p), x, y); }, 0, 1);
    };
    // Far triangles cannot matter.
    const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    const double far_x = std::fmax(0, std::fmax(low.x() - x, x - high.x()));
    const double far_y = std::fmax(0, std::fmax(low.y() - y, y - high.y()));
    if (std::hypot(far_x, far_y) > cutter.radius()) continue;
    best = std::fmax(best, golden(along, 0, 1));
  }
  return best > -1e5 ? best : kNoContact;
}

struct Case {
  double diameter, corner;
};
constexpr Case kCutters[] = {{6, 3}, {6, 0}, {6, 1}, {5, 2.4}};

TriangleMesh bumpy(std::uint64_t seed, std::uint32_t n, bool stepped) {
  Random random(seed);
  std::vector<double> z(n * n);
  for (double& v : z) {
    v = random.uniform(0, 3);
    if (stepped) v = std::floor(v);  // level facets, ridges, steep walls
  }
  TriangleMesh mesh = height_mesh(0, 10, n, 0, 10, n, [&](double x, double y) {
    const auto i = static_cast<std::size_t>(std::lround(x / 10 * (n - 1)));
    const auto j = static_cast<std::size_t>(std::lround(y / 10 * (n - 1)));
    return z[j * n + i];
  });
  // Some triangles away: borders and holes.
  std::vector<std::array<std::uint32_t, 3>> kept;
  for (const auto& t : mesh.triangles) {
    if (!random.chance(0.1)) kept.push_back(t);
  }
  mesh.triangles = kept;
  return mesh;
}

TEST(PointDrop, MatchesSearchOverRandomMeshes) {
  for (const Case& c : kCutters) {
    const CutterShape cutter = shape(c.diameter, c.corner);
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      const TriangleMesh mesh = bumpy(seed, seed < 4 ? 5 : 9, seed % 2 == 1);
      const OffsetSurface offset(mesh, cutter, 0);
      const PointDrop drop(offset);
      Random random(seed + 100);
      for (int k = 0; k < 12; ++k) {
        const double x = random.uniform(-2, 12), y = random.uniform(-2, 12);
        const double found = drop.at(x, y), expected = brute(mesh, cutter, x, y);
        if (expected == kNoContact) {
          EXPECT_EQ(found, kNoContact);
          continue;
        }
        // The search ends within 1e-10 at the steep rim of a cutter; it can only be too low.
        EXPECT_GE(found, expected - 1e-12)
            << c.diameter << " " << c.corner << " seed " << seed << " at " << x << " " << y;
        EXPECT_LE(found, expected + 1e-6);
      }
    }
  }
}

TEST(PointDrop, LevelPlaneIsExact) {
  const TriangleMesh mesh = height_mesh(0, 10, 4, 0, 10, 4, [](double, double) { return 2.5; });
  for (const Case& c : kCutters) {
    const OffsetSurface offset(mesh, shape(c.diameter, c.corner), 0);
    const PointDrop drop(offset);
    EXPECT_EQ(drop.at(5, 5), 2.5);
    EXPECT_EQ(drop.at(0, 0), 2.5);
    EXPECT_EQ(drop.at(10.0 / 3, 7), 2.5);
    EXPECT_EQ(drop.at(10 + c.diameter, 5), kNoContact);
  }
}

TEST(PointDrop, SlopeLiftsByTheOffset) {
  const TriangleMesh mesh =
      height_mesh(0, 20, 5, 0, 20, 5, [](double x, double) { return 0.75 * x; });
  const double slope = std::hypot(1, 0.75);
  const OffsetSurface ball(mesh, shape(6, 3), 0), flat(mesh, shape(6, 0), 0),
      bull(mesh, shape(6, 1), 0);
  EXPECT_NEAR(PointDrop(ball).at(10, 10), 7.5 + 3 * (slope - 1), 1e-13);
  EXPECT_NEAR(PointDrop(flat).at(10, 10), 7.5 + 3 * 0.75, 1e-13);
  EXPECT_NEAR(PointDrop(bull).at(10, 10), 7.5 + 1 * (slope - 1) + 2 * 0.75, 1e-13);
}

// A plane in fans of ever thinner slivers, whose normals are lost in rounding, is still that plane.
TEST(PointDrop, SliversLeaveNoSlits) {
  TriangleMesh mesh;
  const auto z = [](double x, double y) { return 0.031 * x + 0.017 * y; };
  const auto point = [&](double x, double y) {
    mesh.positions.emplace_back(x, y, z(x, y));
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
  };
  const std::uint32_t low = point(60, 60), high = point(60, 66), left = point(52, 63);
  std::uint32_t last = left;
  for (double gap = 1; gap > 1e-9; gap /= 3) {  // along the line from the left to its end
    const std::uint32_t next = point(60 - 8 * gap, 63);
    if (next != last && gap < 1) {
      mesh.triangles.push_back({last, low, next});
      mesh.triangles.push_back({last, next, high});
      last = next;
    }
  }
  const std::uint32_t end = point(60, 63);
  mesh.triangles.push_back({last, low, end});
  mesh.triangles.push_back({last, end, high});
  const std::uint32_t right = point(68, 63);
  mesh.triangles.push_back({end, low, right});
  mesh.triangles.push_back({end, right, high});
  for (const Case& c : kCutters) {
    const CutterShape cutter = shape(c.diameter, c.corner);
    const OffsetSurface offset(mesh, cutter, 0);
    const PointDrop drop(offset);
    const double lean = std::hypot(0.031, 0.017);
    const double lift = cutter.corner() * (std::sqrt(1 + lean * lean) - 1) + cutter.flat() * lean;
    // Over the plane's middle the contact is on the plane: shifted by less than the way to a side.
    const double reach = cutter.corner() * lean + cutter.flat();
    SegmentProfile profile(offset, drop, 1e-7);
    Random random(5);
    for (int k = 0; k < 300; ++k) {
      // Across the fans, with the contact within the plane.
      const Vec2 away(-reach * 0.031 / lean, -reach * 0.017 / lean);
      const Vec2 at(60, 63 + random.uniform(-0.5, 0.5));
      const Vec2 half(1, random.uniform(-0.5, 0.5));
      const Vec2 from = at + away - half, to = at + away + half;
      const PlanLine line(from, to);
      double reached = 0;
      for (const ProfileSegment& s : profile.take(from, to, kNoContact)) {
        EXPECT_LE(s.x0 - reached, 1e-12) << c.diameter << " " << c.corner;
        reached = s.x1;
        if (s.x1 - s.x0 < 1e-12) continue;  // between chords that meet to rounding
        for (const Vec2& corner : {Vec2(s.x0, s.z0), Vec2(s.x1, s.z1)}) {
          const Vec2 plan = line.at(corner.x());
          EXPECT_GE(corner.y(), z(plan.x(), plan.y()) + lift - 2e-7)
              << c.diameter << " " << c.corner;
        }
      }
      EXPECT_GE(reached, line.length - 1e-12);
    }
  }
}

// Two facets of a tilted plane with a sliver between them, anywhere: how far rounding turns the
// sliver's normal is what its pieces have to reach beyond their own bounds, and its corners too.
TEST(PointDrop, ASliverBetweenTwoFacetsLeavesNoSlit) {
  Random random(7);
  int looked_at = 0;
  for (int k = 0; k < 600; ++k) {
    const Vec2 middle(random.uniform(50, 900), random.uniform(50, 900));
    const double turn = random.uniform(0, 6.28), down = random.uniform(0, 6.28);
    const double lean = std::pow(10, random.uniform(-6, 0)), length = random.uniform(4, 12);
    const double width = std::pow(10, random.uniform(-10, -4));
    const Vec2 uphill(std::cos(down), std::sin(down));
    const Vec2 along(std::cos(turn), std::sin(turn)), across(-along.y(), along.x());
    const auto z = [&](const Vec2& p) { return lean * uphill.dot(p - middle); };
    TriangleMesh mesh;
    const auto point = [&](double u, double v) {
      const Vec2 p = middle + u * along + v * across;
      mesh.positions.emplace_back(p.x(), p.y(), z(p));
    };
    point(-length, 0);
    point(length, 0);
    point(-length, width);
    point(length, width);
    point(0, -length);
    point(0, length);
    mesh.triangles = {{0, 4, 1}, {0, 1, 3}, {0, 3, 2}, {2, 3, 5}};
    const Case& c = kCutters[static_cast<std::size_t>(k) % std::size(kCutters)];
    const CutterShape cutter = shape(c.diameter, c.corner);
    const double steep = std::sqrt(1 + lean * lean);
    const double reach = cutter.corner() * lean / steep + cutter.flat();
    if (reach > 0.8 * length) continue;
    ++looked_at;
    const OffsetSurface offset(mesh, cutter, 0);
    const PointDrop drop(offset);
    SegmentProfile profile(offset, drop, 1e-7);
    const double lift = cutter.corner() * (steep - 1) + cutter.flat() * lean;
    for (int m = 0; m < 20; ++m) {
      const Vec2 at =
          middle + random.uniform(-0.1, 0.1) * length * along + width / 2 * across - reach * uphill;
      const Vec2 half = random.uniform(-0.3, 0.3) * along + 0.2 * across;
      double reached = 0;
      for (const ProfileSegment& s : profile.take(at - half, at + half, kNoContact)) {
        ASSERT_LE(s.x0 - reached, 1e-12) << k;
        reached = s.x1;
      }
      const Vec2 near = at + random.uniform(-2, 2) * width * across;
      ASSERT_GE(drop.at(near.x(), near.y()), z(near) + lift - 1e-6) << k;
    }
  }
  EXPECT_GT(looked_at, 300);
}

// A cap around two corners so close together that rounding turns the normals of the two slivers
// between them.
TriangleMesh cap_with_slivers(const Vec2& middle, const Vec2& slope, double bend, double width) {
  TriangleMesh mesh;
  for (const Vec2& p :
       {Vec2(-8, 0), Vec2(8, 0), Vec2(0, -8), Vec2(0, 8), Vec2(0, 0), Vec2(0, width)}) {
    const double z = slope.dot(p) - bend * p.norm();
    mesh.positions.emplace_back(middle.x() + p.x(), middle.y() + p.y(), z);
  }
  mesh.triangles = {{0, 2, 4}, {4, 2, 1}, {0, 4, 5}, {4, 1, 5}, {0, 5, 3}, {5, 1, 3}};
  return mesh;
}

// The region of a corner holds the contacts of all facets around it by their true normals, however
// far rounding turns those ...
TEST(OffsetSurface, CornersOfSliversHoldTheContactsOfTheTrueNormals) {
  Random random(13);
  for (int k = 0; k < 500; ++k) {
    const TriangleMesh mesh =
        cap_with_slivers({random.uniform(50, 900), random.uniform(50, 900)},
                         {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)},
                         random.uniform(0, 0.2), std::pow(10, random.uniform(-9, -4)));
    const Case& c = kCutters[static_cast<std::size_t>(k) % std::size(kCutters)];
    const CutterShape cutter = shape(c.diameter, c.corner);
    const OffsetSurface offset(mesh, cutter, 0);
    using Long = Eigen::Matrix<long double, 3, 1>;
    for (const VertexPiece& v : offset.vertices()) {
      for (const auto& t : mesh.triangles) {
        std::array<Long, 3> p;
        bool around = false;
        for (std::size_t i = 0; i < 3; ++i) {
          p[i] = mesh.positions[t[i]].cast<long double>();
          around = around || mesh.positions[t[i]] == Vec3(v.x, v.y, v.z);
        }
        if (!around) continue;
        const Vec3 n = (p[1] - p[0]).cross(p[2] - p[0]).normalized().cast<double>();
        const Vec2 off = cutter.corner() * n.head<2>() + cutter.flat() * n.head<2>().normalized();
        EXPECT_TRUE(v.x + off.x() >= v.x0 && v.x + off.x() <= v.x1) << k;
        EXPECT_TRUE(v.y + off.y() >= v.y0 && v.y + off.y() <= v.y1) << k;
        EXPECT_GE(v.a[0] * off.x() + v.a[1] * off.y(), -v.slack) << k;
        EXPECT_GE(v.b[0] * off.x() + v.b[1] * off.y(), -v.slack) << k;
      }
    }
  }
}

// ... and is no larger than that takes: disks of the whole cutter over thousands of needles would
// make every pass their envelope.
TEST(OffsetSurface, SliversKeepTheirCornersRegionsNarrow) {
  const TriangleMesh mesh = cap_with_slivers({60, 63}, {0.031, 0.017}, 0, 1e-6);
  for (const Case& c : kCutters) {
    const OffsetSurface offset(mesh, shape(c.diameter, c.corner), 0);
    for (const VertexPiece& v : offset.vertices()) {
      if (v.border) continue;
      EXPECT_LT(v.x1 - v.x0, 1e-4) << c.diameter << " " << c.corner;
      EXPECT_LT(v.y1 - v.y0, 1e-4) << c.diameter << " " << c.corner;
    }
  }
}

TEST(PointDrop, StopsOnlyAtHeightsThatAreEnough) {
  const TriangleMesh mesh = bumpy(3, 9, false);
  for (const Case& c : kCutters) {
    const OffsetSurface offset(mesh, shape(c.diameter, c.corner), 0);
    const PointDrop drop(offset);
    Random random(11);
    for (int k = 0; k < 200; ++k) {
      const double x = random.uniform(-2, 12), y = random.uniform(-2, 12);
      const double full = drop.at(x, y), enough = random.uniform(-1, 4);
      const double stopped = drop.at(x, y, enough);
      EXPECT_LE(stopped, full);
      if (full >= enough) {
        EXPECT_GE(stopped, enough);
      } else {
        EXPECT_EQ(stopped, full);
      }
    }
  }
}

TEST(DropLattice, EqualsSinglePoints) {
  for (const Case& c : kCutters) {
    const CutterShape cutter = shape(c.diameter, c.corner);
    for (const double angle : {0.0, std::numbers::pi / 2, 0.4}) {
      for (std::uint64_t seed = 20; seed < 24; ++seed) {
        const TriangleMesh mesh = bumpy(seed, 12, seed % 2 == 0);
        const OffsetSurface offset(mesh, cutter, angle);
        const PointDrop drop(offset);
        std::vector<double> ys;
        for (int j = 0; j < 41; ++j) ys.push_back(-16 + 0.8 * j);
        constexpr std::size_t kColumns = 43;
        std::vector<double> heights(kColumns * ys.size()), again(heights.size());
        drop_lattice(offset, -16, 0.75, kColumns, ys, heights, 1);
        for (std::size_t j = 0; j < ys.size(); ++j) {
          for (std::size_t i = 0; i < kColumns; ++i) {
            const double x = -16 + 0.75 * static_cast<double>(i);
            const double z = drop.at(x, ys[j]);
            if (z == kNoContact)
              EXPECT_EQ(heights[j * kColumns + i], z);
            else
              EXPECT_NEAR(heights[j * kColumns + i], z, 1e-12) << x << " " << ys[j];
          }
        }
        drop_lattice(offset, -16, 0.75, kColumns, ys, again, 7);
        EXPECT_EQ(heights, again);
      }
    }
  }
}

TEST(OffsetSurface, TurnedFrameDropsTheSame) {
  const TriangleMesh mesh = bumpy(7, 9, true);
  const CutterShape cutter = shape(5, 2);
  const OffsetSurface straight(mesh, cutter, 0), turned(mesh, cutter, 1.1);
  const PointDrop a(straight), b(turned);
  Random random(3);
  for (int k = 0; k < 300; ++k) {
    const Vec3 p(random.uniform(0, 10), random.uniform(0, 10), 0);
    const Vec3 q = turned.to_frame(p);
    EXPECT_NEAR((turned.from_frame(q) - p).norm(), 0, 1e-14);
    const double za = a.at(p.x(), p.y()), zb = b.at(q.x(), q.y());
    if (za == kNoContact || zb == kNoContact)
      EXPECT_EQ(za, zb);
    else
      EXPECT_NEAR(za, zb, 1e-12);
  }
}

TEST(OffsetSurface, SharedAndSplitVerticesDropTheSame) {
  const TriangleMesh mesh = bumpy(9, 8, false);
  TriangleMesh split;
  for (const auto& t : mesh.triangles) {
    const auto at = static_cast<std::uint32_t>(split.positions.size());
    for (const std::uint32_t v : t) split.positions.push_back(mesh.positions[v]);
    split.triangles.push_back({at, at + 1, at + 2});
  }
  for (const Case& c : kCutters) {
    const CutterShape cutter = shape(c.diameter, c.corner);
    const OffsetSurface whole(mesh, cutter, 0), apart(split, cutter, 0);
    const PointDrop a(whole), b(apart);
    Random random(4);
    for (int k = 0; k < 400; ++k) {
      const double x = random.uniform(-1, 11), y = random.uniform(-1, 11);
      const double za = a.at(x, y), zb = b.at(x, y);
      if (za == kNoContact || zb == kNoContact)
        EXPECT_EQ(za, zb);
      else
        EXPECT_NEAR(za, zb, 1e-12) << c.diameter << " " << c.corner << " " << x << " " << y;
    }
  }
}

TEST(CutterShape, RefusesWhatIsNoCutter) {
  EXPECT_FALSE(CutterShape::make({0, 0}));
  EXPECT_FALSE(CutterShape::make({-1, 0}));
  EXPECT_FALSE(CutterShape::make({1e300, 1}));
  EXPECT_FALSE(CutterShape::make({6, 3.1}));
  EXPECT_FALSE(CutterShape::make({6, -0.1}));
  EXPECT_FALSE(CutterShape::make({std::nan(""), 0}));
  EXPECT_TRUE(CutterShape::make({6, 3}));
}

}  // namespace
}  // namespace diesink
