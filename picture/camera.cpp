// SPDX-License-Identifier: Apache-2.0
#include "picture/camera.h"

#include <algorithm>
#include <cmath>

namespace diesink {

Vec3 Camera::project(const Vec3& p) const {
  const Vec3 d = p - centre;
  return {middle.x() + scale * right.dot(d), middle.y() - scale * up.dot(d), toward.dot(d)};
}

Vec3 Camera::turned(const Vec3& direction) const {
  return {right.dot(direction), up.dot(direction), toward.dot(direction)};
}

namespace {

void aim(View view, Camera& camera) {
  switch (view) {
    case View::kPlan:
      return;
    case View::kFront:
      camera.up = Vec3::UnitZ();
      camera.toward = -Vec3::UnitY();
      return;
    case View::kRight:
      camera.right = Vec3::UnitY();
      camera.up = Vec3::UnitZ();
      camera.toward = Vec3::UnitX();
      return;
    case View::kIso: {
      const double half = std::sqrt(0.5), third = std::sqrt(1.0 / 3);
      camera.right = Vec3(half, half, 0);
      camera.toward = Vec3(third, -third, third);
      camera.up = Vec3(-third * half, third * half, 2 * third * half);
      return;
    }
  }
}

}  // namespace

Camera make_camera(View view, const std::array<Vec3, 2>& box, const PixelBox& frame) {
  Camera camera;
  aim(view, camera);
  camera.centre = (box[0] + box[1]) / 2;
  const Vec3 half = (box[1] - box[0]) / 2;
  const double wide = 2 * camera.right.cwiseAbs().dot(half),
               tall = 2 * camera.up.cwiseAbs().dot(half);
  const double room_x = std::max(1.0, frame.right - frame.left);
  const double room_y = std::max(1.0, frame.bottom - frame.top);
  camera.scale = std::min(wide > 0 ? room_x / wide : room_y / std::max(tall, 1e-300),
                          tall > 0 ? room_y / tall : room_x / std::max(wide, 1e-300));
  camera.middle = Vec2((frame.left + frame.right) / 2, (frame.top + frame.bottom) / 2);
  return camera;
}

}  // namespace diesink
