// Flat triangles against a Ferguson surface whose grid is affine in plan, by its own polynomials.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/base/bicubic.h"
#include "core/base/ferguson.h"
#include "core/vec.h"

namespace diesink {

// What holds of the base over a triangle and a little about it.
struct BaseGap {
  double gap = 0;   // largest vertical distance to the flat triangle
  double bend = 0;  // largest norm of the second derivative in plan
  Vec2 slope = Vec2::Zero();
  double slope_spread = 0;  // slopes differ from `slope` by at most this
};

// The height of such a surface is one bicubic a patch over plan coordinates: its terms to the third
// order give the gap by their Bernstein form over the triangle, those of higher order and what
// neighbouring patches differ by are bounded by their second derivatives.
class AffineBase {
 public:
  // Needs: surface.affine().
  explicit AffineBase(const FergusonSurface& surface);

  // Bounds over the triangle, widened in plan by `margin`; false where it spans too many patches
  // to be worth while.
  // Needs:  vertices on the surface.
  // Bound:  exact where the second derivative is constant; above the truth by a third of what it
  //         varies by over an edge.
  bool over(const Vec3& a, const Vec3& b, const Vec3& c, double margin, BaseGap& out) const;

 private:
  AffinePlan plan_;
  int columns_, rows_;  // of patches
  std::vector<Bicubic> patches_;
};

}  // namespace diesink
