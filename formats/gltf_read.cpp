// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_read.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <new>
#include <set>

#include "formats/gltf_color.h"
#include "formats/gltf_primitive.h"
#include "formats/gltf_scene.h"
#include "formats/gltf_weld.h"

namespace diesink {
namespace {

namespace tg = diesink_tinygltf;

constexpr std::size_t kItemsOfAny = 500'000;  // vertices or triangles a file of any size may hold
constexpr std::size_t kItemsPerByte = 4;
constexpr std::size_t kItemsPerPackedByte = 64;
// The placing of an instance: points, normals, and whether it mirrors.
struct Placing {
  bool identity = true;
  Mat3 linear = Mat3::Identity();
  Mat3 for_normals = Mat3::Identity();
  Vec3 move = Vec3::Zero();
  bool mirrors = false, flat = false;

  explicit Placing(const NodeMatrix& m) {
    identity = m == kIdentity;
    if (identity) return;
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) linear(r, c) = m[static_cast<std::size_t>(4 * c + r)];
      move[c] = m[static_cast<std::size_t>(12 + c)];
    }
    const double volume = linear.determinant();
    mirrors = volume < 0;
    flat = volume == 0 || !std::isfinite(volume);
    if (!flat) for_normals = linear.inverse().transpose();
  }

  [[nodiscard]] Vec3 point(const Vec3& p) const { return identity ? p : Vec3(linear * p + move); }
  // Unit length; what is so to a thousandth stays as the file has it. Not finite where there is no
  // direction.
  [[nodiscard]] Vec3 normal(const Vec3& n) const {
    const bool kept = identity && std::abs(n.squaredNorm() - 1) < 2e-3;
    if (kept) return n;
    const Vec3 turned = identity ? n : Vec3(for_normals * n);
    return turned / turned.norm();
  }
};

class Reader {
 public:
  Reader(const GltfModel& model, const ReadOptions& options, Diagnostics& diagnostics,
         std::size_t file_bytes)
      : model_(model),
        options_(options),
        diagnostics_(diagnostics),
        primitives_(model, warnings_),
        weld_(mesh_, options.weld) {
    std::size_t bytes = file_bytes;
    for (const GltfBuffer& buffer : model.buffers) bytes += buffer.owned.size();
    most_items_ = kItemsOfAny + kItemsPerByte * bytes + kItemsPerPackedByte * packed_bytes();
  }

  Result<TriangleMesh> run();

 private:
  using Indices = std::vector<std::uint32_t>;

  [[nodiscard]] const tg::Primitive& file_primitive(const GltfInstance& at, std::size_t p) const {
    return model_.file.meshes[static_cast<std::size_t>(at.mesh)].primitives[p];
  }
  [[nodiscard]] const GltfPrimitiveExtras& extras(const GltfInstance& at, std::size_t p) const {
    return model_.primitives[static_cast<std::size_t>(at.mesh)][p];
  }
  void warn(const std::string& text) { warnings_.add(text); }
  Error wrong(const std::string& what) const {
    return Error{ErrorCode::kInput, place_ + what, Place{options_.file_name}};
  }

  [[nodiscard]] std::size_t packed_bytes() const;
  Status count_items(const GltfScene& scene);
  void prepare_elements();
  void check_extent();
  std::uint32_t element_for(const GltfScene& scene, const GltfInstance& at, std::size_t p);
  std::string fresh_name(std::string name);
  Status add_primitive(const GltfScene& scene, const GltfInstance& at, std::size_t p);
  // Moves the positions into the scene and gives the vertex of each.
  Result<Indices> place_vertices(GltfArrays& arrays, const Placing& placing, const Vec3& offset,
                                 bool lines);
  void add_triangles(const GltfArrays& arrays, const Placing& placing, const Indices& vertex,
                     int mode, std::uint32_t element);
  void add_lines(const GltfArrays& arrays, const Indices& vertex, int mode,
                 const std::vector<GltfCurve>& curves);
  void add_segments(const Indices& points);

