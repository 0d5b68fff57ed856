// The fixed-size vectors of every public header. Never write `auto` for an Eigen expression.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace diesink {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

}  // namespace diesink
