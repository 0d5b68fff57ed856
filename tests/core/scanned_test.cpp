// The scanned base: vertical lines against triangles, by main force and by exact arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include "core/base/scanned.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "core/base/exact_plan.h"
#include "core/compound/compound_surface.h"
#include "core/grid/grid_array.h"
#include "core/parallel.h"
#include "tests/support/height_mesh.h"
#include "tests/support/load_part.h"

namespace diesink {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ScannedSurface scan_of(TriangleMesh mesh, const MeshBase& base = {}) {
  Result<ScannedSurface> surface = ScannedSurface::make(std::move(mesh), base);
  EXPECT_TRUE(surface) << (surface ? "" : surface.error().message);
  return std::move(*surface);
}

// A noisy relief whose inner vertices are shaken in plan, so that edges lie every way.
TriangleMesh shaken_relief(std::uint32_t n, std::uint32_t seed, double shake = 0.3) {
  TriangleMesh mesh = test::height_mesh(-7, 33, n, 2, 42, n, [](double x, double y) {
    return 3 * std::sin(x / 5) * std::cos(y / 4);
  });
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(-1, 1);
  const double cell = 40.0 / (n - 1);
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      Vec3& p = mesh.positions[j * n + i];
      if (i > 0 && i + 1 < n && j > 0 && j + 1 < n) {
        p.x() += shake * cell * part(random);
        p.y() += shake * cell * part(random);
      }
      p.z() += 0.2 * part(random);
    }
  }
  return mesh;
}

// Triangles of every sort, over one another: upright, repeated, degenerate, tiny, large.
TriangleMesh soup(std::size_t count, std::uint32_t seed) {
  TriangleMesh mesh;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-10, 10), size(-1, 1);
  std::uniform_int_distribution<int> kind(0, 9);
  for (std::size_t i = 0; i < count; ++i) {
    const auto v = static_cast<std::uint32_t>(mesh.positions.size());
    const Vec3 a(place(random), place(random), place(random));
    const double reach = kind(random) == 0 ? 15 : 1.5;
    const auto near = [&] {
      return Vec3(a + reach * Vec3(size(random), size(random), size(random)));
    };
    Vec3 b = near(), c = near();
    switch (kind(random)) {
      case 0:
        c = Vec3(b.x(), b.y(), b.z() + 1);
        break;
      case 1:
        c = b;
        break;
      case 2:  // a lattice: lines meet edges and vertices
        for (Vec3* p : {&b, &c}) *p = Vec3(std::round(p->x()), std::round(p->y()), p->z());
        break;
      default:
        break;
    }
    mesh.positions.insert(mesh.positions.end(), {a, b, c});
    mesh.triangles.push_back({v, v + 1, v + 2});
    if (kind(random) == 1) mesh.triangles.push_back({v, v + 2, v + 1});
  }
  return mesh;
}

// The topmost triangle in long double, which carries the products of the lattice exactly.
struct Plain {
  bool hit = false;
  long double z = 0;
  std::uint32_t face = 0;
};
Plain plain_hit(const TriangleMesh& mesh, double x, double y) {
  Plain best;
  using L = long double;
  for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
    const Vec3 &a = mesh.positions[mesh.triangles[f][0]], &b = mesh.positions[mesh.triangles[f][1]],
               &c = mesh.positions[mesh.triangles[f][2]];
    const auto area = [](const Vec3& p, const Vec3& q, L rx, L ry) {
      return (L{q.x()} - L{p.x()}) * (ry - L{p.y()}) - (L{q.y()} - L{p.y()}) * (rx - L{p.x()});
    };
    const L whole = area(a, b, c.x(), c.y());
    if (whole == 0) continue;
    const L u = area(b, c, x, y) / whole, v = area(c, a, x, y) / whole,
            w = area(a, b, x, y) / whole;
    if (u < 0 || v < 0 || w < 0) continue;
    const L z = u * L{a.z()} + v * L{b.z()} + w * L{c.z()};
    if (!best.hit || z > best.z) best = {true, z, f};
  }
  return best;
}

