// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/tile_cuts.h"

#include <algorithm>
#include <cmath>

#include "core/compound/compound_impl.h"
#include "core/tessellate/arrangement.h"
#include "core/tessellate/cell_tree.h"
#include "core/tessellate/home.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// Distances, over the tolerance, within which nothing but crossings may lie beside a cut; the later
// ones where the part leaves no room.
constexpr double kClearances[] = {2, 0.25, 1.0 / 64, 1e-3};
// Places looked at for each.
constexpr int kPlaces = 49;
// Of a tile's width: how far the last of them lies off.
constexpr double kFarthest = 0.125;
// Largest across-to-along ratio of the gradients' bounds: a curve crosses at seven degrees or more.
constexpr double kSteepest = 8;

class CutFinder {
 public:
  CutFinder(const Impl& surface, const PlanBox& domain, double tolerance)
      : surface_(surface),
        domain_(domain),
        tolerance_(tolerance),
        flat_(flat_height(surface, tolerance)),
        vertices_(body_vertices(surface)) {
    // Apexes that are seen: no label changes there, but a face is not smooth.
    for (const BodyLine& line : surface.bodies) {
      const QuadricBody* body = std::get_if<QuadricBody>(&line.body());
      if (body == nullptr || body->shape != QuadricShape::kCone) continue;
      const Vec3 apex = body->p + body->C * body->frame.row(2).transpose();
      const LineState seen = surface.evaluate_face(apex.x(), apex.y());
      if (seen.label == kNoLabel || std::fabs(seen.z - apex.z()) <= flat_)
        apexes_.emplace_back(apex.head<2>());
    }
    if (const auto* scan = std::get_if<ScannedSurface>(&surface.base)) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        for (const Vec3& p : scan->positions())
          vertices_of_scan_[axis].push_back(p[static_cast<Eigen::Index>(axis)]);
        std::sort(vertices_of_scan_[axis].begin(), vertices_of_scan_[axis].end());
      }
    }
  }

  // The cut for part k of n along an axis; `across`: cuts of the other axis already found.
  [[nodiscard]] double find(int axis, int k, int n, const std::vector<double>& across) const;

 private:
  [[nodiscard]] PlanBox box_of(int axis, double at, double half, double a, double b) const {
    return axis == 0 ? PlanBox{at - half, at + half, a, b} : PlanBox{a, b, at - half, at + half};
  }
  // A strip about a cut, and whether curves may cross it in bundles.
  struct Strip {
    int axis = 0;
    double at = 0, half = 0;
    bool bundles = false;
  };
  [[nodiscard]] bool is_clear(const Strip& strip, const std::vector<double>& across) const;
  [[nodiscard]] bool is_clear(const Strip& strip, double a, double b,
                              const std::vector<std::uint32_t>& steps) const;

  const Impl& surface_;
  PlanBox domain_;
  double tolerance_, flat_;
  std::vector<BodyVertices> vertices_;
  std::vector<Vec2> apexes_;
  std::array<std::vector<double>, 2> vertices_of_scan_;  // x and y of all, ascending
};

// Whether each part of the strip shows one face, or one curve that runs across.
bool CutFinder::is_clear(const Strip& strip, double a, double b,
                         const std::vector<std::uint32_t>& steps) const {
  std::vector<std::uint32_t> here = steps;
  CellVerdict verdict;
  const CellBox box = CellBox::of(box_of(strip.axis, strip.at, strip.half, a, b));
  classify(surface_, vertices_, box, here, flat_, verdict);
  if (verdict.kind == CellKind::kPlain) return true;
  const auto runs_across = [&](const PlanFunction& f) {
    const Range &along = strip.axis == 0 ? f.gy : f.gx, &off = strip.axis == 0 ? f.gx : f.gy;
    const double least = along.lo > 0 ? along.lo : along.hi < 0 ? -along.hi : 0;
    return std::fmax(std::fabs(off.lo), std::fabs(off.hi)) <= kSteepest * least;
  };
  if (verdict.kind == CellKind::kArc && verdict.functions.count == 1 &&
      runs_across(verdict.functions[0])) {
    return true;
  }
  if (b - a <= 4 * strip.half) {
    return strip.bundles && verdict.functions.count > 0 && !verdict.functions.full &&
           !verdict.candidates.full &&
           std::all_of(verdict.functions.begin(), verdict.functions.end(), runs_across);
  }
  const double middle = a + 0.5069 * (b - a);
  return is_clear(strip, a, middle, here) && is_clear(strip, middle, b, here);
}

