// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_extras.h"

#include <nlohmann/json.hpp>

#include "core/units.h"

namespace diesink {
namespace {

using Json = nlohmann::json;

const Json* find(const Json& object, const char* key) {
  const auto it = object.find(key);
  return it == object.end() ? nullptr : &*it;
}

LengthUnit unit_named(const std::string& name) {
  for (const LengthUnit unit :
       {LengthUnit::kMillimetre, LengthUnit::kCentimetre, LengthUnit::kMetre, LengthUnit::kInch}) {
    if (name == name_of(unit)) return unit;
  }
  return LengthUnit::kUnknown;
}

CurveKind curve_kind(const std::string& name) {
  if (name == "crease") return CurveKind::kCrease;
  if (name == "edge") return CurveKind::kEdge;
  if (name == "jump") return CurveKind::kJump;
  return CurveKind::kOther;
}

}  // namespace

const Json* our_extras(const Json& from) {
  const Json* const extras = find(from, "extras");
  if (extras == nullptr || !extras->is_object()) return nullptr;
  const Json* const mine = find(*extras, "diesink");
  return mine != nullptr && mine->is_object() ? mine : nullptr;
}

std::string extras_text(const Json& object, const char* key) {
  const Json* const found = find(object, key);
  return found != nullptr && found->is_string() ? found->get<std::string>() : std::string();
}

bool extras_true(const Json& object, const char* key) {
  const Json* const found = find(object, key);
  return found != nullptr && found->is_boolean() && found->get<bool>();
}

std::vector<GltfCurve> curves_of_extras(const Json& mine) {
  std::vector<GltfCurve> curves;
  const Json* const list = find(mine, "curves");
  if (list == nullptr || !list->is_array()) return curves;
  for (const Json& from : *list) {
    GltfCurve curve;
    const Json* const vertices = from.is_object() ? find(from, "vertices") : nullptr;
    // Without a sensible count the segments cannot be given to their curves.
    if (vertices == nullptr || !vertices->is_number_unsigned()) return {};
    curve.vertices = vertices->get<std::size_t>();
    curve.kind = curve_kind(extras_text(from, "kind"));
    curve.closed = extras_true(from, "closed");
    curve.name = extras_text(from, "name");
    if (const Json* const between = find(from, "between");
        between != nullptr && between->is_array() && between->size() == 2) {
      for (std::size_t k = 0; k < 2; ++k) {
        const Json& element = (*between)[k];
        if (element.is_number_unsigned() && element.get<std::uint64_t>() < 0xFFFFFFFFu) {
          curve.between[k] = element.get<std::uint32_t>();
        }
      }
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

RootFrame frame_of_extras(const Json& mine) {
  RootFrame frame;
  frame.unit = unit_named(extras_text(mine, "unit"));
  const std::string up = extras_text(mine, "up");
  frame.up = up == "y" ? UpAxis::kY : up == "z" ? UpAxis::kZ : UpAxis::kUnknown;
  const Json* const offset = find(mine, "offset");
  if (offset != nullptr && offset->is_array() && offset->size() == 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      if ((*offset)[k].is_number()) {
        frame.offset[static_cast<int>(k)] = (*offset)[k].get<double>();
      }
    }
  }
  return frame;
}

}  // namespace diesink
