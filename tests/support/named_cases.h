// The degenerate dies by name: what touches, coincides, fades or is thin. Each a part program.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

namespace diesink::test {

struct NamedCase {
  std::string name;
  std::string text;
  double tolerance = 0.01;
};

inline void PrintTo(const NamedCase& c, std::ostream* out) { *out << c.name; }

// A program on the plane z = 0 over [x0, x1] x [y0, y1]; `expression` goes on after B.
inline std::string on_plane(const std::string& solids, const std::string& expression,
                            const std::string& x_range = "0,40",
                            const std::string& y_range = "0,40") {
  return "SOLID-DEF\n" + solids + "BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB" + expression +
         "\nMACHI-DEF\nX-RNG," + x_range + "\nY-RNG," + y_range + "\nTOLER,.01\n";
}

inline std::string sphere(const std::string& id, const std::string& centre,
                          const std::string& radius) {
  return id + ",SPHER,1\nP1," + centre + "\nRAD," + radius + "\n";
}
inline std::string box(const std::string& id, const std::string& low, const std::string& high) {
  return id + ",4-PRIS,3\nP1," + low + "\nP2," + high + "\n";
}
inline std::string cylinder(const std::string& id, const std::string& from, const std::string& to,
                            const std::string& radius) {
  return id + ",R-CYLI,1\nP1," + from + "\nP2," + to + "\nRAD," + radius + "\n";
}
inline std::string cone(const std::string& id, const std::string& base, const std::string& apex,
                        const std::string& radius) {
  return id + ",R-CONE,1\nP1," + base + "\nP2," + apex + "\nRAD," + radius + "\n";
}

// A block from z = -5 to 9 about (20, 20), turned, whose edges are rounded by 2: three blocks, and
// a bar and a ball at each corner. `sign` + adds it; - makes the pocket, down to z = -9.
inline std::string rounded_block(double turn, char sign) {
  std::string solids;
  const auto at = [&](double x, double y, double z) {
    const double c = std::cos(turn), s = std::sin(turn);
    char text[96];
    std::snprintf(text, sizeof text, "%.12f,%.12f,%.12f", 20 + c * x - s * y, 20 + s * x + c * y,
                  sign == '+' ? z : -z);
    return std::string(text);
  };
  const auto block = [&](const char* id, double x, double y, double high) {
    solids += std::string(id) + ",4-PRIS,2\nP1," + at(-x, -y, -5) + "\nP2," + at(x, -y, -5) +
              "\nP3," + at(x, y, -5) + "\nP4," + at(-x, y, -5) + "\nHEI," +
              std::to_string(sign == '+' ? high + 5 : -high - 5) + "\n";
  };
  block("L", 8, 6, 7);
  block("W", 10, 4, 7);
  block("T", 8, 4, 9);
  const double corners[5][2] = {{-8, -4}, {8, -4}, {8, 4}, {-8, 4}, {-8, -4}};
  for (int k = 0; k < 4; ++k) {
    const std::string number = std::to_string(k);
    const double *p = corners[k], *q = corners[k + 1];
    solids += cylinder("U" + number, at(p[0], p[1], -5), at(p[0], p[1], 7), "2") +
              sphere("S" + number, at(p[0], p[1], 7), "2") +
              cylinder("E" + number, at(p[0], p[1], 7), at(q[0], q[1], 7), "2");
  }
  return solids;
}
inline std::string rounded_block_terms(char sign) {
  std::string terms;
  for (const char* id :
       {"L", "W", "T", "U0", "S0", "E0", "U1", "S1", "E1", "U2", "S2", "E2", "U3", "S3", "E3"})
    terms += std::string(1, sign) + id;
  return terms;
}

// On a rectangle from (x0, y0) to (x1, y1) at z = 0.
inline std::string pyramid(const std::string& id, const std::array<int, 4>& plan, int height) {
  const std::string x0 = std::to_string(plan[0]), y0 = std::to_string(plan[1]),
                    x1 = std::to_string(plan[2]), y1 = std::to_string(plan[3]);
  return id + ",PYRAM,2\nP1," + x0 + "," + y0 + ",0\nP2," + x1 + "," + y0 + ",0\nP3," + x1 + "," +
         y1 + ",0\nP4," + x0 + "," + y1 + ",0\nHEI," + std::to_string(height) + "\n";
}

// The wall leaves the bar's silhouette by a few 1e-8 at one end.
inline std::string bar_and_block_of_six_decimals() {
  return "SOLID-DEF\nA,R-CYLI,1\nP1,40,30,0\nP2,64.748737,54.748737,0\nRAD,1.25\n"
         "K,4-PRIS,2\nP1,40.883883,29.116117,-10\nP2,65.632621,53.864854,-10\n"
         "P3,63.864854,55.632621,-10\nP4,39.116117,30.883883,-10\nHEI,10\n"
         "BSURF-DEF\nPLANE\nP1,0,0,0\nNOR,.1,0,1\nBOOLE-DEF\nB+A+K\n"
         "MACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\nTOLER,.05\n";
}

// The numbers of a part program as a drawing has them: walls and silhouettes that are one line lie
// up to a millionth of a millimetre apart.
inline std::string with_six_decimals(const std::string& text) {
  std::string out, field;
  for (const char c : text) {
    if (c != ',' && c != '\n') {
      field += c;
      continue;
    }
    char* end = nullptr;
    const double value = std::strtod(field.c_str(), &end);
    if (*end == '\0' && field.find('.') != std::string::npos) {
      std::array<char, 40> rounded{};
      std::snprintf(rounded.data(), rounded.size(), "%.6f", value);
      field = rounded.data();
    }
    out += field + c;
    field.clear();
  }
  return out + field;
}

inline std::vector<NamedCase> named_cases() {
  const auto steinmetz = [](const std::string& radius) {
    return on_plane(
        cylinder("A", "5,20,0", "35,20,0", "8") + cylinder("C", "20,5,0", "20,35,0", radius),
        "+A+C");
  };
  return {
      {"SphereOnPlane", on_plane(sphere("S", "20,20,8", "8"), "+S")},
      {"SphereUnderPlane", on_plane(sphere("S", "20,20,-8", "8"), "+S")},
      {"SphereTopFlushWithPlaneSubtracted", on_plane(sphere("S", "20,20,8", "8"), "-S")},
      {"HemisphereBoss", on_plane(sphere("S", "20,20,0", "8"), "+S")},
      {"HemispherePocket", on_plane(sphere("S", "20,20,0", "8"), "-S")},
      {"SpheresSideBySide",
       on_plane(sphere("S", "12,20,0", "8") + sphere("T", "28,20,0", "8"), "+S+T")},
      {"SphereInSphereTouching",
       on_plane(sphere("S", "20,20,0", "8") + sphere("T", "20,20,4", "4"), "+S+T")},
      {"SameSphereTwice",
       on_plane(sphere("S", "20,20,0", "8") + sphere("T", "20,20,0", "8"), "+S+T")},
      {"ConeAndItsSphereTwice",
       on_plane(cone("K", "20,20,0", "22,24,9", "8") + sphere("S", "20,20,0", "7"), "+K+S+S")},
      {"PocketFilledUpAgain",
       on_plane(cylinder("A", "12,20,-4", "13,26,6", "8") + box("P", "16,9,1", "35,30,9"),
                "+A-P+A")},
      {"CutTwice",
       on_plane(cylinder("A", "20,20,-3", "20,24,5", "9") + cone("K", "20,20,8", "22,20,-6", "12") +
                    box("S", "9,16,-1", "19,26,6"),
                "+A-K+S-K")},
      {"BaseAgainAfterACut", on_plane(sphere("S", "20,20,2", "9"), "-S+B+S-S")},
      {"CylindersSideBySide",
       on_plane(cylinder("A", "5,12,0", "35,12,0", "8") + cylinder("C", "5,28,0", "35,28,0", "8"),
                "+A+C")},
      {"CylinderOnCylinder",
       on_plane(cylinder("A", "5,20,0", "35,20,0", "6") + cylinder("C", "20,5,9", "20,35,9", "3"),
                "+A+C")},
      {"CylinderLyingOnPlane", on_plane(cylinder("A", "5,20,6", "35,20,6", "6"), "+A")},
      {"Steinmetz", steinmetz("8")},
      {"SteinmetzJustSmaller", steinmetz("7.9999999")},
      {"SteinmetzJustLarger", steinmetz("8.0000001")},
      {"SteinmetzPocket",
       on_plane(cylinder("A", "5,20,0", "35,20,0", "8") + cylinder("C", "20,5,0", "20,35,0", "8"),
                "-A-C")},
      {"FlushBoxes",
       on_plane(box("A", "5,5,-1", "20,20,4") + box("C", "20,5,-1", "35,20,4"), "+A+C")},
      {"OverlappingFlushBoxes",
       on_plane(box("A", "5,5,-1", "20,20,4") + box("C", "12,12,-1", "35,30,4"), "+A+C")},
      {"StackedBoxes",
       on_plane(box("A", "5,5,-1", "30,30,4") + box("C", "10,10,4", "20,20,8"), "+A+C")},
      {"TopFlushWithPlane", on_plane(box("A", "5,5,-4", "30,30,0"), "+A")},
      {"PocketFloorFlushWithPlane", on_plane(box("A", "5,5,0", "30,30,4"), "-A")},
      {"BoxesMeetingInAnEdge",
       on_plane(box("A", "5,5,-1", "20,20,4") + box("C", "20,20,-1", "35,35,6"), "+A+C")},
      {"PocketsMeetingInACorner",
       on_plane(box("A", "5,5,-3", "20,20,4") + box("C", "20,20,-5", "35,35,6"), "-A-C")},
      {"ConcentricCylinders", on_plane(cylinder("A", "20,20,-1", "20,20,4", "10") +
                                           cylinder("C", "20,20,-1", "20,20,8", "10"),
                                       "+A+C")},
      {"CylinderFlushInPocket", on_plane(cylinder("A", "20,20,-6", "20,20,4", "10") +
                                             cylinder("C", "20,20,-8", "20,20,-3", "10"),
                                         "-A+C")},
      // The bar's silhouette runs on under the block's side and ends in the midst of it.
      {"BarAsWideAsTheBlock",
       on_plane(box("P", "8,17,-4", "20.5,34,8") + cylinder("A", "8,3,2", "8,23.3,2", "12.5"),
                "+P-A")},
      {"WallsOnTheBorder",
       on_plane(box("A", "0,0,-1", "20,20,4") + box("C", "30,10,-1", "40,40,3"), "+A+C")},
      // (Lines of the grid are 0.4 apart.)
      {"WallsAndRimsOnGridLines",
       on_plane(box("A", "8,8,-1", "24,20,4") + cylinder("C", "28,28,-1", "28,28,5", "4") +
                    box("D", "12,24,-2", "20,32,3"),
                "+A+C-D")},
      {"SpheresTouchingRoundAHole",
       on_plane(sphere("R", "14,14,0", "6") + sphere("S", "26,14,0", "6") +
                    sphere("T", "14,26,0", "6") + sphere("U", "26,26,0", "6"),
                "+R+S+T+U")},
      {"RimThroughTheBorder", on_plane(cylinder("A", "40,20,-1", "40,20,5", "8"), "+A")},
      {"RimTouchingTheBorder", on_plane(cylinder("A", "32,20,-1", "32,20,5", "8"), "+A")},
      {"SphereOverTheBorder", on_plane(sphere("A", "40,40,0", "9"), "+A")},
      {"ConeApexUp", on_plane(cone("K", "20,20,0", "20,20,12", "9"), "+K")},
      {"ConeApexDownPocket", on_plane(cone("K", "20,20,1", "20,20,-9", "9"), "-K")},
      // Its lowest ruling is upright: all heights below the apex lie over one another.
      {"ConeWithAnUprightRuling",
       on_plane(cone("K", "15,20,-5", "25,20,5", "14.142135623730951"), "+K")},
      // Its rim is seen down to where it touches that ruling.
      {"RimOfAConeWithAnUprightRuling",
       "SOLID-DEF\n" + cone("K", "15,20,-5", "25,20,5", "14.142135623730951") +
           "BSURF-DEF\nPLANE,-30\nBOOLE-DEF\nB+K\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\n"
           "TOLER,.05\n",
       0.05},
      // Its apex stands out over the rim by a hair: two rulings all but upright side by side.
      {"ConeApexOutByAHair",
       "SOLID-DEF\n" + cone("K", "15,20,-5", "22.0711,27.0711,5", "14.1421") +
           "BSURF-DEF\nPLANE,-30\nBOOLE-DEF\nB+K\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\n"
           "TOLER,.05\n",
       0.05},
      {"ConeWithARulingAlmostUpright", on_plane(cone("K", "15,20,-5", "25,20,5", "14.13"), "+K")},
      {"PocketOfAConeWithAnUprightRuling",
       on_plane(cone("K", "15,20,5", "25,20,-5", "14.142135623730951"), "-K")},
      {"ConeApexOnPlane", on_plane(cone("K", "20,20,-9", "20,20,0", "9"), "+K")},
      {"ConeApexOnTheBorder", on_plane(cone("K", "40,20,0", "40,20,12", "9"), "+K")},
      {"ConeLying", on_plane(cone("K", "8,20,0", "32,20,0", "8"), "+K")},
      {"ConeLeaningWithOverhang", on_plane(cone("K", "8,20,2", "32,24,9", "6"), "+K")},
      {"ThreeSpheresThroughOnePoint",
       on_plane(sphere("R", "26,20,0", "10") + sphere("S", "17,25.196152422706632,0", "10") +
                    sphere("T", "17,14.803847577293368,0", "10"),
                "+R+S+T")},
      // Bars, balls and blocks tangent to one another, as round edges are made of.
      {"RoundedBoss", on_plane(rounded_block(0, '+'), rounded_block_terms('+'))},
      {"RoundedBossTurned", on_plane(rounded_block(0.7, '+'), rounded_block_terms('+'))},
      {"RoundedPocketTurned", on_plane(rounded_block(0.3, '-'), rounded_block_terms('-'))},
      {"RibWithABallEnd",
       on_plane(cylinder("A", "12,14,2", "28,27,2", "5") + sphere("S", "12,14,2", "5"), "+S+A")},
      {"LeaningRibWithBallEnds",
       on_plane(cylinder("A", "10,20,1", "30,20,4", "5") + sphere("S", "10,20,1", "5") +
                    sphere("T", "30,20,4", "5"),
                "+A+S+T")},
      {"BarAndBlockOfSixDecimals", bar_and_block_of_six_decimals(), 0.05},
      {"DiscCutByABarAsWide", on_plane(cylinder("A", "20,20,-1", "20,20,10", "8") +
                                           cylinder("C", "5,14,10", "35,26,10", "8"),
                                       "+A-C")},
      {"FourRidgesInOnePoint",
       on_plane(cylinder("A", "5,20,0", "35,20,0", "6") + cylinder("C", "20,5,0", "20,35,0", "6") +
                    cylinder("D", "8,8,0", "32,32,0", "6"),
                "+A+C+D")},
      {"PyramidsMeetingInAnApex",
       on_plane("P,PYRAM,1\nP1,10,10,0\nP2,30,10,0\nP3,30,30,0\nP4,10,30,0\nP5,20,20,8\n" +
                    sphere("S", "20,20,0", "8"),
                "+P+S")},
      {"FadingJump", on_plane(cylinder("A", "5,20,2", "35,20,-3", "6"), "+A")},
      {"FadingJumpOfASphere",
       on_plane(sphere("S", "20,20,3", "8") + box("A", "5,10,-1", "22,30,3"), "+S+A")},
      // The crease is a hundredth high and half a millimetre long; its ends lie on the rim.
      {"CreaseAHairBesideARim",
       on_plane(sphere("S", "7.875,35.5,1.5", "1.625") + sphere("T", "11.125,35.625,-2", "3.875"),
                "+S+T")},
      {"OverhangOverAStep",
       on_plane(box("A", "5,5,-1", "20,35,3") + cylinder("C", "8,20,6", "34,20,6", "4"), "+A+C")},
      {"NeedleWall", on_plane(box("A", "5,20,-1", "35,20.002,6"), "+A")},
      {"NeedleGap",
       on_plane(box("A", "5,5,-1", "20,35,6") + box("C", "20.001,5,-1", "35,35,6"), "+A+C")},
      {"SliverOfPlaneBetweenCylinders", on_plane(cylinder("A", "20,10,-1", "20,10,5", "9.9995") +
                                                     cylinder("C", "20,30,-1", "20,30,7", "9.9995"),
                                                 "+A+C")},
      {"TinySphere", on_plane(sphere("S", "20.123,20.321,0", "0.05"), "+S"), 0.005},
      {"TinyPeg", on_plane(cylinder("A", "7.77,31.3,-1", "7.77,31.3,2", "0.02"), "+A")},
      {"TinySlot", on_plane(box("A", "3,17.01,-2", "37,17.05,3"), "-A")},
      {"IslandInAPocket", on_plane(sphere("S", "20,20,4", "12") +
                                       cylinder("A", "20.2,20.1,-20", "20.2,20.1,-6", "0.1"),
                                   "-S+A")},
      {"DrilledThroughADome",
       on_plane(sphere("S", "20,20,0", "12") + cylinder("A", "20,20,-3", "20,20,30", "4"), "+S-A")},
      {"GrooveAcrossADome",
       on_plane(sphere("S", "20,20,0", "12") + cylinder("A", "0,20,11", "40,20,11", "3"), "+S-A")},
      {"PlanShadowsTouchInAPoint", on_plane(cylinder("A", "12,20,-1", "12,20,5", "8") +
                                                cylinder("C", "28,20,-1", "28,20,5", "8"),
                                            "+A+C")},
      {"ThousandthOfAMillimetre",
       on_plane(sphere("S", ".0004,.0005,0", ".0002") +
                    cylinder("A", ".0005,.0005,-.0001", ".0005,.0005,.0003", ".0001"),
                "+S+A", "0,.001", "0,.001"),
       1e-6},
      {"TenMetres",
       on_plane(sphere("S", "4000,5000,0", "2000") +
                    cylinder("A", "5000,5000,-1000", "5000,5000,3000", "1000"),
                "+S+A", "0,10000", "0,10000"),
       5},
      {"AKilometreAway", on_plane(sphere("S", "1000020,1000020,0", "8") +
                                      cylinder("A", "1000020,1000020,-1", "1000020,1000020,9", "3"),
                                  "+S+A", "1000000,1000040", "1000000,1000040")},
      {"PocketFilledUpFromBelowItsRim",
       on_plane(box("A", "10,10,-5", "30,30,4") + box("C", "5,5,-9", "25,25,-2"), "-A+C")},
      {"DomeInAPocketUnderItsRim",
       on_plane(box("A", "10,10,-5", "30,30,4") + sphere("S", "12,20,-10", "8"), "-A+S")},
      {"GroupCutDownThroughTheBase",
       on_plane(box("A", "5,5,-1", "30,30,6") + box("C", "15,15,-5", "35,25,9") +
                    box("D", "2,2,3", "38,38,9"),
                "+(A-C-D)")},
      {"NoBaseGroupCutToItsBorder",
       "SOLID-DEF\n" + box("A", "2,2,0", "12,12,2") + box("C", "15,5,0", "35,35,6") +
           cylinder("D", "25,20,3", "25,20,9", "12") +
           "BOOLE-DEF\nA+(C-D)\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.01\n"},
      {"NoBaseTwoTouchingDiscs",
       "SOLID-DEF\n" + cylinder("A", "12,20,0", "12,20,5", "8") +
           cylinder("C", "28,20,0", "28,20,5", "8") +
           "BOOLE-DEF\nA+C\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.01\n"},
      {"NoBaseSphereOverTheBorder",
       "SOLID-DEF\n" + sphere("A", "38,20,0", "8") +
           "BOOLE-DEF\nA\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.01\n"},
      {"NoBaseBoxOfTheWholeDomain",
       "SOLID-DEF\n" + box("A", "0,0,0", "40,40,5") + sphere("S", "20,20,5", "6") +
           "BOOLE-DEF\nA-S\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.01\n"},
      {"ParaboloidsApexOnARidge",
       on_plane("A,PARAB,1\nP1,10,15,5\nP2,10,15,-5\nRAD,5\nC,3-PRIS,1\nP1,5,10,0\nP2,5,20,0\n"
                "P3,5,15,5\nP4,15,10,0\nP5,15,20,0\nP6,15,15,5\n",
                "+A+C")},
      {"EqualSpheresMeetingOnTheBorder",
       on_plane(sphere("A", "20,40,0", "5") + sphere("C", "15,35,0", "5"), "-A+C")},
      {"RimTouchingTheBorderOverASlope",
       "SOLID-DEF\n" + cone("A", "35,10,5", "35,10,15", "10") + sphere("C", "40,5,-5", "5") +
           "BSURF-DEF\nPLANE\nP1,20,20,0\nNOR,1,0,4\nBOOLE-DEF\nB+A-C\nMACHI-DEF\n"
           "X-RNG,0,40\nY-RNG,0,40\nTOLER,.02\n",
       0.02},
      {"PaneThatEndsInACornerOfAPocket",
       "SOLID-DEF\n" + cylinder("A", "15,35,-5", "25,35,-5", "10") +
           "C,PARAB,1\nP1,30,30,0\nP2,30,30,-10\nRAD,10\n"
           "BSURF-DEF\n3,3\n0,0,0\n20,0,5\n40,0,0\n0,20,0\n20,20,0\n40,20,5\n0,40,0\n20,40,5\n"
           "40,40,5\nBOOLE-DEF\nB-A+C\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.02\n",
       0.02},
      {"SphereTouchingTheBorderAtTheBasesHeight",
       "SOLID-DEF\n" + sphere("A", "30,15,0", "10") +
           "BSURF-DEF\n3,3\n0,0,0\n20,0,0\n40,0,0\n0,20,5\n20,20,0\n40,20,0\n0,40,0\n20,40,5\n"
           "40,40,0\nBOOLE-DEF\nB+A\nMACHI-DEF\nTOLER,.02\n",
       0.02},
      {"SphereOnTheBorderTouchingALineOfTheGrid",
       "SOLID-DEF\n" + sphere("A", "0,25,0", "5") + sphere("C", "10,15,-5", "5") +
           "BSURF-DEF\n3,3\n0,0,5\n20,0,0\n40,0,5\n0,20,0\n20,20,0\n40,20,5\n0,40,5\n20,40,5\n"
           "40,40,0\nBOOLE-DEF\nB+C+A\nMACHI-DEF\nTOLER,.02\n",
       0.02},
      // Edges along the border at the base's height, ridges that end in a corner of the domain.
      {"PyramidInTheDomainsCorner", on_plane(pyramid("P", {0, 0, 10, 10}, 6), "+P")},
      {"PyramidInTheOppositeCorner", on_plane(pyramid("P", {30, 30, 40, 40}, 6), "+P")},
      {"PyramidAlongTheBorder", on_plane(pyramid("P", {10, 0, 20, 10}, 6), "+P")},
      {"PyramidHoleInTheDomainsCorner", on_plane(pyramid("P", {0, 0, 10, 10}, -6), "-P")},
      {"TetrahedronInTheDomainsCorner",
       on_plane("T,TETRA,2\nP1,0,0,0\nP2,10,0,0\nP3,0,10,0\nHEI,6\n", "+T")},
      {"PyramidInTheCornerOfAWarpedBase",
       "SOLID-DEF\n" + pyramid("P", {0, 0, 10, 10}, 6) +
           "BSURF-DEF\n3,3\n0,0,0\n20,0,2\n40,0,0\n0,20,0\n20,20,4\n40,20,2\n0,40,0\n"
           "20,40,2\n40,40,1\nBOOLE-DEF\nB+P\nMACHI-DEF\nTOLER,.01\n"},
      // Edges of solids in the base: on its own edge inside the domain, along a line of its grid.
      {"PyramidOnTheEdgeOfAWarpedBase",
       "SOLID-DEF\n" + pyramid("P", {0, 0, 10, 10}, 6) +
           "BSURF-DEF\n3,3\n0,0,0\n20,0,2\n40,0,0\n0,20,0\n20,20,4\n40,20,2\n0,40,0\n"
           "20,40,2\n40,40,1\nBOOLE-DEF\nB+P\nMACHI-DEF\nX-RNG,-1,30\nY-RNG,-1,30\nTOLER,.01\n"},
      {"PyramidHoleAlongALineOfTheGrid",
       "SOLID-DEF\n" + pyramid("P", {20, 35, 30, 45}, 10) + sphere("S", "5,25,-5", "10") +
           "BSURF-DEF\n3,3\n0,0,5\n20,0,0\n40,0,0\n0,20,0\n20,20,0\n40,20,0\n0,40,5\n20,40,0\n"
           "40,40,0\nBOOLE-DEF\nB-P-S\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.02\n",
       0.02},
      // Faces that touch along the domain's border.
      {"CylinderCutTouchingAlongTheBorder",
       on_plane(cylinder("A", "5,40,5", "25,40,5", "5"), "-A")},
      {"CylinderTouchingAlongTheBorderUnderASphere",
       on_plane(cylinder("A", "10,0,-5", "30,0,-5", "5") + sphere("S", "10,5,0", "5"), "+A-S")},
      // Within a tie of the base for far more than a tie of the plan, beside the border.
      {"SphereTouchingTheBorderOverAHollow",
       "SOLID-DEF\n" + sphere("S", "10,10,0", "10") +
           "BSURF-DEF\n3,3\n0,0,0\n20,0,0\n40,0,0\n0,20,5\n20,20,5\n40,20,5\n0,40,0\n20,40,5\n"
           "40,40,0\nBOOLE-DEF\nB+S\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.02\n",
       0.02},
      {"SphereConeAndRimInOnePointOfTheBorder",
       "SOLID-DEF\n" + sphere("S", "40,5,0", "5") + cone("K", "35,5,5", "35,5,-5", "5") +
           "BSURF-DEF\nPLANE\nP1,20,20,0\nNOR,1,1,4\nBOOLE-DEF\nB+S+K\nMACHI-DEF\n"
           "X-RNG,0,40\nY-RNG,0,40\nTOLER,.02\n",
       0.02},
      // Along the domain's border a face is within a tie of the base for far more than a tie of the
      // plan; the end of a prism touches the rim of a hole.
      {"RidgesOnSaddlesOfTheGrid",
       "SOLID-DEF\nP,PARAB,1\nP1,15,25,5\nP2,15,25,-5\nRAD,5\n" + box("A", "35,35,-10", "40,45,5") +
           "C,3-PRIS,1\nP1,10,25,-5\nP2,10,35,-5\nP3,10,30,0\nP4,20,25,-5\nP5,20,35,-5\n"
           "P6,20,30,0\n" +
           cylinder("D", "10,10,0", "10,30,0", "5") +
           "BSURF-DEF\n3,3\n0,0,5\n20,0,0\n40,0,0\n0,20,0\n20,20,5\n40,20,0\n0,40,0\n20,40,5\n"
           "40,40,5\nBOOLE-DEF\nB-P+A+C+D\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.02\n",
       0.02},
      // The apex stands out in plan: both lines of the silhouette end in it.
      {"ApexOverhanging",
       "SOLID-DEF\nS,ECONE,2\nP1,58.973,54.625,1.4625\nNOR,.7198,-1.18751,.51733\n"
       "LVE,.98414,.30458,.05892\nL-R,18.01308\nS-R,5.2536\nLEN,20.07227\nBSURF-DEF\n"
       "PLANE\nP1,50,50,-.67124\nNOR,.12319,.18827,1\nBOOLE-DEF\nB+S\nMACHI-DEF\n"
       "X-RNG,0,100\nY-RNG,0,100\nTOLER,.1\n",
       0.1},
      // One ruling is nearly upright: what is well-shaped on the cone folds over in plan.
      {"SteepFlank",
       "SOLID-DEF\nS,R-CONE,1\nP1,37.31215,38.36654,-8.99594\n"
       "P2,31.71731,38.64511,-.46972\nRAD,6.75788\nBOOLE-DEF\nS\nMACHI-DEF\n"
       "X-RNG,0,100\nY-RNG,0,100\nTOLER,.01\n",
       0.01},
      // Of one face no more than its border and one chord.
      {"CapAtTheBorder",
       "SOLID-DEF\nS,PARAB,1\nP1,97.25544,74.59558,6.38771\n"
       "P2,106.75407,66.23908,10.69594\nRAD,9.60146\nBOOLE-DEF\nS\nMACHI-DEF\n"
       "X-RNG,0,100\nY-RNG,0,100\nTOLER,.3\n",
       0.3},
      // An edge over a silhouette, lower by 0.02: the wall is 1e-5 long.
      {"WallFadingBesideSilhouette",
       "SOLID-DEF\nS7,PYRAM,1\n"
       "P1,33.355950973282425,38.522092946483326,-2.4380891825013995\n"
       "P2,+28.17867112880189,39.50317947231584,-8.748067426640404\n"
       "P3,18.98346703999738,+39.503673122652536,-2.094125043162193\n"
       "P4,22.358785539690466,38.606748236851395,4.657875876804964\n"
       "P5,30.77362102630215,+33.403661820947725,-1.4571853368195735\nS12,RCYL,2\n"
       "LEN,4.628700460200571\n"
       "NOR,-2.4305727480033763,-1.29540474858829,3.716641180436567\n"
       "P1,19.11162500659742,44.229534067829945,-3.351105953606048\n"
       "RAD,+6.045310849215414\nBOOLE-DEF\nS7+S12\nMACHI-DEF\nX-RNG,0,100\n"
       "Y-RNG,0,100\nTOLER,.01\n",
       0.01},
      // A crease runs along a silhouette, up and down on a steep flank.
      {"FlankBesideSilhouette",
       "SOLID-DEF\nS1,PYRAM\n"
       "P1,11.944171381273827,67.23909893065074,-25.361354794017338\n"
       "P2,11.944171381273827,63.1978466084415,0.6996837078416664\n"
       "P3,11.944171381273827,+86.80084336101956,2.3990337056535154\n"
       "P4,11.944171381273827,102.85533928577937,-14.555398998487762\n"
       "P5,2.8253319438498288,63.232914777063726,-11.978714207793484\nS3,R-CONE,1\n"
       "P1,19.536989296496156,87.26700100930675,-5.289453236322225\n"
       "P2,+8.111512463765324,72.33836199600789,-26.95399191041863\n"
       "RAD,24.865420812250086\nBOOLE-DEF\nS1+S3\nMACHI-DEF\nX-RNG,0,100\n"
       "Y-RNG,0,100\nTOLER,.1\n",
       0.1},
      // The border of the base turns sharply seven times a side.
      {"ZigzagBase",
       "SOLID-DEF\nS1,ECONE,2\nP1,43.089,21.797,-11.712\nNOR,1.3018,0.608,-3.9734\n"
       "LVE,-0.6051,0.8013,0.024\nL-R,12.433\nS-R,6.899\nLEN,32.761\nBSURF-DEF\n2,7\n"
       "-5.75,-0.33,-3.61\n103.74,0.98,9.14\n-4.19,15.94,-1.63\n92.05,16.57,-2.34\n"
       "-2.42,33.57,-1.89\n106.68,33.33,-7.83\n6.25,48.79,-6.61\n99,50.84,-0.44\n"
       "6.12,67.6,2.62\n105.9,65.8,-3.68\n0.79,84.04,8.66\n94.8,82.21,4.35\n"
       "-3,100.46,-3.02\n104.79,99.74,9.69\nBOOLE-DEF\nB-S1\nMACHI-DEF\nX-RNG,0,100\n"
       "Y-RNG,0,100\nTOLER,.1\n",
       0.1},
      // Both sides of a wall swap heights where the ground rises through the block's foot.
      {"FootThroughTheGround",
       "SOLID-DEF\nS5,4-PRIS,3\nP1,30,5,0\nP2,35,25,7.5\nBSURF-DEF\nPLANE\n"
       "P1,50,15.3,0\nNOR,.01,.02,1\nBOOLE-DEF\nB+S5-S5\nMACHI-DEF\nX-RNG,5,95\n"
       "Y-RNG,0,50\nTOLER,.05\n",
       0.05},
      // A leaning block's sides are upright to the last digits of its corners.
      {"LeaningBlock",
       "SOLID-DEF\nS16,4-PRIS,2\nP1,49.26988,70.709847,-2.716129\n"
       "P2,53.052998,84.419248,-2.716129\nP3,33.385539,89.846496,-1.273914\n"
       "P4,29.602421,76.137095,-1.273914\nHEI,3.060118\nBSURF-DEF\nPLANE,0\n"
       "BOOLE-DEF\nB-S16\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\nTOLER,.05\n",
       0.05},
      // The same over a slope: what is seen of the sides is wider than last digits of the block's
      // own.
      {"LeaningBlockOnASlope",
       "SOLID-DEF\nS35,4-PRIS,2\nP1,81.371828,49.510678,-4.334414\n"
       "P2,94.349407,56.777739,-4.334414\nP3,87.797899,68.477477,-2.71676\n"
       "P4,74.820321,61.210416,-2.71676\nHEI,5.664308\nBSURF-DEF\nPLANE\nP1,50,50,0\n"
       "NOR,-0.1,0.05,1\nBOOLE-DEF\nB+S35\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n"
       "TOLER,.01\n",
       0.01},
      // Leaning blocks with their undersides in one plane but for rounding.
      {"LeaningBlocksFlush",
       "SOLID-DEF\nS17,4-PRIS,2\nP1,48.873806,68.744392,-0.721108\n"
       "P2,53.720958,86.309675,-0.721108\nP3,34.053499,91.736924,0.721108\n"
       "P4,29.206347,74.17164,0.721108\nHEI,1.060118\nS18,4-PRIS,2\n"
       "P1,51.328965,70.141641,-0.862132\nP2,55.112084,83.851042,-0.862132\n"
       "P3,31.59834,90.339675,0.862132\nP4,27.815222,76.630274,0.862132\n"
       "HEI,1.060118\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB-S17-S18\nMACHI-DEF\n"
       "X-RNG,0.0,100.0\nY-RNG,0.0,100.0\nTOLER,.05\n",
       0.05},
      // Equal bars mitred in one point: a tie reaches far along their crease.
      {"MitredBars",
       "SOLID-DEF\nS16,R-CYLI,1\nP1,58.646431,16.661939,-2.378105\n"
       "P2,58.646431,44.781696,0.709104\nRAD,4.98435\nS19,R-CYLI,1\n"
       "P1,58.646431,44.781696,0.709104\nP2,49.894022,49.781696,0.709104\n"
       "RAD,4.98435\nBOOLE-DEF\nS16+S19\nMACHI-DEF\nX-RNG,0.0,100.0\nY-RNG,0.0,100.0\n"
       "TOLER,.05\n",
       0.05},
      // A bar along a block's edge, flush with its top but for rounding.
      {"BarAlongAnEdge",
       "SOLID-DEF\nS16,4-PRIS,2\nP1,35.869413,67.0073,-2.582324\n"
       "P2,50.791435,81.929321,-2.582324\nP3,37.965637,94.755119,-2.582324\n"
       "P4,23.043615,79.833097,-2.582324\nHEI,8.075601\nS19,R-CYLI,1\n"
       "P1,35.869413,67.0073,4.493278\nP2,50.791435,81.929321,4.493278\nRAD,1.0\n"
       "BOOLE-DEF\nS16+S19\nMACHI-DEF\nX-RNG,0.0,100.0\nY-RNG,0.0,100.0\nTOLER,.01\n",
       0.01},
      // The same of a block that leans: the side under the edge shows in a sliver of 1e-8 all
      // along it.
      {"BarAlongALeaningEdge",
       "SOLID-DEF\nS4,4-PRIS,2\nP1,74.033031,44.308686,-5.200793\n"
       "P2,74.033031,75.973171,-5.200793\nP3,50.219429,75.973171,-0.522401\n"
       "P4,50.219429,44.308686,-0.522401\nHEI,8.47834\nS13,R-CYLI,1\n"
       "P1,51.2711,75.973171,4.830739\nP2,51.2711,44.308686,4.830739\nRAD,3.022873\n"
       "BOOLE-DEF\nS4+S13\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\nTOLER,.02\n",
       0.02},
      // A bar that rises from the top of a leaning block by last digits, in two lines.
      {"BarAlongALeaningTop",
       "SOLID-DEF\nS1,4-PRIS,2\nP1,73.424954,15.327173,-3.387302\n"
       "P2,93.030056,34.932275,-3.387302\nP3,70.03616,57.926171,1.335643\n"
       "P4,50.431058,38.32107,1.335643\nHEI,10.116828\nS4,R-CYLI,1\n"
       "P1,74.198518,14.55361,4.144961\nP2,93.803619,34.158711,4.144961\nRAD,2.505535\n"
       "BOOLE-DEF\nS1+S4\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\nTOLER,.02\n",
       0.02},
      // A bar whose silhouette is the line in which a leaning top meets it, a hair off the top's
      // own end.
      {"BarBesideALeaningTop",
       "SOLID-DEF\nS2,4-PRIS,2\nP1,48.346662,67.518313,-2.949634\n"
       "P2,68.506549,94.502628,-2.949634\nP3,58.191436,102.209013,-1.782391\n"
       "P4,38.031549,75.224697,-1.782391\nHEI,4.525353\nS7,R-CYLI,1\n"
       "P1,66.563818,91.219623,1.557238\nP2,56.248705,98.926008,2.724481\nRAD,3.79281\n"
       "BOOLE-DEF\nS2+S7\nMACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\nTOLER,.02\n",
       0.02},
      // A cone whose silhouette runs into its rim, over a slope.
      {"ConeAcrossASlope",
       "SOLID-DEF\nS1,E-CONE,2\nP1,404.27,8415.33,1025.76\nNOR,3.3287,3.7216,.0997\n"
       "LVE,.116,.131,1.0037\nL-R,1342.9\nS-R,790.2\nLEN,1581.5\nBSURF-DEF\nPLANE\n"
       "P1,5000,5000,-321.9\nNOR,-.10905,.11893,1\nBOOLE-DEF\nB+S1\nMACHI-DEF\n"
       "X-RNG,0,10000\nY-RNG,0,10000\nTOLER,100\n",
       100},
      // Ellipsoids as thin as the tolerance or less, their edges sharper still.
      {"PancakesOnEdgeCrossing",
       "SOLID-DEF\nE,ELLIP,2\nP1,20,20,0\nA,15\nB,.1\nC,5\nF,ELLIP,2\nP1,20,20,0\nA,.2\nB,12\n"
       "C,6\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+E+F\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.05\n",
       0.05},
      {"SlitOfAPancake", on_plane("E,ELLIP,2\nP1,20,20,-1\nA,.1\nB,10\nC,8\n", "-E")},
      {"PancakeOverNothing",
       "SOLID-DEF\nE,ELLIP,2\nP1,20,20,2.5\nA,1.25\nB,10\nC,10\nBOOLE-DEF\nE\nMACHI-DEF\n"
       "X-RNG,0,40\nY-RNG,0,40\nTOLER,.05\n",
       0.05},
      {"NeedleLying", on_plane("E,ELLIP,2\nP1,20,20,0\nA,15\nB,.02\nC,.03\n", "+E")},
      // The quadric of a cone goes on beyond its apex, where it has the height of the block's top
      // above the place at which its rim touches the block.
      {"RimTouchingABlocksCorner",
       on_plane(cone("K", "25,20,0", "25,20,5", "5") + box("A", "10,20,0", "20,25,10"), "+K+A")},
      // Apexes that stand out over what their rulings, or the border, run into: the vertex there is
      // the apex but for rounding.
      {"LeaningConesApexOnTheBorder", on_plane(cone("K", "20,30,0", "30,40,10", "10"), "+K")},
      {"NarrowConesApexOnTheBorder", on_plane(cone("K", "20,40,0", "25,40,20", "5"), "+K")},
      {"ApexOverARim",
       on_plane(cone("K", "5,5,0", "25,25,20", "20") + cone("L", "15,25,0", "15,25,10", "10"),
                "+K+L")},
      {"ApexOverABlocksCorner",
       on_plane(cone("K", "10,30,0", "20,20,10", "10") + box("A", "-5,0,-1", "20,20,30"), "+K+A")},
  };
}

// The text with every point and range moved in plan.
inline std::string moved(const std::string& text, double by) {
  std::istringstream lines(text);
  std::string out;
  for (std::string line; std::getline(lines, line);) {
    const bool point = line.size() > 2 && line[0] == 'P' && line[1] >= '0' && line[1] <= '9';
    const bool range = line.starts_with("X-RNG") || line.starts_with("Y-RNG");
    // A point of a base's grid.
    const bool node = line.find_first_not_of("-+.,0123456789eED") == std::string::npos &&
                      std::count(line.begin(), line.end(), ',') == 2;
    if (!point && !range && !node) {
      out += line + '\n';
      continue;
    }
    std::istringstream fields(line);
    std::string field;
    for (int k = 0; std::getline(fields, field, ','); ++k) {
      if (k == (node ? 0 : 1) || k == (node ? 1 : 2)) {
        char number[40];
        std::replace(field.begin(), field.end(), 'D', 'E');
        std::snprintf(number, sizeof number, "%.17g", std::stod(field) + by);
        field = number;
      }
      out += (k > 0 ? "," : "") + field;
    }
    out += '\n';
  }
  return out;
}

}  // namespace diesink::test
