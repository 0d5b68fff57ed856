// Two quadrics that meet in plane curves: bars of one thickness that cross.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/tessellate/implicit.h"

namespace diesink {

// The plane through a and b in which a whole branch of the curve F = G = 0 lies, where a member of
// the pencil F - k G is a pair of planes and one of them holds both points. With F it is the same
// branch, and it tells the branch where F and G touch.
// Needs:  two quadrics; a and b on both to rounding.
// Bound:  the member is a pair of planes to 1e-12 of its size over the box about a, b and the
//         quadrics' centres; nullopt otherwise.
// Source: the degenerate members of a pencil of quadrics.
std::optional<Implicit> pencil_plane(const Implicit& f, const Implicit& g, const Vec3& a,
                                     const Vec3& b);

}  // namespace diesink