TEST(ExactTurn, AgreesWithWholeNumbers) {
  // Points of a lattice with 2^26 steps a side, near one line: products fit whole numbers.
  std::mt19937_64 random(7);
  std::uniform_int_distribution<std::int64_t> step(-(1 << 26), 1 << 26), little(-1, 1);
  int zeros = 0;
  for (int i = 0; i < 200000; ++i) {
    const std::int64_t ax = step(random), ay = step(random), bx = step(random), by = step(random);
    const std::int64_t k = step(random) % 64;
    const std::int64_t cx = ax + (bx - ax) / 64 * k + little(random),
                       cy = ay + (by - ay) / 64 * k + little(random);
    const std::int64_t det = (ax - cx) * (by - cy) - (ay - cy) * (bx - cx);
    const int sign = det > 0 ? 1 : det < 0 ? -1 : 0;
    zeros += sign == 0 ? 1 : 0;
    const auto d = [](std::int64_t v) { return static_cast<double>(v); };
    ASSERT_EQ(turn(d(ax), d(ay), d(bx), d(by), d(cx), d(cy)), sign);
    ASSERT_EQ(exact_turn(d(ax), d(ay), d(bx), d(by), d(cx), d(cy)), sign);
  }
  EXPECT_GT(zeros, 0);
  // Differences that no double holds: a and b far away on either side, c near where their line
  // passes the origin, all in steps of 1/64.
  std::uniform_int_distribution<std::int64_t> far(-(std::int64_t{1} << 52), std::int64_t{1} << 52);
  std::uniform_int_distribution<std::int64_t> near(-2, 2);
  zeros = 0;
  for (int i = 0; i < 200000; ++i) {
    const std::int64_t ax = 64 * far(random), ay = 64 * far(random),
                       bx = -ax + 64 * near(random) * (i % 2),
                       by = -ay + 64 * near(random) * (i % 2);
    const std::int64_t cx = near(random), cy = near(random) * (i % 3);
    __extension__ using Wide = __int128;
    const auto wide = [](std::int64_t v) { return static_cast<Wide>(v); };
    const Wide det = (wide(ax) - cx) * (wide(by) - cy) - (wide(ay) - cy) * (wide(bx) - cx);
    const int sign = det > 0 ? 1 : det < 0 ? -1 : 0;
    zeros += sign == 0 ? 1 : 0;
    const auto d = [](std::int64_t v) { return static_cast<double>(v) / 64; };
    ASSERT_EQ(turn(d(ax), d(ay), d(bx), d(by), d(cx), d(cy)), sign);
  }
  EXPECT_GT(zeros, 0);
  // One last digit beside the diagonal, far beyond what rounded products tell.
  const double up = std::nextafter(0.5, 1);
  EXPECT_EQ(turn(0.5, 0.5, 12, 12, 24, 24), 0);
  EXPECT_EQ(turn(0.5, up, 12, 12, 24, 24), 1);
  EXPECT_EQ(turn(up, 0.5, 12, 12, 24, 24), -1);
}

TEST(Scanned, PointsAgreeWithMainForce) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    const TriangleMesh mesh = soup(300, seed);
    const ScannedSurface scan = scan_of(mesh);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-14, 14);
    int hits = 0;
    for (int i = 0; i < 3000; ++i) {
      const bool whole = i % 3 == 0;
      const double x = whole ? std::round(place(random)) : place(random),
                   y = whole ? std::round(place(random)) : place(random);
      BaseHit hit;
      const bool there = scan.at(x, y, hit);
      const Plain plain = plain_hit(mesh, x, y);
      ASSERT_EQ(there, plain.hit) << x << ' ' << y;
      if (!there) continue;
      ++hits;
      const double slack = 1e-13 * (1 + std::fabs(hit.zx) + std::fabs(hit.zy));
      ASSERT_NEAR(hit.z, static_cast<double>(plain.z), slack) << x << ' ' << y;
    }
    EXPECT_GT(hits, 1000);
  }
}

