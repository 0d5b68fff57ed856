// SPDX-License-Identifier: Apache-2.0
#include "formats/ply_roles.h"

#include <string_view>
#include <utility>

#include "formats/mesh_builder.h"

namespace diesink {

PlyRole ply_role_of(std::string_view name) {
  using Name = std::pair<std::string_view, PlyRole>;
  constexpr std::array kNames{Name{"x", PlyRole::kX},
                              Name{"y", PlyRole::kY},
                              Name{"z", PlyRole::kZ},
                              Name{"nx", PlyRole::kNx},
                              Name{"ny", PlyRole::kNy},
                              Name{"nz", PlyRole::kNz},
                              Name{"red", PlyRole::kRed},
                              Name{"green", PlyRole::kGreen},
                              Name{"blue", PlyRole::kBlue},
                              Name{"alpha", PlyRole::kAlpha},
                              Name{"r", PlyRole::kRed},
                              Name{"g", PlyRole::kGreen},
                              Name{"b", PlyRole::kBlue},
                              Name{"a", PlyRole::kAlpha},
                              Name{"diffuse_red", PlyRole::kRed},
                              Name{"diffuse_green", PlyRole::kGreen},
                              Name{"diffuse_blue", PlyRole::kBlue}};
  for (const Name& known : kNames) {
    if (known.first == name) return known.second;
  }
  return PlyRole::kSkip;
}

bool PlyPlan::all(PlyRole a, PlyRole b, PlyRole c) const {
  return has[static_cast<std::size_t>(a)] && has[static_cast<std::size_t>(b)] &&
         has[static_cast<std::size_t>(c)];
}

Color PlyPlan::color_of(const PlyRow& row) const {
  Color color{0, 0, 0, 255};
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t i = static_cast<std::size_t>(PlyRole::kRed) + k;
    if (!has[i]) continue;
    const double value = type[i] == PlyType::kUint16 ? row[i] / 257 : row[i];
    color[k] = color_part(value, !is_real(type[i]));
  }
  return color;
}

PlyPlan ply_plan(const PlyElement& element, std::string& skipped) {
  PlyPlan plan;
  for (const PlyProperty& property : element.properties) {
    PlyRole role = property.list ? PlyRole::kSkip : ply_role_of(property.name);
    if (plan.has[static_cast<std::size_t>(role)]) role = PlyRole::kSkip;
    plan.roles.push_back(role);
    if (role == PlyRole::kSkip) {
      skipped += (skipped.empty() ? "" : ", ") + property.name;
    } else {
      plan.has[static_cast<std::size_t>(role)] = true;
      plan.type[static_cast<std::size_t>(role)] = property.type;
    }
  }
  return plan;
}

int PlyFaceNormals::corner_of(const PlyProperty& property) const {
  for (int corner = 0; corner < 3; ++corner) {
    if (each[static_cast<std::size_t>(corner)] == &property) return corner;
  }
  return -1;
}

PlyFaceNormals ply_face_normals(const PlyElement& faces) {
  PlyFaceNormals found;
  found.list = faces.find("normal_indices");
  if (found.list != nullptr && found.list->list) return found;
  found.list = nullptr;
  found.each = {faces.find("normal1"), faces.find("normal2"), faces.find("normal3")};
  for (const PlyProperty* const each : found.each) {
    if (each == nullptr || each->list) return {};
  }
  return found;
}

Vec3 vector_of(const PlyRow& row, PlyRole first) {
  const auto i = static_cast<std::size_t>(first);
  return {row[i], row[i + 1], row[i + 2]};
}

}  // namespace diesink
