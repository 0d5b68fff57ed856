// The compound surface at points, against an evaluator by main force that shares no code with it.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "core/compound/compound_impl.h"
#include "core/compound/compound_surface.h"
#include "core/tessellate/implicit.h"
#include "tests/support/brute_force.h"
#include "tests/support/load_part.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

struct Counts {
  int points = 0, holes = 0, labels = 0, unsure = 0;
};

void compare_at(const CompoundSurface& surface, const test::BruteForce& brute, double x, double y,
                Counts& counts) {
  SCOPED_TRACE("x " + std::to_string(x) + " y " + std::to_string(y));
  const test::BruteForce::Answer expected = brute.at(x, y);
  const std::optional<CcDatum> datum = surface.at(x, y);
  if (!expected.sure) {
    ++counts.unsure;
    return;
  }
  ASSERT_EQ(datum.has_value(), expected.value.defined);
  if (!datum) {
    ++counts.holes;
    return;
  }
  ++counts.points;
  // Beside a silhouette a height is known as well as its plan point is: the slope takes its part.
  const double slope = std::hypot(datum->n.x(), datum->n.y()) / std::max(datum->n.z(), 1e-9);
  const double bound = surface.size() * (1e-12 + 1e-15 * slope);
  EXPECT_NEAR(static_cast<double>(datum->z - expected.value.z), 0, bound)
      << "row " << datum->row << " slope " << slope;
  EXPECT_NEAR(datum->n.norm(), 1, 1e-14);
  EXPECT_GE(datum->n.z(), 0);
  if (expected.margin > 1e-9 * surface.size() && expected.value.sure_face) {
    ++counts.labels;
    EXPECT_EQ(datum->row, expected.value.row);
    EXPECT_EQ(datum->face, expected.value.face);
    EXPECT_EQ(datum->surface, surface.surface_of_row(datum->row));
  }
}

// The normal against differences of neighbouring heights on the same face.
void compare_normal(const CompoundSurface& surface, double x, double y, int& compared) {
  const double h = 1e-5 * surface.size();
  const std::optional<CcDatum> d[] = {surface.at(x, y), surface.at(x - h, y), surface.at(x + h, y),
                                      surface.at(x, y - h), surface.at(x, y + h)};
  for (const std::optional<CcDatum>& one : d) {
    if (!one || one->row != d[0]->row || one->face != d[0]->face) return;
  }
  if (d[0]->n.z() < 0.2) return;
  ++compared;
  const Vec3 n =
      Vec3(-(d[2]->z - d[1]->z) / (2 * h), -(d[4]->z - d[3]->z) / (2 * h), 1).normalized();
  EXPECT_LT((n - d[0]->n).norm(), 2e-4)
      << "x " << x << " y " << y << " row " << d[0]->row << " face " << d[0]->face;
}