TEST(Scanned, NoPinholes) {
  const TriangleMesh mesh = shaken_relief(60, 11, 0.2);
  const ScannedSurface scan = scan_of(mesh);
  BaseHit hit;
  for (const Vec3& p : mesh.positions) {
    ASSERT_TRUE(scan.at(p.x(), p.y(), hit));
    ASSERT_NEAR(hit.z, p.z(), 1e-12 * (1 + std::fabs(hit.zx) + std::fabs(hit.zy)));
  }
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = mesh.positions[t[k]], &b = mesh.positions[t[(k + 1) % 3]];
      const double x = 0.5 * (a.x() + b.x()), y = 0.5 * (a.y() + b.y());
      ASSERT_TRUE(scan.at(x, y, hit)) << x << ' ' << y;
    }
  }
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> x(-7, 33), y(2, 42);
  for (int i = 0; i < 10'000'000; ++i) ASSERT_TRUE(scan.at(x(random), y(random), hit));
}

// Lines from `low` to `high`: even with a short last step, a lattice, uneven, or one alone.
std::vector<double> lines_of(int kind, double low, double high) {
  std::vector<double> lines;
  switch (kind) {
    case 0:
      lines = grid_lines(low, high, 0.173);
      break;
    case 1:
      lines = grid_lines(std::round(low), std::round(high), 0.25);
      break;
    case 2:
      for (double at = low; at < high; at += 0.02 + 0.1 * std::fabs(at)) lines.push_back(at);
      break;
    case 3:  // far finer than the triangles
      lines = grid_lines(0.25 * low, 0.25 * high, 0.011);
      break;
    default:
      lines = {0.5 * (low + high)};
      break;
  }
  return lines;
}

bool same(double a, double b) { return (std::isnan(a) && std::isnan(b)) || a == b; }

TEST(Scanned, RowsAndGridsHaveTheSameDigitsAsPoints) {
  for (const int base : {0, 1, 2}) {
    const ScannedSurface scan = scan_of(base == 0   ? shaken_relief(40, 3)
                                        : base == 1 ? shaken_relief(400, 5)
                                                    : soup(400, 9));
    for (const int kind : {0, 1, 2, 3, 4}) {
      const std::vector<double> xs = lines_of(kind, -14, 46), ys = lines_of(4 - kind, -14, 50);
      const std::size_t n = xs.size() * ys.size();
      std::vector<double> z(n), nx(n), ny(n), nz(n), row_z(xs.size()), zx(xs.size()), zy(xs.size());
      std::vector<std::uint32_t> face(n), row_face(xs.size());
      for (const int threads : {1, 3}) {
        std::fill(z.begin(), z.end(), 1e9);
        scan.grid(xs, ys, {z.data(), nx.data(), ny.data(), nz.data(), face.data()}, threads);
        for (std::size_t j = 0; j < ys.size(); ++j) {
          scan.row(ys[j], xs, row_z.data(), zx.data(), zy.data(), row_face.data());
          for (std::size_t i = 0; i < xs.size(); ++i) {
            const std::size_t k = j * xs.size() + i;
            ASSERT_TRUE(same(z[k], row_z[i])) << xs[i] << ' ' << ys[j];
            ASSERT_EQ(face[k], row_face[i]);
            if (j % 3 != 0) continue;
            BaseHit hit;
            if (!scan.at(xs[i], ys[j], hit)) {
              ASSERT_TRUE(std::isnan(z[k]));
              ASSERT_TRUE(face[k] == kNoFace && nz[k] == 0);
              continue;
            }
            ASSERT_EQ(z[k], hit.z);
            ASSERT_EQ(face[k], hit.face);
            ASSERT_EQ(zx[i], hit.zx);
            ASSERT_EQ(zy[i], hit.zy);
            ASSERT_EQ(scan.normal(hit.face, xs[i], ys[j]), Vec3(nx[k], ny[k], nz[k]));
          }
        }
      }
    }
  }
}

