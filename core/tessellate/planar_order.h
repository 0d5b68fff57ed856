// The order in which many points are inserted into a triangulation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/tessellate/planar_predicates.h"

namespace diesink {

// The indices of the points in rounds drawn at random, each round eight times the one before it,
// and within a round along a Hilbert curve: neighbours in the order are neighbours in the plane,
// yet no arrangement of points makes insertion quadratic. Same order on every machine.
// Needs:  coordinates within +-2^51.
// Source: Amenta, Choi and Rote, "Incremental constructions con BRIO", 2003.
std::vector<std::uint32_t> insertion_order(std::span<const LatticePoint> points);

}  // namespace diesink
