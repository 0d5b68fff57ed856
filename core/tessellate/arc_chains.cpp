// The chains of chords that arcs have become: split, thinned and asked.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "core/tessellate/arc_samples.h"

namespace diesink {

bool ArcSamples::find_splittable(std::uint32_t a, std::uint32_t b, double shortest, Ref& ref,
                                 double& t0, double& t1) const {
  const auto found = chords_.find(key(a, b));
  if (found == chords_.end() || arrangement_.arcs[found->second.arc].fixed) return false;
  ref = found->second;
  if (has_scan(ref.arc)) return false;  // the base has been cut along it
  const SampledArc& arc = arcs[ref.arc];
  const std::uint32_t next = arc.samples[ref.sample].next;
  const ArcPoint &p = points[arc.samples[ref.sample].point], &q = points[arc.samples[next].point];
  const PlanArc& of = arrangement_.arcs[ref.arc];
  t0 = arc.samples[ref.sample].t;
  t1 = arc.samples[next].t <= t0 ? static_cast<double>(of.nodes.size() - 1) : arc.samples[next].t;
  double length = std::numeric_limits<double>::infinity();
  for (const Label label : {of.left, of.right}) {
    if (label != kNoLabel) {
      length = std::fmin(length,
                         (Vec3(p.x, p.y, z_of(p, label)) - Vec3(q.x, q.y, z_of(q, label))).norm());
    }
  }
  return length >= 2 * shortest && t1 - t0 > 1e-12 * (1 + t1);
}

bool ArcSamples::can_split(std::uint32_t a, std::uint32_t b, double shortest) const {
  Ref ref;
  double t0 = 0, t1 = 0;
  return find_splittable(a, b, shortest, ref, t0, t1);
}

// The place on an arc between two others at which the aim's function is zero; halfway where it has
// one sign at both.
double ArcSamples::aimed(std::uint32_t a, double t0, double t1, const Aim& aim) const {
  if (!aim.zero) return halfway(a, t0, t1);
  const auto at = [&](double t) { return aim.zero(lifted(point_at(a, t), aim.label)); };
  const bool rises = at(t1) > 0;
  if (rises == (at(t0) > 0)) return halfway(a, t0, t1);
  double lo = t0, hi = t1;
  for (double t = 0.5 * (lo + hi); t > lo && t < hi; t = 0.5 * (lo + hi))
    ((at(t) > 0) == rises ? hi : lo) = t;
  return lo > t0 ? lo : hi;
}

ArcSamples::Split ArcSamples::split(std::uint32_t a, std::uint32_t b, double shortest,
                                    const Aim& aim) {
  Split result;
  Ref ref;
  double t0 = 0, t1 = 0;
  if (!find_splittable(a, b, shortest, ref, t0, t1)) return result;
  result.arc = ref.arc;
  const double t = aimed(ref.arc, t0, t1, aim);
  const Trial trial{t, point_at(ref.arc, t)};
  const std::uint32_t sample = insert(ref.arc, ref.sample, trial);
  SampledArc& now = arcs[ref.arc];
  result.point = now.samples[sample].point;
  for (const std::uint32_t s : {ref.sample, sample}) {
    const double d = bound(ref.arc, now.samples[s], now.samples[now.samples[s].next]);
    // A part of a chord whose bound could not be shown keeps what was measured for the whole.
    now.samples[s].deviation = d < 1e300 ? d : now.samples[ref.sample].deviation;
  }
  return result;
}

// The faces beside an edge or a shadow need not swap where they have one height (a block taken away
// again down to its foot, whose foot dips into the base beside it): no corner of the arrangement is
// there, but both sides of the wall share a vertex, lest its triangles be twisted.
void ArcSamples::add_fades(std::uint32_t a, std::vector<Trial>& out) const {
  const PlanArc& arc = arrangement_.arcs[a];
  if (arc.fixed || arc.border || arc.left == kNoLabel || arc.right == kNoLabel || has_scan(a))
    return;
  const auto gap_at = [&](const ArcPoint& p) { return z_of(p, arc.left) - z_of(p, arc.right); };
  double t0 = 0;
  ArcPoint p0 = end_of(a, false);
  double gap0 = gap_at(p0);
  for (std::size_t i = 0; i <= out.size(); ++i) {
    const bool at_end = i == out.size();
    const double t1 = at_end ? static_cast<double>(arc.nodes.size() - 1) : out[i].t;
    const ArcPoint p1 = at_end ? end_of(a, true) : out[i].p;
    const double gap1 = gap_at(p1);
    if (gap0 * gap1 < 0 && std::fmin(std::fabs(gap0), std::fabs(gap1)) > options_.unseen) {
      double lo = t0, hi = t1;
      for (double mid = 0.5 * (lo + hi); mid > lo && mid < hi; mid = 0.5 * (lo + hi))
        ((gap_at(point_at(a, mid)) < 0) == (gap0 < 0) ? lo : hi) = mid;
      Trial fade{hi, point_at(a, hi)};
      if (fade.p.node == ArcPoint::kNoNode) {
        fade.p.sides[1].z = fade.p.sides[0].z;
        out.insert(out.begin() + static_cast<std::ptrdiff_t>(i++), fade);
      }
    }
    t0 = t1;
    p0 = p1;
    gap0 = gap1;
  }
}

void ArcSamples::drop(const std::vector<char>& gone) {
  largest_deviation = 0;
  for (std::uint32_t a = 0; a < arcs.size(); ++a) {
    SampledArc& arc = arcs[a];
    bool any = false;
    for (const ArcSample& s : arc.samples) any = any || gone[s.point] != 0;
    if (any) {
      // In the order of the chain; an end is never dropped.
      std::vector<ArcSample> kept;
      std::uint32_t k = 0;
      for (;;) {
        std::uint32_t next = arc.samples[k].next;
        while (next != ArcSample::kEnd && next != 0 && gone[arc.samples[next].point] != 0)
          next = arc.samples[next].next;
        ArcSample s = arc.samples[k];
        if (next != arc.samples[k].next) s.deviation = span_bound(a, k, next);
        if (arc.samples[k].next != ArcSample::kEnd)
          chords_.erase(key(s.point, arc.samples[arc.samples[k].next].point));
        kept.push_back(s);
        if (next == ArcSample::kEnd || next == 0) {
          kept.back().next = next;
          break;
        }
        kept.back().next = static_cast<std::uint32_t>(kept.size());
        k = next;
      }
      for (const ArcSample& s : arc.samples) {
        if (gone[s.point] != 0 && s.next != ArcSample::kEnd)
          chords_.erase(key(s.point, arc.samples[s.next].point));
      }
      arc.samples = std::move(kept);
      for (std::uint32_t n = 0; n < arc.samples.size(); ++n) {
        if (arc.samples[n].next != ArcSample::kEnd)
          chords_[key(arc.samples[n].point, arc.samples[arc.samples[n].next].point)] = {a, n};
      }
    }
    for (const ArcSample& s : arc.samples) {
      if (s.next != ArcSample::kEnd) largest_deviation = std::fmax(largest_deviation, s.deviation);
    }
  }
}

void ArcSamples::chain(std::uint32_t a, std::vector<std::uint32_t>& out) const {
  out.clear();
  const SampledArc& arc = arcs[a];
  std::uint32_t k = 0;
  do {
    out.push_back(arc.samples[k].point);
    k = arc.samples[k].next;
  } while (k != ArcSample::kEnd && k != 0);
  if (k == 0) out.push_back(arc.samples[0].point);
}

double ArcSamples::chord_bound(std::uint32_t a, std::uint32_t b) const {
  const auto found = chords_.find(key(a, b));
  return found == chords_.end() ? 0
                                : arcs[found->second.arc].samples[found->second.sample].deviation;
}

}  // namespace diesink