void compare(const CompoundSurface& surface, int points, std::uint64_t seed, Counts& counts,
             int& normals) {
  const test::BruteForce brute(surface.program());
  const Machining& m = surface.program().machining;
  test::Random random(seed);
  for (int k = 0; k < points; ++k) {
    const double x = random.uniform(m.x_range[0], m.x_range[1]),
                 y = random.uniform(m.y_range[0], m.y_range[1]);
    compare_at(surface, brute, x, y, counts);
    compare_normal(surface, x, y, normals);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(Evaluate, Fig6) {
  Counts counts;
  int normals = 0;
  compare(test::fixture("fig6"), 6000, 1, counts, normals);
  EXPECT_GT(counts.labels, 5900);
  EXPECT_GT(normals, 5500);
}

TEST(Evaluate, EveryPrimitive) {
  Counts counts;
  int normals = 0;
  compare(test::fixture("allprims"), 8000, 2, counts, normals);
  EXPECT_GT(counts.labels, 7900);
  EXPECT_GT(normals, 7000);
}

TEST(Evaluate, RandomPrograms) {
  Counts counts;
  int normals = 0;
  for (std::uint64_t seed = 0; seed < 240; ++seed) {
    test::RandomProgramOptions options;
    options.solids = 2 + static_cast<int>(seed % 14);
    const std::string text = test::random_part_program(seed, options);
    compare(test::surface_of(text), 60, seed, counts, normals);
    ASSERT_FALSE(HasFailure()) << text;
  }
  EXPECT_GT(counts.points, 9000);
  EXPECT_GT(counts.holes, 500);
  EXPECT_GT(counts.labels, 9000);
  EXPECT_LT(counts.unsure, 300);
}

// A cone one of whose rulings is upright: its plan ends in a line through the apex, which only the
// apex lies on. Beyond it the mirrored nappe has the same equation.
TEST(Evaluate, ConesWithAnUprightRuling) {
  Counts counts;
  int normals = 0;
  for (int k = 0; k < 16; ++k) {
    const double turn = std::numbers::pi * k / 8, c = std::cos(turn), s = std::sin(turn);
    const Vec2 apex(20 + 10 * c, 20 + 10 * s);
    for (const bool up : {true, false}) {
      std::ostringstream text;
      text.precision(17);
      text << "SOLID-DEF\nK,R-CONE,1\nP1,20,20," << (up ? -5 : 5) << "\nP2," << apex.x() << ','
           << apex.y() << ',' << (up ? 5 : -5) << "\nRAD,14.142135623730951\nBSURF-DEF\nPLANE,"
           << (up ? -30 : 30) << "\nBOOLE-DEF\nB" << (up ? '+' : '-')
           << "K\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\n";
      const CompoundSurface surface = test::surface_of(text.str());
      compare(surface, 200, static_cast<std::uint64_t>(k), counts, normals);
      const test::BruteForce brute(surface.program());
      for (int i = -12; i <= 12; ++i) {
        for (const double beyond : {0.0, 1e-6, 0.3}) {
          if (i == 0) continue;
          compare_at(surface, brute, apex.x() + beyond * c - i * s, apex.y() + beyond * s + i * c,
                     counts);
        }
      }
      ASSERT_FALSE(HasFailure()) << text.str();
    }
  }
  EXPECT_GT(counts.labels, 7800);
  EXPECT_LT(counts.unsure, 300);
}

// A line that misses a body by more than a tie misses it, however long the body or flat: a bar's
// wall and the silhouette beside it would otherwise trade places from one cell to the next.
TEST(Evaluate, MissesByMoreThanATieMiss) {
  int lines = 0;
  for (int k = 0; k < 12; ++k) {
    const double turn = 0.1 + k * 0.26, c = std::cos(turn), s = std::sin(turn);
    std::ostringstream text;
    text.precision(17);
    text << "SOLID-DEF\nK,R-CYLI,1\nP1," << 100 - 80 * c << ',' << 100 - 80 * s << ",5\nP2,"
         << 100 + 80 * c << ',' << 100 + 80 * s << ",5\nRAD,2\n"
         << "E,ELLIP,1\nP1,100,100,20\nV1," << -s << ',' << c << ",0\nV2,0,0,1\nA,60\nB,1\nC,3\n"
         << "BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+K+E\nMACHI-DEF\nX-RNG,0,200\nY-RNG,0,200\n";
    const CompoundSurface surface = test::surface_of(text.str());
    const int base = surface.at(1, 1)->row;
    const auto row = [&](double along, double across) {
      return surface.at(100 + along * c - across * s, 100 + along * s + across * c)->row;
    };
    const double tie = surface.tie_tolerance();
    const int flat = row(0, 0);
    for (const double side : {-1.0, 1.0}) {
      EXPECT_EQ(row(0, side * (1 - 2 * tie)), flat);
      EXPECT_NE(row(0, side * (1 + 2 * tie)), flat);
    }
    for (int i = -7; i <= 7; ++i) {
      if (i == 0) continue;
      for (const double side : {-1.0, 1.0}) {
        EXPECT_NE(row(10 * i, side * (2 - 2 * tie)), base);
        EXPECT_EQ(row(10 * i, side * (2 + 2 * tie)), base);
        ++lines;
      }
    }
  }
  EXPECT_EQ(lines, 12 * 14 * 2);
}

// A base of six decimals is a plane to these: the planes of its faces meet a hair beyond its
// corners, and heights between go on along them.
TEST(Evaluate, HeightsBesideALowestEdgeAreOnTheFace) {
  const CompoundSurface surface = test::surface_of(
      "SOLID-DEF\nA,4-PRIS,2\nP1,51.645449,54.103524,-7.817577\n"
      "P2,81.386461,66.815244,-7.817577\nP3,78.228093,74.204727,-6.547126\n"
      "P4,48.487082,61.493007,-6.547126\nHEI,7.904081\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB-A\n"
      "MACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n");
  const CompoundSurface::Impl& impl = surface.impl();
  int lowest = 0;
  for (int i = 1; i < 200; ++i) {
    const double t = i / 200.0;
    for (const double beside : {-1e-7, -1e-8, 0.0, 1e-8, 1e-7}) {
      const LineState state = impl.evaluate_face(51.645449 + t * 29.741012 + 0.393 * beside,
                                                 54.103524 + t * 12.71172 - 0.919 * beside);
      ASSERT_NE(state.label, kNoLabel);
      if (state.z > -7.8) continue;
      ++lowest;
      const Vec3 p(51.645449 + t * 29.741012 + 0.393 * beside,
                   54.103524 + t * 12.71172 - 0.919 * beside, state.z);
      EXPECT_LE(std::fabs(face_implicit(impl, state.label).value(p)), 1e-12) << i << ' ' << beside;
    }
  }
  EXPECT_GT(lowest, 500);
}

}  // namespace
}  // namespace diesink
