// Axes and local frames of the quadrics.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/result.h"
#include "core/solids/kinds.h"
#include "core/vec.h"

namespace diesink {

// Lengths below this say nothing: the coordinates may reach 1e9 and doubles carry 16 digits.
inline constexpr double kLeastLength = 1e-9;

// v / |v| without overflow or underflow, no negative zero; a vector along an axis comes out exactly
// along it. Needs: v finite, not zero.
Vec3 unit(const Vec3& v);

// The frame (rows n, o, a) about a unit axis a. An axis along x, y or z gives entries of exactly 0
// and +-1.
Mat3 frame_about(const Vec3& axis);

// The frame whose axis is a and whose first row is the part of `across` perpendicular to it.
// Errors: `across` parallel to the axis (to 1e-9), said under `name`; without a place.
Result<Mat3> frame_about(const Vec3& axis, const Vec3& across, std::string_view name);

// Axis and length from two points.
struct Axis {
  Vec3 direction = Vec3::UnitZ();
  double length = 1;
};
// Errors: the points coincide; placed at `to`.
Result<Axis> axis_between(const FieldValue& from, const FieldValue& to);

}  // namespace diesink
