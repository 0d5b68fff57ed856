// Where labels change along an axis-parallel line of the plan.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/tessellate/cell_tree.h"
#include "core/tessellate/plan_curve.h"
#include "core/tessellate/search_budget.h"

namespace diesink {

// A change, with the labels on the side of lower and of higher coordinate.
struct LineChange {
  double x = 0, y = 0;  // the line's own coordinate to the bit
  Label low = kNoLabel, high = kNoLabel;
  PlanCurve curve;
  std::vector<LabelHeight> heights;  // one a label
};

struct LineLimits {
  double flat = 0;   // height under which candidates count as one surface
  double least = 0;  // length along the line under which what enclosures cannot part is told apart
                     // by evaluation alone
  double wide = 0, deep = 0;                 // what is smaller needs no word: LineFinding
  std::size_t most = SearchBudget().pieces;  // SearchBudget::pieces
};

struct LineFinding {
  std::vector<LineChange> changes;  // in order; each label follows from the one before
  // Of squares on both sides of those pieces in which something may change unseen, where the
  // surfaces lie farther apart than `deep` and the pieces are longer than `wide`.
  double unsettled_area = 0;
  Vec2 unsettled_place = Vec2::Zero();  // in the first of them
};

// Cheap to copy; const functions may be called from any number of threads.
class ChangeSearch {
 public:
  // Needs: everything given by reference outlives this.
  ChangeSearch(const CompoundSurface::Impl& surface, const std::vector<BodyVertices>& vertices,
               const LineLimits& limits)
      : surface_(surface), vertices_(vertices), solver_(surface), limits_(limits) {}

  // The changes between p and q. A function of the surface, p and q alone: `steps` are all that may
  // matter on the line.
  // Needs: p.x = q.x or p.y = q.y, p the lower.
  [[nodiscard]] LineFinding find(const Vec2& p, const Vec2& q,
                                 const std::vector<std::uint32_t>& steps) const;

 private:
  struct Run {
    double shortest = 0, shortest_regular = 0;  // pieces that are not halved
    std::size_t unsettled = 0;
    LineFinding found;
  };
  struct Sample {
    Vec2 p;
    LineState state;
  };
  [[nodiscard]] Sample sample(const Vec2& p) const {
    return {p, surface_.evaluate_face(p.x(), p.y())};
  }
  void search(const Sample& p, const Sample& q, const std::vector<std::uint32_t>& steps, int depth,
              Run& run) const;
  void note_unsettled(const Vec2& at, double length, double depth, Run& run) const;
  void name_by_sliver(const Sample& p, const Sample& q, CurveSolver::Change& change) const;
  void add_change(const Sample& p, const Sample& q, int depth, std::vector<LineChange>& out) const;

  const CompoundSurface::Impl& surface_;
  const std::vector<BodyVertices>& vertices_;
  CurveSolver solver_;
  LineLimits limits_;
};

}  // namespace diesink
