// Runs of vertices and corners on their way into files of narrower numbers.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/mesh.h"

namespace diesink {

// What 32-bit floats about `offset` do to a run of positions.
// Units: mm.
struct FloatRun {
  Vec3 low, high;            // the run's own box, not rounded; of finite positions only
  double moved_squared = 0;  // how far a position moves, at most, squared
  bool within = true;        // no coordinate is beyond the limit in absolute value, none is NaN
};

// Needs: one position at least.
FloatRun measure_floats(std::span<const Vec3> run, const Vec3& offset, double limit);

// Three floats each: coordinate less offset, rounded to nearest, and never -0: equal positions stay
// equal to the bit. `to` needs no alignment and has room for 12 bytes each.
void put_floats(std::span<const Vec3> from, const Vec3& offset, char* to);

// The same about zero. False where a square of the length is further than `slack` from 1, or NaN.
[[nodiscard]] bool put_unit_floats(std::span<const Vec3> from, double slack, char* to);

// 16 bits each: number less base. `to` has room for 2 bytes each.
// Needs: base <= number < base + 65536.
void put_shorts(std::span<const std::uint32_t> from, std::uint32_t base, char* to);

// 32 bits each: number less base. `to` has room for 4 bytes each.
void put_longs(std::span<const std::uint32_t> from, std::uint32_t base, char* to);

// The least and the greatest of the numbers. Needs: one at least.
std::array<std::uint32_t, 2> range_of(std::span<const std::uint32_t> numbers);

// Whether no number is less than the one before it.
[[nodiscard]] bool is_ascending(std::span<const std::uint32_t> numbers);

}  // namespace diesink