  const GltfModel& model_;
  const ReadOptions& options_;
  Diagnostics& diagnostics_;
  GltfWarnings warnings_;
  GltfPrimitives primitives_;
  TriangleMesh mesh_;
  GltfWeld weld_;
  std::size_t most_items_ = 0;
  bool any_normals_ = false;
  std::vector<int> element_of_material_;      // of our own materials, else -1
  std::map<std::string, std::size_t> names_;  // and the last number given behind each
  std::string place_;                         // "meshes[0].primitives[2] ", for messages
};

// Of all views that hold compressed geometry, each counted once.
std::size_t Reader::packed_bytes() const {
  std::set<int> views;
  for (const auto& mesh : model_.primitives) {
    for (const GltfPrimitiveExtras& primitive : mesh) {
      if (primitive.draco) views.insert(primitive.draco->view);
    }
  }
  std::size_t bytes = 0;
  for (const int view : views) {
    bytes += model_.file.bufferViews[static_cast<std::size_t>(view)].byteLength;
  }
  for (const std::optional<GltfMeshopt>& packed : model_.meshopt) {
    if (packed) bytes += packed->length;
  }
  return bytes;
}

// Adds up what the instances will need before anything is built, so that a few bytes cannot ask for
// much.
Status Reader::count_items(const GltfScene& scene) {
  std::size_t vertices = 0, triangles = 0, most_in_group = 0;
  for (const GltfInstance& at : scene.instances) {
    const std::size_t before = scene.ours ? 0 : vertices;
    const auto& primitives = model_.file.meshes[static_cast<std::size_t>(at.mesh)].primitives;
    for (const tg::Primitive& primitive : primitives) {
      const auto position = primitive.attributes.find("POSITION");
      if (position == primitive.attributes.end()) continue;
      const std::size_t points =
          model_.file.accessors[static_cast<std::size_t>(position->second)].count;
      const std::size_t indices =
          primitive.indices < 0
              ? points
              : model_.file.accessors[static_cast<std::size_t>(primitive.indices)].count;
      vertices += points;
      if (primitive.mode >= kTriangleList) {
        triangles += primitive.mode == kTriangleList ? indices / 3 : indices;
      } else {
        triangles += indices / 3;  // lines, at what they cost
      }
      if (primitive.attributes.contains("NORMAL") && primitive.mode >= kTriangleList) {
        any_normals_ = true;
      }
    }
    most_in_group = std::max(most_in_group, vertices - before);
    if (triangles > options_.max_triangles) {
      return Error{ErrorCode::kLimit,
                   "the scene has more than the " + std::to_string(options_.max_triangles) +
                       " triangles that are read",
                   Place{options_.file_name}};
    }
    if (std::max(vertices, triangles) > most_items_) {
      return Error{ErrorCode::kLimit,
                   "the scene claims more than the " + std::to_string(most_items_) +
                       " vertices or triangles that a file of its size may hold",
                   Place{options_.file_name}};
    }
  }
  // Positions, normals, triangles and what is kept beside them while reading.
  if (vertices * 128 + triangles * 48 > options_.max_memory) {
    return Error{ErrorCode::kLimit, "the scene needs more memory than allowed",
                 Place{options_.file_name}};
  }
  weld_.expect(most_in_group);
  mesh_.triangles.reserve(triangles);
  mesh_.triangle_element.reserve(triangles);
  if (any_normals_) mesh_.corner_normals.reserve(triangles);
  return ok();
}

// glTF's unit is the metre; many files hold millimetres all the same.
void Reader::check_extent() {
  if (mesh_.positions.empty()) return;
  Vec3 low = mesh_.positions[0], high = low;
  for (const Vec3& p : mesh_.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double metres = (high - low).maxCoeff() * metres_per(mesh_.unit);
  if (metres > 100 || (metres > 0 && metres < 1e-4)) {
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.begin(), text.end(), metres, std::chars_format::general, 4);
    warn("the mesh is " + std::string(text.begin(), end.ptr) +
         " m large: its unit may not be the metre that glTF prescribes");
  }
}

