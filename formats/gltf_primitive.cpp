// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_primitive.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "formats/draco_mesh.h"
#include "formats/float_rows.h"
#include "formats/gltf_color.h"

namespace diesink {

namespace tg = diesink_tinygltf;

void GltfWarnings::tell(const std::string& file, Diagnostics& diagnostics) const {
  for (const auto& [text, count] : count_) {
    diagnostics.warning(count > 1 ? std::to_string(count) + " times: " + text : text, Place{file});
  }
}

Status GltfPrimitives::decompress(const tg::Primitive& primitive, const GltfDraco& draco,
                                  std::map<std::string, std::vector<std::byte>>& attributes,
                                  Indices& indices) {
  if (primitive.mode != kTriangleList || primitive.indices < 0) {
    return wrong("is compressed with Draco but is no indexed list of triangles");
  }
  const tg::Accessor& index = model_.file.accessors[static_cast<std::size_t>(primitive.indices)];
  if (index.componentType == 5126) return wrong("has floats as indices");
  const auto bytes = accessors_.view(draco.view);
  if (!bytes) return bytes.error();
  DracoLimits limits;
  limits.triangles = index.count / 3;
  limits.vertices = 3 * limits.triangles;
  if (index.componentType == 5121) warnings_.add("indices of a Draco primitive declared as bytes");
  std::vector<DracoRequest> requests;
  std::vector<std::string> names;
  for (const auto& [name, id] : draco.attributes) {
    const auto used = primitive.attributes.find(name);
    if (used == primitive.attributes.end()) {
      return wrong("has a Draco attribute " + name.substr(0, 40) + " that it does not list");
    }
    if (name != "POSITION" && name != "NORMAL" && name != "COLOR_0") continue;
    const tg::Accessor& accessor = model_.file.accessors[static_cast<std::size_t>(used->second)];
    requests.push_back({id, accessor.componentType,
                        tg::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type))});
    names.push_back(name);
  }
  auto decoded = decode_draco(*bytes, limits, requests);
  if (!decoded) {
    return Error{decoded.error().code, place_ + decoded.error().message, {}};
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::size_t count =
        model_.file.accessors[static_cast<std::size_t>(primitive.attributes.at(names[i]))].count;
    if (decoded->vertex_count != count) {
      warnings_.add("a Draco primitive with another number of vertices than its accessors say");
    }
    attributes[names[i]] = std::move(decoded->attributes[i]);
  }
  indices = std::move(decoded->indices);
  return ok();
}

// Warns where the file's bounds are not those of the values. Draco moves values by a step of its
// grid.
void GltfPrimitives::check_bounds(const tg::Accessor& accessor, bool packed,
                                  const std::vector<Vec3>& positions) {
  if (accessor.minValues.size() != 3 || accessor.maxValues.size() != 3) {
    warnings_.add("positions without their bounds");
    return;
  }
  if (accessor.componentType != 5126) return;  // bounds are in stored units
  Vec3 low = positions[0], high = positions[0];
  for (const Vec3& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double slack = packed ? 0.02 * (high - low).maxCoeff() : 0;
  const auto differs = [slack](double told, double found) {
    return !(std::abs(static_cast<double>(static_cast<float>(told)) - found) <= slack);
  };
  for (int k = 0; k < 3; ++k) {
    const std::size_t i = static_cast<std::size_t>(k);
    if (differs(accessor.minValues[i], low[k]) || differs(accessor.maxValues[i], high[k])) {
      warnings_.add("positions whose bounds in the file are not those of their values");
      return;
    }
  }
}

Status GltfPrimitives::set_attributes(const tg::Primitive& primitive,
                                      std::map<std::string, std::vector<std::byte>>& decoded,
                                      GltfArrays& out) {
  for (const auto& [name, number] : primitive.attributes) {
    const bool position = name == "POSITION", normal = name == "NORMAL", color = name == "COLOR_0";
    if (!position && !normal && !color) {
      if (!name.starts_with('_'))
        warnings_.add("an attribute that is not kept: " + name.substr(0, 40));
      continue;
    }
    const tg::Accessor& accessor = model_.file.accessors[static_cast<std::size_t>(number)];
    const bool vector =
        accessor.type == TINYGLTF_TYPE_VEC3 || (color && accessor.type == TINYGLTF_TYPE_VEC4);
    const bool type = accessor.componentType != 5125 &&
                      (accessor.componentType == 5126 || position || accessor.normalized);
    if (!vector || !type) return wrong("has a " + name + " of a type that it cannot be");
    const auto found = decoded.find(name);
    const bool packed = found != decoded.end();
    auto values =
        accessors_.values(number, packed ? std::move(found->second) : std::vector<std::byte>());
    if (!values) return values.error();
    if (position) {
      out.positions = to_vectors(*values);
      for (std::size_t i = 0; i < out.positions.size(); ++i) {
        if (!out.positions[i].allFinite()) {
          return wrong("has a position that is not finite, number " + std::to_string(i));
        }
      }
      if (out.positions.empty()) return wrong("has no positions");
      check_bounds(accessor, packed, out.positions);
    } else if (normal) {
      out.normals = to_vectors(*values);
    } else {
      const auto colors = to_colors(*values);
      out.colors.resize(colors.size());
      std::transform(colors.begin(), colors.end(), out.colors.begin(), srgb_of);
    }
  }
  // The map is in the order of names: colours and normals come before positions.
  if ((!out.normals.empty() && out.normals.size() != out.positions.size()) ||
      (!out.colors.empty() && out.colors.size() != out.positions.size())) {
    return wrong("has attributes of different lengths");
  }
  return ok();
}

Status GltfPrimitives::check_indices(const GltfArrays& arrays) const {
  const std::size_t count = arrays.positions.size();
  if (arrays.indices.empty() || range_of(arrays.indices)[1] < count) return ok();
  for (std::size_t i = 0; i < arrays.indices.size(); ++i) {
    if (arrays.indices[i] >= count) {
      return wrong("has index " + std::to_string(arrays.indices[i]) + " at place " +
                   std::to_string(i) + ", expected less than its " + std::to_string(count) +
                   " vertices");
    }
  }
  return ok();
}

Result<GltfArrays> GltfPrimitives::read(int mesh, std::size_t p) {
  const std::size_t m = static_cast<std::size_t>(mesh);
  place_ = "meshes[" + std::to_string(m) + "].primitives[" + std::to_string(p) + "] ";
  const tg::Primitive& primitive = model_.file.meshes[m].primitives[p];
  GltfArrays out;
  std::map<std::string, std::vector<std::byte>> decoded;
  const std::optional<GltfDraco>& draco = model_.primitives[m][p].draco;
  if (draco) {
    if (Status s = decompress(primitive, *draco, decoded, out.indices); !s) return s.error();
  }
  if (Status s = set_attributes(primitive, decoded, out); !s) return s.error();
  if (!draco && primitive.indices >= 0) {
    const auto values = accessors_.values(primitive.indices);
    if (!values) return values.error();
    auto indices = to_indices(*values);
    if (!indices) return wrong(indices.error().message);
    out.indices = std::move(*indices);
  } else if (!draco) {
    out.indices.resize(out.positions.size());
    for (std::size_t i = 0; i < out.indices.size(); ++i) {
      out.indices[i] = static_cast<std::uint32_t>(i);
    }
  }
  if (Status s = check_indices(out); !s) return s.error();
  return out;
}

}  // namespace diesink
