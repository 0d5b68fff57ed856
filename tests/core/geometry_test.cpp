// Names, face numbers and boxes of bodies.
// SPDX-License-Identifier: Apache-2.0
#include "core/geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/load_part.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

QuadricBody quadric(QuadricShape shape) {
  QuadricBody body;
  body.shape = shape;
  return body;
}

TEST(Geometry, FaceNames) {
  EXPECT_EQ(face_name(quadric(QuadricShape::kCone), kFaceSide), "side");
  EXPECT_EQ(face_name(quadric(QuadricShape::kCone), kFaceBottom), "bottom");
  EXPECT_EQ(face_name(quadric(QuadricShape::kCylinder), kFaceTop), "top");
  EXPECT_EQ(face_name(quadric(QuadricShape::kParaboloid), kFaceSide), "side");
  EXPECT_EQ(face_name(quadric(QuadricShape::kEllipsoid), kFaceSide), "surface");
  EXPECT_EQ(face_name(Polyhedron{}, 5), "face5");
  EXPECT_EQ(face_numbers(quadric(QuadricShape::kCone)), (std::vector<std::uint8_t>{1, 2}));
  EXPECT_EQ(face_numbers(quadric(QuadricShape::kCylinder)), (std::vector<std::uint8_t>{1, 2, 3}));
  EXPECT_EQ(face_numbers(quadric(QuadricShape::kParaboloid)), (std::vector<std::uint8_t>{1, 3}));
  EXPECT_EQ(face_numbers(quadric(QuadricShape::kEllipsoid)), (std::vector<std::uint8_t>{1}));
}

// A point of a quadric body's surface: t in [0, 1] from P1's end to the other, angle round the
// axis.
Vec3 surface_point(const QuadricBody& q, double t, double angle) {
  double radius = 1, w = t * q.C;
  switch (q.shape) {
    case QuadricShape::kCone:
      radius = 1 - t;
      break;
    case QuadricShape::kCylinder:
      break;
    case QuadricShape::kParaboloid:
      radius = std::sqrt(w);
      break;
    case QuadricShape::kEllipsoid:
      radius = std::sin(t * std::numbers::pi);
      w = -q.C * std::cos(t * std::numbers::pi);
      break;
  }
  const Vec3 local(radius * q.A * std::cos(angle), radius * q.B * std::sin(angle), w);
  return q.p + q.frame.transpose() * local;
}

TEST(Geometry, BoxesEncloseAndTouch) {
  int seen = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const PartProgram program = test::program_of(test::random_part_program(seed));
    for (const Solid& solid : program.solids) {
      const std::array<Vec3, 2> box = bounds_of(solid.body);
      const double size = (box[1] - box[0]).norm();
      Vec3 low = Vec3::Constant(INFINITY), high = -low;
      const auto add = [&](const Vec3& p) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      };
      if (const QuadricBody* q = std::get_if<QuadricBody>(&solid.body)) {
        constexpr int kSteps = 240;
        for (int i = 0; i <= kSteps; ++i) {
          for (int j = 0; j < kSteps; ++j) {
            add(surface_point(*q, i / double{kSteps}, j * 2 * std::numbers::pi / kSteps));
          }
        }
        ++seen;
      } else {
        for (const Vec3& v : std::get<Polyhedron>(solid.body).vertices) add(v);
      }
      for (int k = 0; k < 3; ++k) {
        EXPECT_LE(box[0][k], low[k] + 1e-13 * size) << seed << ' ' << solid.id << ' ' << solid.type;
        EXPECT_GE(box[1][k], high[k] - 1e-13 * size)
            << seed << ' ' << solid.id << ' ' << solid.type;
        EXPECT_NEAR(box[0][k], low[k], 1e-3 * size) << seed << ' ' << solid.id << ' ' << solid.type;
        EXPECT_NEAR(box[1][k], high[k], 1e-3 * size)
            << seed << ' ' << solid.id << ' ' << solid.type;
      }
    }
  }
  EXPECT_GT(seen, 200);
}

TEST(Geometry, BoxesOfUprightBodiesAreExact) {
  const PartProgram program = test::program_of(
      "SOLID-DEF\nK,R-CYLI,2\nP1,20,20,-1\nNOR,0,0,1\nRAD,15\nLEN,6\nC,R-CONE,1\nP1,1,2,9\nP2,1,2,"
      "4\nRAD,3\n"
      "S,SPHER\nP1,.1,.2,.3\nRAD,.5\nM,PARAB,2\nP1,0,0,1\nNOR,0,0,2\nFOC,1\nLEN,4\n"
      "BOOLE-DEF\nK+C+S+M\n");
  const auto expect_box = [&](std::size_t solid, const Vec3& low, const Vec3& high) {
    const std::array<Vec3, 2> box = bounds_of(program.solids[solid].body);
    EXPECT_EQ(box[0], low);
    EXPECT_EQ(box[1], high);
  };
  expect_box(0, {5, 5, -1}, {35, 35, 5});
  expect_box(1, {-2, -1, 4}, {4, 5, 9});
  expect_box(2, {0.1 - 0.5, 0.2 - 0.5, 0.3 - 0.5}, {0.1 + 0.5, 0.2 + 0.5, 0.3 + 0.5});
  expect_box(3, {-4, -4, 1}, {4, 4, 5});
}

}  // namespace
}  // namespace diesink