// Our own materials are the elements, in their order, whether a primitive uses them or not.
void Reader::prepare_elements() {
  element_of_material_.assign(model_.materials.size(), -1);
  for (std::size_t m = 0; m < model_.materials.size(); ++m) {
    const GltfMaterialExtras& material = model_.materials[m];
    if (!material.ours) continue;
    MeshElement element;
    element.name = model_.file.materials[m].name;
    element.solid = material.solid;
    if (material.colored && !material.palette) {
      const auto& factor = model_.file.materials[m].pbrMetallicRoughness.baseColorFactor;
      element.color = srgb_of({factor[0], factor[1], factor[2], factor[3]});
    }
    names_[element.name] = 1;
    element_of_material_[m] = static_cast<int>(mesh_.elements.size());
    mesh_.elements.push_back(std::move(element));
  }
}

// The name, or the name with the first number behind it that makes it new.
std::string Reader::fresh_name(std::string name) {
  std::size_t& last = names_[name];
  if (++last == 1) return name;
  for (;; ++last) {
    std::string numbered = name + '#' + std::to_string(last);
    if (names_.try_emplace(numbered, 1).second) return numbered;
  }
}

std::uint32_t Reader::element_for(const GltfScene& scene, const GltfInstance& at, std::size_t p) {
  const tg::Primitive& primitive = file_primitive(at, p);
  const bool has_material = primitive.material >= 0;
  const std::size_t material = has_material ? static_cast<std::size_t>(primitive.material) : 0;
  if (has_material && element_of_material_[material] >= 0) {
    return static_cast<std::uint32_t>(element_of_material_[material]);
  }
  // What our writer leaves without a material belongs to a mesh without elements.
  if (scene.ours && !has_material && mesh_.elements.empty()) return MeshCurve::kNoElement;
  MeshElement element;
  const tg::Mesh& mesh = model_.file.meshes[static_cast<std::size_t>(at.mesh)];
  element.name = model_.file.nodes[static_cast<std::size_t>(at.node)].name;
  if (element.name.empty()) element.name = mesh.name;
  if (element.name.empty()) element.name = "mesh" + std::to_string(at.mesh);
  if (has_material) {
    const tg::Material& look = model_.file.materials[material];
    element.solid = look.name;
    if (model_.materials[material].colored) {
      const auto& factor = look.pbrMetallicRoughness.baseColorFactor;
      element.color = srgb_of({factor[0], factor[1], factor[2], factor[3]});
    }
  }
  if (mesh.primitives.size() > 1) {
    element.name += '.' + (element.solid.empty() ? std::to_string(p) : element.solid);
  }
  element.name = fresh_name(std::move(element.name));
  mesh_.elements.push_back(std::move(element));
  return static_cast<std::uint32_t>(mesh_.elements.size() - 1);
}

Result<Reader::Indices> Reader::place_vertices(GltfArrays& arrays, const Placing& placing,
                                               const Vec3& offset, bool lines) {
  for (std::size_t i = 0; i < arrays.positions.size(); ++i) {
    const Vec3 p = placing.point(arrays.positions[i]) + offset;
    arrays.positions[i] = p;
    if (!p.allFinite()) {
      return wrong("has a position that is not finite in the scene, number " + std::to_string(i));
    }
    // The Khronos samples have a mesh beyond 1e9; past all floats only a node's matrix can lead.
    if (const double size = p.cwiseAbs().maxCoeff(); size > options_.max_coordinate) {
      constexpr auto kLargestFloat = static_cast<double>(std::numeric_limits<float>::max());
      if (size > kLargestFloat) {
        Error over = wrong("has a position beyond any 32-bit float in the scene, number " +
                           std::to_string(i));
        over.code = ErrorCode::kLimit;
        return over;
      }
      warn("a position beyond " + std::to_string(static_cast<long long>(options_.max_coordinate)));
    }
  }
  return lines && arrays.colors.empty() ? weld_.line_vertices(arrays.positions)
                                        : weld_.vertices(arrays.positions, arrays.colors);
}

