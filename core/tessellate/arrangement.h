// The labelled plan of a die: arcs along which two faces meet or one ends, corners, and the regions
// between them. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/compound/compound_impl.h"
#include "core/result.h"
#include "core/tessellate/plan_curve.h"
#include "core/tessellate/seam.h"

namespace diesink {

// A point of the plan where an arc passes, ends or meets others.
struct PlanNode {
  double x = 0, y = 0;
  std::vector<LabelHeight>
      heights;  // one a label that touches the point; equal heights are equal to the bit
  bool corner = false;
  bool border = false;  // on the domain's border
  bool solved = true;   // false: found by halving or as the middle of a least cell
  bool seam = false;    // on a cut between tiles
  bool kept = false;    // inside an arc: its chain runs through the node itself
};

// Labels are seen travelling from the first node to the last.
struct PlanArc {
  std::vector<std::uint32_t> nodes;  // closed arcs repeat the first node at the end
  std::vector<PlanCurve> curves;  // one a stretch between nodes; the border's are of type kUnsolved
  Label left = kNoLabel, right = kNoLabel;
  bool closed = false;
  bool border = false;  // a stretch of the domain's border, the domain on its left
  bool fixed = false;   // of a cut between tiles, or laid straight: its chain is that of its nodes
  std::vector<double> bounds;  // one a stretch where it was laid straight; else worked out
};

// A directed arc of a loop.
struct ArcUse {
  std::uint32_t arc = 0;
  bool forward = true;
};

// A connected area of one label: its outer loop anticlockwise, then its holes clockwise.
struct PlanRegion {
  Label label = kNoLabel;  // kNoLabel: no surface
  std::vector<std::vector<ArcUse>> loops;
};

struct Arrangement {
  PlanBox box;  // the domain; border nodes lie on it exactly
  std::vector<PlanNode> nodes;
  std::vector<PlanArc> arcs;
  std::vector<PlanRegion> regions;
  double uncertified_area = 0;  // plan area of least cells that are not small beside the tolerance
  Vec2 uncertified_place = Vec2::Zero();  // in the first of them
  std::size_t disorder = 0;  // places where what is beside arcs does not fit together; another
                             // variant may
  bool keeps_seams = true;   // false: cells did not join to the seams; another variant may
  std::size_t cells = 0, least_cells = 0;
  bool widened = false;  // by ArrangementOptions::may_widen
  double grain = 0;      // of the lattice that untangle() has laid it on
};

struct ArrangementOptions {
  double tolerance =
      0;  // of the tessellation; decides what is too small to matter, never what is found above it
  double flat = 0;  // length under which surfaces, or lines side by side, count as one; 0 = 1e-4 of
                    // the tolerance
  double least = 0;               // least cell; 0 = least_cell()
  double largest_coordinate = 0;  // of the finished mesh, if it is moved: corners will round to it
  int variant = 0;  // of where cells are cut: another one where what is found cannot be meshed
  SearchBudget budget;
  std::size_t most_cells = 0;  // an error beyond; 0 = no limit
  bool may_widen = false;      // instead: least cells are wider there, told; an error even so where
                               // there are many corners
  int threads = 0;             // 0 = all cores
  // Sides of the box that are cuts between tiles: bottom, right, top, left. Not owned.
  std::array<const Seam*, 4> seams{};
};

// What of the border of a domain is left out: cells end so far inside it, that what only touches
// the border from outside is not seen, nor that two faces which meet along the border count as one
// beside it, as far as a tie reaches down their slope. (Not on cuts between tiles; where there are
// any all variants have one inset.)
double border_inset(const CompoundSurface::Impl& surface, int variant = 0);

// Of the tolerance: a cell no wider needs no word about what is joined in it.
constexpr double kUnseen = 0.05;

// Of the least cell: 2^-22 of the domain's longer side, or what the tolerance does not see, if that
// is smaller; but not below 2^-28 of the side.
double least_cell(double longer_side, double tolerance);

// Height under which surfaces, or lines side by side, count as one.
double flat_height(const CompoundSurface::Impl& surface, double tolerance);

// The exact point of a curve over the chord from a to b, at the fraction s of the chord, with the
// heights of both labels. False where it is not found close to the chord.
bool point_on_stretch(const CompoundSurface::Impl& surface, const CurveSolver& solver,
                      const PlanCurve& curve, Label left, Label right, const PlanNode& a,
                      const PlanNode& b, double s, PlanNode& node);

// Errors: kInput where no vertical line of the domain meets the surface; kLimit beyond most_cells.
// Source: docs/tessellation.md; the maximization diagram of a lower or upper envelope, with `-`
// terms.
Result<Arrangement> arrange(const CompoundSurface& surface, const PlanBox& domain,
                            const ArrangementOptions& options);

}  // namespace diesink
