// Borders that no order can be found for: the plan laid anew in straight chords that do not cross.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "core/tessellate/arc_samples.h"

namespace diesink {

// Crossings of chords, as the triangulation names them, before the grain grows: a die that is hard
// takes a hundredth, and each round of the most that one names is about a second.
inline constexpr std::size_t kMostUntangled = 200'000;

// The chords that arcs have become, made a planar subdivision: where two cross both get a vertex,
// places closer than the grain become one, and each face between chords gets the label that they
// have on its side; where they contradict one another, the label that evaluation finds over most of
// it. Chords that cross nothing stay, with their bounds. What comes out can always be triangulated
// in plan, whatever has gone wrong before: the last resort before a die would be refused.
// Needs:  `samples` of `arrangement`, whose loops and regions do not matter.
//         largest_coordinate: of the mesh, if it will be moved; else 0.
// Shape:  arcs are fixed; their chains are their nodes.
// Bound:  no vertex moves by more than a grain: 2.5e-10 of the size, or four ulps of the largest
//         coordinate; 16 times as much for each time that 32 rounds do not end the crossings, or
//         that they are more than most_crossings over all of those. Nodes
//         of cuts between tiles stay, and the labels beside them. The plan area of faces about
//         which chords do not agree is added to uncertified_area.
// Errors: nothing where grains would be as large as the domain.
// Source: Hobby, "Practical segment intersection with finite precision output", 1999, by repeated
//         exact construction instead of a sweep.
std::optional<Arrangement> untangle(const CompoundSurface::Impl& surface,
                                    const Arrangement& arrangement, const ArcSamples& samples,
                                    double largest_coordinate,
                                    std::size_t most_crossings = kMostUntangled);

}  // namespace diesink
