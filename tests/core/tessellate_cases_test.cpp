// Degenerate dies, each proved in every way it can be meshed.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/load_part.h"
#include "tests/support/mesh_proof.h"
#include "tests/support/named_cases.h"

namespace diesink::test {
namespace {

class NamedCases : public testing::TestWithParam<NamedCase> {};

std::string prove_case(const NamedCase& given, MeshScheme scheme, bool solid) {
  ProofOptions options;
  options.samples = 1500;
  options.tessellation.tolerance = given.tolerance;
  options.tessellation.scheme = scheme;
  options.tessellation.solid = solid;
  return prove(surface_of(given.text), options);
}

TEST_P(NamedCases, Sheet) { EXPECT_EQ(prove_case(GetParam(), MeshScheme::kAdaptive, false), ""); }
TEST_P(NamedCases, Solid) { EXPECT_EQ(prove_case(GetParam(), MeshScheme::kAdaptive, true), ""); }
TEST_P(NamedCases, GridSolid) { EXPECT_EQ(prove_case(GetParam(), MeshScheme::kGrid, true), ""); }

// Least height of a triangle, of the size of the part.
double least_height(const NamedCase& given) {
  TessellationOptions options;
  options.tolerance = given.tolerance;
  const CompoundSurface surface = surface_of(given.text);
  const Result<Tessellation> made = tessellate(surface, options);
  if (!made) return 0;
  double least = 1e300;
  for (const auto& t : made->mesh.triangles) {
    const Vec3 &a = made->mesh.positions[t[0]], &b = made->mesh.positions[t[1]],
               &c = made->mesh.positions[t[2]];
    const double longest =
        std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    least = std::min(least, (b - a).cross(c - a).norm() / longest);
  }
  return least / surface.size();
}

// Rounding gives two curves that touch two crossings side by side, and a silhouette two heights:
// neither may become a triangle.
TEST(DegenerateDies, NoSliverWhereCurvesTouch) {
  for (const NamedCase& given : named_cases()) {
    for (const char* name :
         {"NoBaseTwoTouchingDiscs", "PlanShadowsTouchInAPoint", "CylindersSideBySide"}) {
      if (given.name != name) continue;
      EXPECT_GT(least_height(given), 1e-6) << name;
    }
  }
}

// At its own tolerance where none is given.
void expect_certified(const std::string& die, std::size_t fewer_triangles_than,
                      double tolerance = 0) {
  TessellationOptions options;
  options.tolerance = tolerance;
  const Result<Tessellation> made = tessellate(surface_of(die), options);
  ASSERT_TRUE(made) << die;
  EXPECT_EQ(made->report.uncertified_area, 0) << die;
  EXPECT_EQ(made->report.doubt_count, 0u) << die;
  EXPECT_LT(made->mesh.triangles.size(), fewer_triangles_than) << die;
}

// A millionth of the domain: a cell of 2^-22 of it is wider than what this tolerance does not see.
TEST(DegenerateDies, TenMetresAtAHundredth) {
  const CompoundSurface surface = surface_of(
      "SOLID-DEF\nS,SPHER,1\nP1,4000,5000,0\nRAD,200\nA,R-CYLI,1\nP1,4100,5000,-100\n"
      "P2,4100,5000,300\nRAD,100\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+S+A\n"
      "MACHI-DEF\nX-RNG,0,10000\nY-RNG,0,10000\n");
  TessellationOptions options;
  options.tolerance = 0.01;
  const Result<Tessellation> made = tessellate(surface, options);
  ASSERT_TRUE(made);
  // What is told is the touching of sphere and cylinder: what a tie there hides of it, no cell.
  for (const MeshDoubt& doubt : made->report.doubts) {
    EXPECT_EQ(doubt.what.find("told apart"), std::string::npos) << doubt.what;
    EXPECT_LE((doubt.place.head<2>() - Vec2(4200, 5000)).norm(), 0.5);
  }
  EXPECT_LE(made->report.uncertified_area, 1e-6);
  EXPECT_LE(made->report.certified_deviation, 0.01);
}

// A ball at the end of a bar, both cut by a bar along a block's top: where the seam of ball and bar
// runs into that cut, cells are so small that the two are a tie apart. For evaluation the bar has
// those ties, as it is beyond the ball on both sides of the seam; for cells the ball had them, and
// the seam ended in nothing. 0.3 mm2 were told.
TEST(DegenerateDies, SeamOfABallAndABarThatRunsIntoACut) {
  expect_certified(
      "SOLID-DEF\n" + sphere("S6", "59.896308,35.545981,13.108514", "1") +
          cylinder("S13", "59.896308,68.296534,13.108514", "59.896308,35.545981,13.108514", "1") +
          "S17,4-PRIS,2\nP1,50.59509,19.95518,0\nP2,62.673709,32.033799,0\n"
          "P3,55.308266,39.399242,0\nP4,43.229647,27.320623,0\nHEI,.80397\n" +
          cylinder("S22", "61.721628,31.081718,0", "54.356185,38.447161,0", "1.346445") +
          "BOOLE-DEF\nS6+S13-S17-S22\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n",
      2000, 0.05);
}

// Equal cylinders crossing, as a boss and as a pocket: about the point in which their creases cross
// they are so low that cells stay wide, and two of them find it. At 0.01 something was told.
TEST(DegenerateDies, SteinmetzAtAnyTolerance) {
  const std::string die =
      "SOLID-DEF\n" + cylinder("C1", "5,20,0", "35,20,0", "6") +
      cylinder("C2", "20,5,0", "20,35,0", "6") + cylinder("D1", "45,20,0", "75,20,0", "6") +
      cylinder("D2", "60,5,0", "60,35,0", "6") +
      "BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+C1+C2-D1-D2\nMACHI-DEF\nX-RNG,0,80\nY-RNG,0,40\n";
  for (const double tolerance : {0.1, 0.03, 0.02, 0.015, 0.01, 0.008, 0.005, 0.003, 0.001})
    expect_certified(die, static_cast<std::size_t>(130 / tolerance), tolerance);
}

// A solid may stand in the expression as often as it likes; two dozen filled a cell's lists.
TEST(DegenerateDies, OneSolidThirtyTimes) {
  std::string terms;
  for (int i = 0; i < 30; ++i) terms += i == 15 ? "\n+S" : "+S";
  expect_certified(on_plane(sphere("S", "20,20,0", "5"), terms), 1500, 0.01);
}

// Nor may two dozen of different names that are one and the same fill them.
TEST(DegenerateDies, TwoDozenSolidsThatAreOne) {
  std::string solids, plus, minus;
  for (int i = 0; i < 24; ++i) {
    const std::string number = std::to_string(i);
    solids +=
        sphere("S" + number, "20,20,0", "5") + cylinder("C" + number, "20,20,-9", "20,20,9", "2");
    solids += "K" + number + ",4-PRIS,3\nP1,8,8,0\nP2,16,14,3\n";
    plus += "+S" + number + "+K" + number;
    minus += "-C" + number;
  }
  expect_certified(on_plane(solids, plus + minus + "+S3"), 6000, 0.01);
}

// A pocket with a rounded foot, given to six decimals: the bar touches the leaning side in the edge
// of the floor, reaches through it by a few last digits at the one end and leaves a sliver of floor
// 1e-7 wide at the other. Cells were plain that showed another face in their corners, slivers of a
// few ties had no name, and the side was lost: 675 mm2 told.
TEST(DegenerateDies, BarThatTouchesALeaningSideByLastDigits) {
  expect_certified(
      "SOLID-DEF\nS,4-PRIS,2\nP1,51.645449,54.103524,-7.817577\n"
      "P2,81.386461,66.815244,-7.817577\nP3,78.228093,74.204727,-6.547126\n"
      "P4,48.487082,61.493007,-6.547126\nHEI,7.904081\n"
      "A,R-CYLI,1\nP1,51.257251,55.011774,-7.661424\nP2,80.998262,67.723494,-7.661424\nRAD,1\n"
      "BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB-S-A\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n",
      4500, 0.02);
}

// A bar over a flat cone, its end upright: the bar's side meets the cone and, two millimetres above
// the apex and within a millimetre in plan, the mirrored cone. A corner up there was taken for the
// crease's, and no number of vertices could bring the cone's side up to it: the die did not end.
TEST(DegenerateDies, BarOverAFlatConeUnderItsMirroredNappe) {
  const std::string die =
      "SOLID-DEF\n" +
      cone("S6", "30.354332,13.16561,2.495847", "30.354332,13.16561,5.769761", "30.657456") +
      cylinder("S7", "22.543574,13.16561,2.495847", "37.291125,13.16561,2.495847", "17.969169") +
      "BOOLE-DEF\nS6+S7\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\nX-INT,2.5\nY-INT,2.5\n";
  expect_certified(die, 400, 0.5);
  expect_certified(die, 2500, 0.02);
}

// A pin that leans by a few thousandths: regular triangles on its side fold over in plan, however
// small. 57 000 of them in five seconds for the second at 0.05, 580 000 in fifty at 0.005.
TEST(DegenerateDies, PinsThatHardlyLeanAreTrianglesBetweenRulings) {
  for (const char* top : {"41.39963", "41.39038", "41.363", "41.178"}) {
    const std::string pin = cylinder("S", "41.4,27.05,-.58", top + std::string(",27.05,3.12"), "1");
    const std::string rest = "MACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n";
    expect_certified("SOLID-DEF\n" + pin + "BOOLE-DEF\nS\n" + rest, 200, 0.05);
    // Its foot is a curve of the base, not a rim.
    const std::string over_base =
        "BSURF-DEF\nPLANE\nP1,50,50,0.3\nNOR,.02,-.03,1\nBOOLE-DEF\nB+S\n";
    expect_certified("SOLID-DEF\n" + pin + over_base + rest, 900, 0.05);
  }
  const std::string leaning = "SOLID-DEF\n" +
                              cylinder("S", "41.4,27.05,-.58", "41.39038,27.05,3.12", "1") +
                              "BOOLE-DEF\nS\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n";
  expect_certified(leaning, 400, 0.005);
  expect_certified(leaning, 700, 0.001);
}

// Two pins that lean differently cross in curves that step back over the rulings. None of these
// ended within half a minute; what of them is no strip and folds over is told.
TEST(DegenerateDies, PinsThatHardlyLeanCrossing) {
  const std::string rest = "MACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n";
  const std::string slope = "BSURF-DEF\nPLANE\nP1,50,50,0.3\nNOR,.02,-.03,1\nBOOLE-DEF\n";
  struct Given {
    std::string die;
    double tolerance, told;
  };
  const std::vector<Given> dies{
      {cylinder("S", "50.000044,49.999977,2.447069", "50,50,0.914014", "1.053554") + slope +
           "B+S\n",
       0.0018, 1e-6},
      {cylinder("S", "50,50,-0.662241", "49.996785,50.014338,6.402129", "5.212684") +
           cylinder("T", "55.212684,50,-1.662241", "55.212684,50,2.869944", "2.606342") +
           "BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+S+T\n",
       0.0054, 0.1},
      {cylinder("S", "49.999757,49.999788,8.973084", "50,50,0.285359", "6.610628") +
           cylinder("T", "56.610628,50,-0.714641", "56.610628,50,4.629222", "3.305314") + slope +
           "B+S+T\n",
       0.0891, 0.5}};
  for (const Given& given : dies) {
    TessellationOptions options;
    options.tolerance = given.tolerance;
    const Result<Tessellation> made =
        tessellate(surface_of("SOLID-DEF\n" + given.die + rest), options);
    ASSERT_TRUE(made) << given.die;
    EXPECT_LT(made->mesh.triangles.size(), 6000u) << given.die;
    EXPECT_LT(made->report.uncertified_area, given.told) << given.die;
  }
}

// Seen all around a cone has rulings on every side of its apex.
TEST(DegenerateDies, SlenderConeOnASlopeIsNoStrip) {
  expect_certified(
      "SOLID-DEF\n" +
          cone("S1", "87.559816,11.057391,0.728056", "87.559816,11.057391,8.940991", "0.98663") +
          "BSURF-DEF\nPLANE\nP1,50,50,0\nNOR,0,0.2,1\nBOOLE-DEF\nB+S1\nMACHI-DEF\n"
          "X-RNG,0,100\nY-RNG,0,100\n",
      200, 0.1);
}

// A pin at the end of a block, its top flush: the block's side ends along a ruling of the pin, and
// the pin's side goes on beyond it over a ten-thousandth of a millimetre.
TEST(DegenerateDies, SideThatStepsDownAlongARuling) {
  expect_certified(
      "SOLID-DEF\nS3,4-PRIS,2\nP1,73.72013,74.303063,0.431876\nP2,73.72013,82.760833,0.431876\n"
      "P3,34.463182,82.760833,0.200744\nP4,34.463182,74.303063,0.200744\nHEI,2.893999\n" +
          cylinder("S5", "70.261828,74.303063,0.411515", "70.244789,74.303063,3.305463",
                   "3.458362") +
          "BOOLE-DEF\nS3+S5\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n",
      1500, 0.01);
}

// Drawn conformally they took regular triangles as small as their edges are sharp: 120 000 of them
// in six seconds for the second, and something was told.
TEST(DegenerateDies, LongEllipsoidsAreFewTrianglesAndCertified) {
  struct Given {
    const char* axes;
    double tolerance;
    std::size_t fewer_than;
  };
  for (const Given& given : {Given{"A,7\nB,1\nC,1\n", 0.02, 500},
                             {"A,1\nB,7\nC,20\n", 0.001, 14000},
                             {"A,1\nB,20\nC,20\n", 0.001, 15000},
                             {"A,20\nB,20\nC,1\n", 0.001, 15000},
                             {"A,20\nB,3\nC,3\n", 0.001, 13500},
                             {"A,1\nB,4\nC,4\n", 0.001, 5200}}) {
    expect_certified(std::string("SOLID-DEF\nE,ELLIP,2\nP1,0,0,0\n") + given.axes +
                         "BOOLE-DEF\nE\nMACHI-DEF\nX-RNG,-22,22\nY-RNG,-22,22\n",
                     given.fewer_than, given.tolerance);
  }
}

// Cones whose apex is a vertex of their border, where no distance to the side is bounded: its
// triangles are refined all the same.
TEST(DegenerateDies, ApexesOnBordersAreNotOffTheFace) {
  expect_certified("SOLID-DEF\nS3,PARAB,1\nP1,10,75,-10\nP2,10,75,0\nRAD,5\n" +
                       cone("S9", "7.5,72.5,2.5", "12.5,77.5,7.5", "5") +
                       "BSURF-DEF\nFERGU,2,2\n0,0,0\n100,0,3.333333\n0,100,3.333333\n"
                       "100,100,0.833333\nBOOLE-DEF\nB-S3+S9\nMACHI-DEF\nX-RNG,0,100\n"
                       "Y-RNG,0,100\n",
                   1000, 0.2);
  expect_certified("SOLID-DEF\n" + cone("S4", "30,0,-10", "70,0,5", "40") +
                       cone("S5", "90,30,-10", "90,30,70", "40") +
                       "BOOLE-DEF\nS4+S5\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n",
                   1000, 0.2);
}

// A block's side that leans by last digits, 1e-7 mm wide in plan, and along it the silhouette of a
// bar whose axis is as high as the block's top: side and bar meet in next to nothing, which was
// searched for in half a million cells.
TEST(DegenerateDies, BarAlongASideThatLeansByLastDigits) {
  TessellationOptions options;
  options.tolerance = 0.01;
  const Result<Tessellation> made =
      tessellate(surface_of("SOLID-DEF\nS5,4-PRIS,2\nP1,29.830828,40.840412,-3.753481\n"
                            "P2,49.970561,60.980145,-3.753481\nP3,45.588216,65.362491,-2.78494\n"
                            "P4,25.448483,45.222758,-2.78494\nHEI,8.786821\n" +
                            cylinder("S16", "27.822038,45.677629,5.896509",
                                     "32.204384,41.295284,4.927968", "2") +
                            "BOOLE-DEF\nS5+S16\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n"),
                 options);
  ASSERT_TRUE(made);
  EXPECT_LT(made->mesh.triangles.size(), 3000u);
  // Corners that are 5e-7 mm apart, nearer than is searched, are told.
  EXPECT_LT(made->report.uncertified_area, 1e-3);
}

// Beside an upright ruling the side's own surface runs far below its rim within a hair of plan:
// where it would meet the plane down there it has long ended.
TEST(DegenerateDies, RimsUnderAnUprightRulingAreCertified) {
  for (const char* apex : {"25,20,5", "22.071067811865476,27.071067811865476,5"}) {
    expect_certified("SOLID-DEF\n" + cone("K", "15,20,-5", apex, "14.142135623730951") +
                         "BSURF-DEF\nPLANE,-30\nBOOLE-DEF\nB+K\nMACHI-DEF\nX-RNG,0,40\n"
                         "Y-RNG,0,40\n",
                     4000, 0.05);
  }
}

// Where the apex stands out over the rim or the plane by a hair the side is triangles between
// rulings, too; refinement took tens of thousands there and was not certified.
TEST(DegenerateDies, ApexesOutByAHairAreFans) {
  for (const char* apex : {"25,20,5", "22.071067811865476,27.071067811865476,5"}) {
    for (const char* radius : {"14.1412", "14.14203"}) {
      for (const char* plane : {"0", "-30"}) {
        expect_certified("SOLID-DEF\n" + cone("K", "15,20,-5", apex, radius) + "BSURF-DEF\nPLANE," +
                             plane + "\nBOOLE-DEF\nB+K\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\n",
                         4000, 0.05);
      }
    }
  }
}

// Where bars, balls and blocks touch along a curve they do not cross: its whole length used to be
// searched down to the least cell, a hundred thousand triangles of it. In any order of the terms:
// a tie goes to the one that is beyond the other.
TEST(DegenerateDies, RoundEdgesAreFewTrianglesAndCertified) {
  std::vector<std::string> dies;
  for (const double turn : {0.0, 0.3, 0.7, 2.5}) {
    for (const char sign : {'+', '-'})
      dies.push_back(on_plane(rounded_block(turn, sign), rounded_block_terms(sign)));
  }
  const std::string rib = cylinder("A", "12,14,2", "28,27,2", "5") + sphere("S", "12,14,2", "5") +
                          sphere("T", "28,27,2", "5");
  for (const char* terms : {"+A+S+T", "+S+A+T", "+S+T+A"}) dies.push_back(on_plane(rib, terms));
  for (const std::string& text : dies) expect_certified(text, 15000);
}

// The same die drawn with six decimals: what coincided is a millionth apart. Such dies took minutes
// and a million triangles, or told an area beside their walls.
TEST(DegenerateDies, OfSixDecimalsAreFewTrianglesAndCertified) {
  std::vector<std::string> dies{bar_and_block_of_six_decimals()};
  for (int k = 0; k < 12; ++k) {
    const char sign = k % 2 == 0 ? '+' : '-';
    dies.push_back(with_six_decimals(
        on_plane(rounded_block(0.1 + 0.26 * k, sign), rounded_block_terms(sign))));
  }
  for (const std::string& text : dies) expect_certified(text, 20000);
}

// Where a leaning bar's silhouette ends at its rim the ball's goes on: three curves with one
// tangent, in one corner. A search along them took ten thousand triangles and was told.
TEST(DegenerateDies, LeaningSlotsWithBallEndsAreCertified) {
  const char* slot =
      "SOLID-DEF\nD,R-CYLI,1\nP1,10,22.5,-2.5\nP2,10,22.5,2.5\nRAD,7.5\n"
      "A,R-CYLI,1\nP1,12.5,25,1.25\nP2,27.655,33.75,2.5\nRAD,2.5\n"
      "S,SPHER,1\nP1,12.5,25,1.25\nRAD,2.5\nBOOLE-DEF\nD-A-S\nMACHI-DEF\n"
      "X-RNG,0,50\nY-RNG,0,50\nTOLER,.005\n";
  expect_certified(slot, 3000);
  ProofOptions options;
  EXPECT_EQ(prove(surface_of(slot), options), "");
}

// As few triangles as the sphere that each is but for its axes: as small as their edges are sharp
// they took up to a million.
TEST(DegenerateDies, ThinEllipsoidsTakeFewTriangles) {
  for (const char* axes : {"A,15\nB,.1\nC,5\n", "A,.1\nB,10\nC,8\n", "A,1.25\nB,10\nC,10\n",
                           "A,15\nB,.02\nC,.03\n", "A,15\nB,12\nC,.03\n"}) {
    for (const char sign : {'+', '-'}) {
      expect_certified("SOLID-DEF\nE,ELLIP,2\nP1,20,20,1\n" + std::string(axes) +
                           "BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB" + sign +
                           "E\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.05\n",
                       2500);
    }
  }
}

// Lines of the grid cross the rim of a peg just halfway between two of the places that are looked
// at: without points there its top ended in a triangle without area.
TEST(DegenerateDies, LinesOfTheGridCrossARimJustHalfway) {
  ProofOptions options;
  options.tessellation.scheme = MeshScheme::kGrid;
  EXPECT_EQ(prove(surface_of("SOLID-DEF\nS,4-PRIS,1\nP1,90,20,0\nP2,110,20,0\nP3,110,40,0\n"
                             "P4,90,40,0\nP5,95,25,7.5\nP6,105,25,7.5\nP7,105,35,7.5\n"
                             "P8,95,35,7.5\n" +
                             cylinder("T", "97.5,47.5,-1.25", "97.5,47.5,1.25", "2.5") +
                             "BOOLE-DEF\nS+T\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n"
                             "X-INT,2.5\nY-INT,2.5\nTOLER,.2\n"),
                  options),
            "");
}

// Two walls that touch in a point of the plan, over a slope: what is found of the slope beside the
// point is not its height there.
TEST(DegenerateDies, SphereBesideARimOverASlope) {
  for (const char* normal : {"-.2,.1,1", "-.1,0,1", ".2,.2,1"}) {
    const std::string die = "SOLID-DEF\n" + cone("K", "20,35,6", "20,35,30", "20") +
                            sphere("S", "20,10,6", "5") + "BSURF-DEF\nPLANE\nP1,20,20,0\nNOR," +
                            normal +
                            "\nBOOLE-DEF\nB+K+S\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.01\n";
    expect_certified(die, 6000);
    ProofOptions options;
    EXPECT_EQ(prove(surface_of(die), options), "") << normal;
  }
}

// A part moved by 1e6 has the same elements, curves and corners, but for the rounding of its own
// coordinates, 1e-10 there; how many triangles it takes may hang on that. What is a thousandth of a
// millimetre has only a few digits there.
TEST(DegenerateDies, MovedByAMillionTheyAreTheSame) {
  std::size_t compared = 0, skipped = 0;
  for (const NamedCase& given : named_cases()) {
    if (given.name == "ThousandthOfAMillimetre") {
      ++skipped;
      continue;
    }
    // In how many stretches of some 1e-5 mm two silhouettes that touch change places hangs on
    // rounding.
    if (given.name.find("Rounded") == 0 || given.name.find("Rib") != std::string::npos) {
      ++skipped;
      continue;
    }
    const std::string& name = given.name;
    TessellationOptions options;
    options.tolerance = given.tolerance;
    const Result<Tessellation> near = tessellate(surface_of(given.text), options);
    const Result<Tessellation> far = tessellate(surface_of(moved(given.text, 1e6)), options);
    EXPECT_TRUE(near) << name;
    EXPECT_TRUE(far) << name << (far ? "" : to_text(far.error()));
    if (!near || !far) continue;
    const auto told = [](const Tessellation& made) {
      std::map<std::string, std::vector<double>> curves;
      for (const CurveReport& c : made.report.curves) {
        const auto [a, b] = std::minmax(c.between[0], c.between[1]);
        curves[std::to_string(static_cast<int>(c.kind)) + (c.closed ? " closed " : " ") + a + '|' +
               b]
            .push_back(c.length);
      }
      for (auto& [key, lengths] : curves) std::sort(lengths.begin(), lengths.end());
      return curves;
    };
    const auto one = told(*near), other = told(*far);
    ASSERT_EQ(one.size(), other.size()) << name;
    for (auto a = one.begin(), b = other.begin(); a != one.end(); ++a, ++b) {
      EXPECT_EQ(a->first, b->first) << name;
      if (name == "BarAlongAnEdge" && a->second.size() == b->second.size() + 1) {
        // What parts the bar's end from the edge has six decimals: no corner a thousand kilometres
        // away, of the same length in all.
        const auto sum = [](const std::vector<double>& v) {
          return std::accumulate(v.begin(), v.end(), 0.0);
        };
        EXPECT_NEAR(sum(a->second), sum(b->second), 3 * given.tolerance) << name << ' ' << a->first;
        continue;
      }
      ASSERT_EQ(a->second.size(), b->second.size()) << name << ' ' << a->first;
      for (std::size_t k = 0; k < a->second.size(); ++k)
        EXPECT_NEAR(a->second[k], b->second[k], 3 * given.tolerance) << name << ' ' << a->first;
    }
    // Where faces touch in a point, whether it is a corner hangs on where the cells lie; and
    // corners closer than the least cell are parted only where coordinates have the digits for it.
    const bool touches =
        name == "ParaboloidsApexOnARidge" || name == "SphereTouchingTheBorderAtTheBasesHeight";
    if (name == "BarAlongALeaningTop" || name == "BarAlongAnEdge") {
      EXPECT_LE(far->report.corner_vertices, near->report.corner_vertices);
      if (name == "BarAlongAnEdge") {
        EXPECT_LE(near->report.corner_vertices, far->report.corner_vertices + 1);
      }
    } else {
      EXPECT_NEAR(static_cast<double>(near->report.corner_vertices),
                  static_cast<double>(far->report.corner_vertices), touches ? 1 : 0)
          << name;
    }
    EXPECT_NEAR(near->report.area, far->report.area, 1e-3 * near->report.area) << name;
    EXPECT_LE(far->report.certified_deviation, given.tolerance) << name;
    // A thousand kilometres away a tie is wider than what parts that wall from that silhouette.
    const double told_most = name == "BarAndBlockOfSixDecimals" ? 1e-6 : 0;
    EXPECT_LE(near->report.uncertified_area, told_most) << name;
    EXPECT_LE(far->report.uncertified_area, told_most) << name;
    EXPECT_EQ(
        prove_case({name, moved(given.text, 1e6), given.tolerance}, MeshScheme::kAdaptive, true),
        "");
    const auto n = static_cast<double>(near->mesh.triangles.size());
    EXPECT_NEAR(static_cast<double>(far->mesh.triangles.size()), n, 0.4 * n + 20) << name;
    ++compared;
  }
  EXPECT_EQ(compared + skipped, named_cases().size());
  EXPECT_EQ(skipped, 6u);
}

INSTANTIATE_TEST_SUITE_P(Named, NamedCases, testing::ValuesIn(named_cases()),
                         [](const testing::TestParamInfo<NamedCase>& of) { return of.param.name; });

}  // namespace
}  // namespace diesink::test
