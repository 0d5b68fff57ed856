// The hash by which positions are found, to the bit.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "core/vec.h"

namespace diesink {

// Of a position without -0; its low bits are for tables, the upper ones for tags and parts.
inline std::uint64_t hash_of(const Vec3& p) {
  // Multiplication carries differences upwards only, and floats widened to doubles differ in their
  // upper bits: the fold brings them down again before the table takes its low bits.
  std::array<std::uint64_t, 3> bits{};
  std::memcpy(bits.data(), p.data(), sizeof bits);
  std::uint64_t h = bits[0] * 0x9E3779B97F4A7C15ULL;
  h = (std::rotl(h, 29) ^ bits[1]) * 0xBF58476D1CE4E5B9ULL;
  h = (std::rotl(h, 31) ^ bits[2]) * 0x94D049BB133111EBULL;
  return h ^ (h >> 32);
}

}  // namespace diesink
