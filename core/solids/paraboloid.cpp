// Paraboloid of revolution. Source: Choi, Lee, Hwang and Jun (1988), equation (9): a² = 4 f.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/solids/frame.h"
#include "core/solids/kinds.h"

namespace diesink {
namespace {

using enum FieldShape;
using Values = std::span<const FieldValue>;

constexpr FieldKind kRim[] = {{"P1", kPoint}, {"P2", kPoint}, {"RAD", kLength}};
constexpr FieldKind kFocus[] = {
    {"P1", kPoint}, {"NOR", kDirection}, {"FOC", kLength}, {"LEN", kLength}};

Body paraboloid(const Vec3& vertex, const Axis& axis, double a) {
  return QuadricBody{
      QuadricShape::kParaboloid, vertex, frame_about(axis.direction), a, a, axis.length};
}

Result<Body> paraboloid_rim(Values v) {
  const Result<Axis> axis = axis_between(v[0], v[1]);
  if (!axis) return axis.error();
  return paraboloid(v[0].value, *axis, v[2].value[0] / std::sqrt(axis->length));
}

Result<Body> paraboloid_focus(Values v) {
  return paraboloid(v[0].value, {unit(v[1].value), v[3].value[0]}, 2 * std::sqrt(v[2].value[0]));
}

constexpr SolidOption kOptions[] = {
    {1, kRim, "P1 vertex, P2 centre of the rim, RAD radius of the rim", &paraboloid_rim},
    {2, kFocus,
     "P1 vertex, NOR direction of the axis, FOC focal length (x² + y² = 4 FOC z), LEN length",
     &paraboloid_focus},
};

}  // namespace

const SolidKind kParaboloid = {"PARAB", {}, "paraboloid of revolution", kOptions};

}  // namespace diesink
