// What the properties of PLY's vertices, normals and faces mean, by their names.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/vec.h"
#include "formats/element_table.h"
#include "formats/ply_header.h"

namespace diesink {

enum class PlyRole : std::uint8_t {
  kSkip,
  kX,
  kY,
  kZ,
  kNx,
  kNy,
  kNz,
  kRed,
  kGreen,
  kBlue,
  kAlpha,
  kCount
};
inline constexpr std::size_t kPlyRoles = static_cast<std::size_t>(PlyRole::kCount);

// A row's values by role.
using PlyRow = std::array<double, kPlyRoles>;

PlyRole ply_role_of(std::string_view name);

// The roles of an element's properties, in their order.
struct PlyPlan {
  std::vector<PlyRole> roles;
  std::array<bool, kPlyRoles> has{};
  std::array<PlyType, kPlyRoles> type{};

  [[nodiscard]] bool all(PlyRole a, PlyRole b, PlyRole c) const;
  // Whole numbers run to 255 or 65535, others to 1. Needs red, green and blue.
  [[nodiscard]] Color color_of(const PlyRow& row) const;
};

// Of each role the first property has it; the names of those without one are listed in `skipped`.
PlyPlan ply_plan(const PlyElement& element, std::string& skipped);

// The faces' properties that count the normals of their corners: one list, or three numbers.
struct PlyFaceNormals {
  const PlyProperty* list = nullptr;
  std::array<const PlyProperty*, 3> each{};

  [[nodiscard]] bool any() const { return list != nullptr || each[0] != nullptr; }
  // Which corner's number the property is, -1 for none's.
  [[nodiscard]] int corner_of(const PlyProperty& property) const;
};
PlyFaceNormals ply_face_normals(const PlyElement& faces);

// The three values from `first` on.
Vec3 vector_of(const PlyRow& row, PlyRole first);

}  // namespace diesink
