// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_weld.h"

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

void GltfWeld::grow() {
  slots_.assign(std::max<std::size_t>(slots_.size() * 2, 1024), kNone);
  for (std::uint32_t v = first_; v < mesh_.positions.size(); ++v) {
    std::size_t slot = slot_of(mesh_.positions[v]);
    while (slots_[slot] != kNone) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = v;
  }
}

std::uint32_t GltfWeld::vertex(const Vec3& position, const Color* color) {
  return find_or_add(position, color != nullptr ? *color : kWhite, false);
}

std::uint32_t GltfWeld::line_vertex(const Vec3& position) {
  return find_or_add(position, kWhite, true);
}

std::uint32_t GltfWeld::find_or_add(const Vec3& position, const Color& given, bool any_color) {
  if (!join_) return add(position, given);
  if ((mesh_.positions.size() - first_ + 1) * 2 > slots_.size()) grow();
  std::size_t slot = slot_of(position);
  for (;; slot = (slot + 1) & (slots_.size() - 1)) {
    const std::uint32_t held = slots_[slot];
    if (held == kNone || held < first_) break;
    if (any_color ? mesh_.positions[held] == position : same(held, position, given)) return held;
  }
  return slots_[slot] = add(position, given);
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