TEST(Scanned, GridsMeetEdgesAndVerticesOnTheirLines) {
  // Every line runs through vertices and along edges: nothing is left out, and shared points go to
  // the lowest number.
  const std::uint32_t n = 150;
  const TriangleMesh mesh = test::height_mesh(
      0, n - 1, n, 0, n - 1, n, [](double x, double y) { return std::sin(x) * std::cos(0.3 * y); });
  const ScannedSurface scan = scan_of(mesh);
  const std::vector<double> lines = grid_lines(0, n - 1, 0.5);
  const std::size_t count = lines.size() * lines.size();
  std::vector<double> z(count), nx(count), ny(count), nz(count);
  std::vector<std::uint32_t> face(count);
  scan.grid(lines, lines, {z.data(), nx.data(), ny.data(), nz.data(), face.data()}, 2);
  std::vector<std::uint32_t> lowest(mesh.positions.size(), kNoFace);
  for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
    for (const std::uint32_t v : mesh.triangles[f]) lowest[v] = std::min(lowest[v], f);
  }
  for (std::size_t k = 0; k < count; ++k) {
    ASSERT_FALSE(std::isnan(z[k])) << k;
    const std::size_t i = k % lines.size(), j = k / lines.size();
    if (i % 2 != 0 || j % 2 != 0) continue;
    const std::size_t v = j / 2 * n + i / 2;
    ASSERT_NEAR(z[k], mesh.positions[v].z(), 1e-13);
    // Heights of the triangles around a vertex may differ in the last digit, and the topmost wins.
    if (z[k] == mesh.positions[v].z()) {
      ASSERT_GE(face[k], lowest[v]);
    }
  }
}

TEST(Scanned, TopmostLayerOfAClosedBody) {
  // A box with an upright wall all round, closed: the lid counts, right up to the walls.
  TriangleMesh mesh;
  for (int k = 0; k < 8; ++k) {
    mesh.positions.emplace_back(k & 1 ? 4 : 0, k & 2 ? 3 : 0, k & 4 ? 2 : 0);
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  const ScannedSurface scan = scan_of(mesh);
  EXPECT_EQ(scan.upright(), 8U);
  for (const double x : {0.0, 1.0, 4.0}) {
    for (const double y : {0.0, 1.5, 3.0}) {
      BaseHit hit;
      ASSERT_TRUE(scan.at(x, y, hit));
      EXPECT_EQ(hit.z, 2);
      EXPECT_TRUE(hit.face == 2 || hit.face == 3);
    }
  }
  BaseHit hit;
  EXPECT_FALSE(scan.at(std::nextafter(4.0, 5.0), 1, hit));
}

// A vertex without a triangle and a wall that stands upright beyond the others are no part of it.
TEST(Scanned, ExtentIsThatOfTrianglesWithAnArea) {
  TriangleMesh mesh = shaken_relief(9, 4);
  const ScannedSurface plain = scan_of(mesh);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const double z : {-50.0, 50.0, 60.0}) mesh.positions.emplace_back(90, z, z);
  mesh.positions.emplace_back(200, 200, 200);
  mesh.triangles.push_back({first, first + 1, first + 2});
  const ScannedSurface scan = scan_of(mesh);
  EXPECT_EQ(scan.plan_box().x0, plain.plan_box().x0);
  EXPECT_EQ(scan.plan_box().x1, plain.plan_box().x1);
  EXPECT_EQ(scan.plan_box().y0, plain.plan_box().y0);
  EXPECT_EQ(scan.plan_box().y1, plain.plan_box().y1);
  EXPECT_EQ(scan.z_low(), plain.z_low());
  EXPECT_EQ(scan.z_high(), plain.z_high());
  EXPECT_EQ(scan.upright(), 1U);
}

// What points look into is made when the first asks, whichever thread it is.
TEST(Scanned, ThePlanGridIsMadeOnceForAllThreads) {
  const TriangleMesh mesh = shaken_relief(60, 6);
  const ScannedSurface first = scan_of(mesh), asked = scan_of(mesh);
  std::vector<std::uint32_t> faces(4000);
  parallel_blocks(faces.size(), 1, 4, [&](std::size_t i, std::size_t, int) {
    BaseHit hit;
    const double x = -7 + 40.0 * static_cast<double>(i % 63) / 62,
                 y = 2 + 40.0 * static_cast<double>(i / 63) / 63;
    faces[i] = asked.at(x, y, hit) ? hit.face : kNoFace;
  });
  for (std::size_t i = 0; i < faces.size(); ++i) {
    BaseHit hit;
    const double x = -7 + 40.0 * static_cast<double>(i % 63) / 62,
                 y = 2 + 40.0 * static_cast<double>(i / 63) / 63;
    ASSERT_EQ(first.at(x, y, hit) ? hit.face : kNoFace, faces[i]);
  }
}

