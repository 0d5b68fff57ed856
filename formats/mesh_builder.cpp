// SPDX-License-Identifier: Apache-2.0
#include "formats/mesh_builder.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/mesh_tools/polygon.h"
#include "formats/float_rows.h"

namespace diesink {

FaceVerdict FaceBuilder::add(std::span<const std::uint32_t> vertices,
                             std::span<const std::uint32_t> normals, std::uint32_t element) {
  for (const std::uint32_t v : vertices) {
    if (v >= mesh_.positions.size()) return FaceVerdict::kOutOfRange;
  }
  if (vertices.size() < 3) return FaceVerdict::kTooFew;
  if (vertices.size() - 2 >
      options_.max_triangles - std::min(options_.max_triangles, mesh_.triangles.size())) {
    return FaceVerdict::kTooMany;
  }
  FaceVerdict verdict = FaceVerdict::kFine;
  if (vertices.size() == 3) {
    cut_.assign(1, {0, 1, 2});
  } else {
    cut_.clear();
    corners_.clear();
    for (const std::uint32_t v : vertices) corners_.push_back(mesh_.positions[v]);
    if (!cut_polygon(corners_, cut_)) verdict = FaceVerdict::kCrossing;
  }
  // A face none of whose corners has one is a face without, whatever others of its section have.
  if (std::all_of(normals.begin(), normals.end(), [](std::uint32_t n) { return n == kNoNormal; })) {
    normals = {};
  }
  // Files without normals or elements, most of them, are spared the arrays until the first face has
  // one.
  if (!normals.empty() && mesh_.corner_normals.empty()) {
    mesh_.corner_normals.assign(mesh_.triangles.size(), {kNoNormal, kNoNormal, kNoNormal});
  }
  if (element != 0 && mesh_.triangle_element.empty())
    mesh_.triangle_element.assign(mesh_.triangles.size(), 0);
  const bool with_normals = !normals.empty() || !mesh_.corner_normals.empty();
  const bool with_elements = element != 0 || !mesh_.triangle_element.empty();
  for (const std::array<std::uint32_t, 3>& t : cut_) {
    mesh_.triangles.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
    if (with_elements) mesh_.triangle_element.push_back(element);
    if (with_normals && normals.empty())
      mesh_.corner_normals.push_back({kNoNormal, kNoNormal, kNoNormal});
    if (with_normals && !normals.empty()) {
      mesh_.corner_normals.push_back({normals[t[0]], normals[t[1]], normals[t[2]]});
    }
  }
  return verdict;
}

std::size_t FaceBuilder::finish(ElementTable& elements) {
  if (elements.size() > 1 && mesh_.triangle_element.empty()) {
    mesh_.triangle_element.assign(mesh_.triangles.size(), 0);
  }
  elements.move_into(mesh_);
  std::size_t given = 0;
  // All at once, which is fast, whether there is anything to give.
  const std::vector<std::array<std::uint32_t, 3>>& corners = mesh_.corner_normals;
  if (!corners.empty() && range_of({corners.front().data(), 3 * corners.size()})[1] != kNoNormal) {
    return given;
  }
  for (std::size_t t = 0; t < mesh_.corner_normals.size(); ++t) {
    std::array<std::uint32_t, 3>& n = mesh_.corner_normals[t];
    if (n[0] != kNoNormal && n[1] != kNoNormal && n[2] != kNoNormal) continue;
    const std::array<std::uint32_t, 3>& v = mesh_.triangles[t];
    const Vec3 a = mesh_.positions[v[0]];
    const Vec3 across = (mesh_.positions[v[1]] - a).cross(mesh_.positions[v[2]] - a);
    const double length = across.norm();
    mesh_.normals.push_back(length > 0 ? Vec3(across / length) : Vec3(Vec3::UnitZ()));
    n.fill(static_cast<std::uint32_t>(mesh_.normals.size() - 1));
    ++given;
  }
  if (mesh_.corner_normals.empty()) mesh_.normals.clear();
  return given;
}

Status mesh_fits(std::size_t vertices, std::size_t triangles, const ReadOptions& options,
                 const Place& where) {
  // No count of a file of any size comes near 2^64 / 24.
  const std::size_t bytes =
      vertices * sizeof(Vec3) + triangles * sizeof(std::array<std::uint32_t, 3>);
  if (bytes <= options.max_memory) return ok();
  return Error{ErrorCode::kLimit,
               std::to_string(vertices) + " vertices and " + std::to_string(triangles) +
                   " triangles need " + std::to_string(bytes) +
                   " bytes of memory, more than the limit of " + std::to_string(options.max_memory),
               where};
}

std::uint8_t color_part(double value, bool whole) {
  const double scaled = whole ? value : value * 255;
  if (!(scaled > 0)) return 0;
  return scaled >= 255 ? std::uint8_t{255} : static_cast<std::uint8_t>(std::lround(scaled));
}

}  // namespace diesink
