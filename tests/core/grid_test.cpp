// The grid array and its edges.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/grid/edges.h"
#include "core/grid/grid_array.h"
#include "tests/support/load_part.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

TEST(GridLines, AlwaysEndAtTheRangesEnd) {
  EXPECT_EQ(grid_lines(0, 1, 0.25), (std::vector<double>{0, 0.25, 0.5, 0.75, 1}));
  EXPECT_EQ(grid_lines(1, 2, 0.4), (std::vector<double>{1, 1.4, 1.8, 2}));
  EXPECT_EQ(grid_lines(0, 1, 5), (std::vector<double>{0, 1}));
  const std::vector<double> fig6 = grid_lines(1, 39, 0.8);
  EXPECT_EQ(fig6.size(), 49u);
  EXPECT_EQ(fig6.back(), 39);
  EXPECT_NEAR(fig6.back() - fig6[47], 0.4, 1e-12);
  // 380 spacings of 0.1, whose sum is not 38 to the last digit: no sliver at the end.
  const std::vector<double> fine = grid_lines(1, 39, 0.1);
  EXPECT_EQ(fine.size(), 381u);
  for (std::size_t i = 1; i < fine.size(); ++i) EXPECT_GT(fine[i] - fine[i - 1], 0.0999);
}

TEST(Grid, HoldsThePoints) {
  const CompoundSurface surface = test::fixture("fig6");
  const Result<GridArray> grid = evaluate_grid(surface, 0);
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->columns(), 49u);
  EXPECT_EQ(grid->rows(), 49u);
  for (std::size_t k = 0; k < grid->size(); ++k) {
    const std::optional<CcDatum> a = grid->at(surface, k);
    const std::optional<CcDatum> b = surface.at(grid->x()[k % 49], grid->y()[k / 49]);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) continue;
    EXPECT_EQ(a->z, b->z);
    EXPECT_TRUE(a->surface == b->surface && a->row == b->row && a->face == b->face);
    EXPECT_LT((a->n - b->n).norm(), 1e-12);
  }
}

TEST(Grid, Takes36BytesAPoint) {
  EXPECT_EQ(sizeof(*CcRun{}.z) + sizeof(*CcRun{}.nx) + sizeof(*CcRun{}.ny) + sizeof(*CcRun{}.nz) +
                sizeof(*CcRun{}.label),
            36u);
}

TEST(Grid, RefusesWhatIsTooLarge) {
  const CompoundSurface surface = test::fixture("fig6");
  const std::vector<double> many = grid_lines(1, 39, 38.0 / 10000);
  const Result<GridArray> grid = evaluate_grid(surface, many, many, 1);
  ASSERT_FALSE(grid);
  EXPECT_EQ(grid.error().code, ErrorCode::kLimit);
}

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

TEST(Grid, GivesTheSameBytesForAnyNumberOfThreads) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const CompoundSurface surface =
        seed == 0 ? test::fixture("fig6") : test::surface_of(test::random_part_program(seed));
    const Machining& m = surface.program().machining;
    const std::vector<double> x =
        grid_lines(m.x_range[0], m.x_range[1], (m.x_range[1] - m.x_range[0]) / 333.3);
    const std::vector<double> y =
        grid_lines(m.y_range[0], m.y_range[1], (m.y_range[1] - m.y_range[0]) / 277.7);
    const Result<GridArray> one = evaluate_grid(surface, x, y, 1);
    const std::vector<EdgePair> edges = find_edges(surface, *one, 1);
    for (const int threads : {2, 7}) {
      const Result<GridArray> more = evaluate_grid(surface, x, y, threads);
      EXPECT_TRUE(same_bytes(one->z(), more->z()) && same_bytes(one->nx(), more->nx()) &&
                  same_bytes(one->ny(), more->ny()) && same_bytes(one->nz(), more->nz()) &&
                  same_bytes(one->label(), more->label()));
      const std::vector<EdgePair> again = find_edges(surface, *more, threads);
      ASSERT_EQ(edges.size(), again.size());
      for (std::size_t k = 0; k < edges.size(); ++k) {
        EXPECT_TRUE(edges[k].first.x == again[k].first.x && edges[k].first.y == again[k].first.y &&
                    edges[k].second.x == again[k].second.x && edges[k].kind == again[k].kind);
      }
    }
  }
}

