// Colours between the 8-bit sRGB of meshes and the linear light of glTF.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace diesink {

using LinearColor = std::array<std::uint16_t, 4>;  // linear RGB and alpha, 65535 is one

// Each of these comes back to the same 8 bits through srgb_of.
LinearColor linear_of(const std::array<std::uint8_t, 4>& srgb);
std::array<double, 4> factor_of(const std::array<std::uint8_t, 4>& srgb);  // 0..1, six decimals

// From linear values in 0..1 (clamped; NaN counts as 0).
std::array<std::uint8_t, 4> srgb_of(const std::array<double, 4>& linear);

// The linear colour of an element that has none of its own: neighbours in the table differ clearly.
std::array<double, 4> palette_factor(std::size_t element);

}  // namespace diesink
