// Written with a JSON library and our own layout: tinygltf's writer copies every buffer, knows no
// Draco and reports success on a full disk.
// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_text.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/element_runs.h"
#include "formats/gltf_color.h"

namespace diesink {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFloat = 5126, kUint16 = 5123, kUint32 = 5125;
constexpr int kVertexTarget = 34962, kIndexTarget = 34963;
constexpr int kModeLines = 1;

// Whole numbers without ".0", and no negative zero.
Json number(double value) {
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<std::int64_t>(value);
  return value;
}

// Floats as the doubles they are: readers get the very value back.
Json exact(const std::array<float, 3>& v) {
  return Json::array({number(static_cast<double>(v[0])), number(static_cast<double>(v[1])),
                      number(static_cast<double>(v[2]))});
}

Json numbers(std::span<const double> values) {
  Json out = Json::array();
  for (const double value : values) out.push_back(number(value));
  return out;
}

class Writer {
 public:
  Writer(const GltfLayout& layout, const TriangleMesh& mesh) : layout_(layout), mesh_(mesh) {}

  Json write(const WriteOptions& options, const std::string& uri);

 private:
  int add_accessor(Json accessor);
  [[nodiscard]] int view_number(GltfViewKind kind) const;
  Json primitive_json(const GltfPrimitive& primitive);
  Json attributes_json(const GltfPrimitive& primitive);
  [[nodiscard]] Json curves_json() const;
  [[nodiscard]] Json materials_json() const;
  [[nodiscard]] Json views_json() const;
  [[nodiscard]] Json root_node() const;
  void add_meshes();

  const GltfLayout& layout_;
  const TriangleMesh& mesh_;
  Json json_;
};

int Writer::add_accessor(Json accessor) {
  json_["accessors"].push_back(std::move(accessor));
  return static_cast<int>(json_["accessors"].size() - 1);
}

// Views are numbered in the order views_json lists them: those that hold something.
int Writer::view_number(GltfViewKind kind) const {
  int n = 0;
  for (std::size_t k = 0; k < kind; ++k) n += layout_.views[k].size > 0 ? 1 : 0;
  return n;
}

Json Writer::attributes_json(const GltfPrimitive& primitive) {
  const bool packed = primitive.blob >= 0;
  // Compressed attributes have an accessor that tells their type, and no place in the buffer.
  const auto accessor = [&](GltfViewKind view, std::size_t at, int component, const char* type) {
    Json json;
    if (!packed) json = {{"bufferView", view_number(view)}, {"byteOffset", at}};
    json["componentType"] = component;
    if (view == kColors) json["normalized"] = true;
    json["count"] = primitive.vertex_count;
    json["type"] = type;
    return json;
  };
  Json attributes;
  Json position = accessor(kPositions, primitive.position_at, kFloat, "VEC3");
  position["min"] = exact(primitive.low);
  position["max"] = exact(primitive.high);
  attributes["POSITION"] = add_accessor(std::move(position));
  if (primitive.with_normals) {
    attributes["NORMAL"] = add_accessor(accessor(kNormals, primitive.normal_at, kFloat, "VEC3"));
  }
  if (primitive.colored) {
    attributes["COLOR_0"] = add_accessor(accessor(kColors, primitive.color_at, kUint16, "VEC4"));
  }
  if (packed && layout_.blobs[static_cast<std::size_t>(primitive.blob)].element_id >= 0) {
    attributes["_ELEMENT"] = add_accessor(
        {{"componentType", kUint16}, {"count", primitive.vertex_count}, {"type", "SCALAR"}});
  }
  return attributes;
}

Json Writer::primitive_json(const GltfPrimitive& primitive) {
  const bool is_short = primitive.short_indices();
  Json out = {{"attributes", attributes_json(primitive)}};
  Json indices;
  if (primitive.blob < 0) {
    indices = {{"bufferView", view_number(is_short ? kShortIndices : kLongIndices)},
               {"byteOffset", primitive.index_at}};
  }
  indices["componentType"] = is_short ? kUint16 : kUint32;
  indices["count"] = primitive.index_count;
  indices["type"] = "SCALAR";
  out["indices"] = add_accessor(std::move(indices));
  if (primitive.lines) {
    out["mode"] = kModeLines;
    out["extras"] = {{"diesink", {{"curves", curves_json()}}}};
  } else if (primitive.element != MeshCurve::kNoElement) {
    out["material"] = primitive.element;
  }
  if (primitive.blob >= 0) {
    const DracoBlob& blob = layout_.blobs[static_cast<std::size_t>(primitive.blob)];
    Json ids = {{"POSITION", blob.position_id}};
    if (blob.normal_id >= 0) ids["NORMAL"] = blob.normal_id;
    if (blob.color_id >= 0) ids["COLOR_0"] = blob.color_id;
    if (blob.element_id >= 0) ids["_ELEMENT"] = blob.element_id;
    out["extensions"] = {{"KHR_draco_mesh_compression",
                          {{"bufferView", view_number(kViewKinds) + primitive.blob},
                           {"attributes", std::move(ids)}}}};
  }
  return out;
}

Json Writer::curves_json() const {
  Json curves = Json::array();
  for (const MeshCurve* curve : layout_.lines.curves) {
    Json about = {{"kind", name_of(curve->kind)},
                  {"vertices", curve->vertices.size()},
                  {"closed", curve->closed}};
    if (!curve->name.empty()) about["name"] = curve->name;
    Json between = Json::array();
    for (const std::uint32_t element : curve->between) {
      between.push_back(element < mesh_.elements.size() ? static_cast<std::int64_t>(element) : -1);
    }
    about["between"] = std::move(between);
    curves.push_back(std::move(about));
  }
  return curves;
}

Json Writer::materials_json() const {
  Json materials = Json::array();
  for (std::size_t e = 0; e < mesh_.elements.size(); ++e) {
    const MeshElement& element = mesh_.elements[e];
    const std::array<double, 4> factor =
        element.color ? factor_of(*element.color) : palette_factor(e);
    Json ours = {{"solid", element.solid}};
    if (!element.color) ours["palette"] = true;
    Json material = {
        {"name", element.name},
        {"pbrMetallicRoughness",
         {{"baseColorFactor", numbers(factor)}, {"metallicFactor", 0.2}, {"roughnessFactor", 0.6}}},
        {"doubleSided", true},
        {"extras", {{"diesink", std::move(ours)}}}};
    if (factor[3] < 1) material["alphaMode"] = "BLEND";
    materials.push_back(std::move(material));
  }
  return materials;
}

Json Writer::views_json() const {
  Json views = Json::array();
  for (const GltfView& view : layout_.views) {
    if (view.size == 0) continue;
    Json json = {{"buffer", 0}, {"byteOffset", view.offset}, {"byteLength", view.size}};
    if (view.stride > 0) json["byteStride"] = view.stride;
    json["target"] = view.stride > 0 ? kVertexTarget : kIndexTarget;
    views.push_back(std::move(json));
  }
  for (std::size_t b = 0; b < layout_.blobs.size(); ++b) {
    views.push_back({{"buffer", 0},
                     {"byteOffset", layout_.blob_at[b]},
                     {"byteLength", layout_.blobs[b].bytes.size()}});
  }
  return views;
}

Json Writer::root_node() const {
  const RootFrame& frame = layout_.frame;
  Json root = {{"name", mesh_.name.empty() ? std::string("part") : mesh_.name}};
  const NodeMatrix matrix = matrix_of(frame);
  if (matrix != kIdentity) root["matrix"] = numbers(matrix);
  Json ours = {
      {"unit", diesink::name_of(frame.unit)},
      {"up", frame.up == UpAxis::kUnknown ? "unknown" : (frame.up == UpAxis::kY ? "y" : "z")},
      {"offset", numbers(std::span(frame.offset.data(), 3))}};
  if (mesh_.name.empty()) ours["unnamed"] = true;
  root["extras"] = {{"diesink", std::move(ours)}};
  return root;
}

void Writer::add_meshes() {
  Json surface = Json::array();
  Json lines = Json::array();
  for (const GltfPrimitive& primitive : layout_.primitives) {
    (primitive.lines ? lines : surface).push_back(primitive_json(primitive));
  }
  Json meshes = Json::array();
  if (!surface.empty()) {
    meshes.push_back({{"name", "surface"}, {"primitives", std::move(surface)}});
  }
  if (!lines.empty()) meshes.push_back({{"name", "curves"}, {"primitives", std::move(lines)}});
  Json children = Json::array();
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    children.push_back(json_["nodes"].size());
    json_["nodes"].push_back({{"name", meshes[m]["name"]}, {"mesh", m}});
  }
  if (children.empty()) return;
  json_["nodes"][0]["children"] = std::move(children);
  json_["meshes"] = std::move(meshes);
}

