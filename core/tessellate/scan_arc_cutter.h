// What cut_arcs() works with: the places of nodes on the sheet, the ways of arcs over its triangles
// (scan_arc_ways.cpp) and along its border (scan_arc_border.cpp).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/tessellate/scan_arcs.h"

namespace diesink {

class ArcCutter {
 public:
  ArcCutter(const CompoundSurface::Impl& surface, const ScanSheet& sheet, double least,
            Arrangement& arrangement)
      : surface_(surface),
        sheet_(sheet),
        scan_(std::get<ScannedSurface>(surface.base)),
        arrangement_(arrangement),
        solver_(surface),
        near_(1e-10 * surface.size),
        least_(std::fmax(least, 16 * near_)) {
    sheet.fans(begins_, around_);
    out_.touched.assign(sheet.triangles.size(), 0);
    out_.node_at.assign(sheet.points.size(), ScanSheet::kNone);
    out_.place.resize(arrangement.nodes.size());
  }

  ScanArcs run() {
    drop_specks();
    // Ends of the base first: where its border meets other curves.
    name_outlines();
    for (const PlanArc& arc : arrangement_.arcs) {
      for (std::size_t k = 0; k < arc.curves.size(); ++k) {
        if (arc.curves[k].type != CurveType::kOutline) continue;
        snap_to_border(arc.nodes[k]);
        snap_to_border(arc.nodes[k + 1]);
      }
    }
    solve_border_corners();
    drop_specks();
    for (PlanArc& arc : arrangement_.arcs) {
      if (base_label(arc) != kNoLabel || has_outline(arc)) cut(arc);
    }
    join_at_vertices();
    part_at_shared_nodes();
    return std::move(out_);
  }

 private:
  [[nodiscard]] Label base_label(const PlanArc& arc) const {
    if (is_base(surface_, arc.left)) return arc.left;
    if (!arc.border && is_base(surface_, arc.right)) return arc.right;
    return kNoLabel;
  }
  [[nodiscard]] PlanNode& node(std::uint32_t n) { return arrangement_.nodes[n]; }
  [[nodiscard]] Vec2 at(std::uint32_t n) const {
    return {arrangement_.nodes[n].x, arrangement_.nodes[n].y};
  }
  [[nodiscard]] Vec2 point(std::uint32_t v) const { return sheet_.points[v].head<2>(); }
  [[nodiscard]] std::uint32_t canonical(std::uint32_t h) const {
    return std::min(h, sheet_.twin[h]);  // ScanSheet::kNone is the highest
  }

  ScanPlace place_in(std::uint32_t t, const Vec2& p) const;
  ScanPlace locate(const Vec2& p) const;
  const ScanPlace& place(std::uint32_t n);
  void triangles_at(const ScanPlace& place, std::vector<std::uint32_t>& out) const;
  std::uint32_t add_node(PlanNode made, const ScanPlace& where);
  void settle(std::uint32_t n);
  void snap_to_border(std::uint32_t n);

  void drop_specks();
  [[nodiscard]] bool is_near_border(const Vec2& p) const;
  void name_outlines();
  void solve_border_corners();
  [[nodiscard]] static bool has_outline(const PlanArc& arc) {
    return std::any_of(arc.curves.begin(), arc.curves.end(),
                       [](const PlanCurve& c) { return c.type == CurveType::kOutline; });
  }
  void cut(PlanArc& arc);
  void leave_once_round(PlanArc& arc) const;
  void join_at_vertices();
  void part_at_shared_nodes();
  void part_arc(std::uint32_t arc, const std::vector<std::uint32_t>& passes,
                std::vector<std::uint32_t>& pieces);
  void turn_at(const std::vector<char>& shared, PlanRegion& region) const;
  void trace(std::uint32_t a, std::uint32_t b, const PlanCurve& curve, int depth);
  void follow_border(std::uint32_t a, std::uint32_t b, const PlanCurve& curve);
  void emit(std::uint32_t n, PlanCurve curve, std::uint32_t triangle);
  [[nodiscard]] PlanCurve on_triangle(PlanCurve curve, std::uint32_t triangle) const {
    if (curve.first.solid == SurfaceRef::kBase) curve.first.facet = triangle;
    if (curve.second.solid == SurfaceRef::kBase) curve.second.facet = triangle;
    return curve;
  }
  bool crossing(std::uint32_t a, std::uint32_t b, const PlanCurve& curve, std::uint32_t h,
                std::uint32_t triangle, std::uint32_t& made);
  std::uint32_t middle(std::uint32_t a, std::uint32_t b, const PlanCurve& curve);
  std::uint32_t beyond_edge(std::uint32_t a, std::uint32_t b, const PlanCurve& curve,
                            std::uint32_t triangle);
  void set_heights(PlanNode& n, const PlanCurve& curve, double curve_z, double base_z) const;
  [[nodiscard]] double height_in(std::uint32_t n, Label label, double otherwise) const {
    for (const LabelHeight& h : arrangement_.nodes[n].heights) {
      if (h.label == label) return h.z;
    }
    return otherwise;
  }

  const CompoundSurface::Impl& surface_;
  const ScanSheet& sheet_;
  const ScannedSurface& scan_;
  Arrangement& arrangement_;
  CurveSolver solver_;
  double near_, least_;
  std::vector<std::uint32_t> begins_, around_;
  ScanArcs out_;
  // The arc at work.
  Label left_ = kNoLabel, right_ = kNoLabel, base_ = kNoLabel;
  bool base_left_ = true;
  std::vector<std::uint32_t> nodes_;
  std::vector<PlanCurve> curves_;
  std::size_t trace_steps_ = 0;
};

}  // namespace diesink
