// Chords that cross laid straight and parted, by themselves and as the last resort of whole dies.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/untangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/tessellate/planar_triangulation.h"
#include "tests/support/load_part.h"
#include "tests/support/mesh_proof.h"
#include "tests/support/named_cases.h"
#include "tests/support/tiles.h"

namespace diesink::test {
namespace {

// Searches given up almost at once, so that cells join what does not belong together; no chords
// split where they cross; one way to lay the cells.
constexpr SearchBudget kHardlyAny{40, 0, 64, 0, 1};

std::string text_of(const std::string& name) {
  for (const NamedCase& given : named_cases()) {
    if (given.name == name) return given.text;
  }
  ADD_FAILURE() << name;
  return {};
}

struct Sampled {
  Arrangement arrangement;
  ArcSamples samples;
  Sampled(const CompoundSurface& surface, Arrangement&& from, double tolerance)
      : arrangement(std::move(from)), samples(surface.impl(), arrangement, [&] {
          SamplingOptions options;
          options.sag = options.flat_sag = options.tolerance = tolerance;
          options.shortest = 0.5 * tolerance;
          return options;
        }()) {
    samples.sample_all(1);
  }
};

Arrangement arranged(const CompoundSurface& surface, double tolerance) {
  const Machining& m = surface.program().machining;
  ArrangementOptions options;
  options.tolerance = tolerance;
  options.threads = 1;
  Result<Arrangement> made =
      arrange(surface, {m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]}, options);
  EXPECT_TRUE(made);
  return made ? std::move(*made) : Arrangement{};
}

// Of arcs that have been moved: their curves are not where they say.
std::optional<Arrangement> untangled(const CompoundSurface& surface, Arrangement&& moved) {
  for (PlanArc& arc : moved.arcs) {
    for (PlanCurve& curve : arc.curves) curve = PlanCurve{};
  }
  const Sampled from(surface, std::move(moved), 0.1);
  return untangle(surface.impl(), from.arrangement, from.samples, 0);
}

// The plan area of each label; every region has to be triangulated in plan between its chords, and
// every arc to have the region's label on its side.
std::map<Label, double> areas_of(const CompoundSurface& surface, const Arrangement& arrangement) {
  ArcSamples samples(surface.impl(), arrangement, {});
  samples.sample_all(1);
  std::map<Label, double> areas;
  std::vector<std::uint32_t> chain;
  for (const PlanRegion& region : arrangement.regions) {
    std::vector<Vec2> points;
    std::map<std::uint32_t, std::uint32_t> local;
    std::vector<PlanarTriangulation::Segment> segments;
    for (const std::vector<ArcUse>& loop : region.loops) {
      for (const ArcUse& use : loop) {
        const PlanArc& arc = arrangement.arcs[use.arc];
        EXPECT_EQ(use.forward ? arc.left : arc.right, region.label);
        samples.chain(use.arc, chain);
        if (!use.forward) std::reverse(chain.begin(), chain.end());
        const auto number = [&](std::uint32_t p) {
          const auto [it, fresh] = local.try_emplace(p, static_cast<std::uint32_t>(points.size()));
          if (fresh) points.emplace_back(samples.points[p].x, samples.points[p].y);
          return it->second;
        };
        for (std::size_t k = 0; k + 1 < chain.size(); ++k)
          segments.push_back({number(chain[k]), number(chain[k + 1])});
      }
    }
    PlanarTriangulation triangulation;
    EXPECT_TRUE(triangulation.build(points, segments).empty());
    for (const auto& t : triangulation.triangles()) {
      const Vec2 u = points[t[1]] - points[t[0]], v = points[t[2]] - points[t[0]];
      areas[region.label] += 0.5 * (u.x() * v.y() - u.y() * v.x());
    }
  }
  return areas;
}

TEST(Untangle, ChordsThatCrossNothingStay) {
  for (const char* name : {"IslandInAPocket", "PyramidsMeetingInAnApex",
                           "SpheresTouchingRoundAHole", "ZigzagBase", "NoBaseTwoTouchingDiscs"}) {
    const CompoundSurface surface = surface_of(text_of(name));
    const Sampled from(surface, arranged(surface, 0.1), 0.1);
    const std::optional<Arrangement> made =
        untangle(surface.impl(), from.arrangement, from.samples, 0);
    ASSERT_TRUE(made) << name;
    EXPECT_EQ(made->uncertified_area, 0) << name;
    EXPECT_EQ(made->regions.size(), from.arrangement.regions.size()) << name;
    // What arcs enclose, but for the roundness of their chords, which are the same.
    const std::map<Label, double> areas = areas_of(surface, *made);
    std::size_t chords = 0, before = 0;
    for (const PlanArc& arc : made->arcs) chords += arc.nodes.size() - 1;
    for (const SampledArc& arc : from.samples.arcs)
      before += arc.samples.size() - (arc.samples.back().next == 0 ? 0 : 1);
    EXPECT_LE(chords, before) << name;
    EXPECT_GE(chords + 8, before) << name;
    double all = 0;
    for (const auto& [label, area] : areas) all += area;
    const PlanBox& box = made->box;
    EXPECT_NEAR(all, (box.x1 - box.x0) * (box.y1 - box.y0), 1e-9 * all) << name;
  }
}

// Two blocks whose outlines are said to lie over one another: four by four of their area is
// claimed by both.
TEST(Untangle, OutlinesOverOneAnotherAreParted) {
  const CompoundSurface surface = surface_of(
      on_plane(box("A", "10,10,-5", "20,20,5") + box("C", "26,16,-5", "36,26,7"), "+A+C"));
  Arrangement wrong = arranged(surface, 0.1);
  for (PlanNode& node : wrong.nodes) {
    if (!node.border && node.x > 23) node.x -= 10;
  }
  const std::optional<Arrangement> made = untangled(surface, std::move(wrong));
  ASSERT_TRUE(made);
  EXPECT_GT(made->uncertified_area, 0);
  const std::map<Label, double> areas = areas_of(surface, *made);
  // Over the common part evaluation shows A, which is there; over the rest of C's outline the base.
  ASSERT_EQ(areas.size(), 2U);
  EXPECT_NEAR(areas.at(surface.impl().evaluate_face(12, 12).label), 100, 1e-6);
  EXPECT_NEAR(areas.at(surface.impl().evaluate_face(5, 5).label), 1500, 1e-6);
}

// Chords side by side at a distance of rounding cross again and again wherever one is cut at a
// rounded point: they become one.
TEST(Untangle, ChordsOnOneAnotherBecomeOne) {
  const CompoundSurface surface = surface_of(
      on_plane(box("A", "10,10,-5", "20,20,5") + box("C", "20,10,-5", "30,20,7"), "+A+C"));
  Arrangement wrong = arranged(surface, 0.1);
  const std::size_t regions = wrong.regions.size();
  // A second outline of everything, turned by 1e-10.
  const std::size_t arcs = wrong.arcs.size();
  for (std::size_t a = 0; a < arcs; ++a) {
    if (wrong.arcs[a].border) continue;
    PlanArc again = wrong.arcs[a];
    for (std::uint32_t& n : again.nodes) {
      PlanNode node = wrong.nodes[n];
      const double x = node.x - 20, y = node.y - 15;
      node.x += 1e-10 * y;
      node.y -= 1e-10 * x;
      n = static_cast<std::uint32_t>(wrong.nodes.size());
      wrong.nodes.push_back(node);
    }
    if (again.closed) again.nodes.back() = again.nodes.front();
    wrong.arcs.push_back(std::move(again));
  }
  const std::optional<Arrangement> made = untangled(surface, std::move(wrong));
  ASSERT_TRUE(made);
  EXPECT_EQ(made->regions.size(), regions);
  EXPECT_LE(made->arcs.size(), arcs + 4);
}

// Outlines a hair off, over and over: as many crossings as there are of them. With fewer to be done
// away with than that the lattice is wider, where they are one, and what that moves is in the
// bounds.
TEST(Untangle, MoreCrossingsThanMayBeAreFewerOnAWiderLattice) {
  const CompoundSurface surface = surface_of(on_plane(box("A", "10,10,-5", "20,20,5"), "+A"));
  const auto copies = [&] {
    Arrangement wrong = arranged(surface, 0.1);
    const std::size_t arcs = wrong.arcs.size();
    for (int copy = 1; copy <= 8; ++copy) {
      for (std::size_t a = 0; a < arcs; ++a) {
        if (wrong.arcs[a].border) continue;
        PlanArc again = wrong.arcs[a];
        for (std::uint32_t& n : again.nodes) {
          PlanNode node = wrong.nodes[n];
          const double turned = 1e-6 * copy, x = node.x - 15, y = node.y - 15;
          node.x += turned * y;
          node.y -= turned * x;
          n = static_cast<std::uint32_t>(wrong.nodes.size());
          wrong.nodes.push_back(node);
        }
        if (again.closed) again.nodes.back() = again.nodes.front();
        wrong.arcs.push_back(std::move(again));
      }
    }
    return wrong;
  };
  const auto straight = [&](std::size_t most) {
    Arrangement moved = copies();
    for (PlanArc& arc : moved.arcs) {
      for (PlanCurve& curve : arc.curves) curve = PlanCurve{};
    }
    const Sampled from(surface, std::move(moved), 0.1);
    return untangle(surface.impl(), from.arrangement, from.samples, 0, most);
  };
  const std::optional<Arrangement> fine = straight(kMostUntangled), coarse = straight(20);
  ASSERT_TRUE(fine && coarse);
  EXPECT_EQ(fine->regions.size(), 2U);
  EXPECT_EQ(coarse->regions.size(), 2U);
  EXPECT_GT(coarse->grain, 10 * fine->grain);
  for (const std::optional<Arrangement>& made : {fine, coarse}) {
    double largest = 0, all = 0;
    for (const PlanArc& arc : made->arcs)
      for (const double bound : arc.bounds) largest = std::fmax(largest, bound);
    EXPECT_GE(largest, 2 * made->grain);
    for (const auto& [label, area] : areas_of(surface, *made)) all += area;
    const PlanBox& domain = made->box;
    EXPECT_NEAR(all, (domain.x1 - domain.x0) * (domain.y1 - domain.y0), 1e-9 * all);
  }
}

// What neighbours have agreed on along a cut stays, whatever is made of the rest of a tile.
TEST(Untangle, TilesKeepTheirSeams) {
  for (const char* name : {"IslandInAPocket", "PyramidsMeetingInAnApex", "TinyPeg", "ZigzagBase"}) {
    const CompoundSurface surface = surface_of(text_of(name));
    TessellationOptions options;
    options.tolerance = 1;
    options.budget = kHardlyAny;
    options.budget.pieces = SearchBudget().pieces;  // of the cuts
    Faults faults;
    check_seams(make_tiles(surface, options, {3, 2}), false, faults);
    EXPECT_EQ(faults.text(), "") << name;
  }
}

// Features of a ten-thousandth of a millimetre a kilometre away, with tolerances far wider than the
// part.
TEST(CoarseTolerances, AThousandthOfAMillimetreFarAway) {
  for (const double by : {1e5, 1e6, 1e7}) {
    const CompoundSurface surface = surface_of(moved(text_of("ThousandthOfAMillimetre"), by));
    for (const double tolerance : {1e-4, 1e-3, 1e-2, 1.0}) {
      TessellationOptions options;
      options.tolerance = tolerance;
      options.solid = true;
      const Result<Tessellation> made = tessellate(surface, options);
      ASSERT_TRUE(made) << by << ' ' << tolerance << ' ' << to_text(made.error());
      Faults faults;
      check_topology(made->mesh, true, faults);
      EXPECT_EQ(faults.text(), "") << by << ' ' << tolerance;
    }
  }
}

class NamedDies : public testing::TestWithParam<NamedCase> {};

// Whatever cells have made of a die it is delivered: a closed solid, the same for any number of
// threads, with the place told.
TEST_P(NamedDies, AreDeliveredWithHardlyAnySearch) {
  const CompoundSurface surface = surface_of(GetParam().text);
  TessellationOptions options;
  options.tolerance = 10 * GetParam().tolerance;
  options.solid = true;
  options.threads = 1;
  options.budget = kHardlyAny;
  const Result<Tessellation> one = tessellate(surface, options);
  ASSERT_TRUE(one) << to_text(one.error());
  Faults faults;
  check_topology(one->mesh, true, faults);
  EXPECT_EQ(faults.text(), "");
  EXPECT_TRUE(one->report.watertight);
  options.threads = 2;
  const Result<Tessellation> two = tessellate(surface, options);
  ASSERT_TRUE(two);
  EXPECT_TRUE(same_bytes(one->mesh, two->mesh));
  EXPECT_EQ(one->report.uncertified_area, two->report.uncertified_area);
}

INSTANTIATE_TEST_SUITE_P(Cases, NamedDies, testing::ValuesIn(named_cases()),
                         [](const auto& given) { return given.param.name; });

}  // namespace
}  // namespace diesink::test
