// Length units. Inside the program every length is in the part program's own unit; only formats convert.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace diesink {

enum class LengthUnit : std::uint8_t { kUnknown, kMillimetre, kCentimetre, kMetre, kInch };
enum class UpAxis : std::uint8_t { kUnknown, kY, kZ };

// Metres per unit; kUnknown counts as millimetre.
constexpr double metres_per(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::kCentimetre: return 0.01;
    case LengthUnit::kMetre: return 1.0;
    case LengthUnit::kInch: return 0.0254;
    case LengthUnit::kUnknown:
    case LengthUnit::kMillimetre: break;
  }
  return 0.001;
}

// "mm", "cm", "m", "inch", "unknown".
constexpr std::string_view name_of(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::kMillimetre: return "mm";
    case LengthUnit::kCentimetre: return "cm";
    case LengthUnit::kMetre: return "m";
    case LengthUnit::kInch: return "inch";
    case LengthUnit::kUnknown: break;
  }
  return "unknown";
}

}  // namespace diesink
