// A convex body made ready for one row: the constants of BodyLine::meet() at one y, and the part of
// the row it can touch.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "core/compound/body_line.h"
#include "core/compound/compound_surface.h"

namespace diesink {

// How the side of a body bounds the lines of a row; SideRule with its degenerate cases told apart.
enum class RowSide : std::uint8_t {
  kNone,              // polyhedron
  kBetween,           // between two roots
  kParaboloidAbove,   // upright paraboloid, inside above its one root
  kParaboloidBelow,   // the same, inside below
  kBelowFirst,        // steep cone, apex up
  kBelowFirstLinear,  // with a generator upright: one root
  kAboveLast,         // steep cone, apex down
  kAboveLastLinear,
  kColumn,  // upright cylinder
};

// The most caps and upright faces of any body: a hexahedron has six faces.
inline constexpr std::size_t kMostRowFaces = 8;

// z = (z0 + zx dx) + zy_dy, as BodyLine has it.
struct RowCap {
  double z0, zx, zy_dy;
  std::uint64_t label;
};

// (a dx + b_dy) + c > slack is outside.
struct RowHalf {
  double a, b_dy, c;
};

// What a kernel needs of a body on a row. dx = x - cx; every sum is in the order of
// BodyLine::meet(), so that the digits are the same.
struct BodyRow {
  RowSide side = RowSide::kNone;
  bool plus = true;
  double cx = 0, cz = 0, slack = 0, tie = 0, z_low = 0, z_high = 0;
  double q2 = 0, disc_slack = 0, b0_twice = 0;
  double b0 = 0, bx = 0, by_dy = 0;
  double c0 = 0, cx1 = 0, cxx = 0, cxy_dy = 0, c_dy = 0;
  double d0 = 0, dx1 = 0, dxx = 0, dxy_dy = 0, d_dy = 0;
  std::uint64_t side_label = 0;
  std::size_t uppers = 0, lowers = 0, halves = 0;
  std::array<RowCap, kMostRowFaces> upper, lower;
  std::array<RowHalf, kMostRowFaces> half;
};

// Where along the row the body can be: a range of x that contains every point where meet() is true,
// as tight as its shadow's border allows; empty (lo > hi) where the row passes it by.
Range row_span(const BodyLine& body, double y);

// The constants of a row. `row` is the Boolean table's, which the labels name.
void make_body_row(const BodyLine& body, double y, int row, Sign sign, double tie, BodyRow& out);

}  // namespace diesink