// The promises of edges.h, for any surface: every change of label is bridged by a chain of pairs,
// each between neighbouring doubles.
void check_edges(const CompoundSurface& surface, const GridArray& grid,
                 const std::vector<EdgePair>& edges) {
  std::size_t next = 0;
  for (const bool along_x : {true, false}) {
    for (std::size_t j = 0; j < grid.rows(); ++j) {
      for (std::size_t i = 0; i < grid.columns(); ++i) {
        if (along_x ? i + 1 == grid.columns() : j + 1 == grid.rows()) continue;
        const std::size_t at = j * grid.columns() + i, to = along_x ? at + 1 : at + grid.columns();
        Label now = grid.label()[at];
        const Label last = grid.label()[to];
        if (now == last) continue;
        double from = along_x ? grid.x()[i] : grid.y()[j];
        const double end = along_x ? grid.x()[i + 1] : grid.y()[j + 1];
        for (; now != last || (next < edges.size() && edges[next].i == i && edges[next].j == j &&
                               edges[next].along_x == along_x);
             ++next) {
          ASSERT_LT(next, edges.size());
          const EdgePair& e = edges[next];
          ASSERT_TRUE(e.along_x == along_x && e.i == i && e.j == j);
          EXPECT_EQ(e.first.label, now);
          EXPECT_NE(e.second.label, now);
          now = e.second.label;
          const double a = along_x ? e.first.x : e.first.y, b = along_x ? e.second.x : e.second.y;
          EXPECT_EQ(along_x ? e.first.y : e.first.x, along_x ? grid.y()[j] : grid.x()[i]);
          EXPECT_EQ(std::nextafter(a, HUGE_VAL), b);
          EXPECT_GE(a, from);
          EXPECT_LE(b, end);
          from = b;
          EXPECT_EQ(e.kind == EdgeKind::kEdge, !e.first.datum || !e.second.datum);
          EXPECT_EQ(e.first.datum.has_value(), surface.at(e.first.x, e.first.y).has_value());
        }
      }
    }
  }
  EXPECT_EQ(next, edges.size());
}

TEST(Edges, BridgeEveryChangeOfLabel) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const CompoundSurface surface = test::surface_of(test::random_part_program(seed));
    const Result<GridArray> grid = evaluate_grid(surface, 2);
    check_edges(surface, *grid, find_edges(surface, *grid, 2));
    ASSERT_FALSE(HasFailure()) << "seed " << seed;
  }
}

// fig6: the rim of the upright cylinder S2 (radius 15 about 20, 20, top at 5) over the base, whose
// height is below 4.
TEST(Edges, LieOnTheRimsOfFig6) {
  const CompoundSurface surface = test::fixture("fig6");
  const Result<GridArray> grid = evaluate_grid(surface, 2);
  const std::vector<EdgePair> edges = find_edges(surface, *grid, 2);
  check_edges(surface, *grid, edges);
  int rims = 0, creases = 0;
  for (const EdgePair& e : edges) {
    const std::string a = surface.element_name(e.first.label),
                      b = surface.element_name(e.second.label);
    if ((a == "B" && b == "S2.top") || (a == "S2.top" && b == "B")) {
      ++rims;
      EXPECT_NEAR(std::hypot(e.first.x - 20, e.first.y - 20), 15, 1e-10);
      EXPECT_EQ(e.kind, EdgeKind::kJump);
    }
    // The sphere S3 (radius 12 about the origin of the cylinder's axis) rises out of the top.
    if ((a == "S3.surface" && b == "S2.top") || (a == "S2.top" && b == "S3.surface")) {
      ++creases;
      EXPECT_NEAR(std::hypot(e.first.x - 20, e.first.y - 20), std::sqrt(144.0 - 25), 1e-10);
      EXPECT_EQ(e.kind, EdgeKind::kCrease);
      EXPECT_NEAR(e.first.datum->z, e.second.datum->z, 1e-10);
    }
  }
  EXPECT_GT(rims, 50);
  EXPECT_GT(creases, 50);
}

TEST(Edges, KindsOfOneSphereAndOneHole) {
  // A hemisphere on a plane it meets at its equator: a crease, though the sphere is upright there.
  // Beside it a sphere that floats: a jump. Without a base: an edge.
  const std::string solids =
      "SOLID-DEF\nS1,SPHER,1\nP1,10,10,0\nRAD,5\nS2,SPHER,1\nP1,30,10,3\nRAD,5\n";
  const std::string machining = "MACHI-DEF\nX-RNG,0,40\nY-RNG,0,20\nX-INT,1\nY-INT,1\n";
  const auto kinds = [&](const std::string& text, double x0, double x1) {
    const CompoundSurface surface = test::surface_of(text);
    std::vector<EdgePair> edges;
    find_edges_between(surface, Vec2(x0, 10), Vec2(x1, 10), edges);
    std::string names;
    for (const EdgePair& e : edges) names += std::string(name_of(e.kind)) + ' ';
    return names;
  };
  const std::string plane = solids + "BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+S1+S2\n" + machining;
  EXPECT_EQ(kinds(plane, 1, 10), "crease ");
  EXPECT_EQ(kinds(plane, 21, 30), "jump ");
  EXPECT_EQ(kinds(solids + "BOOLE-DEF\nS1+S2\n" + machining, 1, 10), "edge ");
  // From one sphere to the other all changes in between are met by a midpoint.
  EXPECT_EQ(kinds(plane, 12, 27), "crease jump ");
}

}  // namespace
}  // namespace diesink
