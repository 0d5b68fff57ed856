// SPDX-License-Identifier: Apache-2.0
#include "viewer/scene.h"

#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <unordered_map>

#include "core/parallel.h"
#include "formats/json_writer.h"
#include "formats/path_file.h"
#include "viewer/packed_arrays.h"
#include "viewer/page.h"

namespace diesink {
namespace {

using Box = std::array<Vec3, 2>;

constexpr double kNormalSteps = 2047;  // either way, of an octahedron's coordinate
// A browser's longest string is 512 MiB.
constexpr std::size_t kMostBytes = std::size_t{360} << 20;

double round_down_to_decade(double value) { return std::pow(10, std::floor(std::log10(value))); }

Box box_of(const Scene& scene) {
  Box box{Vec3::Constant(std::numeric_limits<double>::infinity()),
          Vec3::Constant(-std::numeric_limits<double>::infinity())};
  const auto add = [&](const Vec3& p) {
    box[0] = box[0].cwiseMin(p);
    box[1] = box[1].cwiseMax(p);
  };
  for (const auto& triangle : scene.mesh.triangles) {
    for (const std::uint32_t v : triangle) add(scene.mesh.positions[v]);
  }
  if (scene.path) {
    for (const ClPoint& point : scene.path->points) add(point.tip);
  }
  return box;
}

// The grid of a scene's coordinates: whole steps from a corner that is a whole number of steps
// itself.
struct Grid {
  double per_unit = 1;         // steps a unit of length
  Vec3 corner = Vec3::Zero();  // in steps

  [[nodiscard]] std::array<std::int32_t, 3> of(const Vec3& p) const {
    std::array<std::int32_t, 3> steps{};
    for (int k = 0; k < 3; ++k) {
      steps[static_cast<std::size_t>(k)] =
          static_cast<std::int32_t>(std::round(p[k] * per_unit) - corner[k]);
    }
    return steps;
  }
};

Grid grid_of(const Box& box, double quantum) {
  Grid grid;
  grid.per_unit = quantum < 1 ? std::round(1 / quantum) : 1 / quantum;
  for (int k = 0; k < 3; ++k) grid.corner[k] = std::round(box[0][k] * grid.per_unit);
  return grid;
}

void append(std::vector<std::int32_t>& to, const std::array<std::int32_t, 3>& steps) {
  to.insert(to.end(), steps.begin(), steps.end());
}

// A unit vector on the octahedron |x| + |y| + |z| = 1, its lower half folded outward.
std::array<std::int32_t, 2> octahedral(const Vec3& n) {
  const double sum = std::abs(n.x()) + std::abs(n.y()) + std::abs(n.z());
  if (!(sum > 0)) return {0, 0};
  double u = n.x() / sum, v = n.y() / sum;
  if (n.z() < 0) {
    const double folded = (1 - std::abs(v)) * (u < 0 ? -1 : 1);
    v = (1 - std::abs(u)) * (v < 0 ? -1 : 1);
    u = folded;
  }
  return {static_cast<std::int32_t>(std::lround(u * kNormalSteps)),
          static_cast<std::int32_t>(std::lround(v * kNormalSteps))};
}

// The triangles of one element with vertices of their own: a vertex has one normal, and none is
// shared with another element, so that each can be drawn alone.
class ElementMesh {
 public:
  explicit ElementMesh(const TriangleMesh& mesh) : mesh_(&mesh) {}

  void add(std::size_t t) {
    triangles_.push_back(static_cast<std::uint32_t>(t));
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t key =
          std::uint64_t{mesh_->triangles[t][k]} << 32 | mesh_->corner_normals[t][k];
      const auto next = static_cast<std::uint32_t>(vertices_.size());
      const auto [found, fresh] = known_.try_emplace(key, next);
      if (fresh) vertices_.push_back(key);
      indices_.push_back(found->second);
    }
  }

