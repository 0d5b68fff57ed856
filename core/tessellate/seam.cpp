// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/seam.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/tessellate/chart.h"
#include "core/tessellate/deviation.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// Length of chords over that of regular triangles that just keep the tolerance: what refinement
// puts beside a chord that cannot be split is longer than the chord.
constexpr double kEdgeShare = 0.7;
// Chords over that many times the shortest are halved while something lies nearer than half their
// length.
constexpr double kNearest = 8;
// Of the tolerance: chords without a bound are halved down to it, as those of arcs are.
constexpr double kUnboundShare = 0.1;
constexpr int kDeepest = 40;  // halvings between two changes

class SeamMaker {
 public:
  SeamMaker(const Impl& surface, const SeamOptions& options, Seam& seam)
      : surface_(surface),
        options_(options),
        vertices_(body_vertices(surface)),
        solver_(surface),
        seam_(seam) {}
  void make();

 private:
  struct Place {
    double along = 0, z = 0;
    bool change = false;
  };
  [[nodiscard]] Vec2 plan(double along) const {
    return seam_.axis == 0 ? Vec2(seam_.at, along) : Vec2(along, seam_.at);
  }
  [[nodiscard]] Vec3 at(const Place& p) const {
    const Vec2 xy = plan(p.along);
    return {xy.x(), xy.y(), p.z};
  }
  [[nodiscard]] bool height(Label label, double along, double& z) const {
    const Vec2 p = plan(along);
    return solver_.height(label, p.x(), p.y(), z);
  }
  const FaceChart& chart(Label label) {
    FaceChart& made = charts_.try_emplace(label, surface_, label).first->second;
    made.draw_for(options_.tolerance);
    return made;
  }
  void add(Label label, const Place& p);
  [[nodiscard]] bool is_scan(Label label) const {
    return std::holds_alternative<ScannedSurface>(surface_.base) &&
           solver_.ref_of(label).solid == SurfaceRef::kBase;
  }
  void snap(LineChange& change) const;
  void between(const Place& a, const Place& b, Label label);
  void divide(const Place& a, const Place& b, Label label, int depth);
  [[nodiscard]] bool is_clear(const Place& a, const Place& b) const;
  [[nodiscard]] double chord_bound(Label label, const Place& a, const Place& b) const;

  const Impl& surface_;
  const SeamOptions& options_;
  std::vector<BodyVertices> vertices_;
  CurveSolver solver_;
  std::unordered_map<Label, FaceChart> charts_;
  Seam& seam_;
};

void SeamMaker::add(Label label, const Place& p) {
  SeamPoint point;
  point.along = p.along;
  point.low = point.high = label;
  point.heights.push_back({label, p.z});
  seam_.points.push_back(std::move(point));
}

// Nothing but the seam's own changes within half the chord's length of it.
bool SeamMaker::is_clear(const Place& a, const Place& b) const {
  const double half = 0.5 * (b.along - a.along);
  const PlanBox& d = options_.domain;
  PlanBox box{seam_.at - half, seam_.at + half, a.along, b.along};
  if (seam_.axis == 1) box = {a.along, b.along, seam_.at - half, seam_.at + half};
  box = {std::fmax(box.x0, d.x0), std::fmin(box.x1, d.x1), std::fmax(box.y0, d.y0),
         std::fmin(box.y1, d.y1)};
  std::vector<std::uint32_t> steps;
  surface_.index.over(box, steps);
  CellVerdict verdict;
  classify(surface_, vertices_, CellBox::of(box), steps, options_.search.flat, verdict);
  if (verdict.kind == CellKind::kPlain) return true;
  return verdict.kind == CellKind::kArc && verdict.functions.count == 1 && (a.change || b.change);
}

// Of the distance between the chord and the face's own section along the seam.
double SeamMaker::chord_bound(Label label, const Place& a, const Place& b) const {
  CurvePair pair;
  pair.f = solver_.implicit(solver_.ref_of(label));
  pair.g.kind = Implicit::Kind::kPlane;
  pair.g.c = at({a.along, 0});
  pair.g.n = seam_.axis == 0 ? Vec3::UnitX() : Vec3::UnitY();
  return chord_deviation(pair, at(a), at(b));
}

void SeamMaker::divide(const Place& a, const Place& b, Label label, int depth) {
  Place m;
  m.along = 0.5 * (a.along + b.along);
  if (depth > kDeepest || !(m.along > a.along && m.along < b.along) || !height(label, m.along, m.z))
    return;
  const Vec3 p = at(a), q = at(b), middle = at(m);
  const double length = (q - p).norm();
  if (length <= 2 * options_.shortest) {
    // Beside a silhouette, where the section turns within less, only shorter chords have a bound.
    if (length <= kUnboundShare * options_.tolerance || chord_bound(label, a, b) < HUGE_VAL) return;
    divide(a, m, label, depth + 1);
    add(label, m);
    return divide(m, b, label, depth + 1);
  }
  const FaceChart& on = chart(label);
  double edge = HUGE_VAL;
  for (const Vec3& r : {p, middle, q}) edge = std::fmin(edge, on.spacing(r, options_.tolerance));
  bool split = length > kEdgeShare * edge;
  split = split || (b.along - a.along > kNearest * options_.shortest && !is_clear(a, b));
  split = split || !(chord_bound(label, a, b) <= options_.sag);
  if (!split) return;
  divide(a, m, label, depth + 1);
  add(label, m);
  divide(m, b, label, depth + 1);
}

