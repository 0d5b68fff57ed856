// SPDX-License-Identifier: Apache-2.0
#include "core/mesh_tools/vertex_table.h"

#include <bit>
#include <cassert>

#include "core/large_array.h"
#include "core/mesh_tools/position_hash.h"

namespace diesink {
namespace {

bool same(const Vec3& a, const Vec3& b) {
  return a.x() == b.x() && a.y() == b.y() && a.z() == b.z();
}

}  // namespace

VertexTable::VertexTable(std::size_t expected) {
  const std::size_t slots = std::bit_ceil(std::max<std::size_t>(2 * expected, 64));
  // Looked up all over: every look-up finds its page.
  reserve_large(slots_, slots);
  slots_.assign(slots, {kAbsent, 0});
  mask_ = slots - 1;
  reserve_large(positions_, expected);
}

std::uint32_t VertexTable::find_or_add(const Vec3& position, std::uint64_t hash) {
  const auto tag = static_cast<std::uint32_t>(hash >> 32);
  std::size_t at = static_cast<std::size_t>(hash) & mask_;
  for (; slots_[at].index != kAbsent; at = (at + 1) & mask_) {
    if (slots_[at].hash == tag && same(positions_[slots_[at].index], position))
      return slots_[at].index;
  }
  assert(positions_.size() < kAbsent);
  const auto index = static_cast<std::uint32_t>(positions_.size());
  slots_[at] = {index, tag};
  positions_.push_back(position);
  if (positions_.size() * 5 > slots_.size() * 3) grow();
  return index;
}

void VertexTable::grow() {
  const std::size_t slots = slots_.size() * 2;
  slots_ = {};
  reserve_large(slots_, slots);
  slots_.assign(slots, {kAbsent, 0});
  mask_ = slots - 1;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const std::uint64_t hash = hash_of(positions_[i]);
    std::size_t at = static_cast<std::size_t>(hash) & mask_;
    while (slots_[at].index != kAbsent) at = (at + 1) & mask_;
    slots_[at] = {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(hash >> 32)};
  }
}

std::uint32_t VertexTable::add(const Vec3& position) {
  const Vec3 p = position + Vec3::Zero();  // -0 becomes 0
  return find_or_add(p, hash_of(p));
}

std::uint32_t VertexTable::find(const Vec3& position) const {
  const Vec3 p = position + Vec3::Zero();
  const std::uint64_t hash = hash_of(p);
  const auto tag = static_cast<std::uint32_t>(hash >> 32);
  std::size_t at = static_cast<std::size_t>(hash) & mask_;
  for (; slots_[at].index != kAbsent; at = (at + 1) & mask_) {
    if (slots_[at].hash == tag && same(positions_[slots_[at].index], p)) return slots_[at].index;
  }
  return kAbsent;
}

}  // namespace diesink