TEST(Scanned, NeedlesKeepTheirHeights) {
  // Slivers along a slope: the height is the slope's, whatever the needle's own shape.
  std::mt19937 random(4);
  std::uniform_real_distribution<double> part(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const double thin = std::ldexp(part(random) + 0.5, -static_cast<int>(30 * part(random)) - 3);
    const double angle = 6.3 * part(random);
    const Vec2 along(std::cos(angle), std::sin(angle)), across(-along.y(), along.x());
    TriangleMesh mesh;
    const Vec2 places[3] = {Vec2(100, 50), Vec2(Vec2(100, 50) + 20 * along),
                            Vec2(Vec2(100, 50) + 9 * along + thin * across)};
    for (const Vec2& p : places)
      mesh.positions.emplace_back(p.x(), p.y(), 0.25 * p.x() - 0.5 * p.y());
    mesh.triangles = {{0, 1, 2}};
    const ScannedSurface scan = scan_of(mesh);
    const double u = part(random), v = part(random) * (1 - u);
    const Vec2 at = places[0] + u * (places[1] - places[0]) + v * (places[2] - places[0]);
    BaseHit hit;
    if (!scan.at(at.x(), at.y(), hit)) continue;
    // The vertices' own heights are rounded to 2^-47 at this distance; a needle tilts by that over
    // its width, but no further than its corners.
    ASSERT_NEAR(hit.z, 0.25 * at.x() - 0.5 * at.y(), 2e-13);
  }
}

TEST(Scanned, BoundsHoldWhateverIsThere) {
  const ScannedSurface scan = scan_of(shaken_relief(30, 8));
  std::mt19937 random(2);
  std::uniform_real_distribution<double> x(-9, 35), y(0, 44), size(0, 3), part(0, 1);
  int inside = 0, outside = 0, partly = 0;
  for (int i = 0; i < 3000; ++i) {
    PlanBox box{x(random), 0, y(random), 0};
    box.x1 = box.x0 + size(random) * part(random);
    box.y1 = box.y0 + size(random) * part(random);
    const BaseBounds b = scan.bounds(box);
    inside += b.coverage == Coverage::kInside ? 1 : 0;
    outside += b.coverage == Coverage::kOutside ? 1 : 0;
    partly += b.coverage == Coverage::kPartly ? 1 : 0;
    for (int k = 0; k < 20; ++k) {
      const double px = k == 0   ? box.x0
                        : k == 1 ? box.x1
                                 : box.x0 + part(random) * (box.x1 - box.x0);
      const double py = k == 0   ? box.y0
                        : k == 1 ? box.y1
                                 : box.y0 + part(random) * (box.y1 - box.y0);
      BaseHit hit;
      const bool there = scan.at(px, py, hit);
      ASSERT_FALSE(there && b.coverage == Coverage::kOutside);
      ASSERT_FALSE(!there && b.coverage == Coverage::kInside);
      if (!there) continue;
      ASSERT_TRUE(b.z.lo <= hit.z && hit.z <= b.z.hi);
      ASSERT_TRUE(b.zx.lo <= hit.zx && hit.zx <= b.zx.hi);
      ASSERT_TRUE(b.zy.lo <= hit.zy && hit.zy <= b.zy.hi);
    }
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(outside, 50);
  EXPECT_GT(partly, 50);
}

TEST(Scanned, PlacementInTheOrderOfItsSteps) {
  TriangleMesh mesh;
  mesh.positions = {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 1, 0)};
  mesh.triangles = {{0, 1, 2}};
  using Kind = MeshPlacement::Kind;
  MeshBase base;
  base.placement = {{Kind::kScale, Vec3(2, 0, 0)},
                    {Kind::kMove, Vec3(1, 0, 5)},
                    {Kind::kRotateZ, Vec3(90, 0, 0)},
                    {Kind::kRotateX, Vec3(180, 0, 0)}};
  const ScannedSurface scan = scan_of(mesh, base);
  // (2, 0, 0) -> (4, 0, 0) -> (5, 0, 5) -> (0, 5, 5) -> (0, -5, -5)
  EXPECT_EQ(scan.positions()[0], Vec3(0, -1, -5));
  EXPECT_EQ(scan.positions()[1], Vec3(0, -5, -5));
  EXPECT_EQ(scan.positions()[2], Vec3(-2, -1, -5));
  BaseHit hit;
  ASSERT_TRUE(scan.at(-0.5, -2, hit));
  EXPECT_EQ(hit.z, -5);
}

