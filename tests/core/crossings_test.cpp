// Triangles that cross one another, against separating planes in whole numbers.
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh_tools/crossings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "core/mesh_tools/exact_space.h"
#include "tests/support/random_mesh.h"

namespace diesink {
namespace {

using testing::append;
using testing::box_mesh;
using testing::torus_mesh;

using Whole = std::array<std::int64_t, 3>;

Whole operator-(const Whole& a, const Whole& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Whole cross(const Whole& a, const Whole& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::int64_t dot(const Whole& a, const Whole& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 as_vec(const Whole& p) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

// Whether two convex hulls of up to three points are apart: then one of these planes parts them.
bool are_apart(const std::vector<Whole>& s, const std::vector<Whole>& t) {
  std::vector<Whole> edges, axes;
  for (const auto* points : {&s, &t}) {
    for (std::size_t i = 0; i < points->size(); ++i) {
      for (std::size_t j = i + 1; j < points->size(); ++j)
        edges.push_back((*points)[j] - (*points)[i]);
    }
  }
  for (const Whole& e : edges) {
    for (const Whole& f : edges) axes.push_back(cross(e, f));
  }
  const std::size_t planes = axes.size();
  for (std::size_t i = 0; i < planes; ++i) {
    for (const Whole& e : edges) axes.push_back(cross(axes[i], e));
  }
  const auto parts = [&](const Whole& axis) {
    std::int64_t most = INT64_MIN, least = INT64_MAX;
    for (const Whole& p : s) most = std::max(most, dot(axis, p));
    for (const Whole& p : t) least = std::min(least, dot(axis, p));
    return most < least;
  };
  return std::any_of(axes.begin(), axes.end(), [&](const Whole& axis) {
    return parts(axis) || parts({-axis[0], -axis[1], -axis[2]});
  });
}

bool has_area(const std::vector<Whole>& t) {
  return cross(t[1] - t[0], t[2] - t[0]) != Whole{0, 0, 0};
}

bool cross_in_whole_numbers(const std::vector<Whole>& s, const std::vector<Whole>& t) {
  std::vector<Whole> common, of_s, of_t;
  for (const Whole& p : s) {
    const bool both = std::find(t.begin(), t.end(), p) != t.end();
    (both ? common : of_s).push_back(p);
  }
  for (const Whole& p : t) {
    if (std::find(s.begin(), s.end(), p) == s.end()) of_t.push_back(p);
  }
  if (common.size() == 3) return false;
  if (common.empty()) return !are_apart(s, t);
  if (common.size() == 1) return !are_apart(of_s, t) || !are_apart(s, of_t);
  const Whole edge = common[1] - common[0];
  const Whole n = cross(edge, of_s[0] - common[0]), m = cross(edge, of_t[0] - common[0]);
  return cross(n, m) == Whole{0, 0, 0} && dot(n, m) > 0;
}

// Where touches, common vertices and planes are many; also sheared and far from the origin.
TEST(Crossings, OfPairsAreThoseInWholeNumbers) {
  std::mt19937_64 random(1);
  std::size_t crossing = 0, all = 0;
  for (int round = 0; round < 40000; ++round) {
    const std::int64_t size = 2 + round % 4;
    std::vector<Whole> s(3), t(3);
    for (auto* triangle : {&s, &t}) {
      for (Whole& p : *triangle) {
        for (std::int64_t& x : p)
          x = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(size));
        if (round % 3 == 0) p[2] = p[0] + p[1];  // in one plane
      }
    }
    if (!has_area(s) || !has_area(t)) continue;
    TriangleMesh mesh;
    for (const auto* triangle : {&s, &t}) {
      for (const Whole& p : *triangle) mesh.positions.push_back(as_vec(p));
    }
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    const bool expected = cross_in_whole_numbers(s, t);
    ASSERT_EQ(find_crossings(mesh, 1).pairs, expected ? 1U : 0U) << round;
    // A shear by large whole numbers changes nothing, and leaves the filters little.
    for (Vec3& p : mesh.positions) {
      p = Vec3(p.x() + 94906267.0 * p.y(), p.y() + 1e9 * p.z(), p.z()) + Vec3::Constant(1e15);
    }
    ASSERT_EQ(find_crossings(mesh, 1).pairs, expected ? 1U : 0U) << round;
    crossing += expected ? 1 : 0;
    ++all;
  }
  EXPECT_GT(crossing, all / 5);
  EXPECT_LT(crossing, all * 4 / 5);
}

TEST(Crossings, OfClosedBodiesAreNone) {
  EXPECT_EQ(find_crossings(box_mesh(Vec3(0, 0, 0), Vec3(1, 2, 3))).pairs, 0U);
  EXPECT_EQ(find_crossings(torus_mesh(60, 40)).pairs, 0U);
  EXPECT_EQ(find_crossings(TriangleMesh{}).pairs, 0U);
}

TEST(Crossings, OfTwoBodiesAreCountedAlikeByAnyNumberOfThreads) {
  TriangleMesh mesh = torus_mesh(60, 40);
  const std::size_t before = mesh.triangles.size();
  append(mesh, box_mesh(Vec3(0, -0.31, -0.27), Vec3(50, 0.3, 0.26)));
  const MeshCrossings one = find_crossings(mesh, 1);
  EXPECT_GT(one.pairs, 10U);
  EXPECT_GT(one.triangles, 10U);
  EXPECT_LT(one.first[0], before);
  EXPECT_GE(one.first[1], before);
  // The place lies in both triangles' boxes.
  for (const std::uint32_t t : one.first) {
    const auto& corners = mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const auto of = [&](std::size_t i) { return mesh.positions[corners[i]][k]; };
      EXPECT_GE(one.at[k], std::min({of(0), of(1), of(2)}) - 1e-9);
      EXPECT_LE(one.at[k], std::max({of(0), of(1), of(2)}) + 1e-9);
    }
  }
  for (const int threads : {2, 5}) {
    const MeshCrossings many = find_crossings(mesh, threads);
    EXPECT_EQ(many.pairs, one.pairs);
    EXPECT_EQ(many.triangles, one.triangles);
    EXPECT_EQ(many.first, one.first);
    EXPECT_EQ(many.at, one.at);
  }
}

TEST(ExactSide, IsTheSignOfTheDeterminantWhereDoublesRound) {
  const Vec3 p(0, 0, 0), q(1, 0, 1), r(0, 1, 1), on(0.1, 0.2, 0.1 + 0.2);
  // 0.1 + 0.2 is a little more than the sum of the two as they are held, 0.3 a little less.
  EXPECT_EQ(side(p, q, r, on), -side(p, q, r, Vec3(0.1, 0.2, 0.3)));
  EXPECT_NE(side(p, q, r, on), 0);
  EXPECT_EQ(side(p, q, r, Vec3(0.25, 0.5, 0.75)), 0);
}

// Coordinates so far apart that differences round; the determinant in whole numbers of 128 bits.
TEST(ExactSide, IsTheSignInWholeNumbers) {
  std::mt19937_64 random(3);
  const auto any = [&random](int bits) {
    const auto x = static_cast<std::int64_t>(random() >> (64 - bits));
    return random() % 2 == 0 ? x : -x;
  };
  for (int round = 0; round < 5000; ++round) {
    std::array<Whole, 4> p;
    for (Whole& each : p) {
      each = {round % 2 == 0 && random() % 2 == 0 ? any(12) * (std::int64_t{1} << 45) : any(4),
              any(round % 3 == 0 ? 2 : 30), any(round % 3 == 0 ? 2 : 30)};
    }
    const Whole a = p[0] - p[3], b = p[1] - p[3], c = p[2] - p[3];
    __extension__ typedef __int128 Wide;
    const Wide det = Wide{a[0]} * (Wide{b[1]} * c[2] - Wide{b[2]} * c[1]) +
                     Wide{a[1]} * (Wide{b[2]} * c[0] - Wide{b[0]} * c[2]) +
                     Wide{a[2]} * (Wide{b[0]} * c[1] - Wide{b[1]} * c[0]);
    const int expected = det > 0 ? 1 : det < 0 ? -1 : 0;
    const std::array<Vec3, 4> q{as_vec(p[0]), as_vec(p[1]), as_vec(p[2]), as_vec(p[3])};
    ASSERT_EQ(exact_side(q[0], q[1], q[2], q[3]), expected) << round;
    ASSERT_EQ(side(q[0], q[1], q[2], q[3]), expected) << round;
  }
}

}  // namespace
}  // namespace diesink
