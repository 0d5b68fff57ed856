// The path interval from a cusp height: equations (15) to (17).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/machining/cutter.h"
#include "core/vec.h"

namespace diesink {

// Distance on the surface between the contacts of two neighbouring passes of a ball of radius R
// that leave a cusp of height h between them; curvature across the passes, positive where the
// surface is convex (1/rho of the paper), 0 for a plane. Infinity where no cusp of that height can
// form. Source: equation (15), and (16) for a plane.
double cusp_interval(double R, double curvature, double h);

// Surface unit normal (n_z > 0) and unit plan direction of the pass: the paper's plan interval for
// an interval of `on_surface`. Source: equation (17).
double plan_interval(double on_surface, const Vec3& normal, const Vec2& along);

// The distance between passes of a cutter dropped on the surface, measured square to the passes in
// plan, at a contact with the given normal and curvature across: the interval of the cutter's
// centres (equation (15) taken from the contacts to the centres), and square to the pass where (17)
// takes the length in plan. A flat end counts with its width on level ground and with its corner's
// cusp on slopes. Infinity where the contact sets no limit.
double drop_interval(const CutterShape& cutter, const Vec3& normal, const Vec2& along,
                     double curvature, double h);

// Unit vector across the pass, tangent to the surface. Source: after equation (17).
Vec3 across_of(const Vec3& normal, const Vec2& along);

}  // namespace diesink