Json Writer::write(const WriteOptions& options, const std::string& uri) {
  json_["asset"] = {{"version", "2.0"}};
  if (!options.program_comment.empty()) json_["asset"]["generator"] = options.program_comment;
  if (!options.extras_json.empty()) {
    json_["asset"]["extras"] = Json::parse(options.extras_json, nullptr, false);
  }
  if (!layout_.blobs.empty()) {
    json_["extensionsUsed"] = json_["extensionsRequired"] =
        Json::array({"KHR_draco_mesh_compression"});
  }
  json_["scene"] = 0;
  json_["scenes"] = Json::array({{{"nodes", Json::array({0})}}});
  json_["nodes"] = Json::array({root_node()});
  add_meshes();
  if (!mesh_.elements.empty()) json_["materials"] = materials_json();
  if (layout_.buffer_size > 0) {
    json_["bufferViews"] = views_json();
    Json buffer;
    if (!uri.empty()) buffer["uri"] = uri;
    buffer["byteLength"] = layout_.buffer_size;
    json_["buffers"] = Json::array({std::move(buffer)});
  }
  return std::move(json_);
}

}  // namespace

Result<std::string> gltf_text(const GltfLayout& layout, const TriangleMesh& mesh,
                              const WriteOptions& options, const std::string& uri) {
  if (!options.extras_json.empty() && !Json::accept(options.extras_json)) {
    return Error{ErrorCode::kUsage, "the extras for the file are not JSON", {}};
  }
  const Json json = Writer(layout, mesh).write(options, uri);
  return json.dump(uri.empty() ? -1 : 1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace diesink
