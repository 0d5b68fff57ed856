// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "core/base/ferguson.h"

namespace diesink {

void FergusonSurface::row(double y, std::span<const double> xs, double* z, double* zx,
                          double* zy) const {
  FergusonHint hint;
  BaseHit hit;
  for (std::size_t i = 0; i < xs.size(); ++i) {
    const bool found = at(xs[i], y, hit, hint);
    z[i] = found ? hit.z : std::numeric_limits<double>::quiet_NaN();
    zx[i] = found ? hit.zx : 0;
    zy[i] = found ? hit.zy : 0;
  }
}

}  // namespace diesink
