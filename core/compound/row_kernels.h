// The inner loops of row evaluation, several points at a time, by run-time dispatch to the
// machine's vectors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/compound/row_plan.h"

namespace diesink {

// The value of the expression so far along a row: z is NaN where it is undefined. Labels are as
// wide as heights so that one mask serves both.
struct RowState {
  double* z;
  std::uint64_t* label;
};

// One body over points [begin, end) of the row: added or subtracted as BodyRow says.
void apply_body(const BodyRow& body, const double* xs, std::size_t begin, std::size_t end,
                const RowState& state);

// Heights with labels of their own (a group's), or one label (the base's) over [begin, end); NaN is
// no height.
void apply_heights(const double* z, const std::uint64_t* label, std::size_t begin, std::size_t end,
                   double tie, const RowState& state);
void apply_base(const double* z, std::uint64_t label, bool plus, std::size_t begin, std::size_t end,
                double tie, const RowState& state);

// Unit normals of a height's slopes over `count` points.
void slope_normals(const double* zx, const double* zy, std::size_t count, double* nx, double* ny,
                   double* nz);

// The gradient of a quadric: M (r - centre) + linear, half the derivative of its equation.
struct QuadricGradient {
  double centre[3];
  double m[6];  // xx, xy, xz, yy, yz, zz
  double linear[3];
  double at_zero[3];  // the unit normal where the gradient vanishes (a cone's apex)
};

// Unit normals of a quadric, turned upward, at points (xs[i], y, z[i]).
void quadric_normals(const QuadricGradient& g, const double* xs, double y, const double* z,
                     std::size_t count, double* nx, double* ny, double* nz);

}  // namespace diesink
