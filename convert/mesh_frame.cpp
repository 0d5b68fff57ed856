// Scaling between units, turning between up axes.
// SPDX-License-Identifier: Apache-2.0
#include "convert/mesh_frame.h"

#include <cstdio>

namespace diesink {
namespace {

constexpr double kDoubtfullyLarge = 100;     // metres
constexpr double kDoubtfullySmall = 0.0001;  // metres

double extent_of(const TriangleMesh& mesh) {
  if (mesh.positions.empty()) return 0;
  Vec3 low = mesh.positions[0], high = mesh.positions[0];
  for (const Vec3& each : mesh.positions) {
    low = low.cwiseMin(each);
    high = high.cwiseMax(each);
  }
  return (high - low).maxCoeff();
}

void warn_of_doubtful_unit(const TriangleMesh& mesh, std::vector<std::string>& warnings) {
  const double metres = extent_of(mesh) * metres_per(mesh.unit);
  if (metres == 0 || (metres >= kDoubtfullySmall && metres <= kDoubtfullyLarge)) return;
  char text[160];
  std::snprintf(
      text, sizeof text,
      "the mesh is %.3g m long with its lengths in %s; --units-in says what they are in", metres,
      mesh.unit == LengthUnit::kUnknown ? "mm (assumed)" : std::string(name_of(mesh.unit)).c_str());
  warnings.emplace_back(text);
}

Status scale(TriangleMesh& mesh, LengthUnit to) {
  if (mesh.unit == LengthUnit::kUnknown) {
    return Error{
        ErrorCode::kUsage, "the file does not say its unit: --units-out needs --units-in", {}};
  }
  if (mesh.unit == to) return ok();
  // A quotient of whole hundredths of millimetres where there is one: 25.4, not 25.400000000000002.
  const double from_units = metres_per(mesh.unit) * 1e5, to_units = metres_per(to) * 1e5;
  for (Vec3& each : mesh.positions) each = each * from_units / to_units;
  mesh.unit = to;
  return ok();
}

Status turn(TriangleMesh& mesh, UpAxis to) {
  if (mesh.up == UpAxis::kUnknown) {
    return Error{
        ErrorCode::kUsage, "the file does not say which axis is up: --up-out needs --up-in", {}};
  }
  if (mesh.up == to) return ok();
  const auto turned = [&](const Vec3& v) {
    return to == UpAxis::kZ ? Vec3(v.x(), -v.z(), v.y()) : Vec3(v.x(), v.z(), -v.y());
  };
  for (Vec3& each : mesh.positions) each = turned(each);
  for (Vec3& each : mesh.normals) each = turned(each);
  mesh.up = to;
  return ok();
}

}  // namespace

Status change_frame(TriangleMesh& mesh, const MeshFrame& frame,
                    std::vector<std::string>& warnings) {
  mesh.unit = frame.unit_in.value_or(mesh.unit);
  mesh.up = frame.up_in.value_or(mesh.up);
  warn_of_doubtful_unit(mesh, warnings);
  if (frame.unit_out) {
    if (Status done = scale(mesh, *frame.unit_out); !done) return done;
  }
  if (frame.up_out) {
    if (Status done = turn(mesh, *frame.up_out); !done) return done;
  }
  return ok();
}

}  // namespace diesink
