// How two lines across which labels may change lie to one another in a box.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/tessellate/cell_tree.h"

namespace diesink {

// Two functions with the same zero line in the box: flush walls, concentric rims.
bool same_line(const PlanFunction& f, const PlanFunction& g, const CellBox& box, double tie);

// The gradients of the two are nowhere in the box along one another: their lines meet once at most.
bool is_transverse(const PlanFunction& f, const PlanFunction& g);

// How often the zero lines of functions of one verdict meet, beyond their gradients: lines that
// draw near to one another over the whole length of an edge, as those of an edge, and of the two
// faces beside it with a bar along it, at the six decimals of a drawing.
class LinePairs {
 public:
  enum class Meeting : std::uint8_t { kUnknown, kOnceAtMost, kNever };

  // Needs: the verdict's functions and candidates, which stay as they are while this is used.
  LinePairs(const CellVerdict& verdict, const CellBox& box, double tie)
      : verdict_(verdict), box_(box), tie_(tie) {}

  // Bound: to ties; lines closer than a few ties all along are not told apart.
  // Source: a conic on a line is a polynomial of degree two, its values and its slope lie between
  //         their Bernstein coefficients; where z_a = z_b and z_b = z_c, z_a = z_c.
  [[nodiscard]] Meeting of(int i, int j) const;

 private:
  [[nodiscard]] Meeting alone(const PlanFunction& f, const PlanFunction& g) const;
  [[nodiscard]] Meeting on_line(const PlanFunction& line, const PlanFunction& conic) const;

  const CellVerdict& verdict_;
  const CellBox& box_;
  double tie_;
};

}  // namespace diesink
