// Cones and cylinders, regular and elliptic: one set of statements, two shapes.
// Source: Choi, Lee, Hwang and Jun (1988), equation (9).
// SPDX-License-Identifier: Apache-2.0
#include "core/solids/frame.h"
#include "core/solids/kinds.h"

namespace diesink {
namespace {

using enum FieldShape;
using Values = std::span<const FieldValue>;

constexpr FieldKind kRegularPoints[] = {{"P1", kPoint}, {"P2", kPoint}, {"RAD", kLength}};
constexpr FieldKind kRegularAxis[] = {
    {"P1", kPoint}, {"NOR", kDirection}, {"RAD", kLength}, {"LEN", kLength}};
constexpr FieldKind kEllipticPoints[] = {
    {"P1", kPoint}, {"P2", kPoint}, {"LVE", kDirection}, {"L-R", kLength}, {"S-R", kLength}};
constexpr FieldKind kEllipticAxis[] = {{"P1", kPoint},   {"NOR", kDirection}, {"LVE", kDirection},
                                       {"L-R", kLength}, {"S-R", kLength},    {"LEN", kLength}};

template <QuadricShape kShape>
Body regular(const Vec3& base, const Axis& axis, double radius) {
  return QuadricBody{kShape, base, frame_about(axis.direction), radius, radius, axis.length};
}

template <QuadricShape kShape>
Result<Body> regular_points(Values v) {
  const Result<Axis> axis = axis_between(v[0], v[1]);
  if (!axis) return axis.error();
  return regular<kShape>(v[0].value, *axis, v[2].value[0]);
}

template <QuadricShape kShape>
Result<Body> regular_axis(Values v) {
  return regular<kShape>(v[0].value, {unit(v[1].value), v[3].value[0]}, v[2].value[0]);
}

template <QuadricShape kShape>
Result<Body> elliptic(const Vec3& base, const Axis& axis, const FieldValue& across, double a,
                      double b) {
  const Result<Mat3> frame = frame_about(axis.direction, across.value, "LVE");
  if (!frame) return Error{ErrorCode::kInput, frame.error().message, across.where};
  return Body(QuadricBody{kShape, base, *frame, a, b, axis.length});
}

template <QuadricShape kShape>
Result<Body> elliptic_points(Values v) {
  const Result<Axis> axis = axis_between(v[0], v[1]);
  if (!axis) return axis.error();
  return elliptic<kShape>(v[0].value, *axis, v[2], v[3].value[0], v[4].value[0]);
}

template <QuadricShape kShape>
Result<Body> elliptic_axis(Values v) {
  return elliptic<kShape>(v[0].value, {unit(v[1].value), v[5].value[0]}, v[2], v[3].value[0],
                          v[4].value[0]);
}

template <QuadricShape kShape>
constexpr SolidOption kRegularOptions[] = {
    {1, kRegularPoints,
     kShape == QuadricShape::kCone ? "P1 centre of the base, P2 apex, RAD radius of the base"
                                   : "P1 and P2 centres of the ends, RAD radius",
     &regular_points<kShape>},
    {2, kRegularAxis, "P1 centre of the base, NOR direction of the axis, RAD radius, LEN length",
     &regular_axis<kShape>},
};
template <QuadricShape kShape>
constexpr SolidOption kEllipticOptions[] = {
    {1, kEllipticPoints,
     kShape == QuadricShape::kCone
         ? "P1 centre of the base, P2 apex, LVE direction of the long axis, L-R and S-R long and "
           "short radius of the base"
         : "P1 and P2 centres of the ends, LVE direction of the long axis, L-R and S-R long and "
           "short radius",
     &elliptic_points<kShape>},
    {2, kEllipticAxis,
     "P1 centre of the base, NOR direction of the axis, LVE direction of the long axis, L-R and "
     "S-R long and short radius, LEN length",
     &elliptic_axis<kShape>},
};

constexpr std::string_view kRegularConeAliases[] = {"RCONE"};
constexpr std::string_view kEllipticConeAliases[] = {"ECONE"};
constexpr std::string_view kRegularCylinderAliases[] = {"RCYLI", "RCYL"};
constexpr std::string_view kEllipticCylinderAliases[] = {"ECYLI"};

}  // namespace

const SolidKind kRegularCone = {"R-CONE", kRegularConeAliases, "right circular cone",
                                kRegularOptions<QuadricShape::kCone>};
const SolidKind kEllipticCone = {"E-CONE", kEllipticConeAliases, "elliptic cone",
                                 kEllipticOptions<QuadricShape::kCone>};
const SolidKind kRegularCylinder = {"R-CYLI", kRegularCylinderAliases, "right circular cylinder",
                                    kRegularOptions<QuadricShape::kCylinder>};
const SolidKind kEllipticCylinder = {"E-CYLI", kEllipticCylinderAliases, "elliptic cylinder",
                                     kEllipticOptions<QuadricShape::kCylinder>};

}  // namespace diesink
