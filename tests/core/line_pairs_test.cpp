// Lines a hair apart all along an edge: settled in a cell as wide as the edge allows, not in cells
// as small as what they lie apart. SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/line_pairs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/compound/compound_impl.h"
#include "core/tessellate/cell_tree.h"
#include "core/tessellate/implicit.h"
#include "tests/support/load_part.h"
#include "tests/support/named_cases.h"

namespace diesink::test {
namespace {

// What a box about a place of a die holds.
struct Verdict {
  CompoundSurface surface;
  CellVerdict verdict;

  Verdict(const std::string& program, double x, double y, double half)
      : surface(surface_of(program)) {
    const CompoundSurface::Impl& impl = surface.impl();
    std::vector<std::uint32_t> steps;
    const PlanBox box{x - half, x + half, y - half, y + half};
    impl.index.over(box, steps);
    classify(impl, body_vertices(impl), CellBox::of(box), steps, 0, verdict);
  }
};

// A block from (20, 20) to (40, 40), up to z = 5, its floor `rise` higher at x = 40 than at 20: its
// wall there leans inwards by half of that.
std::string block(const std::string& rise) {
  return "S1,4-PRIS,2\nP1,20,20,-5\nP2,40,20," + rise + "\nP3,40,40," + rise +
         "\nP4,20,40,-5\nHEI,10\n";
}

std::string die(const std::string& solids, const std::string& terms) {
  return "SOLID-DEF\n" + solids + "BSURF-DEF\nPLANE,-3\nBOOLE-DEF\nB" + terms +
         "\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\nTOLER,.02\n";
}

TEST(LinePairs, ABarBesideAnEdgeByTenMillionths) {
  for (const NamedCase& named : named_cases()) {
    if (named.name != "BarAlongALeaningEdge") continue;
    // The edge, and 1e-8 beside it the line in which the side under it meets the bar.
    const Verdict at(named.text, 51.8538, 60, 0.1);
    EXPECT_EQ(at.verdict.functions.count, 2);
    EXPECT_EQ(at.verdict.kind, CellKind::kCorner);
    EXPECT_FALSE(at.verdict.branched);
    return;
  }
  FAIL() << "no such case";
}

TEST(LinePairs, ABarThatRisesFromATopByLastDigits) {
  // The top and the bar meet in two lines 2.2 thousandths apart.
  const Verdict two(
      die(block("-5") + cylinder("S2", "20,30,2.0000002", "40,30,2.0000002", "3"), "+S1+S2"), 30,
      30, 1);
  EXPECT_EQ(two.verdict.kind, CellKind::kCorner);
  EXPECT_TRUE(two.verdict.branched);
  ASSERT_EQ(two.verdict.functions.count, 1);
  EXPECT_EQ(two.verdict.functions[0].two, TwoGraphs::kOverX);
  // Turned, neither axis runs along them.
  const Verdict turned(
      die(block("-5") + cylinder("S2", "22,24,2.0000002", "38,36,2.0000002", "3"), "+S1+S2"), 30,
      30, 1);
  EXPECT_EQ(turned.verdict.kind, CellKind::kCorner);
  EXPECT_TRUE(turned.verdict.branched);
  // Under the top by as little it is not seen at all.
  const Verdict none(
      die(block("-5") + cylinder("S2", "20,30,1.9999998", "40,30,1.9999998", "3"), "+S1+S2"), 30,
      30, 1);
  EXPECT_EQ(none.verdict.functions.count, 0);
}

TEST(LinePairs, ABarThroughAWallThatLeansByLastDigits) {
  // Over 6.5e-7 of plan: the top's edge, the wall and the bar that comes out of it.
  const Verdict at(die(block("-4.9999987") + cylinder("S2", "40,10,0", "40,50,0", "3"), "+S1+S2"),
                   40, 30, 1);
  EXPECT_EQ(at.verdict.kind, CellKind::kCorner);
}

// The line x = 0, and the conic 2 x + 0.05 x² = 0, which is it and another far off, over 2 by 2.
struct LineAndConic {
  CellBox box{0, 0, 1, 1};
  PlanFunction line, conic;