bool CutFinder::is_clear(const Strip& strip, const std::vector<double>& across) const {
  const int axis = strip.axis;
  const double at = strip.at, half = strip.half;
  // Vertices of a scan are points on a cut or well off it.
  const std::vector<double>& all = vertices_of_scan_[static_cast<std::size_t>(axis)];
  const double near = 1e-9 * surface_.size;
  const auto first = std::lower_bound(all.begin(), all.end(), at - near);
  if (first != all.end() && *first <= at + near) return false;
  for (const Vec2& apex : apexes_) {
    if (std::fabs(apex[axis] - at) <= half) return false;
  }
  std::vector<std::uint32_t> steps;
  for (const double other : across) {
    // The tiles' corner: a face and nothing else, farther than a crossing runs along a cut.
    const double room = 2 * kSteepest * half;
    const PlanBox box = box_of(axis, at, room, other - room, other + room);
    surface_.index.over(box, steps);
    CellVerdict verdict;
    classify(surface_, vertices_, CellBox::of(box), steps, flat_, verdict);
    if (verdict.kind != CellKind::kPlain) return false;
  }
  const double inset = border_inset(surface_);
  const double from = (axis == 0 ? domain_.y0 : domain_.x0) + inset;
  const double to = (axis == 0 ? domain_.y1 : domain_.x1) - inset;
  surface_.index.over(box_of(axis, at, half, from, to), steps);
  return is_clear(strip, from, to, steps);
}

double CutFinder::find(int axis, int k, int n, const std::vector<double>& across) const {
  const double a = axis == 0 ? domain_.x0 : domain_.y0, b = axis == 0 ? domain_.x1 : domain_.y1;
  const double even = a + (b - a) * k / n, width = (b - a) / n;
  const double most = width / 64;  // clearance: tiles of less than the tolerance's width
  // Where a face goes over into another without an edge, as round edges do, several curves lie in
  // one line and cross every cut together: so they may, if nothing else goes.
  for (const bool bundles : {false, true}) {
    for (const double clearance : kClearances) {
      const double half =
          std::clamp(clearance * tolerance_, 32 * surface_.tie, std::fmax(most, 32 * surface_.tie));
      for (int place = 0; place < kPlaces; ++place) {
        // To either side in turn, a little farther each time, and never by a round part.
        const int away = (place + 1) / 2;  // 0, 1, 1, 2, 2, ...
        const double off = kFarthest * width * away / (0.5 * kPlaces) * 0.98713;
        const double at = place % 2 == 1 ? even + off : even - off;
        if (is_clear({axis, at, half, bundles}, across)) return at;
      }
    }
  }
  return even;
}

}  // namespace

TileCuts tile_cuts(const CompoundSurface& surface, const std::array<int, 2>& tiles,
                   double tolerance) {
  const Home home(surface);
  const Machining& m = home.surface().program().machining;
  const PlanBox domain{m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]};
  const CutFinder finder(home.surface().impl(), domain, tolerance);
  TileCuts cuts;
  std::vector<double> inner;
  cuts.x.push_back(domain.x0);
  for (int k = 1; k < tiles[0]; ++k) inner.push_back(finder.find(0, k, tiles[0], {}));
  cuts.x.insert(cuts.x.end(), inner.begin(), inner.end());
  cuts.x.push_back(domain.x1);
  cuts.y.push_back(domain.y0);
  for (int k = 1; k < tiles[1]; ++k) cuts.y.push_back(finder.find(1, k, tiles[1], inner));
  cuts.y.push_back(domain.y1);
  for (double& x : cuts.x) x -= home.way().x();
  for (double& y : cuts.y) y -= home.way().y();
  return cuts;
}

}  // namespace diesink
