// Tetrahedron, prisms and pyramid: corners and faces of the paper's Fig. 7.
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>

#include "core/solids/frame.h"
#include "core/solids/kinds.h"
#include "core/solids/polyhedron.h"

namespace diesink {
namespace {

using enum FieldShape;
using Values = std::span<const FieldValue>;

constexpr FieldKind kPoints[] = {{"P1", kPoint}, {"P2", kPoint}, {"P3", kPoint}, {"P4", kPoint},
                                 {"P5", kPoint}, {"P6", kPoint}, {"P7", kPoint}, {"P8", kPoint}};
constexpr FieldKind kThreeAndHeight[] = {
    {"P1", kPoint}, {"P2", kPoint}, {"P3", kPoint}, {"HEI", kHeight}};
constexpr FieldKind kFourAndHeight[] = {
    {"P1", kPoint}, {"P2", kPoint}, {"P3", kPoint}, {"P4", kPoint}, {"HEI", kHeight}};

constexpr std::span<const FieldKind> points(std::size_t count) { return {kPoints, count}; }

std::vector<Vec3> corners_of(Values values, std::size_t count) {
  std::vector<Vec3> corners;
  for (std::size_t k = 0; k < count; ++k) corners.push_back(values[k].value);
  return corners;
}

// The ring P1.., then the triangles from its edges to the apex behind it.
Result<Body> pyramid(const std::vector<Vec3>& corners) {
  const std::size_t n = corners.size() - 1;
  std::vector<FaceCorners> faces(n + 1);
  const auto index = [](std::size_t k) { return static_cast<std::uint8_t>(k); };
  faces[0].count = index(n);
  for (std::size_t k = 0; k < n; ++k) {
    faces[0].corner[k] = index(k);
    faces[k + 1] = {{index((k + 1) % n), index(k), index(n)}, 3};
  }
  return make_polyhedron(corners, faces);
}

// The ring P1.., the opposite ring, then the sides from P1P2 on.
Result<Body> prism(const std::vector<Vec3>& corners) {
  const std::size_t n = corners.size() / 2;
  std::vector<FaceCorners> faces(n + 2);
  const auto index = [](std::size_t k) { return static_cast<std::uint8_t>(k); };
  faces[0].count = faces[1].count = index(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t next = (k + 1) % n;
    faces[0].corner[k] = index(k);
    faces[1].corner[k] = index(n + (n - k) % n);
    faces[k + 2] = {{index(next), index(k), index(n + k), index(n + next)}, 4};
  }
  return make_polyhedron(corners, faces);
}

// HEI along the right-hand normal of P1, P2, P3.
Result<Vec3> height_vector(Values values) {
  const Vec3 a = values[1].value - values[0].value, b = values[2].value - values[0].value;
  const Vec3 normal = a.cross(b);
  if (normal.norm() <= 1e-12 * a.norm() * b.norm() || a.norm() < kLeastLength ||
      b.norm() < kLeastLength) {
    return Error{ErrorCode::kInput, "P1, P2 and P3 lie on one line; HEI needs a plane to rise from",
                 values[2].where};
  }
  return Vec3(values.back().value[0] * unit(normal));
}

Result<Body> pyramid_corners(Values values) { return pyramid(corners_of(values, values.size())); }
Result<Body> prism_corners(Values values) { return prism(corners_of(values, values.size())); }

Result<Body> pyramid_height(Values values) {
  const Result<Vec3> height = height_vector(values);
  if (!height) return height.error();
  std::vector<Vec3> corners = corners_of(values, values.size() - 1);
  // The mean as an offset from P1: exact where a coordinate is the same all round.
  Vec3 offset = Vec3::Zero();
  for (const Vec3& corner : corners) offset += corner - corners[0];
  corners.push_back(corners[0] + offset / static_cast<double>(corners.size()) + *height);
  return pyramid(corners);
}

Result<Body> prism_height(Values values) {
  const Result<Vec3> height = height_vector(values);
  if (!height) return height.error();
  const std::size_t n = values.size() - 1;
  std::vector<Vec3> corners = corners_of(values, n);
  for (std::size_t k = 0; k < n; ++k) corners.push_back(corners[k] + *height);
  return prism(corners);
}

Result<Body> box(Values values) {
  const Vec3 a = values[0].value, b = values[1].value;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(a[k] - b[k]) >= kLeastLength) continue;
    constexpr const char* kAxes[] = {"x", "y", "z"};
    return Error{ErrorCode::kInput,
                 std::string("P1 and P2 have the same ") + kAxes[k] +
                     "; opposite corners differ in x, y and z",
                 values[1].where};
  }
  return prism({{a[0], a[1], a[2]},
                {b[0], a[1], a[2]},
                {b[0], b[1], a[2]},
                {a[0], b[1], a[2]},
                {a[0], a[1], b[2]},
                {b[0], a[1], b[2]},
                {b[0], b[1], b[2]},
                {a[0], b[1], b[2]}});
}

constexpr SolidOption kTetrahedronOptions[] = {
    {1, points(4), "P1..P4 the corners", &pyramid_corners},
    {2, kThreeAndHeight, "P1..P3 base, HEI height of the apex over the base's centroid",
     &pyramid_height},
};
constexpr SolidOption kTriangularPrismOptions[] = {
    {1, points(6), "P1..P3 one end, P4..P6 the other, P1 joined to P4", &prism_corners},
    {2, kThreeAndHeight, "P1..P3 one end, HEI height", &prism_height},
};
constexpr SolidOption kPyramidOptions[] = {
    {1, points(5), "P1..P4 base, P5 apex", &pyramid_corners},
    {2, kFourAndHeight, "P1..P4 base, HEI height of the apex over the mean of the base's corners",
     &pyramid_height},
};
constexpr SolidOption kRectangularPrismOptions[] = {
    {1, points(8), "P1..P4 one end, P5..P8 the other, P1 joined to P5", &prism_corners},
    {2, kFourAndHeight, "P1..P4 one end, HEI height", &prism_height},
    {3, points(2), "P1 and P2 opposite corners, sides along the axes", &box},
};
constexpr std::string_view kTriangularPrismAliases[] = {"3PRIS", "TPRIS"};
constexpr std::string_view kRectangularPrismAliases[] = {"4PRIS", "RPRIS"};

}  // namespace

const SolidKind kTetrahedron = {"TETRA", {}, "tetrahedron", kTetrahedronOptions};
const SolidKind kTriangularPrism = {"3-PRIS", kTriangularPrismAliases,
                                    "triangular prism or truncated tetrahedron",
                                    kTriangularPrismOptions};
const SolidKind kPyramid = {"PYRAM", {}, "pyramid", kPyramidOptions};
const SolidKind kRectangularPrism = {"4-PRIS", kRectangularPrismAliases,
                                     "rectangular prism or truncated pyramid",
                                     kRectangularPrismOptions};

}  // namespace diesink