  LineAndConic() {
    line.exact = conic.exact = true;
    line.cgx = 1;
    line.gx = {1, 1};
    conic.cgx = 2, conic.hxx = 0.1, conic.bend = 0.05;
    conic.gx = {1.9, 2.1};
  }
};

TEST(LinePairs, LinesThatMeetAtNextToNoAngle) {
  auto [box, line, conic] = LineAndConic();
  conic.cgy = 2e-8, conic.gy = {2e-8, 2e-8};
  CellVerdict both;
  both.functions.push(line);
  both.functions.push(conic);
  const LinePairs pairs(both, box, 1e-12);
  EXPECT_FALSE(is_transverse(line, conic));
  EXPECT_EQ(pairs.of(0, 1), LinePairs::Meeting::kOnceAtMost);
  EXPECT_EQ(pairs.of(1, 0), LinePairs::Meeting::kOnceAtMost);
  both.functions[1].v = 2.1e-8;  // beyond the box
  EXPECT_EQ(pairs.of(0, 1), LinePairs::Meeting::kNever);
  both.functions[1].v = 1.9e-8;
  EXPECT_EQ(pairs.of(0, 1), LinePairs::Meeting::kOnceAtMost);
  // Along the line it falls and rises again: twice, or not at all.
  both.functions[1].v = -1e-9;
  both.functions[1].cgy = 0;
  both.functions[1].hyy = 1e-8;
  EXPECT_EQ(pairs.of(0, 1), LinePairs::Meeting::kUnknown);
  both.functions[1].v = 1e-9;
  EXPECT_EQ(pairs.of(0, 1), LinePairs::Meeting::kUnknown);  // its middle coefficient is beneath
  both.functions[1].v = 6e-9;
  EXPECT_EQ(pairs.of(0, 1), LinePairs::Meeting::kNever);
}

TEST(LinePairs, AConicThatFollowsALine) {
  // A silhouette, and the line in which the bar meets a plane through its axis.
  auto [box, line, conic] = LineAndConic();
  EXPECT_TRUE(same_line(line, conic, box, 1e-12));
  EXPECT_TRUE(same_line(conic, line, box, 1e-12));
  conic.v = 1.4e-11;
  EXPECT_TRUE(same_line(line, conic, box, 1e-12));
  conic.v = 1.6e-11;
  EXPECT_FALSE(same_line(line, conic, box, 1e-12));
  conic.v = 0;
  conic.cgy = 1.6e-11;
  EXPECT_FALSE(same_line(line, conic, box, 1e-12));
}

TEST(LinePairs, ALineThatIsAllButStraightBesideAConic) {
  auto [box, line, conic] = LineAndConic();
  conic.v = 1e-6;
  conic.gy = {0, 0};
  line.exact = false;
  line.bend = 1e-8;  // off by no more in plan
  CellVerdict both;
  both.functions.push(line);
  both.functions.push(conic);
  const LinePairs pairs(both, box, 1e-12);
  both.functions[1].bend = 1e300;  // lest enclosures tell
  EXPECT_EQ(pairs.of(0, 1), LinePairs::Meeting::kNever);
  both.functions[0].bend = 1e-6;
  EXPECT_EQ(pairs.of(0, 1), LinePairs::Meeting::kUnknown);
  // How it runs along the conic is not known, even where it would meet a straight one once.
  both.functions[0].bend = 1e-8;
  both.functions[1].v = 0;
  both.functions[1].cgy = 1e-6, both.functions[1].gy = {1e-6, 1e-6};
  EXPECT_EQ(pairs.of(0, 1), LinePairs::Meeting::kUnknown);
}

TEST(PlanFunction, BendsByItsDirectionNotByItsLength) {
  PlanFunction f;
  f.gx = {1e-9, 2e-9};
  f.gy = {1, 9};
  EXPECT_TRUE(f.is_nearly_straight());
  f.gx = {-3, 3};
  EXPECT_FALSE(f.is_nearly_straight());
  f.gx = {0, 0};
  f.gy = {-1e-3, 1};  // two lines in one box
  EXPECT_FALSE(f.is_nearly_straight());
  f.two = TwoGraphs::kOverX;
  EXPECT_TRUE(f.is_nearly_straight());
}

// Bars that are a drawing's rounded edges along the axes: their two lines have a gradient across
// them alone, or but for last digits, which is no reason to call that regular.
TEST(LinePairs, TwoLinesAlongAnAxis) {
  for (const char* y : {"30", "30.00000001"}) {
    const Verdict at(die(block("-5") + cylinder("S2", "20,30,2.0000002",
                                                "40," + std::string(y) + ",2.0000002", "3"),
                         "+S1+S2"),
                     30, 30, 1);
    EXPECT_EQ(at.verdict.kind, CellKind::kCorner) << y;
    EXPECT_TRUE(at.verdict.branched) << y;
    ASSERT_EQ(at.verdict.functions.count, 1) << y;
    EXPECT_EQ(at.verdict.functions[0].two, TwoGraphs::kOverX) << y;
  }
}

// Two equal bars of one corner, the one all but upright: beside the point where both silhouettes
// and both planes of their mitre meet their crease has a bound all the same.
TEST(CellBounds, EqualBarsMitreBesideBothSilhouettes) {
  const Verdict at(
      "SOLID-DEF\n" +
          cylinder("S8", "34.361396,60.923793,2.780061", "34.366463,60.895189,-0.324799", "2") +
          cylinder("S16", "30.679557,81.708481,-0.522556", "34.366463,60.895189,-0.324799", "2") +
          "BSURF-DEF\nPLANE,2\nBOOLE-DEF\nB-S8-S16\nMACHI-DEF\nX-RNG,0,100\n"
          "Y-RNG,0,100\nTOLER,.01\n",
      32.390, 60.5893, 2e-3);
  bool crosses = false;
  for (const PlanFunction& f : at.verdict.functions) {
    if (f.kind != PlanFunction::Kind::kCrossing || f.solid < 0) continue;
    crosses = true;
    EXPECT_TRUE(f.regular());
    EXPECT_TRUE(f.exact);
  }
  EXPECT_TRUE(crosses);
}

// A bar that rises by 1 in 3900: its lower cap is an ellipse 1.5e-3 wide and 6 long in plan, of
// which one half is where the bar ends.
TEST(CellBounds, TheRimOfACapThatIsAllButUprightIsOneLine) {
  const Verdict at("SOLID-DEF\n" + cylinder("S1", "60,50,0", "99,50,0.01", "3") +
                       "BSURF-DEF\nPLANE,-5\nBOOLE-DEF\nB+S1\nMACHI-DEF\nX-RNG,0,100\n"
                       "Y-RNG,0,100\nTOLER,.01\n",
                   60, 50.5, 0.2);
  EXPECT_EQ(at.verdict.kind, CellKind::kArc);
  ASSERT_EQ(at.verdict.functions.count, 1);
  const PlanFunction& rim = at.verdict.functions[0];
  EXPECT_EQ(rim.kind, PlanFunction::Kind::kRim);
  // Inside the bar positive; on the rim, at the half that stands out, zero.
  const double lean = 0.01 / 39, up = std::sqrt(9 - 0.25);
  EXPECT_GT(rim.cgx, 0);
  EXPECT_NEAR(rim.v / rim.cgx, up * lean, 0.02 * up * lean);
}

// A corner of a block that leans, given to six decimals, is where its faces' planes meet.
TEST(CellBounds, CornersLieOnTheirFaces) {
  const CompoundSurface surface = surface_of(
      die("S,4-PRIS,2\nP1,51.645449,54.103524,-7.817577\nP2,81.386461,66.815244,-7.817577\n"
          "P3,78.228093,74.204727,-6.547126\nP4,48.487082,61.493007,-6.547126\nHEI,7.904081\n",
          "-S"));
  const CompoundSurface::Impl& impl = surface.impl();
  const std::vector<Vec3> points = body_vertices(impl)[0].points;
  ASSERT_EQ(points.size(), 8u);
  for (const Vec3& p : points) {
    int on = 0;
    for (const std::uint8_t face : face_numbers(impl.bodies[0].body()))
      on += std::fabs(face_implicit(impl.bodies[0], face).value(p)) < 1e-13 ? 1 : 0;
    EXPECT_EQ(on, 3);
  }
}

}  // namespace
}  // namespace diesink::test
