// The scanned base: vertical lines against triangles, by main force and by exact arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include "core/base/scanned.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "core/compound/compound_surface.h"
#include "core/grid/grid_array.h"
#include "core/parallel.h"
#include "tests/support/height_mesh.h"
#include "tests/support/load_part.h"
#include "tests/support/scans.h"

namespace diesink {
namespace {

using test::scan_of;
using test::shaken_relief;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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

// Cells with many layers are looked through from the top: the same answers, and of equal heights
// the lowest number.
TEST(Scanned, ManyLayersOfWhichSomeAreOneTwice) {
  std::mt19937 random(41);
  std::vector<int> height;
  for (int k = 0; k < 60; ++k) height.push_back(k / 2);
  std::shuffle(height.begin(), height.end(), random);
  TriangleMesh mesh;
  std::uniform_real_distribution<double> lean(-0.8, 0.8), place(-1, 11);
  std::vector<std::array<double, 2>> leans;
  for (int k = 0; k < 30; ++k) leans.push_back({lean(random) / 5, lean(random) / 5});
  for (const int h : height) {
    const auto v = static_cast<std::uint32_t>(mesh.positions.size());
    const auto [zx, zy] = leans[static_cast<std::size_t>(h)];
    for (const auto& [x, y] : {std::pair{0, 0}, {10, 0}, {10, 10}, {0, 10}})
      mesh.positions.emplace_back(x, y, h + zx * x + zy * y);
    mesh.triangles.push_back({v, v + 1, v + 2});
    mesh.triangles.push_back({v, v + 2, v + 3});
  }
  const ScannedSurface surface = scan_of(mesh);
  for (int k = 0; k < 3000; ++k) {
    const double x = k < 30 ? k % 6 * 2.0 : place(random), y = k < 30 ? k % 5 * 2.0 : place(random);
    BaseHit best, hit;
    bool any = false;
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
      const auto& t = mesh.triangles[f];
      ScannedTriangle one;
      if (!one.set(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]])) continue;
      if (!one.covers(x, y)) continue;
      const double z = one.height(one.along_row(y), x);
      if (!any || z > best.z) best = {z, one.zx, one.zy, f};
      any = true;
    }
    ASSERT_EQ(surface.at(x, y, hit), any);
    std::uint32_t face = kNoFace;
    double z = 0, zx = 0, zy = 0;
    surface.row(y, std::span(&x, 1), &z, &zx, &zy, &face);
    if (!any) {
      EXPECT_FALSE(surface.is_above(x, y, -1e3));
      EXPECT_EQ(face, kNoFace);
      continue;
    }
    EXPECT_EQ(hit.z, best.z);
    EXPECT_EQ(hit.face, best.face);
    EXPECT_EQ(z, best.z);
    EXPECT_EQ(face, best.face);
    EXPECT_TRUE(surface.is_above(x, y, std::nextafter(best.z, -1e9)));
    EXPECT_FALSE(surface.is_above(x, y, best.z));
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
    ScannedSurface::Band band;
    const BaseBounds b = scan.bounds(box, band);
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

}  // namespace
}  // namespace diesink
