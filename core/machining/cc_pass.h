// CC-data along one pass: sampling, edge detection and the step length of the paper.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/machining/tool_path_plan.h"

namespace diesink {

// A point of a pass: where on the curve, on which face, and how it follows the point before it.
struct CcSample {
  double s = 0;  // of the curve
  CcContact contact;
  int row = 0, face = 0;
  bool after_edge =
      false;  // the pair of an edge: the face, or the height, changed since the last one
};

// A curve in plan, s in [0, 1].
using PlanCurve = std::function<Vec2(double s)>;

// Equation (12): the cutting error of the straight move between two contacts of one face, for an
// effective cutter radius R: positive where it overcuts (convex), negative where it undercuts
// (concave). `direction` is the unit plan direction of the pass. Source: equations (12) to (14).
double cutting_error(const CcContact& a, const CcContact& b, const Vec2& direction, double R);

// Stretches of the curve over the surface and inside the domain, each in order of s: evenly spaced
// points (at most `spacing` apart), the pair of points on either side of every change of face, and
// midpoints until every move keeps `intol` and `outtol`.
std::vector<std::vector<CcSample>> cc_pass(const CompoundSurface& surface, const PlanCurve& curve,
                                           double R, double spacing, double intol, double outtol);

}  // namespace diesink
