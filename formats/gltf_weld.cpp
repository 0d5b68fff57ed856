// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_weld.h"

#include <algorithm>
#include <bit>

namespace diesink {

std::uint32_t GltfWeld::add(const Vec3& position, const Color& color) {
  mesh_.positions.push_back(position);
  first_normal_.push_back(kNone);
  if (!mesh_.vertex_colors.empty() || color != kWhite) {
    mesh_.vertex_colors.resize(mesh_.positions.size() - 1, kWhite);
    mesh_.vertex_colors.push_back(color);
  }
  return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
}

bool GltfWeld::same(std::uint32_t vertex, const Vec3& position, const Color& color) const {
  if (mesh_.positions[vertex] != position) return false;
  return (mesh_.vertex_colors.empty() ? kWhite : mesh_.vertex_colors[vertex]) == color;
}

std::size_t GltfWeld::slot_of(const Vec3& position) const {
  std::uint64_t h = 0;
  for (int k = 0; k < 3; ++k) {
    h = (h ^ std::bit_cast<std::uint64_t>(position[k] + 0.0)) * 0x9E3779B97F4A7C15u;
    h ^= h >> 32;
  }
  return h & (slots_.size() - 1);
}

// So many more vertices will leave half of the slots free.
void GltfWeld::make_room(std::size_t vertices) {
  const std::size_t most = mesh_.positions.size() - first_ + vertices;
  if (2 * most <= slots_.size()) return;
  slots_.assign(std::bit_ceil(std::max<std::size_t>(2 * most, 1024)), kNone);
  for (std::uint32_t v = first_; v < mesh_.positions.size(); ++v) {
    std::size_t slot = slot_of(mesh_.positions[v]);
    while (slots_[slot] != kNone) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = v;
  }
}

std::uint32_t GltfWeld::find_or_add(std::size_t slot, const Vec3& position, const Color& color,
                                    bool any_color) {
  for (;; slot = (slot + 1) & (slots_.size() - 1)) {
    const std::uint32_t held = slots_[slot];
    if (held == kNone || held < first_) break;
    if (any_color ? mesh_.positions[held] == position : same(held, position, color)) return held;
  }
  return slots_[slot] = add(position, color);
}

// The slots and the positions they lead to lie anywhere in memory: both are fetched some vertices
// ahead, which takes half the time.
std::vector<std::uint32_t> GltfWeld::find_or_add(std::span<const Vec3> positions,
                                                 std::span<const Color> colors, bool any_color) {
  constexpr std::size_t kAhead = 16;  // a slot; its vertex half as far
  std::vector<std::uint32_t> out(positions.size());
  const auto color = [&](std::size_t i) -> const Color& {
    return colors.empty() ? kWhite : colors[i];
  };
  if (!join_) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = add(positions[i], color(i));
    return out;
  }
  make_room(positions.size());
  std::array<std::size_t, kAhead> slots{};
  for (std::size_t i = 0; i < out.size() + kAhead; ++i) {
    if (i >= kAhead) {
      const std::size_t v = i - kAhead;
      out[v] = find_or_add(slots[v % kAhead], positions[v], color(v), any_color);
    }
    if (i < out.size()) {
      slots[i % kAhead] = slot_of(positions[i]);
      __builtin_prefetch(&slots_[slots[i % kAhead]]);
    }
    if (i >= kAhead / 2 && i - kAhead / 2 < out.size()) {
      const std::uint32_t held = slots_[slots[(i - kAhead / 2) % kAhead]];
      if (held != kNone) __builtin_prefetch(mesh_.positions.data() + held);
    }
  }
  return out;
}

std::vector<std::uint32_t> GltfWeld::vertices(std::span<const Vec3> positions,
                                              std::span<const Color> colors) {
  return find_or_add(positions, colors, false);
}

std::vector<std::uint32_t> GltfWeld::line_vertices(std::span<const Vec3> positions) {
  return find_or_add(positions, {}, true);
}

std::uint32_t GltfWeld::normal(std::uint32_t vertex, const Vec3& normal) {
  for (std::uint32_t n = first_normal_[vertex]; n != kNone; n = next_normal_[n]) {
    if (mesh_.normals[n] == normal) return n;
  }
  const std::uint32_t added = static_cast<std::uint32_t>(mesh_.normals.size());
  mesh_.normals.push_back(normal);
  next_normal_.push_back(first_normal_[vertex]);
  first_normal_[vertex] = added;
  return added;
}

}  // namespace diesink
