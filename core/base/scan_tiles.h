// What the grids of a scan are drawn by (scanned_grid.cpp): tiles of the grid, the triangles sorted
// into them, and the buffer a tile is drawn in.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/line_search.h"
#include "core/vec.h"

namespace diesink {
namespace scan_grid {

// A tile's points, 32 bytes each, stay in a core's second cache together with its triangles.
constexpr std::size_t kMostColumns = 128, kMostRows = 32;
// Vectors may reach beyond a row's end by less than the widest of them.
constexpr std::size_t kPadding = 8;
constexpr std::size_t kStride = kMostColumns + kPadding;

// The lines of one direction. Where they are even, which of them a stretch can hold needs no look
// at the lines: a coordinate's place among them, counted in steps, is known to `slack`.
struct GridLines {
  explicit GridLines(std::span<const double> lines) : search(lines) {
    const auto count = static_cast<double>(lines.size());
    origin = lines.front();
    // The last step may be cut short; a single line has any step.
    const std::size_t whole = lines.size() > 2 ? lines.size() - 2 : lines.size() - 1;
    step = whole > 0 ? (lines[whole] - origin) / static_cast<double>(whole) : 1;
    if (!(step > 0)) step = 1;
    per_length = 1 / step;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      slack = std::max(slack, std::fabs((lines[k] - origin) * per_length - static_cast<double>(k)));
    }
    // Half a step off, and candidates would be half as many again.
    even = slack < 0.5;
    // Each place is rounded three times, by 2^-53 of at most the number of lines: beyond them
    // places are cut off.
    slack += (count + 2) * 0x1p-50;
    last = count - 1;
  }

  LineSearch search;
  double origin = 0, step = 1, per_length = 1;
  double slack = 0, last = 0;
  bool even = true;
};

// What the kernels know of the grid and of the mesh.
struct Scene {
  GridLines x, y;
  const Vec3* positions;
  const std::array<std::uint32_t, 3>* triangles;
  unsigned column_bits, row_bits;  // a tile has 2^bits lines each way
  std::uint32_t tile_columns;
};

// The lines a triangle's box can hold, both included; none where a first is beyond its last.
struct Reach {
  std::int32_t x0, y0, x1, y1;
};

// The tiles a triangle reaches into: that of its lowest corner and how many more there are each
// way. Four bytes: ranges of all triangles stand side by side while they are sorted.
struct TileRange {
  std::uint32_t packed;
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu, kMany = 0xFFFFFFFEu;
  static constexpr unsigned kTileBits = 24, kMoreBits = 4;
  static constexpr std::uint32_t kMostMore = (1u << kMoreBits) - 1;
};
// A grid of 100 million points, the limit, in one column has the most tiles.
static_assert(100'000'000 / kMostRows < (std::size_t{1} << TileRange::kTileBits) - 2);

// Points of one tile while it is drawn. Labels are as wide as heights so that one mask serves both.
struct TileBuffer {
  std::array<double, kStride> xs;
  std::array<double, kMostRows + 1> ys;
  // One row more than there are: blocks of two rows reach beyond the last.
  std::array<double, kStride*(kMostRows + 1)> z, zx, zy;
  std::array<std::uint64_t, kStride*(kMostRows + 1)> face;
};

// A triangle in a tile's list, with what would be looked up far away where they come in random
// order.
struct BinnedTriangle {
  std::uint32_t face;
  std::array<std::uint32_t, 3> vertices;
};

struct TilePlace {
  std::size_t column, row, columns, rows;
};

// How many triangles ahead memory is asked for theirs: in random order each is somewhere else.
constexpr std::size_t kAhead = 16;

}  // namespace scan_grid
}  // namespace diesink
