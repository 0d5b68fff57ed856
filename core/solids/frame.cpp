// SPDX-License-Identifier: Apache-2.0
#include "core/solids/frame.h"

#include <Eigen/Geometry>

namespace diesink {
namespace {

// Turns -0 into 0, so that equal frames have equal bytes.
template <class M>
M without_negative_zero(const M& m) {
  return m.array() + 0.0;
}

Mat3 rows(const Vec3& n, const Vec3& o, const Vec3& a) {
  Mat3 frame;
  frame.row(0) = n;
  frame.row(1) = o;
  frame.row(2) = a;
  return without_negative_zero(frame);
}

}  // namespace

Vec3 unit(const Vec3& v) {
  const Vec3 scaled = v / v.cwiseAbs().maxCoeff();
  return without_negative_zero(Vec3(scaled / scaled.norm()));
}

Mat3 frame_about(const Vec3& axis) {
  // e_k x a for the coordinate axis e_k farthest from a: perpendicular to a to the last bit,
  // because the two products of the dot product are the same numbers.
  int k = 0;
  axis.cwiseAbs().minCoeff(&k);
  const Vec3 n = unit(Vec3::Unit(k).cross(axis));
  return rows(n, axis.cross(n), axis);
}

Result<Mat3> frame_about(const Vec3& axis, const Vec3& across, std::string_view name) {
  const Vec3 given = unit(across);
  Vec3 part = given - given.dot(axis) * axis;
  if (part.norm() <= 1e-9) {
    return Error{ErrorCode::kInput, std::string(name) + " is parallel to the axis", {}};
  }
  // Once more: the first pass leaves a remainder along the axis where the two are nearly parallel.
  const Vec3 first = unit(part);
  part = first - first.dot(axis) * axis;
  const Vec3 n = unit(part);
  return rows(n, axis.cross(n), axis);
}

Result<Axis> axis_between(const FieldValue& from, const FieldValue& to) {
  const Vec3 along = to.value - from.value;
  const double length = along.stableNorm();
  if (length < kLeastLength) {
    return Error{ErrorCode::kInput, "P1 and P2 coincide; two different points are needed",
                 to.where};
  }
  return Axis{unit(along), length};
}

}  // namespace diesink
