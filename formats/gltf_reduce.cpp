// tinygltf 2.7.0 lets dozens of wrong files pass and overflows its stack on nested extras, so it
// sees only what has been checked here, written anew.
// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_reduce.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "core/counted.h"
#include "formats/gltf_checker.h"
#include "formats/gltf_extras.h"

namespace diesink {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kObjectsOfAny = 60'000;  // tinygltf spends a thousand bytes on each
constexpr std::size_t kBytesPerObject = 30;
constexpr std::size_t kNoIndex = JsonChecker::kNoIndex;

// Extensions that change only how a mesh looks, so that a file may require them and still be read.
bool only_appearance(std::string_view name) {
  constexpr std::array<std::string_view, 12> kNames{
      "KHR_texture_transform",   "KHR_texture_basisu",    "EXT_texture_webp",
      "EXT_texture_avif",        "KHR_lights_punctual",   "KHR_xmp_json_ld",
      "EXT_structural_metadata", "EXT_mesh_features",     "EXT_feature_metadata",
      "EXT_lights_image_based",  "KHR_animation_pointer", "KHR_techniques_webgl"};
  return name.starts_with("KHR_materials_") ||
         std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

bool is_read(std::string_view name) {
  return name == "KHR_draco_mesh_compression" || name == "KHR_mesh_quantization" ||
         name == "EXT_meshopt_compression";
}

class Reducer {
 public:
  Reducer(const Json& in, std::string file, Diagnostics& diagnostics)
      : in_(in), file_(std::move(file)), diagnostics_(diagnostics) {}

  Result<ReducedGltf> run(std::size_t file_bytes);

 private:
  using Each = void (Reducer::*)(const Json& from, Json& to);

  void warn(std::string text) { ++warnings_[std::move(text)]; }
  [[nodiscard]] std::size_t count(const char* name) const {
    const Json* const array = JsonChecker::find(in_, name);
    return array != nullptr && array->is_array() ? array->size() : 0;
  }

  void asset();
  void extensions();
  void unread_sections();
  void limit_objects(std::size_t file_bytes);
  void each(const char* name, Each one);
  void buffer(const Json& from, Json& to);
  void view(const Json& from, Json& to);
  void accessor(const Json& from, Json& to);
  void sparse(const Json& from, Json& to, std::uint64_t count);
  void material(const Json& from, Json& to);
  void mesh(const Json& from, Json& to);
  void primitive(const Json& from, Json& to, GltfPrimitiveExtras& extras);
  void node(const Json& from, Json& to);
  void scene(const Json& from, Json& to);
  void copy_indices(const Json& from, Json& to, const char* key, std::size_t count);

  const Json& in_;
  std::string file_;
  Diagnostics& diagnostics_;
  JsonChecker check_;
  Json out_ = Json::object();
  ReducedGltf reduced_;
  std::map<std::string, std::size_t> warnings_;
  std::size_t morphed_ = 0, skinned_ = 0, cameras_ = 0, weights_ = 0;
};

void Reducer::asset() {
  check_.enter("asset", kNoIndex);
  const Json* const asset = JsonChecker::find(in_, "asset");
  if (asset == nullptr || !asset->is_object()) {
    check_.enter("the file", kNoIndex);
    check_.fail(" has no asset object, expected one with a version");
    return;
  }
  const std::string version = check_.text(*asset, "version");
  if (!version.starts_with("2.") || version.size() != 3) {
    check_.fail(".version is \"" + version.substr(0, 20) + "\", expected 2.0");
  } else if (version != "2.0") {
    warn("asset.version is " + version.substr(0, 20) + ", read as 2.0");
  }
  const std::string least = check_.text(*asset, "minVersion");
  if (!least.empty() && least != "2.0") {
    check_.fail(".minVersion is \"" + least.substr(0, 20) + "\", at most 2.0 is read");
  }
  out_["asset"] = {{"version", "2.0"}};
}

void Reducer::extensions() {
  check_.enter("the file", kNoIndex);
  std::set<std::string> required;
  for (const char* key : {"extensionsRequired", "extensionsUsed"}) {
    const Json* const names = check_.array(in_, key);
    if (names == nullptr) continue;
    for (const Json& name : *names) {
      if (!name.is_string()) {
        check_.fail(std::string(".") + key + " holds " + JsonChecker::shown(name) +
                    ", expected names");
        return;
      }
      const std::string text = name.get<std::string>();
      if (is_read(text)) continue;
      const bool needed = key == std::string_view("extensionsRequired");
      if (needed && !only_appearance(text)) {
        check_.fail(" requires the extension " + text.substr(0, 60) + ", which is not read");
        return;
      }
      if (needed) required.insert(text);
      if (needed || !required.contains(text)) {
        warn("the extension " + text.substr(0, 60) + " is not read");
      }
    }
  }
}

void Reducer::unread_sections() {
  check_.enter("the file", kNoIndex);
  for (const char* key : {"animations", "skins", "cameras", "images", "textures", "samplers"}) {
    const Json* const section = check_.array(in_, key);
    if (section != nullptr && key != std::string_view("samplers")) {
      std::string one(key);
      one.pop_back();
      warn(counted(section->size(), one + " is|" + key + " are| not read"));
    }
  }
}

void Reducer::limit_objects(std::size_t file_bytes) {
  std::size_t objects = 0;
  for (const char* key :
       {"accessors", "bufferViews", "buffers", "materials", "meshes", "nodes", "scenes"}) {
    objects += count(key);
  }
  if (const Json* const meshes = JsonChecker::find(in_, "meshes");
      meshes != nullptr && meshes->is_array()) {
    for (const Json& mesh : *meshes) {
      const auto it = mesh.is_object() ? mesh.find("primitives") : mesh.end();
      if (mesh.is_object() && it != mesh.end() && it->is_array()) objects += it->size();
    }
  }
  const std::size_t most = kObjectsOfAny + file_bytes / kBytesPerObject;
  if (objects > most) {
    check_.fail_limit("the file holds " + std::to_string(objects) +
                      " nodes, meshes, accessors and so on, at most " + std::to_string(most) +
                      " are read from a file of its size");
  }
}

void Reducer::each(const char* name, Each one) {
  if (check_.failed()) return;
  check_.enter("the file", kNoIndex);
  const Json* const array = check_.array(in_, name);
  if (array == nullptr) return;
  if (array->empty()) warn(std::string(name) + " is an empty array");
  Json& out = out_[name] = Json::array();
  for (std::size_t i = 0; i < array->size() && !check_.failed(); ++i) {
    check_.enter(name, i);
    const Json& from = (*array)[i];
    if (!from.is_object()) {
      check_.fail(" is " + JsonChecker::shown(from) + ", expected an object");
      return;
    }
    Json to = Json::object();
    (this->*one)(from, to);
    out.push_back(std::move(to));
  }
}

void Reducer::copy_indices(const Json& from, Json& to, const char* key, std::size_t count) {
  const Json* const array = check_.array(from, key);
  if (array == nullptr) return;
  if (array->empty()) warn(std::string("an empty array of ") + key);
  Json& out = to[key] = Json::array();
  for (const Json& value : *array) {
    const int index = check_.index_value(value, key, count);
    if (check_.failed()) return;
    out.push_back(static_cast<unsigned>(index));
  }
}

void Reducer::buffer(const Json& from, Json& /*to*/) {
  GltfBufferSource source;
  source.length = check_.whole(from, "byteLength", 1, JsonChecker::kMost, std::nullopt);
  source.has_uri = from.contains("uri");
  source.uri = check_.text(from, "uri");
  if (const Json* const all = check_.object(from, "extensions"); all != nullptr) {
    const Json* const meshopt = check_.object(*all, "EXT_meshopt_compression");
    source.fallback = meshopt != nullptr && check_.truth(*meshopt, "fallback");
  }
  reduced_.buffers.push_back(std::move(source));
}

void Reducer::view(const Json& from, Json& to) {
  const std::size_t buffers = count("buffers");
  if (!from.contains("buffer")) check_.fail(" has no buffer");
  to["buffer"] = check_.index(from, "buffer", buffers);
  to["byteOffset"] = check_.whole(from, "byteOffset", 0, JsonChecker::kMost, 0);
  const std::uint64_t length =
      check_.whole(from, "byteLength", 0, JsonChecker::kMost, std::nullopt);
  if (length == 0 && !check_.failed()) warn("a buffer view of no bytes");
  to["byteLength"] = length;
  if (from.contains("byteStride")) {
    const std::uint64_t stride = check_.whole(from, "byteStride", 4, 252, std::nullopt);
    if (stride % 4 != 0) {
      check_.fail(".byteStride is " + std::to_string(stride) + ", expected a multiple of 4");
    }
    if (stride > length && !check_.failed()) warn("a buffer view whose stride is its whole length");
    to["byteStride"] = stride;
  }
  std::optional<GltfMeshopt> packed;
  const Json* const all = check_.object(from, "extensions");
  const Json* const meshopt =
      all == nullptr ? nullptr : check_.object(*all, "EXT_meshopt_compression");
  if (meshopt != nullptr) {
    check_.inside(".EXT_meshopt_compression");
    packed.emplace();
    if (!meshopt->contains("buffer")) check_.fail(" has no buffer");
    packed->buffer = check_.index(*meshopt, "buffer", buffers);
    packed->offset = check_.whole(*meshopt, "byteOffset", 0, JsonChecker::kMost, 0);
    packed->length = check_.whole(*meshopt, "byteLength", 1, JsonChecker::kMost, std::nullopt);
    packed->stride = check_.whole(*meshopt, "byteStride", 1, 256, std::nullopt);
    packed->count = check_.whole(*meshopt, "count", 1, 0xFFFFFFFFu, std::nullopt);
    packed->mode = check_.text(*meshopt, "mode");
    packed->filter = check_.text(*meshopt, "filter");
  }
  reduced_.model.meshopt.push_back(std::move(packed));
}

void Reducer::sparse(const Json& from, Json& to, std::uint64_t count) {
  check_.inside(".sparse");
  const Json* const indices = check_.object(from, "indices");
  const Json* const values = check_.object(from, "values");
  if (indices == nullptr || values == nullptr) {
    check_.fail(" has no indices or no values");
    return;
  }
  const std::size_t views = this->count("bufferViews");
  Json& out = to["sparse"];
  out["count"] = check_.whole(from, "count", 1, count, std::nullopt);
  for (const auto& [name, part] : {std::pair("indices", indices), std::pair("values", values)}) {
    if (!part->contains("bufferView")) check_.fail(std::string(".") + name + " has no bufferView");
    out[name] = {{"bufferView", check_.index(*part, "bufferView", views)},
                 {"byteOffset", check_.whole(*part, "byteOffset", 0, JsonChecker::kMost, 0)}};
  }
  const std::uint64_t type = check_.whole(*indices, "componentType", 5121, 5125, std::nullopt);
  if (type != 5121 && type != 5123 && type != 5125) {
    check_.fail(".indices.componentType is " + std::to_string(type) +
                ", expected 5121, 5123 or 5125");
  }
  out["indices"]["componentType"] = type;
}

void Reducer::accessor(const Json& from, Json& to) {
  const std::size_t views = count("bufferViews");
  const int view = check_.index(from, "bufferView", views);
  reduced_.model.without_view.push_back(view < 0);
  to["bufferView"] = static_cast<unsigned>(std::max(view, 0));
  if (view < 0 && from.contains("byteOffset")) check_.fail(" has a byteOffset but no bufferView");
  to["byteOffset"] = check_.whole(from, "byteOffset", 0, JsonChecker::kMost, 0);
  const std::uint64_t type = check_.whole(from, "componentType", 5120, 5126, std::nullopt);
  if (type == 5124) check_.fail(".componentType is 5124, which glTF does not have");
  to["componentType"] = type;
  const bool normalized = check_.truth(from, "normalized");
  if (normalized && (type == 5126 || type == 5125)) {
    warn("a normalized accessor of floats or 32-bit integers is read as it is");
  }
  to["normalized"] = normalized;
  const std::uint64_t count = check_.whole(from, "count", 1, 0xFFFFFFFFu, std::nullopt);
  to["count"] = count;
  const std::string shape = check_.text(from, "type");
  constexpr std::array<std::string_view, 7> kShapes{"SCALAR", "VEC2", "VEC3", "VEC4",
                                                    "MAT2",   "MAT3", "MAT4"};
  if (std::find(kShapes.begin(), kShapes.end(), shape) == kShapes.end()) {
    check_.fail(".type is \"" + shape.substr(0, 20) + "\", expected SCALAR, VEC2 .. MAT4");
  }
  to["type"] = shape;
  if (const Json* const part = check_.object(from, "sparse"); part != nullptr) {
    sparse(*part, to, count);
  }
  check_.inside("");
  if (shape == "VEC3") {
    for (const char* key : {"min", "max"}) {
      const std::vector<double> bounds = check_.numbers(from, key, 3);
      if (!bounds.empty()) to[key] = bounds;
    }
  }
}

void Reducer::material(const Json& from, Json& to) {
  GltfMaterialExtras extras;
  to["name"] = check_.text(from, "name");
  if (const Json* const look = check_.object(from, "pbrMetallicRoughness"); look != nullptr) {
    check_.inside(".pbrMetallicRoughness");
    const std::vector<double> factor = check_.numbers(*look, "baseColorFactor", 4);
    if (!factor.empty()) {
      extras.colored = true;
      to["pbrMetallicRoughness"] = {{"baseColorFactor", factor}};
    }
  }
  if (const Json* const mine = our_extras(from); mine != nullptr) {
    extras.ours = true;
    extras.palette = extras_true(*mine, "palette");
    extras.solid = extras_text(*mine, "solid");
  }
  reduced_.model.materials.push_back(std::move(extras));
}

void Reducer::primitive(const Json& from, Json& to, GltfPrimitiveExtras& extras) {
  const std::size_t accessors = count("accessors");
  const Json* const attributes = check_.object(from, "attributes");
  if (attributes == nullptr || attributes->empty()) {
    check_.fail(" has a primitive without attributes");
    return;
  }
  for (const auto& [name, value] : attributes->items()) {
    to["attributes"][name] =
        static_cast<unsigned>(check_.index_value(value, "primitives.attributes", accessors));
    if (check_.failed()) return;
  }
  if (const int indices = check_.index(from, "indices", accessors); indices >= 0) {
    to["indices"] = static_cast<unsigned>(indices);
  }
  if (const int material = check_.index(from, "material", count("materials")); material >= 0) {
    to["material"] = static_cast<unsigned>(material);
  }
  to["mode"] = check_.whole(from, "mode", 0, 6, 4);
  if (check_.array(from, "targets") != nullptr) ++morphed_;
  if (const Json* const all = check_.object(from, "extensions"); all != nullptr) {
    const Json* const draco = check_.object(*all, "KHR_draco_mesh_compression");
    const Json* const ids = draco == nullptr ? nullptr : check_.object(*draco, "attributes");
    if (draco != nullptr && (ids == nullptr || !draco->contains("bufferView"))) {
      check_.fail(" has a Draco extension without bufferView or attributes");
      return;
    }
    if (draco != nullptr) {
      extras.draco.emplace();
      extras.draco->view = check_.index(*draco, "bufferView", count("bufferViews"));
      for (const auto& [name, id] : ids->items()) {
        if (!id.is_number_unsigned() || id.get<std::uint64_t>() > 0xFFFFFFFFu) {
          check_.fail(" has a Draco attribute with the id " + JsonChecker::shown(id));
          return;
        }
        extras.draco->attributes[name] = id.get<std::uint32_t>();
      }
    }
  }
  if (const Json* const mine = our_extras(from); mine != nullptr)
    extras.curves = curves_of_extras(*mine);
}

void Reducer::mesh(const Json& from, Json& to) {
  to["name"] = check_.text(from, "name");
  const Json* const primitives = check_.array(from, "primitives");
  if (primitives == nullptr || primitives->empty()) {
    check_.fail(" has no primitives");
    return;
  }
  std::vector<GltfPrimitiveExtras>& extras = reduced_.model.primitives.emplace_back();
  Json& out = to["primitives"] = Json::array();
  for (const Json& part : *primitives) {
    if (!part.is_object()) {
      check_.fail(" has a primitive that is no object");
      return;
    }
    Json reduced = Json::object();
    primitive(part, reduced, extras.emplace_back());
    if (check_.failed()) return;
    out.push_back(std::move(reduced));
  }
}

void Reducer::node(const Json& from, Json& to) {
  GltfNodeExtras extras;
  to["name"] = check_.text(from, "name");
  copy_indices(from, to, "children", count("nodes"));
  if (const int mesh = check_.index(from, "mesh", count("meshes")); mesh >= 0) {
    to["mesh"] = static_cast<unsigned>(mesh);
  }
  const std::vector<double> matrix = check_.numbers(from, "matrix", 16);
  if (!matrix.empty()) to["matrix"] = matrix;
  const std::array<std::pair<const char*, std::size_t>, 3> parts{
      {{"translation", 3}, {"rotation", 4}, {"scale", 3}}};
  for (const auto& [key, size] : parts) {
    const std::vector<double> values = check_.numbers(from, key, size);
    if (values.empty()) continue;
    if (!matrix.empty())
      warn("a node with a matrix and a " + std::string(key) + ", which is left out");
    if (matrix.empty()) to[key] = values;
  }
  skinned_ += from.contains("skin") ? 1 : 0;
  cameras_ += from.contains("camera") ? 1 : 0;
  weights_ += from.contains("weights") ? 1 : 0;
  if (const Json* const mine = our_extras(from); mine != nullptr) {
    extras.frame = frame_of_extras(*mine);
    extras.unnamed = extras_true(*mine, "unnamed");
  }
  reduced_.model.nodes.push_back(extras);
}

void Reducer::scene(const Json& from, Json& to) {
  to["name"] = check_.text(from, "name");
  copy_indices(from, to, "nodes", count("nodes"));
}

Result<ReducedGltf> Reducer::run(std::size_t file_bytes) {
  asset();
  extensions();
  unread_sections();
  limit_objects(file_bytes);
  each("buffers", &Reducer::buffer);
  each("bufferViews", &Reducer::view);
  each("accessors", &Reducer::accessor);
  each("materials", &Reducer::material);
  each("meshes", &Reducer::mesh);
  each("nodes", &Reducer::node);
  each("scenes", &Reducer::scene);
  check_.enter("the file", kNoIndex);
  if (const int scene = check_.index(in_, "scene", count("scenes")); scene >= 0) {
    out_["scene"] = static_cast<unsigned>(scene);
  }
  if (check_.failed()) {
    Error error = check_.error();
    error.where.file = file_;
    return error;
  }
  const std::array<std::pair<std::size_t, const char*>, 4> left_out{
      {{morphed_, "primitive has|primitives have| morph targets"},
       {skinned_, "node has|nodes have| a skin"},
       {cameras_, "node holds|nodes hold| a camera"},
       {weights_, "node has|nodes have| morph weights"}}};
  for (const auto& [count, what] : left_out) {
    if (count > 0) warn(counted(count, what) + ", which is left out");
  }
  for (const auto& [text, count] : warnings_) {
    diagnostics_.warning(count > 1 ? text + " (" + std::to_string(count) + " times)" : text,
                         Place{file_});
  }
  out_.erase("buffers");
  // Accessors without a view are given the first; where the file has none, one for them to name.
  if (count("bufferViews") == 0) {
    out_["bufferViews"] = Json::array({{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 1}}});
    reduced_.model.meshopt.emplace_back();
  }
  reduced_.text = out_.dump(-1, ' ', true, Json::error_handler_t::replace);
  return std::move(reduced_);
}

}  // namespace

Result<ReducedGltf> reduce_gltf(const Json& json, std::size_t file_bytes, const std::string& file,
                                Diagnostics& diagnostics) {
  return Reducer(json, file, diagnostics).run(file_bytes);
}

}  // namespace diesink