TEST(Scanned, SmoothNormalsAreThoseOfTheSphere) {
  const double r = 20;
  TriangleMesh mesh = test::height_mesh(-10, 10, 80, -10, 10, 80, [&](double x, double y) {
    return std::sqrt(r * r - x * x - y * y);
  });
  MeshBase base;
  base.smooth_normals = true;
  const ScannedSurface smooth = scan_of(mesh, base), flat = scan_of(mesh);
  double worst_smooth = 0, worst_flat = 0;
  for (double x = -9.03; x < 9; x += 0.31) {
    for (double y = -9.01; y < 9; y += 0.37) {
      BaseHit hit;
      ASSERT_TRUE(smooth.at(x, y, hit));
      const Vec3 truth = Vec3(x, y, hit.z).normalized();
      worst_smooth = std::fmax(worst_smooth, (smooth.normal(hit.face, x, y) - truth).norm());
      worst_flat = std::fmax(worst_flat, (flat.normal(hit.face, x, y) - truth).norm());
    }
  }
  EXPECT_LT(worst_smooth, 0.002);
  EXPECT_GT(worst_flat, 0.005);
  // A file that repeats the vertices for each facet is no less smooth.
  TriangleMesh apart;
  for (const auto& t : mesh.triangles) {
    const auto v = static_cast<std::uint32_t>(apart.positions.size());
    for (const std::uint32_t corner : t) apart.positions.push_back(mesh.positions[corner]);
    apart.triangles.push_back({v, v + 1, v + 2});
  }
  const ScannedSurface repeated = scan_of(apart, base);
  for (double x = -9.03; x < 9; x += 0.7) {
    BaseHit hit;
    ASSERT_TRUE(smooth.at(x, 1.3, hit));
    ASSERT_EQ(repeated.normal(hit.face, x, 1.3), smooth.normal(hit.face, x, 1.3));
  }
}

// A hilly sheet with its triangles in a disk left out, but for those in an inner one.
template <class Height>
TriangleMesh holed_sheet(double radius, double island, const Height& height) {
  TriangleMesh mesh = test::height_mesh(-10, 10, 81, -10, 10, 81, height);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    const Vec3 m = (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3;
    const double r = std::hypot(m.x() - 1.03, m.y() + 0.57);
    return r < radius && r > island;
  });
  return mesh;
}

TEST(Scanned, FillGoesOnWithWhatIsAround) {
  const double r = 20;
  const auto plane = [](double x, double y) { return 3 + 0.25 * x - 0.5 * y; };
  const auto sphere = [&](double x, double y) { return std::sqrt(r * r - x * x - y * y); };
  const auto saddle = [](double x, double y) { return 0.02 * x * x - 0.03 * y * y + 0.01 * x * y; };
  MeshBase base;
  base.fill_size = 6.5;
  const auto worst = [&](const ScannedSurface& scan, const auto& height) {
    double most = 0;
    for (double x = -9.9; x < 9.9; x += 0.093) {
      for (double y = -9.9; y < 9.9; y += 0.097) {
        BaseHit hit;
        EXPECT_TRUE(scan.at(x, y, hit));
        most = std::fmax(most, std::fabs(hit.z - height(x, y)));
      }
    }
    return most;
  };
  for (const double island : {0.0, 1.1}) {
    const TriangleMesh holed = holed_sheet(3, island, plane);
    const std::size_t given = holed.triangles.size();
    const ScannedSurface flat = scan_of(holed, base);
    EXPECT_EQ(flat.fill().holes, 1U);
    EXPECT_EQ(flat.triangles().size(), given + flat.fill().triangles);
    const double missing = (80 * 80 * 2 - static_cast<double>(given)) * 0.25 * 0.25 / 2;
    EXPECT_NEAR(flat.fill().area, missing, 1e-9);
    EXPECT_LT(worst(flat, plane), 1e-9);
    // A lid would lie 0.22 below the sphere's top.
    EXPECT_LT(worst(scan_of(holed_sheet(3, island, sphere), base), sphere), 0.006);
    EXPECT_LT(worst(scan_of(holed_sheet(3, island, saddle), base), saddle), 0.006);
  }
}

