// SPDX-License-Identifier: Apache-2.0
#include "core/geometry.h"

#include <cmath>

namespace diesink {

std::string face_name(const Body& body, std::uint8_t number) {
  if (std::holds_alternative<Polyhedron>(body)) return "face" + std::to_string(number);
  if (number == kFaceBottom) return "bottom";
  if (number == kFaceTop) return "top";
  return std::get<QuadricBody>(body).shape == QuadricShape::kEllipsoid ? "surface" : "side";
}

std::vector<std::uint8_t> face_numbers(const Body& body) {
  std::vector<std::uint8_t> numbers;
  if (const Polyhedron* polyhedron = std::get_if<Polyhedron>(&body)) {
    for (const PolyhedronFace& face : polyhedron->faces) numbers.push_back(face.number);
    return numbers;
  }
  switch (std::get<QuadricBody>(body).shape) {
    case QuadricShape::kEllipsoid:
      return {kFaceSide};
    case QuadricShape::kCone:
      return {kFaceSide, kFaceBottom};
    case QuadricShape::kCylinder:
      return {kFaceSide, kFaceBottom, kFaceTop};
    case QuadricShape::kParaboloid:
      return {kFaceSide, kFaceTop};
  }
  return numbers;
}

std::array<Vec3, 2> bounds_of(const Body& body) {
  std::array<Vec3, 2> box;
  if (const Polyhedron* polyhedron = std::get_if<Polyhedron>(&body)) {
    box = {polyhedron->vertices.front(), polyhedron->vertices.front()};
    for (const Vec3& v : polyhedron->vertices) {
      box[0] = box[0].cwiseMin(v);
      box[1] = box[1].cwiseMax(v);
    }
    return box;
  }
  const QuadricBody& q = std::get<QuadricBody>(body);
  for (int k = 0; k < 3; ++k) {
    // The direction e_k in the local frame: the support function of the body along it.
    const double u = q.frame(0, k), v = q.frame(1, k), w = q.frame(2, k);
    const double disc = std::hypot(q.A * u, q.B * v);  // of the rim ellipse
    double lo = 0, hi = 0;
    switch (q.shape) {
      case QuadricShape::kEllipsoid: {
        hi = std::hypot(disc, q.C * w);
        lo = -hi;
        break;
      }
      case QuadricShape::kCylinder:
        lo = std::fmin(0, q.C * w) - disc;
        hi = std::fmax(0, q.C * w) + disc;
        break;
      case QuadricShape::kCone:
        lo = std::fmin(-disc, q.C * w);
        hi = std::fmax(disc, q.C * w);
        break;
      case QuadricShape::kParaboloid: {
        // Support over rim and over the surface point whose normal is the direction.
        const double radial = q.A * std::hypot(u, v);
        const auto support = [&](double s) {
          const double rim = s * w * q.C + radial * std::sqrt(q.C);
          if (s * w >= 0) return rim;
          const double root =
              radial / (-2 * s * w);  // sqrt of local height where the normal matches
          return root * root <= q.C ? radial * root + s * w * root * root : rim;
        };
        hi = support(1);
        lo = -support(-1);
        break;
      }
    }
    box[0][k] = q.p[k] + lo;
    box[1][k] = q.p[k] + hi;
  }
  return box;
}

}  // namespace diesink
