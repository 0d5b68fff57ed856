// The prepared compound surface: what evaluation by point, row and cell and the tessellator share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "core/base/ferguson.h"
#include "core/base/plane.h"
#include "core/base/scanned.h"
#include "core/compound/body_line.h"
#include "core/compound/compound_surface.h"
#include "core/compound/side_contacts.h"

namespace diesink {

// What rounding may leave between two descriptions of one line, in ties.
constexpr double kLineSlack = 8;

// A step of the Boolean expression in evaluation order.
struct CompoundStep {
  BooleanStep::Kind kind = BooleanStep::Kind::kTerm;
  Sign sign = Sign::kPlus;
  std::int32_t solid = -1;  // index of the body; -1 = the base
  std::int32_t row = 0;
  // The first row of the same body and sign: a mesh labels faces by it, lest a face that two rows
  // show be parted from itself.
  std::int32_t first_row = 0;
};

// The value of the expression so far on one line.
struct LineState {
  double z = 0;
  Label label = kNoLabel;
};

// Which steps can matter over each cell of a uniform plan grid, in evaluation order.
class PlanIndex {
 public:
  void build(const std::vector<CompoundStep>& steps, const std::vector<PlanBox>& boxes,
             const PlanBox& extent);

  // The steps that may matter over (x, y); valid for every point of the plan.
  [[nodiscard]] std::span<const std::uint32_t> at(double x, double y) const;
  // The steps that may matter anywhere over a box, ascending; `out` is cleared first.
  void over(const PlanBox& box, std::vector<std::uint32_t>& out) const;

 private:
  std::vector<PlanBox> boxes_;
  PlanBox extent_;
  int nx_ = 1, ny_ = 1;
  double inv_dx_ = 0, inv_dy_ = 0;
  std::vector<std::uint32_t> start_, items_;
};

// A stretch of the border of a Ferguson base in plan, with the range of its inward unit normal.
struct BaseBorderPiece {
  PlanBox box;
  double x = 0, y = 0;  // a point of it
  Range nx, ny;
  std::uint32_t side = 0;
  bool straight = false;
  double close = 0;  // plan distance within which a point beside it counts as on it
};

struct CompoundSurface::Impl {
  PartProgram program;
  std::vector<BodyLine> bodies;  // one a solid of the program
  std::vector<std::int32_t>
      side_class;         // of each body: the first body whose side is the same quadric
  SideContacts contacts;  // of the bodies' sides
  std::vector<CompoundStep> steps;
  std::vector<std::uint32_t> step_of_row;
  std::variant<std::monostate, PlaneSurface, FergusonSurface, ScannedSurface> base;
  std::vector<BaseBorderPiece> base_border;  // Ferguson bases only
  PlanIndex index;
  double size = 0, tie = 0;

  [[nodiscard]] bool base_at(double x, double y, BaseHit& hit) const;
  // The expression over (x, y), only the given steps counted (all that matter there must be among
  // them).
  [[nodiscard]] LineState evaluate(std::span<const std::uint32_t> steps_here, double x,
                                   double y) const;
  [[nodiscard]] LineState evaluate(double x, double y) const {
    return evaluate(index.at(x, y), x, y);
  }
  // The same for a mesh: with the face's label by its first row, and where two faces touch and do
  // not cross, a tie goes to the one that is beyond the other on both sides of where they touch. (A
  // side that reaches through a plane by no more than kLineSlack ties touches it: given to last
  // digits, a bar along a leaning side does that for millimetres.)
  [[nodiscard]] LineState evaluate_face(double x, double y) const;
  [[nodiscard]] Label face_label(Label label) const {
    if (label == kNoLabel) return label;
    const CompoundStep& step = steps[step_of_row[static_cast<std::size_t>(row_of(label))]];
    return make_label(step.first_row, static_cast<std::uint32_t>(face_of(label)));
  }
  // Of two faces within kLineSlack ties of one another over (x, y), f is nowhere below g, because
  // the one touches the other and does not cross it. `planes_alone`: where one of the two is a
  // plane.
  [[nodiscard]] bool touches_from_above(Label f, Label g, double x, double y,
                                        bool planes_alone) const;
  // Unit upward normal of the label's own surface at a point of it.
  [[nodiscard]] Vec3 normal(Label label, const Vec3& point) const;
};

}  // namespace diesink