  // Neighbours after one another, triangles and vertices: small differences, and fast to draw.
  // `triangles_too`: triangles() in the new order as well, which takes longer.
  void sort(bool triangles_too) {
    if (indices_.empty()) return;
    std::vector<std::uint32_t> order(indices_.size());
    meshopt_optimizeVertexCache(order.data(), indices_.data(), indices_.size(), vertices_.size());
    if (triangles_too) sort_triangles_like(order);
    std::vector<std::uint32_t> place(vertices_.size(), kNone);
    std::vector<std::uint64_t> sorted;
    sorted.reserve(vertices_.size());
    for (std::uint32_t& each : order) {
      if (place[each] == kNone) {
        place[each] = static_cast<std::uint32_t>(sorted.size());
        sorted.push_back(vertices_[each]);
      }
      each = place[each];
    }
    indices_ = std::move(order);
    vertices_ = std::move(sorted);
  }

  [[nodiscard]] const std::vector<std::uint32_t>& indices() const { return indices_; }
  [[nodiscard]] const std::vector<std::uint32_t>& triangles() const { return triangles_; }
  [[nodiscard]] std::size_t vertex_count() const { return vertices_.size(); }
  [[nodiscard]] const Vec3& position(std::size_t v) const {
    return mesh_->positions[static_cast<std::uint32_t>(vertices_[v] >> 32)];
  }
  [[nodiscard]] const Vec3& normal(std::size_t v) const {
    return mesh_->normals[static_cast<std::uint32_t>(vertices_[v])];
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  // meshoptimizer tells the new order of corners only: each triangle is found by them again. Equal
  // triangles keep their order among themselves.
  void sort_triangles_like(const std::vector<std::uint32_t>& order) {
    using Key = std::array<std::uint32_t, 3>;
    const auto key = [](const std::uint32_t* corner) {
      Key sorted{corner[0], corner[1], corner[2]};
      std::sort(sorted.begin(), sorted.end());
      return sorted;
    };
    std::vector<std::pair<Key, std::uint32_t>> before(triangles_.size()), after(triangles_.size());
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      before[t] = {key(&indices_[3 * std::size_t{t}]), t};
      after[t] = {key(&order[3 * std::size_t{t}]), t};
    }
    std::sort(before.begin(), before.end());
    std::sort(after.begin(), after.end());
    std::vector<std::uint32_t> sorted(triangles_.size());
    for (std::size_t k = 0; k < before.size(); ++k) {
      sorted[after[k].second] = triangles_[before[k].second];
    }
    triangles_ = std::move(sorted);
  }

  const TriangleMesh* mesh_;
  std::vector<std::uint32_t> triangles_, indices_;
  std::vector<std::uint64_t> vertices_;  // position and normal
  std::unordered_map<std::uint64_t, std::uint32_t> known_;
};

double area_of(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles) {
  double sum = 0;
  for (const std::uint32_t t : triangles) {
    const auto& [i, j, k] = mesh.triangles[t];
    sum += (mesh.positions[j] - mesh.positions[i])
               .cross(mesh.positions[k] - mesh.positions[i])
               .norm() /
           2;
  }
  return sum;
}

std::string hex_of(const Rgb& color) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text = "#";
  for (const float each : color) {
    const auto value = static_cast<unsigned>(std::lround(std::clamp(each, 0.0F, 1.0F) * 255));
    text += kDigits[value >> 4];
    text += kDigits[value & 15];
  }
  return text;
}

// So that the largest takes 15 bits.
double deviation_step(std::span<const float> deviations) {
  float largest = 0;
  for (const float each : deviations) largest = std::max(largest, std::abs(each));  // NaN: passed
  return largest > 0 ? static_cast<double>(largest) / 32767 : 1;
}

