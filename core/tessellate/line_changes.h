// Where labels change along an axis-parallel line of the plan.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/tessellate/cell_tree.h"
#include "core/tessellate/plan_curve.h"

namespace diesink {

// A change, with the labels on the side of lower and of higher coordinate.
struct LineChange {
  double x = 0, y = 0;  // the line's own coordinate to the bit
  Label low = kNoLabel, high = kNoLabel;
  PlanCurve curve;
  std::vector<LabelHeight> heights;  // one a label
};

// Cheap to copy; const functions may be called from any number of threads.
class ChangeSearch {
 public:
  // `flat`: height under which candidates count as one surface; `least`: length along the line
  // under which what enclosures cannot part is told apart by evaluation alone.
  // Needs: everything given by reference outlives this.
  ChangeSearch(const CompoundSurface::Impl& surface, const std::vector<BodyVertices>& vertices,
               double flat, double least)
      : surface_(surface), vertices_(vertices), solver_(surface), flat_(flat), least_(least) {}

  // Adds the changes between p and q, in order; each label follows from the one before. A function
  // of the surface, p and q alone: `steps` are all that may matter on the line.
  // Needs: p.x = q.x or p.y = q.y, p the lower.
  void find(const Vec2& p, const Vec2& q, const std::vector<std::uint32_t>& steps,
            std::vector<LineChange>& out) const;

 private:
  struct Sample {
    Vec2 p;
    LineState state;
  };
  [[nodiscard]] Sample sample(const Vec2& p) const {
    return {p, surface_.evaluate_face(p.x(), p.y())};
  }
  void search(const Sample& p, const Sample& q, const std::vector<std::uint32_t>& steps, int depth,
              double shortest, std::vector<LineChange>& out) const;
  void add_change(const Sample& p, const Sample& q, std::vector<LineChange>& out) const;

  const CompoundSurface::Impl& surface_;
  const std::vector<BodyVertices>& vertices_;
  CurveSolver solver_;
  double flat_, least_;
};

}  // namespace diesink
