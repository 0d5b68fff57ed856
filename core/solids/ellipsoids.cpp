// Sphere and ellipsoid. Source: Choi, Lee, Hwang and Jun (1988), equation (9) and the frame before
// (10).
// SPDX-License-Identifier: Apache-2.0
#include "core/solids/frame.h"
#include "core/solids/kinds.h"

namespace diesink {
namespace {

using enum FieldShape;
using Values = std::span<const FieldValue>;

constexpr FieldKind kCentreRadius[] = {{"P1", kPoint}, {"RAD", kLength}};
constexpr FieldKind kCentrePoint[] = {{"P1", kPoint}, {"P2", kPoint}};
constexpr FieldKind kTurned[] = {{"P1", kPoint}, {"V1", kDirection}, {"V2", kDirection},
                                 {"A", kLength}, {"B", kLength},     {"C", kLength}};
constexpr FieldKind kAligned[] = {{"P1", kPoint}, {"A", kLength}, {"B", kLength}, {"C", kLength}};

Body ellipsoid(const Vec3& centre, const Mat3& frame, double a, double b, double c) {
  return QuadricBody{QuadricShape::kEllipsoid, centre, frame, a, b, c};
}

Body sphere(const Vec3& centre, double radius) {
  return ellipsoid(centre, Mat3::Identity(), radius, radius, radius);
}

Result<Body> sphere_radius(Values v) { return sphere(v[0].value, v[1].value[0]); }

Result<Body> sphere_point(Values v) {
  const Result<Axis> radius = axis_between(v[0], v[1]);
  if (!radius) return radius.error();
  return sphere(v[0].value, radius->length);
}

Result<Body> ellipsoid_turned(Values v) {
  // frame_about puts the part of V1 across the axis V2 into the first row; the paper wants it as
  // the local y axis.
  const Vec3 axis = unit(v[2].value);
  const Result<Mat3> turned = frame_about(axis, v[1].value, "V1");
  if (!turned) {
    return Error{ErrorCode::kInput, "V1 is parallel to V2, the local z axis", v[1].where};
  }
  Mat3 frame;
  frame.row(0) = -turned->row(1);
  frame.row(1) = turned->row(0);
  frame.row(2) = turned->row(2);
  frame.array() += 0.0;  // no negative zero
  return ellipsoid(v[0].value, frame, v[3].value[0], v[4].value[0], v[5].value[0]);
}

Result<Body> ellipsoid_aligned(Values v) {
  return ellipsoid(v[0].value, Mat3::Identity(), v[1].value[0], v[2].value[0], v[3].value[0]);
}

constexpr SolidOption kSphereOptions[] = {
    {1, kCentreRadius, "P1 centre, RAD radius", &sphere_radius},
    {2, kCentrePoint, "P1 centre, P2 a point on the sphere", &sphere_point},
};
constexpr SolidOption kEllipsoidOptions[] = {
    {1, kTurned,
     "P1 centre, V1 direction of the local y axis, V2 direction of the local z axis, A, B, C "
     "semi-axes along local x, y, z",
     &ellipsoid_turned},
    {2, kAligned, "P1 centre, A, B, C semi-axes along x, y, z", &ellipsoid_aligned},
};
constexpr std::string_view kSphereAliases[] = {"SPHERE"};

}  // namespace

const SolidKind kSphere = {"SPHER", kSphereAliases, "sphere", kSphereOptions};
const SolidKind kEllipsoid = {"ELLIP", {}, "ellipsoid", kEllipsoidOptions};

}  // namespace diesink
