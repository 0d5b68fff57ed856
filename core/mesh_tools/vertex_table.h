// Finds positions again.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/vec.h"

namespace diesink {

// Gives every different position one index, in the order of first appearance.
// Needs:  finite coordinates; fewer than 2^32 - 1 different positions. -0 and 0 are the same, and 0
// is kept.
class VertexTable {
 public:
  // `expected`: how many different positions there may be; it grows as needed.
  explicit VertexTable(std::size_t expected);

  std::uint32_t add(const Vec3& position);

  // The index of a position that is there, kAbsent of one that is not.
  static constexpr std::uint32_t kAbsent = 0xFFFFFFFFU;
  [[nodiscard]] std::uint32_t find(const Vec3& position) const;

  [[nodiscard]] std::size_t size() const { return positions_.size(); }

 private:
  struct Slot {
    std::uint32_t index;  // kAbsent where there is none
    std::uint32_t hash;
  };

  std::uint32_t find_or_add(const Vec3& position, std::uint64_t hash);
  void grow();

  std::vector<Slot> slots_;  // a power of two
  std::size_t mask_ = 0;
  std::vector<Vec3> positions_;
};

}  // namespace diesink
