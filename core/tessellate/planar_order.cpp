// The order in which many points are inserted into a triangulation.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/planar_order.h"

#include <algorithm>
#include <array>

namespace diesink {
namespace {

constexpr int kBits = 15;             // of a coordinate on the curve
constexpr std::uint32_t kRounds = 4;  // the rest of a 32-bit key

// Place along the Hilbert curve. A state is how the curve lies in the present square; the tables
// give, for the quarter (2 * x + y), its place in the order and the state within.
std::uint32_t along_curve(std::uint32_t x, std::uint32_t y) {
  static constexpr std::array<std::uint8_t, 16> kPlace{0, 1, 3, 2, 0, 3, 1, 2,
                                                       2, 3, 1, 0, 2, 1, 3, 0};
  static constexpr std::array<std::uint8_t, 16> kState{1, 0, 3, 0, 0, 2, 1, 1,
                                                       2, 1, 2, 3, 3, 3, 0, 2};
  std::uint32_t state = 0, place = 0;
  for (int bit = kBits - 1; bit >= 0; --bit) {
    const std::uint32_t quarter = 4 * state + 2 * ((x >> bit) & 1U) + ((y >> bit) & 1U);
    place = 4 * place + kPlace[quarter];
    state = kState[quarter];
  }
  return place;
}

// Which round an index falls into: seven of eight into the last.
std::uint32_t round_of(std::uint32_t index) {
  std::uint32_t hash = (index + 1) * 0x9E3779B9U;
  hash = (hash ^ (hash >> 16)) * 0x85EBCA6BU;
  hash ^= hash >> 13;
  std::uint32_t round = kRounds - 1;
  for (; round > 0 && (hash & 7U) == 0; --round) hash >>= 3;
  return round;
}

// Sorts by the upper halves, keeping the order of equals.
void radix_sort(std::vector<std::uint64_t>& keys) {
  constexpr int kDigit = 11;
  std::vector<std::uint64_t> other(keys.size());
  for (int shift = 32; shift < 64; shift += kDigit) {
    std::array<std::uint32_t, 1U << kDigit> start{};
    const auto digit = [shift](std::uint64_t key) {
      return static_cast<std::size_t>((key >> shift) & ((1U << kDigit) - 1));
    };
    for (const std::uint64_t key : keys) ++start[digit(key)];
    std::uint32_t sum = 0;
    for (std::uint32_t& s : start) {
      const std::uint32_t count = s;
      s = sum;
      sum += count;
    }
    for (const std::uint64_t key : keys) other[start[digit(key)]++] = key;
    keys.swap(other);
  }
}

}  // namespace

std::vector<std::uint32_t> insertion_order(std::span<const LatticePoint> points) {
  double reach = 1;  // the curve fills the square of the points themselves
  for (const LatticePoint& p : points) {
    reach = std::max({reach, std::abs(p.x), std::abs(p.y)});
  }
  const double scale = ((1 << kBits) - 1) / (2 * reach);
  std::vector<std::uint64_t> keys(points.size());
  for (std::uint32_t i = 0; i < keys.size(); ++i) {
    const auto x = static_cast<std::uint32_t>((points[i].x + reach) * scale);
    const auto y = static_cast<std::uint32_t>((points[i].y + reach) * scale);
    const std::uint32_t key = (round_of(i) << (2 * kBits)) | along_curve(x, y);
    keys[i] = (static_cast<std::uint64_t>(key) << 32) | i;
  }
  if (keys.size() < 2000) {
    std::sort(keys.begin(), keys.end());
  } else {
    radix_sort(keys);
  }
  std::vector<std::uint32_t> order(keys.size());
  for (std::size_t k = 0; k < keys.size(); ++k) order[k] = static_cast<std::uint32_t>(keys[k]);
  return order;
}

}  // namespace diesink
