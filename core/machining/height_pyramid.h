// Heights over a lattice with the largest of every block of two by two, four by four and so on.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/machining/cutter.h"
#include "core/machining/swept_heights.h"

namespace diesink {

class HeightPyramid {
 public:
  // NaN heights are holes. Needs: heights as the lattice says.
  HeightPyramid(const PlanLattice& lattice, std::vector<double> heights);

  // True where no lattice point within the cutter's radius stands more than `slack` above the
  // cutter with its tip at `tip`.
  [[nodiscard]] bool clears(const CutterShape& cutter, const Vec3& tip, double slack) const;

 private:
  [[nodiscard]] bool clears(const CutterShape& cutter, const Vec3& tip, double slack,
                            std::size_t level, std::size_t i, std::size_t j) const;

  struct Level {
    std::size_t columns = 0, rows = 0;
    std::vector<double> top;
  };
  PlanLattice lattice_;
  std::vector<Level> levels_;
};

}  // namespace diesink
