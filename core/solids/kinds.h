// The table of solids: parser, help, documentation and tests walk it. A new solid is a SolidKind in
// a file of its own and a line in kinds.cpp (docs/adding-a-solid.md).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry.h"
#include "core/result.h"

namespace diesink {

// What a data statement holds and must satisfy; the parser checks it before make() is called.
enum class FieldShape : std::uint8_t {
  kPoint,      // x,y,z
  kDirection,  // i,j,k, not all zero
  kLength,     // one length > 0
  kHeight,     // one length, not 0
};

struct FieldKind {
  std::string_view keyword;
  FieldShape shape = FieldShape::kPoint;
};

// A data statement as read: lengths in value[0]. `where` holds line and column only.
struct FieldValue {
  Vec3 value = Vec3::Zero();
  Place where;
};

struct SolidOption {
  int number = 1;
  std::span<const FieldKind> fields;
  std::string_view meaning;  // what the fields say, for help
  // The body from the values, in the order of `fields`. An Error without a line is one of the whole
  // solid.
  Result<Body> (*make)(std::span<const FieldValue> values) = nullptr;
};

struct SolidKind {
  std::string_view keyword;  // "R-CYLI"
  std::span<const std::string_view> aliases;
  std::string_view summary;
  std::span<const SolidOption> options;  // numbered 1, 2, ..
};

// All kinds, in the order of the language's description.
std::span<const SolidKind* const> solid_kinds();

// By keyword or alias in upper case; null where unknown.
const SolidKind* find_solid_kind(std::string_view word);

// Every keyword and alias, and every keyword of a data statement, once each.
std::vector<std::string_view> solid_type_words();
std::vector<std::string_view> solid_field_words();

extern const SolidKind kTetrahedron, kTriangularPrism, kPyramid,
    kRectangularPrism;                                       // polyhedra.cpp
extern const SolidKind kRegularCone, kEllipticCone;          // cones_cylinders.cpp
extern const SolidKind kRegularCylinder, kEllipticCylinder;  // cones_cylinders.cpp
extern const SolidKind kSphere, kEllipsoid;                  // ellipsoids.cpp
extern const SolidKind kParaboloid;                          // paraboloid.cpp

}  // namespace diesink
