// The colours of a picture: of elements, heights, slopes and deviations, and the light on them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/mesh.h"
#include "core/vec.h"

namespace diesink {

using Rgb = std::array<float, 3>;  // 0..1

enum class Coloring : std::uint8_t { kElement, kHeight, kSlope, kDeviation };

struct PaletteEntry {
  std::string name;
  Rgb color;
  bool listed = true;  // in the legend
  bool block = false;  // a side or the floor under a part: no height, slope or deviation to tell
};
using Palette = std::vector<PaletteEntry>;

// B, then the faces and the wall of every solid, each solid in a hue of its own; then the sides and
// the floor under the part.
Palette palette_of(const CompoundSurface& surface);
// The elements' own colours where they have one, else a hue a solid.
Palette palette_of(const TriangleMesh& mesh);

// Entry of the palette for each element of the mesh, by name; unknown names take entry 0.
std::vector<std::uint32_t> entries_of(const TriangleMesh& mesh, const Palette& palette);
// Entry of the palette for each label the surface can have, indexed by the label.
std::vector<std::uint32_t> entries_of(const CompoundSurface& surface, const Palette& palette);

// t in 0..1 (beyond: the end's colour) on the scale of that colouring.
Rgb scale_color(Coloring coloring, double t);

struct Paint {
  Coloring coloring = Coloring::kElement;
  const Palette* palette = nullptr;
  const CompoundSurface* surface = nullptr;  // for deviations
  double low = 0, high = 1;  // heights, degrees from level, or deviations at the ends of the scale

  // Colour of a point with its unit normal (either side), without light.
  [[nodiscard]] Rgb color(std::uint32_t entry, const Vec3& point, const Vec3& normal) const;
};

// How bright a point with this unit normal in the camera's frame is: 0..about 1.1. The side away
// from the eye is lit like the side toward it.
float light_on(const Vec3& normal);

}  // namespace diesink
