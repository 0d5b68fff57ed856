// SPDX-License-Identifier: Apache-2.0
#include "convert/lattice_map.h"

#include <algorithm>
#include <cmath>

namespace diesink {

LatticeMap thinned(const VerifyReport& found, double intol, std::size_t most) {
  LatticeMap map;
  map.every = std::max<std::size_t>(1, (std::max(found.columns, found.rows) + most - 1) / most);
  map.columns = (found.columns + map.every - 1) / map.every;
  map.rows = (found.rows + map.every - 1) / map.every;
  const auto weight = [&](std::size_t k) {
    const double h = static_cast<double>(found.height[k]);
    if (found.state[k] != CutState::kCut) return found.state[k] == CutState::kUncut ? 1e6 : 0.0;
    return h < -intol ? 1e9 - h : 1 + std::fmax(0, h);
  };
  map.points.reserve(map.columns * map.rows);
  for (std::size_t y = 0; y < found.rows; y += map.every) {
    for (std::size_t x = 0; x < found.columns; x += map.every) {
      std::size_t best = y * found.columns + x;
      for (std::size_t j = y; j < std::min(y + map.every, found.rows); ++j) {
        for (std::size_t i = x; i < std::min(x + map.every, found.columns); ++i) {
          if (weight(j * found.columns + i) > weight(best)) best = j * found.columns + i;
        }
      }
      map.points.push_back(best);
    }
  }
  return map;
}

}  // namespace diesink