void Reader::add_triangles(const GltfArrays& arrays, const Placing& placing, const Indices& vertex,
                           int mode, std::uint32_t element) {
  constexpr std::uint32_t kUnknown = 0xFFFFFFFFu;
  const Indices& indices = arrays.indices;
  Indices normal_of(any_normals_ ? arrays.normals.size() : 0, kUnknown);
  const auto normal_at = [&](std::uint32_t corner) {
    Vec3 n = placing.normal(arrays.normals[corner]);
    if (!n.allFinite()) {
      warn("a normal without a direction is read as 0 0 1");
      n = Vec3::UnitZ();
    }
    return weld_.normal(vertex[corner], n);
  };
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    std::array<std::uint32_t, 3> corner{indices[a], indices[b], indices[c]};
    if (mode == kTriangleStrip &&
        (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0])) {
      warn("a triangle without area that joins parts of a strip is left out");
      return;
    }
    if (placing.mirrors) std::swap(corner[1], corner[2]);
    const std::array<std::uint32_t, 3> triangle{vertex[corner[0]], vertex[corner[1]],
                                                vertex[corner[2]]};
    mesh_.triangles.push_back(triangle);
    mesh_.triangle_element.push_back(element);
    if (!any_normals_) return;
    std::array<std::uint32_t, 3> normals{};
    Vec3 flat = Vec3::UnitZ();
    if (arrays.normals.empty()) {
      // Without normals a primitive is shaded flat (glTF 2.0, section 3.7.2.1).
      const Vec3& o = mesh_.positions[triangle[0]];
      const Vec3 n = (mesh_.positions[triangle[1]] - o).cross(mesh_.positions[triangle[2]] - o);
      if (n.norm() > 0) flat = n.normalized();
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (arrays.normals.empty()) {
        normals[k] = weld_.normal(triangle[k], flat);
        continue;
      }
      std::uint32_t& known = normal_of[corner[k]];
      if (known == kUnknown) known = normal_at(corner[k]);
      normals[k] = known;
    }
    mesh_.corner_normals.push_back(normals);
  };
  const std::size_t count = indices.size();
  if (mode == kTriangleList) {
    if (count % 3 != 0) warn("a list of triangles with a corner or two too many");
    for (std::size_t i = 0; i + 2 < count; i += 3) add(i, i + 1, i + 2);
  } else {
    if (count < 3) warn("a strip or fan of less than three corners");
    for (std::size_t i = 0; i + 2 < count; ++i) {
      if (mode == kTriangleFan) {
        add(0, i + 1, i + 2);
      } else {
        add(i, i + 1 + i % 2, i + 2 - i % 2);
      }
    }
  }
}

// Pairs of points; those that go on where the last ended make one curve.
void Reader::add_segments(const Indices& points) {
  MeshCurve curve;
  const auto finish = [&] {
    if (curve.vertices.size() > 3 && curve.vertices.front() == curve.vertices.back()) {
      curve.vertices.pop_back();
      curve.closed = true;
    }
    if (curve.vertices.size() > 1) mesh_.curves.push_back(curve);
    curve = MeshCurve{};
  };
  for (std::size_t i = 0; i + 1 < points.size(); i += 2) {
    if (curve.vertices.empty() || curve.vertices.back() != points[i]) {
      finish();
      curve.vertices.push_back(points[i]);
    }
    curve.vertices.push_back(points[i + 1]);
  }
  finish();
}

void Reader::add_lines(const GltfArrays& arrays, const Indices& vertex, int mode,
                       const std::vector<GltfCurve>& curves) {
  Indices points(arrays.indices.size());
  std::transform(arrays.indices.begin(), arrays.indices.end(), points.begin(),
                 [&vertex](std::uint32_t index) { return vertex[index]; });
  std::size_t told = 0;
  for (const GltfCurve& curve : curves) {
    told = curve.vertices <= vertex.size() - told ? told + curve.vertices : vertex.size() + 1;
    if (told > vertex.size()) break;
  }
  if (!curves.empty() && told == vertex.size()) {
    std::size_t at = 0;
    for (const GltfCurve& from : curves) {
      MeshCurve curve;
      curve.kind = from.kind;
      curve.closed = from.closed;
      curve.name = from.name;
      for (std::size_t k = 0; k < 2; ++k) {
        if (from.between[k] < mesh_.elements.size()) curve.between[k] = from.between[k];
      }
      const auto begin = vertex.begin() + static_cast<std::ptrdiff_t>(at);
      curve.vertices.assign(begin, begin + static_cast<std::ptrdiff_t>(from.vertices));
      at += from.vertices;
      mesh_.curves.push_back(std::move(curve));
    }
    return;
  }
  if (mode == kLineList) {
    if (points.size() % 2 != 0) warn("a list of lines with an end too many");
    add_segments(points);
    return;
  }
  MeshCurve curve;
  curve.closed = mode == kLineLoop && points.size() > 2;
  curve.vertices = std::move(points);
  if (curve.vertices.size() > 1) mesh_.curves.push_back(std::move(curve));
}

