// Where a domain is cut into tiles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "core/compound/compound_surface.h"

namespace diesink {

// Ascending, the domain's own ends first and last: tile (i, j) is x[i] .. x[i + 1], y[j] ..
// y[j + 1].
struct TileCuts {
  std::vector<double> x, y;
};

// Even parts of the domain, but that a cut keeps off what lies along it or meets in it (walls,
// creases, rims, corners): there it moves aside, by an eighth of a tile at most, to where every
// curve crosses it at an angle of more than seven degrees with nothing else beside the crossing, or
// several that lie in one line. Where there is no such place the part is even.
// A function of the surface, the domain, the number of tiles and the tolerance: whoever makes a
// tile finds the same cuts.
// Needs: tiles >= 1, tolerance > 0.
TileCuts tile_cuts(const CompoundSurface& surface, const std::array<int, 2>& tiles,
                   double tolerance);

}  // namespace diesink
