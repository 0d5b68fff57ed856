// The lattice of a verification, thinned for pictures.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/machining/verify.h"

namespace diesink {

struct LatticeMap {
  std::size_t columns = 0, rows = 0;  // row-major from the low corner, as the lattice is
  std::size_t every = 1;              // lattice lines a pixel, each way
  std::vector<std::size_t> points;    // one a pixel
};

// At most `most` pixels a side. Of the lattice points under one pixel the one that stands out most:
// the deepest gouge beyond `intol`, else what is not cut, else what stays highest.
LatticeMap thinned(const VerifyReport& found, double intol, std::size_t most);

}  // namespace diesink
