// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_split.h"

#include <algorithm>
#include <string>

namespace diesink {
namespace {

Error wrong(std::string what) { return Error{ErrorCode::kInput, std::move(what), {}}; }

// Whether every array has its length and every index is in range.
Status check(const TriangleMesh& mesh, bool with_normals) {
  const std::size_t triangle_count = mesh.triangles.size();
  if (!mesh.triangle_element.empty() && mesh.triangle_element.size() != triangle_count) {
    return wrong("the mesh has " + std::to_string(mesh.triangle_element.size()) +
                 " element numbers, expected one for each of " + std::to_string(triangle_count) +
                 " triangles");
  }
  if (with_normals && mesh.corner_normals.size() != triangle_count) {
    return wrong("the mesh has normals for " + std::to_string(mesh.corner_normals.size()) +
                 " triangles, expected " + std::to_string(triangle_count));
  }
  if (!mesh.vertex_colors.empty() && mesh.vertex_colors.size() != mesh.positions.size()) {
    return wrong("the mesh has " + std::to_string(mesh.vertex_colors.size()) +
                 " vertex colours, expected " + std::to_string(mesh.positions.size()));
  }
  const std::size_t positions = mesh.positions.size();
  for (std::size_t t = 0; t < triangle_count; ++t) {
    const auto& corner = mesh.triangles[t];
    if (std::max({corner[0], corner[1], corner[2]}) >= positions) {
      return wrong("triangle " + std::to_string(t) + " has a vertex beyond the " +
                   std::to_string(positions) + " of the mesh");
    }
  }
  if (with_normals) {
    for (std::size_t t = 0; t < triangle_count; ++t) {
      const auto& corner = mesh.corner_normals[t];
      if (std::max({corner[0], corner[1], corner[2]}) >= mesh.normals.size()) {
        return wrong("triangle " + std::to_string(t) + " has a normal beyond the " +
                     std::to_string(mesh.normals.size()) + " of the mesh");
      }
    }
  }
  for (const std::uint32_t element : mesh.triangle_element) {
    if (element >= std::max<std::size_t>(mesh.elements.size(), 1)) {
      return wrong("a triangle belongs to element " + std::to_string(element) + " of " +
                   std::to_string(mesh.elements.size()));
    }
  }
  return ok();
}

// Triangle numbers grouped by element, in the order of the mesh within each; empty where they are
// already so.
std::vector<std::uint32_t> order_by_element(const TriangleMesh& mesh,
                                            const std::vector<std::size_t>& first) {
  if (std::is_sorted(mesh.triangle_element.begin(), mesh.triangle_element.end())) return {};
  std::vector<std::size_t> next = first;
  std::vector<std::uint32_t> order(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    order[next[mesh.triangle_element[t]]++] = static_cast<std::uint32_t>(t);
  }
  return order;
}

// The vertices made so far for each position, all within one primitive.
class CornerTable {
 public:
  explicit CornerTable(std::size_t positions) : head_(positions) {}

  // Forgets the vertices of the last primitive.
  void next_primitive() {
    ++primitive_;
    more_.clear();
  }

  // The vertex of this corner, or `fresh` where it is new (then `is_new` is set).
  std::uint32_t vertex(std::uint32_t position, std::uint32_t normal, std::uint32_t fresh,
                       bool& is_new) {
    Head& head = head_[position];
    if (head.primitive != primitive_) {
      if (head.primitive == 0) ++used_;
      head = {primitive_, normal, fresh, kEnd};
      is_new = true;
      return fresh;
    }
    if (head.normal == normal) return head.vertex;
    for (std::uint32_t at = head.more; at != kEnd; at = more_[at].more) {
      if (more_[at].normal == normal) return more_[at].vertex;
    }
    more_.push_back({normal, fresh, head.more});
    head.more = static_cast<std::uint32_t>(more_.size() - 1);
    is_new = true;
    return fresh;
  }

  [[nodiscard]] std::size_t used() const { return used_; }  // positions that got a vertex at all

 private:
  static constexpr std::uint32_t kEnd = 0xFFFFFFFFu;
  struct Head {
    std::uint32_t primitive = 0, normal = 0, vertex = 0, more = kEnd;
  };
  struct More {
    std::uint32_t normal, vertex, more;
  };
  std::vector<Head> head_;
  std::vector<More> more_;       // further normals at a position, chained
  std::uint32_t primitive_ = 0;  // from 1
  std::size_t used_ = 0;
};

}  // namespace

Result<SplitMesh> split_by_element(const TriangleMesh& mesh, bool with_normals) {
  if (Status status = check(mesh, with_normals); !status) return status.error();
  SplitMesh split;
  const std::size_t triangle_count = mesh.triangles.size();
  if (triangle_count == 0) return split;

  const std::size_t element_count = std::max<std::size_t>(mesh.elements.size(), 1);
  std::vector<std::size_t> first(element_count + 1, 0);
  if (mesh.triangle_element.empty()) {
    std::fill(first.begin() + 1, first.end(), triangle_count);
  } else {
    for (const std::uint32_t element : mesh.triangle_element) ++first[element + 1];
    for (std::size_t e = 0; e < element_count; ++e) first[e + 1] += first[e];
  }
  const std::vector<std::uint32_t> order = order_by_element(mesh, first);

  split.triangles.resize(triangle_count);
  split.position.reserve(mesh.positions.size() + mesh.positions.size() / 8);
  if (with_normals) split.normal.reserve(split.position.capacity());
  CornerTable table(mesh.positions.size());
  for (std::size_t e = 0; e < element_count; ++e) {
    if (first[e] == first[e + 1]) continue;
    SplitPrimitive primitive;
    if (!mesh.elements.empty()) primitive.element = static_cast<std::uint32_t>(e);
    primitive.first_vertex = static_cast<std::uint32_t>(split.position.size());
    primitive.first_triangle = first[e];
    primitive.triangle_count = first[e + 1] - first[e];
    table.next_primitive();
    std::uint32_t fresh = 0;
    for (std::size_t i = first[e]; i < first[e + 1]; ++i) {
      const std::size_t t = order.empty() ? i : order[i];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t position = mesh.triangles[t][k];
        const std::uint32_t normal = with_normals ? mesh.corner_normals[t][k] : 0;
        bool is_new = false;
        split.triangles[i][k] = table.vertex(position, normal, fresh, is_new);
        if (!is_new) continue;
        ++fresh;
        split.position.push_back(position);
        if (with_normals) split.normal.push_back(normal);
      }
    }
    primitive.vertex_count = fresh;
    split.primitives.push_back(primitive);
  }
  split.used_positions = table.used();
  return split;
}

}  // namespace diesink
