// Two numbers as one key.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace diesink {

// In their order: (a, b) and (b, a) are two.
inline std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{a} << 32 | b;
}

}  // namespace diesink
