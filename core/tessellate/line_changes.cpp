// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/line_changes.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

namespace diesink {

namespace {

constexpr double kLonger = 16;  // of the pieces of a search that was given up
// Labels within one piece that nothing tells apart but evaluation: more are noise.
constexpr int kMostBetween = 8;
// Of the size: slivers that draw_together() takes away.
constexpr double kNarrow = 1e-9;

}  // namespace

LineFinding ChangeSearch::find(const Vec2& p, const Vec2& q,
                               const std::vector<std::uint32_t>& steps) const {
  // Sides of cells smaller than the least are searched as finely as theirs.
  const double finest = 0.25 * std::fmin(limits_.least, (q - p).norm());
  const Sample from = sample(p), to = sample(q);
  for (double longer = 1;; longer *= kLonger) {
    Run run;
    run.shortest = longer * finest;
    // Lines that cross the border once each are told apart as long as ties do not make them one.
    run.shortest_regular =
        longer > 1 ? std::fmax(4 * surface_.tie, run.shortest) : 4 * surface_.tie;
    search(from, to, steps, 0, run);
    if (run.unsettled <= limits_.most) return std::move(run.found);
  }
}

void ChangeSearch::search(const Sample& p, const Sample& q, const std::vector<std::uint32_t>& steps,
                          int depth, Run& run) const {
  if (run.unsettled > limits_.most) return;  // to be searched anew
  std::vector<std::uint32_t> here = steps;
  CellVerdict verdict;
  const CellBox box = CellBox::of({p.p.x(), q.p.x(), p.p.y(), q.p.y()});
  classify(surface_, vertices_, box, here, limits_.flat, verdict);
  if (verdict.kind == CellKind::kPlain && p.state.label == q.state.label) return;
  const bool along_y = box.hy > box.hx;
  // Lists that overflowed tell nothing of what is in them.
  bool regular = !verdict.functions.full && !verdict.candidates.full;
  for (const PlanFunction& f : verdict.functions)
    regular = regular && (along_y ? f.regular_y() : f.regular_x());
  const bool single = regular && verdict.functions.count <= 1;
  const double length = 2 * std::fmax(box.hx, box.hy);
  const double least = regular ? run.shortest_regular : run.shortest;
  if (single || length <= least || depth > 60) {
    if (!single) note_unsettled(p.p, length, verdict.depth, run);
    if (p.state.label != q.state.label) add_change(p, q, 0, run.found.changes);
    return;
  }
  // p + s (q - p): the line's own coordinate stays as it is to the bit.
  const Sample mid = sample(p.p + 0.5069 * (q.p - p.p));
  search(p, mid, here, depth + 1, run);
  search(mid, q, here, depth + 1, run);
}

void ChangeSearch::note_unsettled(const Vec2& at, double length, double depth, Run& run) const {
  ++run.unsettled;
  if (!(length > limits_.wide && depth > limits_.deep)) return;
  if (run.found.unsettled_area == 0) run.found.unsettled_place = at;
  run.found.unsettled_area += 2 * length * length;
}

namespace {

// One order of curves wherever slivers are looked at from.
bool is_before(const PlanCurve& one, const PlanCurve& two) {
  const auto key = [](const PlanCurve& curve) {
    const auto of = [](const SurfaceRef& ref) { return ref.solid * 256 + ref.face; };
    const int a = of(curve.first), b = of(curve.second);
    return std::make_tuple(curve.type, std::min(a, b), std::max(a, b));
  };
  return key(one) < key(two);
}

}  // namespace

// Where nothing parts the two labels themselves, one of the curves that part them from the sliver
// between them does: the same one from both sides.
void ChangeSearch::name_by_sliver(const Sample& p, const Sample& q,
                                  CurveSolver::Change& change) const {
  const auto between = [&](const Sample& from, const Sample& to, ThirdLabel third) {
    return solver_.change_between(from.p, from.state.label, from.state.z, to.p, to.state.label,
                                  to.state.z, third);
  };
  const CurveSolver::Change sliver = between(p, q, ThirdLabel::kAny);
  if (!sliver.third) return;
  const Sample middle = sample(sliver.third_at);
  const CurveSolver::Change near = between(p, middle, ThirdLabel::kNone),
                            far = between(middle, q, ThirdLabel::kNone);
  // No vertex may be farther from the other face; nor is a sliver one that rounding makes.
  const double wide = std::hypot(far.at.x - near.at.x, far.at.y - near.at.y);
  if (!(wide > kLineSlack * surface_.tie && wide <= kNarrow * surface_.size)) return;
  const bool near_known = near.curve.type != CurveType::kUnsolved,
             far_known = far.curve.type != CurveType::kUnsolved;
  if (!near_known && !far_known) return;
  const bool takes_near = near_known && (!far_known || is_before(near.curve, far.curve));
  change.curve = (takes_near ? near : far).curve;
  change.at = (takes_near ? near : far).at;
  const auto height_of = [&](Label label, double beside) {
    double z = beside;
    const Vec3 at(change.at.x, change.at.y, change.at.z);
    if (label != kNoLabel) {
      if (std::fabs(solver_.implicit(solver_.ref_of(label)).value(at)) <= kNarrow * surface_.size)
        return change.at.z;
      solver_.height(label, at.x(), at.y(), z);
    }
    return z;
  };
  change.za = height_of(p.state.label, near.za);
  change.zb = height_of(q.state.label, far.zb);
}

void ChangeSearch::add_change(const Sample& p, const Sample& q, int depth,
                              std::vector<LineChange>& out) const {
  CurveSolver::Change change =
      solver_.change_between(p.p, p.state.label, p.state.z, q.p, q.state.label, q.state.z,
                             depth < kMostBetween ? ThirdLabel::kToldApart : ThirdLabel::kNone);
  if (change.third) {
    const Sample between = sample(change.third_at);
    std::vector<LineChange> parts;
    add_change(p, between, depth + 1, parts);
    add_change(between, q, depth + 1, parts);
    bool wide = true;
    for (std::size_t k = 1; k < parts.size(); ++k) {
      wide = wide && std::hypot(parts[k].x - parts[k - 1].x, parts[k].y - parts[k - 1].y) >
                         kNarrow * surface_.size;
    }
    if (wide) {
      std::ranges::move(parts, std::back_inserter(out));
      return;
    }
    change = solver_.change_between(p.p, p.state.label, p.state.z, q.p, q.state.label, q.state.z,
                                    ThirdLabel::kNone);
  }
  if (change.curve.type == CurveType::kUnsolved) name_by_sliver(p, q, change);
  LineChange found;
  found.x = change.at.x;
  found.y = change.at.y;
  // The line the change was looked for on keeps its own coordinate to the bit.
  if (p.p.x() == q.p.x()) {
    found.x = p.p.x();
    found.y = std::clamp(found.y, p.p.y(), q.p.y());
  } else {
    found.y = p.p.y();
    found.x = std::clamp(found.x, p.p.x(), q.p.x());
  }
  found.low = p.state.label;
  found.high = q.state.label;
  found.curve = change.curve;
  if (found.low != kNoLabel) found.heights.push_back({found.low, change.za});
  if (found.high != kNoLabel) found.heights.push_back({found.high, change.zb});
  out.push_back(std::move(found));
}

}  // namespace diesink
