// Transfer function: IEC 61966-2-1 (sRGB), as glTF 2.0 section 3.9.2 names it.
// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_color.h"

#include <cmath>

namespace diesink {
namespace {

double to_linear(double s) { return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4); }

double to_srgb(double l) {
  return l <= 0.0031308 ? l * 12.92 : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
}

std::array<std::uint16_t, 256> linear_table() {
  std::array<std::uint16_t, 256> table{};
  for (std::size_t i = 0; i < 256; ++i) {
    table[i] =
        static_cast<std::uint16_t>(std::lround(to_linear(static_cast<double>(i) / 255) * 65535));
  }
  return table;
}

}  // namespace

LinearColor linear_of(const std::array<std::uint8_t, 4>& srgb) {
  static const std::array<std::uint16_t, 256> table = linear_table();
  return {table[srgb[0]], table[srgb[1]], table[srgb[2]],
          static_cast<std::uint16_t>(srgb[3] * 257)};
}

std::array<double, 4> factor_of(const std::array<std::uint8_t, 4>& srgb) {
  std::array<double, 4> factor{};
  for (std::size_t k = 0; k < 4; ++k) {
    const double value = srgb[k] / 255.0;
    factor[k] = std::round((k < 3 ? to_linear(value) : value) * 1e6) / 1e6;
  }
  return factor;
}

std::array<std::uint8_t, 4> srgb_of(const std::array<double, 4>& linear) {
  std::array<std::uint8_t, 4> srgb{};
  for (std::size_t k = 0; k < 4; ++k) {
    const double value = linear[k] > 0 ? std::fmin(linear[k], 1) : 0;
    srgb[k] = static_cast<std::uint8_t>(std::lround((k < 3 ? to_srgb(value) : value) * 255));
  }
  return srgb;
}

std::array<double, 4> palette_factor(std::size_t element) {
  constexpr std::array<std::array<std::uint8_t, 3>, 12> kPalette = {{{176, 184, 192},
                                                                     {230, 159, 0},
                                                                     {86, 180, 233},
                                                                     {0, 158, 115},
                                                                     {240, 228, 66},
                                                                     {0, 114, 178},
                                                                     {213, 94, 0},
                                                                     {204, 121, 167},
                                                                     {150, 120, 90},
                                                                     {120, 190, 120},
                                                                     {160, 140, 200},
                                                                     {200, 110, 110}}};
  const auto& color = kPalette[element % kPalette.size()];
  return factor_of({color[0], color[1], color[2], 255});
}

}  // namespace diesink
