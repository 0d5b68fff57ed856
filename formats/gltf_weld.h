// Joins the vertices that a glTF file has to repeat: at creases, between primitives, where colours
// differ not. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh.h"

namespace diesink {

// Adds vertices to a mesh, equal ones once. Only vertices of the same group are joined: the parts
// of an assembly that touch stay apart.
class GltfWeld {
 public:
  using Color = std::array<std::uint8_t, 4>;

  // With `join` false every vertex stays its own.
  GltfWeld(TriangleMesh& mesh, bool join) : mesh_(mesh), join_(join) {}

  // From here on no vertex is joined to one before.
  void next_group() { first_ = static_cast<std::uint32_t>(mesh_.positions.size()); }

  // The number of the vertex at this position, equal to the bit, and of this colour. Where colours
  // are given at all, vertices without one are white.
  std::uint32_t vertex(const Vec3& position, const Color* color);
  // The number of a vertex at this position of whatever colour: lines have none of their own.
  std::uint32_t line_vertex(const Vec3& position);
  // The number of this normal, equal to the bit, at this vertex.
  std::uint32_t normal(std::uint32_t vertex, const Vec3& normal);

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  static constexpr Color kWhite{255, 255, 255, 255};

  std::uint32_t find_or_add(const Vec3& position, const Color& color, bool any_color);
  std::uint32_t add(const Vec3& position, const Color& color);
  void grow();
  [[nodiscard]] std::size_t slot_of(const Vec3& position) const;
  [[nodiscard]] bool same(std::uint32_t vertex, const Vec3& position, const Color& color) const;

  TriangleMesh& mesh_;
  bool join_;
  std::uint32_t first_ = 0;
  std::vector<std::uint32_t> slots_;         // open addressing; entries before first_ count as free
  std::vector<std::uint32_t> first_normal_;  // of each vertex, or kNone
  std::vector<std::uint32_t> next_normal_;   // of each normal: another one at the same vertex
};

}  // namespace diesink
