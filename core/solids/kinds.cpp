// SPDX-License-Identifier: Apache-2.0
#include "core/solids/kinds.h"

#include <algorithm>

namespace diesink {
namespace {

constexpr const SolidKind* kKinds[] = {
    &kTetrahedron, &kTriangularPrism, &kPyramid,      &kRectangularPrism,
    &kRegularCone, &kRegularCylinder, &kEllipticCone, &kEllipticCylinder,
    &kSphere,      &kEllipsoid,       &kParaboloid,
};

}  // namespace

std::span<const SolidKind* const> solid_kinds() { return kKinds; }

const SolidKind* find_solid_kind(std::string_view word) {
  for (const SolidKind* kind : kKinds) {
    if (kind->keyword == word || std::ranges::find(kind->aliases, word) != kind->aliases.end()) {
      return kind;
    }
  }
  return nullptr;
}

std::vector<std::string_view> solid_type_words() {
  std::vector<std::string_view> words;
  for (const SolidKind* kind : kKinds) {
    words.push_back(kind->keyword);
    words.insert(words.end(), kind->aliases.begin(), kind->aliases.end());
  }
  return words;
}

std::vector<std::string_view> solid_field_words() {
  std::vector<std::string_view> words;
  for (const SolidKind* kind : kKinds) {
    for (const SolidOption& option : kind->options) {
      for (const FieldKind& field : option.fields) {
        if (std::ranges::find(words, field.keyword) == words.end()) words.push_back(field.keyword);
      }
    }
  }
  return words;
}

}  // namespace diesink
