// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "core/compound/compound_surface.h"

namespace diesink {

void CompoundSurface::row(double y, std::span<const double> xs, const CcRun& out) const {
  for (std::size_t i = 0; i < xs.size(); ++i) {
    const std::optional<CcDatum> datum = at(xs[i], y);
    out.z[i] = datum ? datum->z : std::numeric_limits<double>::quiet_NaN();
    out.nx[i] = datum ? datum->n.x() : 0;
    out.ny[i] = datum ? datum->n.y() : 0;
    out.nz[i] = datum ? datum->n.z() : 0;
    out.label[i] =
        datum ? make_label(datum->row, static_cast<std::uint32_t>(datum->face)) : kNoLabel;
  }
}

}  // namespace diesink
