// Rows against points: the same labels, the same digits of z.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/compound/compound_surface.h"
#include "tests/support/load_part.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

struct RowValues {
  std::vector<double> z, nx, ny, nz;
  std::vector<Label> label;
};

RowValues row_of_surface(const CompoundSurface& surface, double y, const std::vector<double>& xs) {
  const std::size_t n = xs.size();
  RowValues v{std::vector<double>(n, 7), std::vector<double>(n, 7), std::vector<double>(n, 7),
              std::vector<double>(n, 7), std::vector<Label>(n, 7)};
  surface.row(y, xs, {v.z.data(), v.nx.data(), v.ny.data(), v.nz.data(), v.label.data()});
  return v;
}

// Counts the points with a surface.
std::size_t expect_points(const CompoundSurface& surface, double y, const std::vector<double>& xs) {
  const RowValues row = row_of_surface(surface, y, xs);
  std::size_t found = 0;
  for (std::size_t i = 0; i < xs.size(); ++i) {
    SCOPED_TRACE("x " + std::to_string(xs[i]) + " y " + std::to_string(y));
    const std::optional<CcDatum> datum = surface.at(xs[i], y);
    if (!datum) {
      EXPECT_EQ(row.label[i], kNoLabel);
      EXPECT_TRUE(std::isnan(row.z[i]));
      EXPECT_EQ(row.nz[i], 0);
      continue;
    }
    ++found;
    EXPECT_EQ(row.label[i], make_label(datum->row, static_cast<std::uint32_t>(datum->face)))
        << surface.element_name(row.label[i]);
    EXPECT_EQ(row.z[i], datum->z);
    EXPECT_NEAR(row.nx[i], datum->n.x(), 1e-12);
    EXPECT_NEAR(row.ny[i], datum->n.y(), 1e-12);
    EXPECT_NEAR(row.nz[i], datum->n.z(), 1e-12);
  }
  return found;
}

std::vector<double> lines(double lo, double hi, int count) {
  std::vector<double> xs;
  for (int i = 0; i < count; ++i) xs.push_back(lo + (hi - lo) * i / (count - 1));
  return xs;
}

std::size_t compare(const CompoundSurface& surface, int columns, int rows) {
  const Machining& m = surface.program().machining;
  const double dx = 0.01 * (m.x_range[1] - m.x_range[0]), dy = 0.01 * (m.y_range[1] - m.y_range[0]);
  std::size_t found = 0;
  // A little over the domain, then the domain exactly.
  for (const double over : {1.0, 0.0}) {
    const std::vector<double> xs =
        lines(m.x_range[0] - over * dx, m.x_range[1] + over * dx, columns);
    for (const double y : lines(m.y_range[0] - over * dy, m.y_range[1] + over * dy, rows)) {
      found += expect_points(surface, y, xs);
      if (testing::Test::HasFailure()) return found;
    }
  }
  return found;
}

TEST(Row, IsThePointsOfFig6) { EXPECT_GT(compare(test::fixture("fig6"), 241, 241), 100000u); }

TEST(Row, IsThePointsOfEveryPrimitive) {
  EXPECT_GT(compare(test::fixture("allprims"), 301, 157), 90000u);
}

TEST(Row, IsThePointsOfRandomPrograms) {
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    test::RandomProgramOptions options;
    options.solids = 3 + static_cast<int>(seed % 20);
    const std::string text = test::random_part_program(seed, options);
    compare(test::surface_of(text), 67, 31);
    ASSERT_FALSE(HasFailure()) << text;
  }
}

// Upright rulings of cones, and the lines through their apexes, on columns and between.
TEST(Row, IsThePointsOfConesWithAnUprightRuling) {
  const std::string radius = "\nRAD,14.142135623730951\n";
  const auto cone = [&](const char* name, const char* p1, const char* p2) {
    return std::string(name) + ",R-CONE,1\nP1," + p1 + "\nP2," + p2 + radius;
  };
  const std::string text =
      "SOLID-DEF\n" + cone("K", "15,20,-5", "25,20,5") + cone("L", "80,20,-5", "80,10,5") +
      cone("M", "20,70,20", "27.071067811865476,77.071067811865476,10") +
      cone("N", "80,80,20", "70,80,10") +
      "BSURF-DEF\nPLANE,15\nBOOLE-DEF\nB-M-N+K+L\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n";
  EXPECT_GT(compare(test::surface_of(text), 201, 201), 80000u);
}

// So many solids that a row looks up which of them it can touch.
TEST(Row, IsThePointsOfManySolids) {
  test::RandomProgramOptions options;
  options.solids = 700;
  options.size = 400;
  options.base = test::RandomBase::kPlane;
  for (std::uint64_t seed = 1; seed < 4; ++seed) {
    EXPECT_GT(compare(test::surface_of(test::random_part_program(seed, options)), 203, 61), 10000u);
  }
}

TEST(Row, OfAnyLengthAndSpacing) {
  const CompoundSurface surface = test::fixture("fig6");
  test::Random random(4);
  for (int count = 1; count < 40; ++count) {
    std::vector<double> xs;
    for (int i = 0; i < count; ++i) xs.push_back(random.uniform(-2, 42));
    std::sort(xs.begin(), xs.end());
    if (count % 3 == 0) {  // bunched: nothing like evenly spaced
      for (double& x : xs) x = 20 + std::pow((x - 20) / 22, 7) * 22;
    }
    expect_points(surface, random.uniform(0, 40), xs);
  }
  expect_points(surface, 20, {});
  expect_points(surface, 20, {20, 20, 20});  // repeated lines
}

// Rows along walls, rims and the corners of solids, where many lines only just touch.
TEST(Row, AlongWallsAndRims) {
  const CompoundSurface surface = test::fixture("fig6");
  std::vector<double> xs = lines(0, 40, 401);
  for (const double x : {5.0, 8.0, 14.0, 15.0, 25.0, 26.0, 28.0, 32.0, 35.0}) {
    xs.push_back(std::nextafter(x, -1));
    xs.push_back(std::nextafter(x, 99));
  }
  std::sort(xs.begin(), xs.end());
  for (const double y : {2.0, 5.0, 8.0, 13.0, 14.0, 16.0, 20.0, 24.0, 26.0, 28.0, 32.0, 35.0}) {
    for (const double shifted : {std::nextafter(y, -1), y, std::nextafter(y, 99)})
      expect_points(surface, shifted, xs);
  }
}

TEST(Row, LeavesTheRestOfTheArraysAlone) {
  const CompoundSurface surface = test::fixture("fig6");
  for (std::size_t n = 1; n < 20; ++n) {
    const std::vector<double> xs = lines(17, 23, static_cast<int>(n) + 1);
    std::vector<double> z(n + 9, 7), nx(z), ny(z), nz(z);
    std::vector<Label> label(n + 9, 7);
    surface.row(20, std::span(xs).first(n),
                {z.data(), nx.data(), ny.data(), nz.data(), label.data()});
    for (std::size_t i = n; i < n + 9; ++i) {
      EXPECT_TRUE(z[i] == 7 && nx[i] == 7 && ny[i] == 7 && nz[i] == 7 && label[i] == 7);
    }
  }
}

}  // namespace
}  // namespace diesink
