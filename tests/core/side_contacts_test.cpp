// Sides in contact along a curve, and planes tangent to sides.
// SPDX-License-Identifier: Apache-2.0
#include "core/compound/side_contacts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/compound/compound_impl.h"
#include "core/tessellate/deviation.h"
#include "core/tessellate/implicit.h"
#include "core/tessellate/pencil_plane.h"
#include "tests/support/load_part.h"
#include "tests/support/named_cases.h"

namespace diesink::test {
namespace {

constexpr double kSlack = 1e-10;  // mm

// The two bodies of a program, and which of them is inside the other.
struct Pair {
  std::vector<BodyLine> bodies;
  bool first_inside = false, second_inside = false;

  explicit Pair(const std::string& solids) {
    const PartProgram program = program_of(on_plane(solids, "+A+C"));
    for (const Solid& solid : program.solids) bodies.emplace_back(solid.body, 0.0);
    SideContacts contacts;
    contacts.build(bodies, kSlack);
    first_inside = contacts.is_inside(0, 1);
    second_inside = contacts.is_inside(1, 0);
  }
};

std::string ellipsoid(const std::string& id, const std::string& axes) {
  return id + ",ELLIP,2\nP1,12,14,2\n" + axes;
}

TEST(SideContacts, TheBallAtTheEndOfABarIsInsideTheBar) {
  for (const char* to : {"28,27,2", "28,14,2", "28,27,9", "12.001,14,9"}) {
    const Pair pair(cylinder("A", "12,14,2", to, "5") + sphere("C", "12,14,2", "5"));
    EXPECT_FALSE(pair.first_inside) << to;
    EXPECT_TRUE(pair.second_inside) << to;
  }
}

TEST(SideContacts, AnEllipsoidInABarOfItsSectionIsInsideIt) {
  const Pair pair(cylinder("A", "2,14,2", "28,14,2", "5") + ellipsoid("C", "A,9\nB,5\nC,5\n"));
  EXPECT_TRUE(pair.second_inside);
  EXPECT_FALSE(pair.first_inside);
}

TEST(SideContacts, ABallTangentToAConeAllAroundIsInsideIt) {
  // Apex (30, 14, 2), half the angle at it 30 degrees: at a distance of 18 the ball has a radius of
  // 9.
  const Pair pair("A,R-CONE,1\nP1,0,14,2\nP2,30,14,2\nRAD,17.320508075688775\n" +
                  sphere("C", "12,14,2", "9"));
  EXPECT_TRUE(pair.second_inside);
  EXPECT_FALSE(pair.first_inside);
}

TEST(SideContacts, OneOfTwoConcentricBallsIsInsideTheOther) {
  const Pair pair(sphere("A", "12,14,2", "5") + sphere("C", "12,14,2", "7"));
  EXPECT_TRUE(pair.first_inside);
  EXPECT_FALSE(pair.second_inside);
}

TEST(SideContacts, WhatCrossesIsNotInside) {
  const std::string bar = cylinder("A", "12,14,2", "28,27,2", "5");
  for (const std::string& other :
       {sphere("C", "12,14,2", "5.000001"), sphere("C", "12,14,2.000001", "5"),
        sphere("C", "20,14,2", "5"), cylinder("C", "12,14,2", "28,14,2", "5"),
        ellipsoid("C", "A,9\nB,5\nC,5\n")}) {
    const Pair pair(bar + other);
    EXPECT_FALSE(pair.first_inside) << other;
    EXPECT_FALSE(pair.second_inside) << other;
  }
}

// Random pairs in contact: no point of the one is outside the other, by evaluating both forms.
TEST(SideContacts, NoPointOfTheInnerOneIsOutside) {
  for (int k = 0; k < 50; ++k) {
    const double turn = 0.13 * k, rise = 0.3 * std::sin(3.0 * k);
    char to[96];
    std::snprintf(to, sizeof to, "%.12f,%.12f,%.12f", 12 + 9 * std::cos(turn),
                  14 + 9 * std::sin(turn), 2 + 9 * rise);
    const Pair pair(cylinder("A", "12,14,2", to, "5") + sphere("C", "12,14,2", "5"));
    ASSERT_TRUE(pair.second_inside) << to;
    const Implicit bar = face_implicit(pair.bodies[0], kFaceSide);
    for (int n = 0; n < 200; ++n) {
      const double u = 0.7 * n, h = std::cos(1.1 * n);
      const Vec3 p = Vec3(12, 14, 2) + 5 * Vec3(std::sqrt(1 - h * h) * std::cos(u),
                                                std::sqrt(1 - h * h) * std::sin(u), h);
      EXPECT_LE(bar.value(p), 1e-12) << to;
    }
  }
}

TEST(TangentPlanes, PassABarAboveAndBelow) {
  const Pair pair(cylinder("A", "12,14,2", "28,27,2", "5") + sphere("C", "0,0,0", "1"));
  const BodyLine& bar = pair.bodies[0];
  EXPECT_EQ(side_of_tangent_plane(bar, {13, 15, 7}, 0, 0, {3, 3}, kSlack), 1);
  EXPECT_EQ(side_of_tangent_plane(bar, {13, 15, -3}, 0, 0, {3, 3}, kSlack), -1);
  EXPECT_EQ(side_of_tangent_plane(bar, {13, 15, 6.999999}, 0, 0, {3, 3}, kSlack), 0);
  // Clear of it by more than nothing it still does not cross.
  EXPECT_EQ(side_of_tangent_plane(bar, {13, 15, 7.000001}, 0, 0, {3, 3}, kSlack), 1);
  EXPECT_EQ(side_of_tangent_plane(bar, {13, 15, 7}, 0.01, 0, {3, 3}, kSlack), 0);
}

TEST(TangentPlanes, OfAConeAreNotToldBeyondItsApex) {
  // A cone lying along x: a plane touches it along its top ruling from above, and the mirrored
  // nappe from below.
  const Pair pair("A,R-CONE,1\nP1,10,14,2\nP2,30,14,2\nRAD,15\n" + sphere("C", "0,0,0", "1"));
  const BodyLine& body = pair.bodies[0];
  const double slope = 15.0 / 20;
  EXPECT_EQ(side_of_tangent_plane(body, {20, 14.1, 2 + 10 * slope}, -slope, 0, {1, 1}, kSlack), 1);
  EXPECT_EQ(side_of_tangent_plane(body, {40, 14.1, 2 - 10 * slope}, -slope, 0, {1, 1}, kSlack), 0);
  EXPECT_EQ(side_of_tangent_plane(body, {20, 14.1, 2 - 10 * slope}, slope, 0, {1, 1}, kSlack), -1);
}

// Whatever is told of planes that touch, cut or miss a leaning side holds at every point about
// where that has heights, by evaluating it there.
TEST(TangentPlanes, PassWhereTheyAreToldTo) {
  const Pair cone(
      "A,E-CONE,2\nP1,4,84,10\nNOR,3.33,3.72,.1\nLVE,.116,.131,1.004\nL-R,13.4\nS-R,7.9\nLEN,15."
      "8\n" +
      sphere("C", "0,0,0", "1"));
  const Pair bar(cylinder("A", "4,84,10", "15,95,13", "6") + sphere("C", "0,0,0", "1"));
  int told = 0;
  for (const Pair* pair : {&cone, &bar}) {
    const BodyLine& body = pair->bodies[0];
    for (int n = 0; n < 4000; ++n) {
      const double x = 24 * std::fabs(std::sin(1.7 * n)),
                   y = 75 + 25 * std::fabs(std::sin(2.9 * n));
      const double z = -15 + 45 * std::fabs(std::cos(0.7 * n)), reach = 0.3 + 0.03 * (n % 700);
      const double zx = 0.8 * std::sin(5.3 * n), zy = 0.8 * std::cos(4.1 * n);
      const int sign = side_of_tangent_plane(body, {x, y, z}, zx, zy, {reach, reach}, kSlack);
      if (sign == 0) continue;
      ++told;
      for (int k = 0; k < 100; ++k) {
        const double dx = reach * std::sin(1.3 * k) * 0.7, dy = reach * std::cos(2.1 * k) * 0.7;
        for (const bool upper : {true, false}) {
          double height = 0;
          if (!body.face_height(kFaceSide, upper, x + dx, y + dy, height) ||
              height > body.z_high() || height < body.z_low())
            continue;
          ASSERT_GE(sign * (z + zx * dx + zy * dy - height), -1e-9) << n << ' ' << sign;
        }
      }
    }
  }
  EXPECT_GT(told, 100);
}

// Two bars of one thickness meet in two ellipses; the plane of one of them holds its points.
TEST(PencilPlanes, HoldTheBranchOfTwoEqualBars) {
  const Pair pair(cylinder("A", "0,20,3", "40,20,3", "8") +
                  cylinder("C", "20,0,3", "20,40,3", "8"));
  const Implicit f = face_implicit(pair.bodies[0], kFaceSide),
                 g = face_implicit(pair.bodies[1], kFaceSide);
  const auto point = [](double angle) {  // of the branch over x - 20 = y - 20
    return Vec3(20 + 8 * std::cos(angle), 20 + 8 * std::cos(angle), 3 + 8 * std::sin(angle));
  };
  const auto plane = pencil_plane(f, g, point(1.2), point(1.7));
  ASSERT_TRUE(plane);
  for (const double angle : {0.1, 0.9, 1.5, 2.9}) EXPECT_NEAR(plane->value(point(angle)), 0, 1e-12);
  // Over the point where the branches cross both surfaces have one tangent plane; the bound holds.
  double farthest = 0;
  const Vec3 a = point(1.55), b = point(1.5907963267948966);
  for (int k = 0; k <= 100; ++k) {
    const Vec3 p = point(1.55 + 0.0407963267948966 * k / 100), chord = (b - a).normalized();
    farthest = std::fmax(farthest, ((p - a) - chord * chord.dot(p - a)).norm());
  }
  const double bound = chord_deviation({f, g}, a, b);
  EXPECT_GE(bound, farthest);
  EXPECT_LE(bound, 1.2 * farthest);
  // Points of two branches have no such plane.
  const Vec3 other(20 + 8 * std::cos(1.7), 20 - 8 * std::cos(1.7), 3 + 8 * std::sin(1.7));
  EXPECT_FALSE(pencil_plane(f, g, point(1.2), other));
}

TEST(PencilPlanes, AreNotFoundOfOtherBars) {
  const Pair pair(cylinder("A", "0,20,3", "40,20,3", "8") +
                  cylinder("C", "20,0,3", "20,40,3", "7.999"));
  const Implicit f = face_implicit(pair.bodies[0], kFaceSide),
                 g = face_implicit(pair.bodies[1], kFaceSide);
  const auto point = [](double y) {  // of both
    const double z = std::sqrt(64 - y * y);
    return Vec3(20 + std::sqrt(7.999 * 7.999 - z * z), 20 + y, 3 + z);
  };
  EXPECT_FALSE(pencil_plane(f, g, point(1), point(1.5)));
}

}  // namespace
}  // namespace diesink::test