// Triangles, vertices and normals; writes the list of elements into the head.
void pack_mesh(const Scene& scene, const Grid& grid, PackedArrays& arrays, JsonWriter& head) {
  const TriangleMesh& mesh = scene.mesh;
  std::vector<ElementMesh> parts(std::max<std::size_t>(1, mesh.elements.size()), ElementMesh(mesh));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    parts[mesh.triangle_element.empty() ? 0 : mesh.triangle_element[t]].add(t);
  }
  std::vector<std::int32_t> positions, normals, deviations;
  std::vector<std::uint32_t> indices;
  const double step = deviation_step(scene.deviations);
  head.key("elements").begin_array();
  for (std::size_t e = 0; e < parts.size(); ++e) {
    ElementMesh& part = parts[e];
    if (part.triangles().empty()) continue;
    part.sort(!scene.deviations.empty());
    const auto base = static_cast<std::uint32_t>(positions.size() / 3);
    for (const std::uint32_t each : part.indices()) indices.push_back(base + each);
    for (std::size_t v = 0; v < part.vertex_count(); ++v) {
      append(positions, grid.of(part.position(v)));
      const auto octahedron = octahedral(part.normal(v));
      normals.insert(normals.end(), octahedron.begin(), octahedron.end());
    }
    if (!scene.deviations.empty()) {
      for (const std::uint32_t t : part.triangles()) {
        const double off = static_cast<double>(scene.deviations[t]);
        // The least number stands for "not known".
        deviations.push_back(std::isnan(off) ? -32768
                                             : static_cast<std::int32_t>(std::lround(off / step)));
      }
    }
    const SceneElement& element = scene.elements[e];
    head.begin_object()
        .field("name", element.name)
        .field("type", element.type)
        .field("sign", element.sign)
        .field("color", hex_of(element.color))
        .field("block", element.block)
        .field("area", area_of(mesh, part.triangles()))
        .field("triangles", static_cast<std::uint64_t>(part.triangles().size()))
        .field("vertices", static_cast<std::uint64_t>(part.vertex_count()));
    if (element.certified_deviation) head.field("certified", *element.certified_deviation);
    head.end_object();
    // What comes after takes about as long again.
    tell_progress(0.5 * static_cast<double>(indices.size()) /
                  static_cast<double>(3 * mesh.triangles.size()));
    part = ElementMesh(mesh);
  }
  head.end_array();
  arrays.add("position", positions, 3);
  arrays.add("normal", normals, 2);
  arrays.add_indices("index", indices);
  if (deviations.empty()) return;
  arrays.add("deviation", deviations, 1);
  head.field("deviation_step", step).field("deviation_scale", scene.deviation_scale);
}

// Creases first, then edges, jumps and what has no kind; the head has the number of curves of each.
void pack_curves(const TriangleMesh& mesh, const Grid& grid, PackedArrays& arrays,
                 JsonWriter& head) {
  std::vector<std::int32_t> points, lengths;
  head.key("curves").begin_object();
  for (const auto& [kind, name] :
       {std::pair(CurveKind::kCrease, "crease"), std::pair(CurveKind::kEdge, "edge"),
        std::pair(CurveKind::kJump, "jump"), std::pair(CurveKind::kOther, "other")}) {
    std::uint64_t count = 0;
    for (const MeshCurve& curve : mesh.curves) {
      if (curve.kind != kind || curve.vertices.size() < 2) continue;
      ++count;
      for (const std::uint32_t v : curve.vertices) append(points, grid.of(mesh.positions[v]));
      if (curve.closed) append(points, grid.of(mesh.positions[curve.vertices[0]]));
      lengths.push_back(static_cast<std::int32_t>(curve.vertices.size() + (curve.closed ? 1 : 0)));
    }
    head.field(name, count);
  }
  head.end_object();
  arrays.add("curve_point", points, 3);
  arrays.add("curve_length", lengths, 1);
}

void pack_path(const ToolPath& path, const Grid& grid, PackedArrays& arrays, JsonWriter& head) {
  std::vector<std::int32_t> points, rapid;
  for (const ClPoint& each : path.points) {
    append(points, grid.of(each.tip));
    rapid.push_back(each.motion == Motion::kRapid ? 1 : 0);
  }
  arrays.add("path_point", points, 3);
  arrays.add("path_rapid", rapid, 1);
  head.key("path")
      .begin_object()
      .field("name", path.name)
      .field("feed", path.feed)
      .field("spindle", path.spindle)
      .end_object();
}

void pack_cut(const CutMap& cut, PackedArrays& arrays, JsonWriter& head) {
  // The limit in 100 steps, the two ends of the range for what is no height.
  const double step = (cut.limit > 0 ? cut.limit : 1) / 100;
  std::vector<std::int32_t> heights;
  heights.reserve(cut.height.size());
  for (const float each : cut.height) {
    heights.push_back(each == CutMap::kNothing ? -32768
                      : each == CutMap::kUncut
                          ? 32767
                          : static_cast<std::int32_t>(std::lround(
                                std::clamp(static_cast<double>(each) / step, -32767.0, 32766.0))));
  }
  arrays.add("cut", heights, 1);
  head.key("cut")
      .begin_object()
      .field("columns", static_cast<std::uint64_t>(cut.columns))
      .field("rows", static_cast<std::uint64_t>(cut.rows))
      .field("step", step)
      .field("limit", cut.limit)
      .field("gouge_limit", cut.gouge_limit);
  const auto pair = [&](std::string_view name, const std::array<double, 2>& values) {
    head.key(name).begin_array().value(values[0]).value(values[1]).end_array();
  };
  pair("corner", cut.corner);
  pair("pixel", cut.pixel);
  head.end_object();
}

