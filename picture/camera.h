// Where a picture looks from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "core/vec.h"

namespace diesink {

enum class View : std::uint8_t { kPlan, kIso, kFront, kRight };

// A part of the picture in pixels, y down.
struct PixelBox {
  double left = 0, top = 0, right = 0, bottom = 0;
};

// Parallel projection. `right`, `up` and `toward` (to the eye) are unit, orthogonal, right-handed.
struct Camera {
  Vec3 right = Vec3::UnitX(), up = Vec3::UnitY(), toward = Vec3::UnitZ();
  Vec3 centre = Vec3::Zero();  // is seen at `middle`
  Vec2 middle = Vec2::Zero();
  double scale = 1;  // pixels a unit of length

  // Pixels in x and y (down), and the height toward the eye in z, in units of length.
  [[nodiscard]] Vec3 project(const Vec3& p) const;
  [[nodiscard]] Vec3 turned(const Vec3& direction) const;  // in the frame (right, up, toward)
};

// plan: x right, y up. front: from -y. right: from +x. iso: the three axes equally inclined, from
// +x, -y, +z.
// The box {low, high} fills `frame` as far as its shape allows.
Camera make_camera(View view, const std::array<Vec3, 2>& box, const PixelBox& frame);

}  // namespace diesink