Status Reader::add_primitive(const GltfScene& scene, const GltfInstance& at, std::size_t p) {
  place_ = "meshes[" + std::to_string(at.mesh) + "].primitives[" + std::to_string(p) + "] ";
  const tg::Primitive& primitive = file_primitive(at, p);
  if (!primitive.attributes.contains("POSITION")) {
    warn("a primitive without positions is left out");
    return ok();
  }
  if (primitive.mode == kPoints) {
    warn("a primitive of points is left out");
    return ok();
  }
  auto loaded = primitives_.read(at.mesh, p);
  if (!loaded) return loaded.error();
  const Placing placing(at.matrix);
  if (placing.flat) warn("a node whose matrix makes its mesh flat");
  const bool lines = primitive.mode < kTriangleList;
  const auto vertex = place_vertices(*loaded, placing, scene.frame.offset, lines);
  if (!vertex) return vertex.error();
  if (lines) {
    add_lines(*loaded, *vertex, primitive.mode, extras(at, p).curves);
  } else {
    add_triangles(*loaded, placing, *vertex, primitive.mode, element_for(scene, at, p));
  }
  return ok();
}

Result<TriangleMesh> Reader::run() {
  const GltfScene scene = scene_of(model_, options_.file_name, diagnostics_);
  if (Status s = count_items(scene); !s) return s.error();
  mesh_.name = scene.name;
  mesh_.unit = scene.frame.unit;
  mesh_.up = scene.frame.up;
  prepare_elements();
  for (const GltfInstance& at : scene.instances) {
    if (!scene.ours) weld_.next_group();
    const std::size_t count =
        model_.file.meshes[static_cast<std::size_t>(at.mesh)].primitives.size();
    for (std::size_t p = 0; p < count; ++p) {
      if (Status s = add_primitive(scene, at, p); !s) return s.error();
    }
  }
  if (mesh_.triangles.empty() && mesh_.curves.empty()) warn("the scene holds no triangles");
  if (!scene.ours) check_extent();
  if (mesh_.elements.empty()) {
    mesh_.triangle_element.clear();
  } else {
    // Triangles without an element beside others that have one.
    for (std::uint32_t& element : mesh_.triangle_element) {
      if (element != MeshCurve::kNoElement) continue;
      element = static_cast<std::uint32_t>(mesh_.elements.size());
    }
    const auto beyond = std::find(mesh_.triangle_element.begin(), mesh_.triangle_element.end(),
                                  mesh_.elements.size());
    if (beyond != mesh_.triangle_element.end()) {
      mesh_.elements.push_back({fresh_name("unnamed"), "", {}});
    }
  }
  if (!mesh_.vertex_colors.empty()) {
    mesh_.vertex_colors.resize(mesh_.positions.size(), {255, 255, 255, 255});
  }
  warnings_.tell(options_.file_name, diagnostics_);
  return std::move(mesh_);
}

}  // namespace

Result<TriangleMesh> read_gltf(std::span<const std::byte> bytes, const ReadOptions& options,
                               Diagnostics& diagnostics) {
  try {
    const auto model = load_gltf(bytes, options, diagnostics);
    if (!model) return model.error();
    auto mesh = Reader(*model, options, diagnostics, bytes.size()).run();
    if (!mesh && mesh.error().where.file.empty()) mesh.error().where.file = options.file_name;
    return mesh;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kLimit, "not enough memory", Place{options.file_name}};
  } catch (const std::length_error&) {
    return Error{ErrorCode::kLimit, "more than memory can hold", Place{options.file_name}};
  }
}

}  // namespace diesink