void SeamMaker::between(const Place& a, const Place& b, Label label) {
  if (is_scan(label)) {
    for (const Vec2& vertex : options_.profile) {
      const bool fresh = seam_.points.empty() || seam_.points.back().along < vertex.x();
      if (vertex.x() > a.along && vertex.x() < b.along && fresh)
        add(label, {vertex.x(), vertex.y(), false});
    }
    return;
  }
  if (options_.grid == nullptr) return divide(a, b, label, 0);
  // What a change lies beside by a thousandth of the interval, the change stands for.
  const std::vector<double>& lines = *options_.grid;
  const double close = lines.size() > 1 ? 1e-3 * (lines[1] - lines[0]) : 0;
  for (const double line : lines) {
    Place p;
    p.along = line;
    if (line > a.along + close && line < b.along - close && height(label, line, p.z)) add(label, p);
  }
}

// A change of or to a scanned base at one of its vertices is there to the digit.
void SeamMaker::snap(LineChange& change) const {
  const double near = 2e-10 * surface_.size;  // what arcs over a scan count as one, and a little
  double& along = seam_.axis == 0 ? change.y : change.x;
  const auto vertex =
      std::lower_bound(options_.profile.begin(), options_.profile.end(), along - near,
                       [](const Vec2& v, double at) { return v.x() < at; });
  if (vertex == options_.profile.end() || vertex->x() > along + near) return;
  double before = 0;
  bool known = false;
  for (const LabelHeight& h : change.heights) {
    if (!is_scan(h.label)) continue;
    before = h.z;
    known = true;
  }
  if (!known) return;
  along = vertex->x();
  for (LabelHeight& h : change.heights) {
    if (h.z == before) h.z = vertex->y();
  }
}

void SeamMaker::make() {
  const Vec2 p = plan(seam_.from), q = plan(seam_.to);
  std::vector<std::uint32_t> steps;
  surface_.index.over({p.x(), q.x(), p.y(), q.y()}, steps);
  LineFinding found = ChangeSearch(surface_, vertices_, options_.search).find(p, q, steps);
  std::vector<LineChange>& changes = found.changes;
  seam_.unsettled_area = found.unsettled_area;
  seam_.unsettled_place = found.unsettled_place;
  for (LineChange& change : changes) snap(change);
  const LineState first = surface_.evaluate_face(p.x(), p.y()),
                  last = surface_.evaluate_face(q.x(), q.y());
  const auto height_in = [](const LineChange& change, Label label) {
    for (const LabelHeight& h : change.heights) {
      if (h.label == label) return h.z;
    }
    return 0.0;
  };
  for (std::size_t k = 0; k <= changes.size(); ++k) {
    const Label label = k == 0 ? first.label : changes[k - 1].high;
    Place a{seam_.from, first.z, false}, b{seam_.to, last.z, false};
    const auto along = [&](const LineChange& c) { return seam_.axis == 0 ? c.y : c.x; };
    if (k > 0) a = {along(changes[k - 1]), height_in(changes[k - 1], label), true};
    if (k < changes.size()) b = {along(changes[k]), height_in(changes[k], label), true};
    if (label != kNoLabel && a.along < b.along) between(a, b, label);
    if (k == changes.size()) break;
    SeamPoint point;
    point.along = b.along;
    point.change = true;
    point.low = changes[k].low;
    point.high = changes[k].high;
    point.curve = changes[k].curve;
    point.heights = changes[k].heights;
    seam_.points.push_back(std::move(point));
  }
}

}  // namespace

std::size_t Seam::changes() const {
  return static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(), [](const SeamPoint& p) { return p.change; }));
}

TileSides::TileSides(const PlanBox& box, const TessellationOptions& options, double inset)
    : cut{options.tile[1] > 0, options.tile[0] + 1 < options.tiles[0],
          options.tile[1] + 1 < options.tiles[1], options.tile[0] > 0},
      at{box.y0, box.x1, box.y1, box.x0} {
  const auto off = [&](std::size_t side) { return cut[side] ? 0 : inset; };
  const PlanBox inner{box.x0 + off(3), box.x1 - off(1), box.y0 + off(0), box.y1 - off(2)};
  from = {inner.x0, inner.y0, inner.x0, inner.y0};
  to = {inner.x1, inner.y1, inner.x1, inner.y1};
}

Seam make_seam(const Impl& surface, int axis, double at, double from, double to,
               const SeamOptions& options) {
  Seam seam;
  seam.axis = axis;
  seam.at = at;
  seam.from = from;
  seam.to = to;
  SeamMaker(surface, options, seam).make();
  return seam;
}

}  // namespace diesink
