// What enclosures cannot tell of surfaces that touch: along the side of a box, along a straight
// line. SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/tessellate/cell_tree.h"

namespace diesink {

// Of a tie: enclosures that decide one leave evaluation its rounding, lest a cell be plain that
// shows another label in its corner.
inline constexpr double kEnclosureSlack = 0.125;

// f lies nowhere in the box below g by more than a tie, and above it in the middle: their
// difference rises the same way everywhere in the box, so that it is least in one of its corners.
// Faces that touch along the domain's border are told apart by this.
bool rises_above(const CompoundSurface::Impl& surface, const FaceOver& f, const FaceOver& g,
                 const CellBox& box);

// f is nowhere below g where both are there, because the one touches the other along a line or a
// curve and does not cross it: two sides as SideContacts has them, a side and a plane tangent to
// it. (A point of contact alone is told, too.)
bool touches_from_above(const CompoundSurface::Impl& surface, const FaceOver& f, const FaceOver& g,
                        const CellBox& box);

// f is nowhere below g where both are there: one is a quadric's side and the other a plane face
// that is all but upright, and the middle plane of the quadric is beyond another face of that
// face's body, but for so little that on the steep face it is less than a tie of the plan. So a bar
// along the edge of a block covers the block's side, its axis as high as the block's top.
bool covers_steep_face(const CompoundSurface::Impl& surface, const FaceOver& f, const FaceOver& g,
                       const CellBox& box);

// Takes out of the functions those crossings that vanish, to eight ties, along a shadow, silhouette
// or edge of the list that is straight and parallel to an axis: a regular function has no other
// zero line in the box. So an edge of a solid that lies in the base is one line, not two. False
// where there is none.
bool drop_crossings_along_lines(const CompoundSurface::Impl& surface, const CellBox& box,
                                CellVerdict& verdict);

}  // namespace diesink