TEST(Scanned, FillLeavesLargerHolesAndTheOuterBorder) {
  const auto height = [](double x, double y) { return 0.1 * x * y; };
  const TriangleMesh mesh = holed_sheet(3, 0, height);
  MeshBase base;
  base.fill_size = 5.5;
  const ScannedSurface open = scan_of(mesh, base);
  EXPECT_EQ(open.fill().holes, 0U);
  EXPECT_EQ(open.triangles().size(), mesh.triangles.size());
  // The size is that of the placed scan.
  base.placement = {{MeshPlacement::Kind::kScale, Vec3(0.5, 0, 0)}};
  EXPECT_EQ(scan_of(mesh, base).fill().holes, 1U);
  // Facets that share no vertices, turned at random, are the same scan.
  TriangleMesh soup;
  std::mt19937 random(1);
  for (auto t : mesh.triangles) {
    if (random() % 2 == 0) std::swap(t[0], t[1]);
    const auto v = static_cast<std::uint32_t>(soup.positions.size());
    for (const std::uint32_t corner : t) soup.positions.push_back(mesh.positions[corner]);
    soup.triangles.push_back({v, v + 1, v + 2});
  }
  base.placement.clear();
  base.fill_size = 1000;
  const ScannedSurface closed = scan_of(soup, base);
  EXPECT_EQ(closed.fill().holes, 1U);
  const ScannedSurface shared = scan_of(mesh, base);
  EXPECT_EQ(closed.fill().triangles, shared.fill().triangles);
  BaseHit hit;
  EXPECT_FALSE(closed.at(10.01, 0, hit));
  // Two holes that touch in a vertex are two.
  TriangleMesh two = test::height_mesh(0, 6, 7, 0, 6, 7, height);
  std::erase_if(two.triangles, [&](const auto& t) {
    const Vec3 m = (two.positions[t[0]] + two.positions[t[1]] + two.positions[t[2]]) / 3;
    return (m.x() > 1 && m.x() < 2 && m.y() > 1 && m.y() < 2) ||
           (m.x() > 2 && m.x() < 4 && m.y() > 2 && m.y() < 4);
  });
  base.fill_size = 1.5;
  EXPECT_EQ(scan_of(two, base).fill().holes, 1U);
  base.fill_size = 3;
  EXPECT_EQ(scan_of(two, base).fill().holes, 2U);
}

TEST(Scanned, WhatCannotBeABaseIsRefused) {
  TriangleMesh mesh;
  EXPECT_FALSE(ScannedSurface::make(mesh, {}));
  mesh.positions = {Vec3(0, 0, 0), Vec3(1, 1, 0), Vec3(2, 2, 1)};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_FALSE(ScannedSurface::make(mesh, {}));
  mesh.positions[2] = Vec3(0, kNaN, 0);
  EXPECT_FALSE(ScannedSurface::make(mesh, {}));
  mesh.positions[2] = Vec3(0, 2e9, 0);
  EXPECT_FALSE(ScannedSurface::make(mesh, {}));
  mesh.positions[2] = Vec3(0, 2, 0);
  EXPECT_TRUE(ScannedSurface::make(mesh, {}));
}