void write_head(const Scene& scene, const Box& box, double quantum, const Grid& grid,
                PackedArrays& arrays, JsonWriter& head) {
  head.begin_object()
      .field("title", scene.title)
      .field("maker", scene.maker)
      .field("unit", scene.unit == LengthUnit::kUnknown ? "" : name_of(scene.unit))
      .field("tolerance", scene.tolerance)
      .field("quantum", quantum)
      .field("coloring", scene.coloring)
      .field("per_unit", grid.per_unit);
  if (scene.certified_deviation) head.field("certified", *scene.certified_deviation);
  head.key("corner").begin_array();
  for (int k = 0; k < 3; ++k) head.value(grid.corner[k]);
  head.end_array().key("bounds").begin_array();
  for (const Vec3& each : box) {
    head.begin_array().value(each.x()).value(each.y()).value(each.z()).end_array();
  }
  head.end_array();
  if (scene.cutter) {
    head.key("cutter")
        .begin_object()
        .field("diameter", scene.cutter->diameter)
        .field("corner_radius", scene.cutter->corner_radius)
        .end_object();
  }
  pack_mesh(scene, grid, arrays, head);
  pack_curves(scene.mesh, grid, arrays, head);
  if (scene.path) pack_path(*scene.path, grid, arrays, head);
  if (scene.cut) pack_cut(*scene.cut, arrays, head);
  head.key("arrays");
  arrays.describe(head);
  head.end_object();
}

// A '<' in a name would end the script element the text stands in.
std::string for_script(const std::string& json) {
  std::string text;
  for (const char each : json) text += each == '<' ? std::string("\\u003c") : std::string(1, each);
  return text;
}

}  // namespace

double scene_quantum(double extent, double tolerance) {
  constexpr double kOfTolerance = 1e-2, kOfExtent = 1e-6, kLeast = 1e-8;
  if (!(extent > 0)) extent = 1;
  const double wanted =
      round_down_to_decade(tolerance > 0 ? tolerance * kOfTolerance : extent * kOfExtent);
  return std::max(wanted, 10 * round_down_to_decade(extent * kLeast));
}

Status can_view() {
  if (viewer_page()) return ok();
  return Error{
      ErrorCode::kUnsupported,
      "this build has no viewer: it was configured without esbuild or three.js; install "
      "Debian's esbuild and libjs-three (scripts/setup.sh does), configure and build again",
      {"diesink", 0, 0, -1}};
}

Result<std::string> viewer_page_of(const Scene& scene) {
  if (Status there = can_view(); !there) return there.error();
  const std::string_view page = *viewer_page();
  if (scene.mesh.triangles.empty() && (!scene.path || scene.path->points.size() < 2)) {
    return Error{ErrorCode::kInput, "nothing to show: no triangle and no move", {}};
  }
  const Box box = box_of(scene);
  const double quantum = scene_quantum((box[1] - box[0]).maxCoeff(), scene.tolerance);
  const Grid grid = grid_of(box, quantum);
  PackedArrays arrays;
  JsonWriter head;
  write_head(scene, box, quantum, grid, arrays, head);
  const Result<std::vector<std::uint8_t>> body = deflated(arrays.bytes());
  if (!body) return body.error();
  if (body->size() > kMostBytes) {
    return Error{ErrorCode::kLimit, "too much for one page; a larger --tolerance gives less", {}};
  }
  const std::size_t head_at = page.find(kHeadMark), body_at = page.find(kBodyMark, head_at);
  std::string text(page.substr(0, head_at));
  text += for_script(head.text());
  text += page.substr(head_at + kHeadMark.size(), body_at - head_at - kHeadMark.size());
  text += base64(*body);
  text += page.substr(body_at + kBodyMark.size());
  return text;
}

}  // namespace diesink
