// Points of faces and distances to them by ways of their own, for tests of charts and bounds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/compound/compound_impl.h"
#include "core/compound/compound_surface.h"
#include "core/part_program/part_program.h"
#include "tests/support/random_program.h"

namespace diesink::test {

inline CompoundSurface surface_of(const std::string& text) {
  Diagnostics diagnostics;
  const std::optional<PartProgram> program = parse_part_program(text, "test.part", diagnostics);
  EXPECT_TRUE(program.has_value()) << text;
  Result<CompoundSurface> surface = CompoundSurface::make(*program);
  EXPECT_TRUE(surface.has_value());
  return std::move(*surface);
}

inline std::string fixture(const std::string& name) {
  std::ifstream file(std::string(DIESINK_SOURCE_DIR "/fixtures/parts/") + name);
  EXPECT_TRUE(file.good()) << name;
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// A face that can be seen from above, on its upper side for an added body and on its lower for a
// subtracted one.
struct SeenFace {
  const CompoundSurface::Impl* surface = nullptr;
  Label label = kNoLabel;
  const BodyLine* body = nullptr;  // null: the base
  bool upper = true;

  [[nodiscard]] int number() const { return face_of(label); }
  [[nodiscard]] bool height(double x, double y, double& z) const {
    if (!body) {
      BaseHit hit;
      const bool there = surface->base_at(x, y, hit);
      z = hit.z;
      return there;
    }
    return body->face_height(static_cast<std::uint8_t>(number()), upper, x, y, z);
  }
  // A point of the face over the body itself; false where this draw met none.
  bool draw(Random& random, Vec3& p) const {
    PlanBox box;
    if (body) {
      box = body->plan_box();
    } else {
      const Machining& m = surface->program.machining;
      box = {m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]};
    }
    const double x = random.uniform(box.x0, box.x1), y = random.uniform(box.y0, box.y1);
    double z = 0;
    if (body) {
      LineHit hit;
      if (!body->meet(x, y, hit)) return false;
      if ((upper ? hit.upper_face : hit.lower_face) != number()) return false;
    }
    if (!height(x, y, z)) return false;
    p = Vec3(x, y, z);
    return true;
  }
};

inline std::vector<SeenFace> seen_faces(const CompoundSurface& surface) {
  const CompoundSurface::Impl& impl = surface.impl();
  std::vector<SeenFace> faces;
  Random random(5);
  for (int row = 0; row < surface.row_count(); ++row) {
    const int solid = surface.surface_of_row(row) - 1;
    SeenFace face;
    face.surface = &impl;
    face.upper = surface.sign_of_row(row) == Sign::kPlus;
    if (solid < 0) {
      face.label = make_label(row, 0);
      faces.push_back(face);
      continue;
    }
    face.body = &impl.bodies[static_cast<std::size_t>(solid)];
    for (const std::uint8_t number : face_numbers(face.body->body())) {
      face.label = make_label(row, number);
      Vec3 p;
      bool seen = false;
      for (int k = 0; k < 300 && !seen; ++k) seen = face.draw(random, p);
      if (seen) faces.push_back(face);
    }
  }
  return faces;
}

// The quadric of a body's side in program coordinates, homogeneous: (r, 1)'Q(r, 1). Built from the
// definition in core/geometry.h and nothing else.
inline Eigen::Matrix4d side_matrix(const QuadricBody& body) {
  Eigen::Matrix4d local = Eigen::Matrix4d::Zero();
  local(0, 0) = 1 / (body.A * body.A);
  local(1, 1) = 1 / (body.B * body.B);
  switch (body.shape) {
    case QuadricShape::kEllipsoid:
      local(2, 2) = 1 / (body.C * body.C);
      local(3, 3) = -1;
      break;
    case QuadricShape::kCylinder:
      local(3, 3) = -1;
      break;
    case QuadricShape::kCone:
      local(2, 2) = -1 / (body.C * body.C);
      local(2, 3) = local(3, 2) = 1 / body.C;
      local(3, 3) = -1;
      break;
    case QuadricShape::kParaboloid:
      local(2, 3) = local(3, 2) = -0.5;
      break;
  }
  Eigen::Matrix4d into = Eigen::Matrix4d::Identity();
  into.topLeftCorner<3, 3>() = body.frame;
  into.topRightCorner<3, 1>() = -body.frame * body.p;
  return into.transpose() * local * into;
}

// Point of the quadric nearest to p, by Newton's method on p - r = t grad F(r), F(r) = 0.
inline Vec3 nearest_on(const Eigen::Matrix4d& q, const Vec3& p) {
  const Mat3 a = q.topLeftCorner<3, 3>();
  const Vec3 b = q.topRightCorner<3, 1>();
  Vec3 r = p;
  for (int k = 0; k < 4; ++k) {  // onto the surface first
    const Vec3 g = 2 * (a * r + b);
    r -= g * ((r.dot(a * r) + 2 * b.dot(r) + q(3, 3)) / g.squaredNorm());
  }
  Vec3 g = 2 * (a * r + b);
  double t = (p - r).dot(g) / g.squaredNorm();
  for (int k = 0; k < 30; ++k) {
    g = 2 * (a * r + b);
    Eigen::Matrix4d m;
    m.topLeftCorner<3, 3>() = Mat3::Identity() + 2 * t * a;
    m.topRightCorner<3, 1>() = g;
    m.bottomLeftCorner<1, 3>() = g.transpose();
    m(3, 3) = 0;
    Eigen::Vector4d rhs;
    rhs.head<3>() = p - r - t * g;
    rhs(3) = -(r.dot(a * r) + 2 * b.dot(r) + q(3, 3));
    const Eigen::Vector4d step = m.fullPivLu().solve(rhs);
    r += step.head<3>();
    t += step(3);
    if (step.head<3>().norm() < 1e-14 * (1 + r.norm())) break;
  }
  return r;
}

}  // namespace diesink::test
