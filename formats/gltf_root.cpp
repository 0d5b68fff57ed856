// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_root.h"

#include <algorithm>
#include <cmath>

namespace diesink {
namespace {

constexpr double kMatrixTolerance =
    1e-6;  // tools that go through floats or TRS come back within this

Vec3 offset_for(const Vec3& low, const Vec3& high) {
  Vec3 offset = Vec3::Zero();
  const double extent = (high - low).maxCoeff();
  if (!(extent > 0) || !std::isfinite(extent)) return offset;
  const double step = std::exp2(std::ceil(std::log2(extent)));
  for (int k = 0; k < 3; ++k) {
    const double nearest = low[k] > 0 ? low[k] : (high[k] < 0 ? -high[k] : 0);
    if (nearest > 2 * extent) offset[k] = std::round((low[k] + high[k]) / 2 / step) * step;
  }
  return offset;
}

bool same_matrix(const NodeMatrix& a, const NodeMatrix& b) {
  for (std::size_t i = 0; i < 16; ++i) {
    // The linear part is of the size of a[0]; translations have their own size.
    const double size = i >= 12 ? std::max(std::abs(a[0]), std::abs(a[i])) : std::abs(a[0]);
    if (!(std::abs(a[i] - b[i]) <= kMatrixTolerance * size)) return false;
  }
  return true;
}

}  // namespace

RootFrame frame_for(const TriangleMesh& mesh, const Vec3& low, const Vec3& high) {
  RootFrame frame;
  frame.unit = mesh.unit;
  frame.up = mesh.up;
  frame.offset = offset_for(low, high);
  return frame;
}

NodeMatrix matrix_of(const RootFrame& frame) {
  const double s = metres_per(frame.unit);
  const Vec3& o = frame.offset;
  if (frame.up == UpAxis::kY) {
    return {s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, s * o.x(), s * o.y(), s * o.z(), 1};
  }
  return {s, 0, 0, 0, 0, 0, -s, 0, 0, s, 0, 0, s * o.x(), s * o.z(), -s * o.y(), 1};
}

std::optional<RootFrame> frame_of(const NodeMatrix& matrix,
                                  const std::optional<RootFrame>& claimed) {
  if (claimed && same_matrix(matrix_of(*claimed), matrix)) return claimed;
  for (const LengthUnit unit :
       {LengthUnit::kMillimetre, LengthUnit::kInch, LengthUnit::kCentimetre, LengthUnit::kMetre}) {
    for (const UpAxis up : {UpAxis::kZ, UpAxis::kY}) {
      RootFrame frame;
      frame.unit = unit;
      frame.up = up;
      const double s = metres_per(unit);
      const double x = matrix[12] / s, y = matrix[13] / s, z = matrix[14] / s;
      frame.offset = up == UpAxis::kY ? Vec3(x, y, z) : Vec3(x, -z, y);
      if (same_matrix(matrix_of(frame), matrix)) return frame;
    }
  }
  return std::nullopt;
}

}  // namespace diesink