TEST(Scanned, CompoundSurfaceOnAScan) {
  const char* const text =
      "SOLID-DEF\nS1,SPHER,1\nP1,10,20,0\nRAD,6\nBSURF-DEF\nMESH,scan.stl\nBOOLE-DEF\nB+S1\n";
  const PartProgram program = test::program_of(text, "scan");
  EXPECT_FALSE(CompoundSurface::make(program));
  const TriangleMesh mesh = shaken_relief(40, 6);
  Result<CompoundSurface> surface = CompoundSurface::make(program, mesh);
  ASSERT_TRUE(surface);
  // What the program leaves open is the plan of the scan.
  const Machining& m = surface->program().machining;
  EXPECT_EQ(m.x_range, (std::array<double, 2>{-7, 33}));
  EXPECT_EQ(m.y_range, (std::array<double, 2>{2, 42}));
  EXPECT_DOUBLE_EQ(m.x_interval, 0.4);
  const Result<GridArray> grid = evaluate_grid(*surface, 0);
  ASSERT_TRUE(grid);
  const ScannedSurface scan = scan_of(mesh);
  int of_base = 0;
  for (std::size_t k = 0; k < grid->size(); ++k) {
    const double x = grid->x()[k % grid->columns()], y = grid->y()[k / grid->columns()];
    const std::optional<CcDatum> row = grid->at(*surface, k), point = surface->at(x, y);
    ASSERT_TRUE(row && point);
    ASSERT_EQ(row->z, point->z);
    ASSERT_EQ(row->surface, point->surface);
    ASSERT_NEAR((row->n - point->n).norm(), 0, row->surface == 0 ? 0 : 1e-15);
    BaseHit hit;
    ASSERT_TRUE(scan.at(x, y, hit));
    const double rest = 36 - (x - 10) * (x - 10) - (y - 20) * (y - 20);
    const double ball = rest >= 0 ? std::sqrt(rest) : -1e9;
    ASSERT_NEAR(row->z, std::fmax(hit.z, ball), 1e-6);
    of_base += row->surface == 0 ? 1 : 0;
  }
  EXPECT_GT(of_base, 1000);
  EXPECT_LT(of_base, static_cast<int>(grid->size()) - 100);
}

TEST(Scanned, GridsOfACompoundSurfaceHaveTheDigitsOfItsPoints) {
  // Drawn as a whole, and row by row where few of the triangles are met; with the scan first,
  // later, in a group or not at all, with smooth normals.
  for (const char* const expression : {"B+S1-S2", "S1+B-S2", "S2+(B-S1)", "S1+S2"}) {
    for (const char* const smooth : {"", "NORMALS,SMOOTH\n"}) {
      const std::string text =
          std::string(
              "SOLID-DEF\nS1,SPHER,1\nP1,10,20,0\nRAD,6\nS2,SPHER,1\nP1,16,24,3\nRAD,5\n"
              "BSURF-DEF\nMESH,scan.stl\n") +
          smooth + "BOOLE-DEF\n" + expression + "\n";
      const Result<CompoundSurface> surface =
          CompoundSurface::make(test::program_of(text, "scan"), shaken_relief(80, 6));
      ASSERT_TRUE(surface);
      for (const double interval : {0.37, 9.0}) {
        Result<GridArray> grid =
            evaluate_grid(*surface, grid_lines(-9, 35, interval), grid_lines(0, 43, interval), 2);
        ASSERT_TRUE(grid);
        std::size_t there = 0;
        for (std::size_t k = 0; k < grid->size(); ++k) {
          const std::optional<CcDatum> a = grid->at(*surface, k),
                                       b = surface->at(grid->x()[k % grid->columns()],
                                                       grid->y()[k / grid->columns()]);
          ASSERT_EQ(a.has_value(), b.has_value()) << expression << ' ' << k;
          if (!a) {
            ASSERT_EQ(grid->row(0).nz[k], 0);
            continue;
          }
          ++there;
          ASSERT_EQ(a->z, b->z);
          ASSERT_EQ(a->row, b->row);
          ASSERT_NEAR((a->n - b->n).norm(), 0, a->surface == 0 ? 0 : 1e-15);
        }
        if (interval < 1) {
          EXPECT_GT(there, 500U);
        }
      }
    }
  }
}

}  // namespace
}  // namespace diesink
