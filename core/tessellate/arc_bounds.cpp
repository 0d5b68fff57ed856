// How far the chords of arcs are off: the curve itself, and what lies under and over a wall's.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/tessellate/arc_samples.h"
#include "core/tessellate/outline.h"

namespace diesink {

double ArcSamples::sag_of(std::uint32_t a) const {
  const PlanArc& arc = arrangement_.arcs[a];
  for (const Label label : {arc.left, arc.right}) {
    if (label != kNoLabel && (is_scan(label) || !charts_.at(label).is_plane())) return options_.sag;
  }
  return options_.flat_sag;
}

double ArcSamples::bound(std::uint32_t a, const ArcSample& s, const ArcSample& e) const {
  const double t1 = e.t <= s.t ? static_cast<double>(arrangement_.arcs[a].nodes.size() - 1) : e.t;
  return bound(a, s.t, points[s.point], t1, points[e.point]);
}

double ArcSamples::bound(std::uint32_t a, double t0, const ArcPoint& p, double t1,
                         const ArcPoint& q) const {
  // Beside a scan each stretch is a curve of its own, in the plane of one facet: farthest from a
  // chord over several of them is a point between two, or the curve beside its own chord.
  const auto first = static_cast<std::size_t>(t0) + 1;
  const auto end = static_cast<std::size_t>(std::ceil(t1));
  if (first >= end || !(has_scan(a))) return bound_of(a, 0.5 * (t0 + t1), p, q);
  double off = 0, most = 0;
  ArcPoint from = p;
  for (std::size_t k = first; k <= end; ++k) {
    const ArcPoint to = k == end ? q : point_at(a, static_cast<double>(k));
    if (k < end) off = std::fmax(off, lifted_sag(a, p, to, q));
    most = std::fmax(most, bound_of(a, static_cast<double>(k) - 0.5, from, to));
    from = to;
  }
  return most + off;
}

bool ArcSamples::has_scan(std::uint32_t a) const {
  const PlanArc& arc = arrangement_.arcs[a];
  return (arc.left != kNoLabel && is_scan(arc.left)) ||
         (arc.right != kNoLabel && is_scan(arc.right));
}

double ArcSamples::bound_of(std::uint32_t a, double t, const ArcPoint& p, const ArcPoint& q) const {
  const PlanArc& arc = arrangement_.arcs[a];
  const std::size_t k = std::min(static_cast<std::size_t>(t), arc.nodes.size() - 2);
  const PlanCurve& curve = arc.curves[k];
  if (arc.border) {
    if (arc.left == kNoLabel || is_scan(arc.left)) return 0;
    CurvePair pair;
    pair.f = solver_.implicit(solver_.ref_of(arc.left));
    pair.g.kind = Implicit::Kind::kPlane;
    pair.g.c = Vec3(p.x, p.y, 0);
    pair.g.n = p.x == q.x ? Vec3::UnitX() : Vec3::UnitY();
    return chord_deviation(pair, lifted(p, arc.left), lifted(q, arc.left));
  }
  if (curve.type == CurveType::kOutline) {
    if (std::holds_alternative<ScannedSurface>(surface_.base)) {
      // Straight in plan; what is beside the scan there is cut by an upright plane.
      const double length = std::hypot(q.x - p.x, q.y - p.y);
      double most = 0;
      for (const Label beside : {arc.left, arc.right}) {
        if (beside == kNoLabel || is_scan(beside) || !(length > 0)) continue;
        CurvePair pair;
        pair.f = solver_.implicit(solver_.ref_of(beside));
        pair.g.kind = Implicit::Kind::kPlane;
        pair.g.c = Vec3(p.x, p.y, 0);
        pair.g.n = Vec3((q.y - p.y) / length, (p.x - q.x) / length, 0);
        most = std::fmax(most, chord_deviation(pair, lifted(p, beside), lifted(q, beside)));
      }
      return most;
    }
    const double lateral = outline_chord_deviation(surface_, {p.x, p.y}, {q.x, q.y});
    double most = lateral;
    for (const Label label : {arc.left, arc.right}) {
      if (label != kNoLabel && !(solver_.ref_of(label) == curve.first))
        most = std::fmax(most, beside(lateral, label, p, q, curve));
    }
    return most;
  }
  if (curve.type != CurveType::kMeet && curve.type != CurveType::kShadow) return 0;
  const CurvePair pair{solver_.implicit(curve.first), solver_.implicit(curve.second)};
  Label own = arc.left;
  if (own == kNoLabel || !curve.is_height_of(solver_.ref_of(own))) own = arc.right;
  if (own == kNoLabel) own = arc.left;
  if (curve.type == CurveType::kMeet) {
    const double lateral = chord_deviation(pair, lifted(p, own), lifted(q, own));
    double most = lateral;
    for (const Label label : {arc.left, arc.right}) {
      if (label != kNoLabel && label != own && z_of(p, label) != z_of(p, own) &&
          !curve.is_height_of(solver_.ref_of(label)))
        most = std::fmax(most, beside(lateral, label, p, q, curve));
    }
    return most;
  }
  // The curve itself, at the body's own height even where that is hidden.
  Vec3 c0(p.x, p.y, 0), c1(q.x, q.y, 0);
  if (solver_.ref_of(own) == curve.first) {
    c0.z() = z_of(p, own);
    c1.z() = z_of(q, own);
  } else {
    c0.z() = solver_.shadow_height(curve, p.x, p.y);
    c1.z() = solver_.shadow_height(curve, q.x, q.y);
  }
  const double lateral = chord_deviation(pair, c0, c1);
  double most = lateral;
  for (const Label label : {arc.left, arc.right}) {
    if (label != kNoLabel && !(solver_.ref_of(label) == curve.first))
      most = std::fmax(most, beside(lateral, label, p, q, curve));
  }
  return most;
}

// The other side's border lies under or over the same plan curve. Where the upright surface on the
// plan curve is known it is where that meets the face; else it is as far from its chord as the cut
// of its face by the upright plane through the chord, then sideways as far as the plan curve, up
// and down by its slope there.
double ArcSamples::beside(double lateral, Label label, const ArcPoint& a, const ArcPoint& b,
                          const PlanCurve& curve) const {
  if (!(lateral < 1e300) || label == kNoLabel) return lateral;
  const FaceChart& chart = charts_.at(label);
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  double aslant = lateral;
  for (const ArcPoint* n : {&a, &b}) {
    const double nz = chart.normal(lifted(*n, label)).z();
    if (nz > 1e-3) aslant = std::fmax(aslant, lateral / nz);
  }
  if (is_scan(label) || chart.is_plane() || !(length > 0)) return aslant;
  CurvePair cut;
  cut.f = solver_.implicit(solver_.ref_of(label));
  if (const std::optional<Implicit> upright = solver_.upright(curve)) {
    cut.g = *upright;
    // Without a bound where the face touches the upright surface, as where rims touch.
    return std::fmax(lateral, chord_deviation(cut, lifted(a, label), lifted(b, label)));
  }
  cut.g.kind = Implicit::Kind::kPlane;
  cut.g.c = Vec3(a.x, a.y, 0);
  cut.g.n = Vec3((b.y - a.y) / length, (a.x - b.x) / length, 0);
  return aslant + chord_deviation(cut, lifted(a, label), lifted(b, label));
}

double ArcSamples::span_bound(std::uint32_t a, std::uint32_t from, std::uint32_t to) const {
  const SampledArc& arc = arcs[a];
  const ArcPoint &p = points[arc.samples[from].point], &q = points[arc.samples[to].point];
  double most = 0, off = 0;
  // Straight in plan, and how far in height the scan's own mesh tells.
  const PlanArc& of = arrangement_.arcs[a];
  if (of.border && of.left != kNoLabel && is_scan(of.left)) return 0;
  for (std::uint32_t k = from; k != to;) {
    most = std::fmax(most, arc.samples[k].deviation);
    k = arc.samples[k].next;
    if (k == ArcSample::kEnd) break;
    if (k != to) off = std::fmax(off, lifted_sag(a, p, points[arc.samples[k].point], q));
  }
  return most + off;
}

}  // namespace diesink
