// A Ferguson composite surface as a base: bicubic patches over points, met by vertical lines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/base_surface.h"
#include "core/base/bicubic.h"
#include "core/part_program/part_program.h"
#include "core/result.h"
#include "core/vec.h"

namespace diesink {

// Where the last point was found; a start for the next one nearby. It changes the time taken, never
// the answer. u, v are the surface's parameters of that point: u along a row of the grid from 0 to
// columns - 1, v across.
struct FergusonHint {
  double u = 0, v = 0;
  std::int32_t patch = -1;  // -1: none yet
};

// Degree and number of terms of the polynomial that starts the inversion of a patch.
inline constexpr int kInverseDegree = 7;
inline constexpr int kInverseTerms = (kInverseDegree + 1) * (kInverseDegree + 2) / 2;

// One bicubic patch; s, t in [0, 1] are the fractions of u and v.
struct FergusonPatch {
  Bicubic x, y, z;
  PlanBox box;             // contains the patch in plan
  double closeness = 0;    // parameter distance within which the border still belongs to the patch
  double convergence = 0;  // a Newton step below this is rounding
};

// A fitted polynomial (x, y) -> (s, t) of a patch of a grid that is not affine in plan, in the
// terms xi^i eta^j, j ascending inside ascending i, xi = (x - cx) ix, eta = (y - cy) iy. Near
// enough for Newton's method, not exact.
struct InversePatch {
  double cx = 0, cy = 0, ix = 0, iy = 0;
  std::array<double, kInverseTerms> s{}, t{};
};

// Derivatives of the plan map of a patch and one over its Jacobian.
template <class T>
struct PlanSlopes {
  T xs, xt, ys, yt, inverse;
};

// Where a vertical line meets the surface, in the parameters of one patch.
struct FergusonFoot {
  std::uint32_t patch = 0;
  double s = 0, t = 0;
  PlanSlopes<double> plan{};  // of a warped grid only
};

// A grid that is affine in plan: u = ux (x - x0) + uy (y - y0), v likewise. No iteration is needed.
struct AffinePlan {
  double x0 = 0, y0 = 0;
  double ux = 0, uy = 0, vx = 0, vy = 0;
};

// Tangents along rows and columns are those of the C2 cubic spline with natural ends, one unit of
// parameter a span; twists are zero. The plan is closed: its border, to 1e-12 of the largest
// coordinate, is part of it. Immutable after make(); every const function may be called from
// several threads.
// Source: Choi et al. 1988, steps (b), (f); Scherrer and Hillberry, CAD 10(5), 1978.
class FergusonSurface {
 public:
  // Needs: columns, rows >= 2 and columns * rows points, finite.
  // Errors: kInput where the grid is folded, collapsed or overlaps itself in plan. The Bernstein
  //         coefficients of every patch's plan Jacobian, subdivided, must show one sign; what they
  //         cannot show is refused. The outline, sampled eight times a span, must not cross
  //         itself.
  static Result<FergusonSurface> make(const FergusonBase& base);

  // The errors of make() without the work that only evaluation needs.
  static Status check_plan(const FergusonBase& base);

  // The surface over (x, y); false outside its plan. The digits do not depend on the hint.
  // Bound: |dz| <= 1e-13 of the largest coordinate for slopes up to 1
  // (tests/core/ferguson_test.cpp).
  bool at(double x, double y, BaseHit& hit, FergusonHint& hint) const;

  // A run along x at one y, the same digits as at(); z is NaN and slopes 0 outside the plan.
  // Shape: the arrays have the length of xs, which ascends.
  void row(double y, std::span<const double> xs, double* z, double* zx, double* zy) const;

  // Certain enclosures over a plan box.
  // Bound: z is wider than its true range by O(h²), derivatives by O(h), h the box's size.
  [[nodiscard]] BaseBounds bounds(const PlanBox& box) const;

  // Parameters of the point over (x, y): u in [0, columns - 1], v in [0, rows - 1]; empty outside.
  [[nodiscard]] std::optional<Vec2> invert(double x, double y) const;

  struct Point {
    Vec3 r, ru, rv;  // position and derivatives by u and v
  };
  // Needs: parameters inside their ranges; they are clamped to them.
  [[nodiscard]] Point point(double u, double v) const;

  // The plan's outline: four curves, closed, the surface on the left of each: side k from
  // border(k, 0) to border(k, border_length(k)) = border(k + 1, 0).
  [[nodiscard]] double border_length(int side) const;
  // Plan point and its derivative by the curve's parameter w.
  struct BorderPoint {
    Vec2 at, along;
  };
  [[nodiscard]] BorderPoint border(int side, double w) const;

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] PlanBox plan_box() const { return plan_box_; }  // contains the plan
  [[nodiscard]] const std::optional<AffinePlan>& affine() const { return affine_; }

 private:
  [[nodiscard]] int patch_columns() const { return columns_ - 1; }
  [[nodiscard]] const FergusonPatch& patch(int i, int j) const {
    return patches_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_ - 1) +
                    static_cast<std::size_t>(i)];
  }
  static Result<FergusonSurface> with_patches(const FergusonBase& base);
  void make_patches(const FergusonBase& base);
  void make_inverses();
  void make_bins();
  [[nodiscard]] bool affine_foot(double x, double y, FergusonFoot& foot) const;
  [[nodiscard]] std::span<const std::uint32_t> patches_near(double x, double y) const;
  bool invert_in(std::uint32_t patch, double x, double y, FergusonFoot& foot) const;
  bool invert_surely(std::uint32_t patch, double x, double y, FergusonFoot& foot) const;
  bool invert_patch(double x, double y, std::int32_t hint, FergusonFoot& foot) const;
  // The patch next to one, or it itself, towards a point of its parameters; -1 beyond the grid.
  [[nodiscard]] std::int32_t beside(std::int32_t patch, double s, double t) const;
  [[nodiscard]] BaseBounds affine_bounds(const PlanBox& box) const;
  [[nodiscard]] BaseBounds warped_bounds(const PlanBox& box) const;

  int columns_ = 0, rows_ = 0;
  double size_ = 0;      // largest coordinate
  bool turned_ = false;  // the plan Jacobian is negative
  PlanBox plan_box_;
  std::optional<AffinePlan> affine_;
  double u_close_ = 0, v_close_ = 0;  // closed border of an affine plan, in parameters
  std::vector<FergusonPatch> patches_;
  std::vector<InversePatch> inverses_;  // one a patch; empty for an affine plan
  // Uniform plan bins of patch numbers, ascending, for warped grids.
  int bins_x_ = 1, bins_y_ = 1;
  double bin_ix_ = 0, bin_iy_ = 0;
  std::vector<std::uint32_t> bin_start_, bin_items_;
};

}  // namespace diesink
