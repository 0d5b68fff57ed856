// Joins the vertices that a glTF file has to repeat: at creases, between primitives, where colours
// differ not. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
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

  // A group will be given so many vertices at most; more are taken, too, but cost more time.
  void expect(std::size_t vertices) {
    if (join_) make_room(vertices);
  }

  // Of each position the number of the vertex there, equal to the bit, and of its colour; without
  // colours they are white. Needs: no colours, or one a position.
  std::vector<std::uint32_t> vertices(std::span<const Vec3> positions,
                                      std::span<const Color> colors);
  // The numbers of vertices of whatever colour: lines have none of their own.
  std::vector<std::uint32_t> line_vertices(std::span<const Vec3> positions);
  // The number of this normal, equal to the bit, at this vertex.
  std::uint32_t normal(std::uint32_t vertex, const Vec3& normal);

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  static constexpr Color kWhite{255, 255, 255, 255};

  std::vector<std::uint32_t> find_or_add(std::span<const Vec3> positions,
                                         std::span<const Color> colors, bool any_color);
  std::uint32_t find_or_add(std::size_t slot, const Vec3& position, const Color& color,
                            bool any_color);
  std::uint32_t add(const Vec3& position, const Color& color);
  void make_room(std::size_t vertices);
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
