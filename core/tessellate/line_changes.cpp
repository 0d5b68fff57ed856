// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/line_changes.h"

#include <algorithm>
#include <cmath>

namespace diesink {

void ChangeSearch::find(const Vec2& p, const Vec2& q, const std::vector<std::uint32_t>& steps,
                        std::vector<LineChange>& out) const {
  // Sides of cells smaller than the least are searched as finely as theirs.
  search(sample(p), sample(q), steps, 0, 0.25 * std::fmin(least_, (q - p).norm()), out);
}

void ChangeSearch::search(const Sample& p, const Sample& q, const std::vector<std::uint32_t>& steps,
                          int depth, double shortest, std::vector<LineChange>& out) const {
  std::vector<std::uint32_t> here = steps;
  CellVerdict verdict;
  const CellBox box = CellBox::of({p.p.x(), q.p.x(), p.p.y(), q.p.y()});
  classify(surface_, vertices_, box, here, flat_, verdict);
  if (verdict.kind == CellKind::kPlain && p.state.label == q.state.label) return;
  const bool along_y = box.hy > box.hx;
  bool regular = !verdict.functions.full;
  for (const PlanFunction& f : verdict.functions)
    regular = regular && (along_y ? f.regular_y() : f.regular_x());
  const bool single = regular && verdict.functions.count <= 1;
  const double length = 2 * std::fmax(box.hx, box.hy);
  // Lines that cross the border once each are told apart as long as ties do not make them one.
  const double least = regular ? 4 * surface_.tie : shortest;
  if (single || length <= least || depth > 60) {
    if (p.state.label != q.state.label) add_change(p, q, out);
    return;
  }
  // p + s (q - p): the line's own coordinate stays as it is to the bit.
  const Sample mid = sample(p.p + 0.5069 * (q.p - p.p));
  search(p, mid, here, depth + 1, shortest, out);
  search(mid, q, here, depth + 1, shortest, out);
}

void ChangeSearch::add_change(const Sample& p, const Sample& q,
                              std::vector<LineChange>& out) const {
  const CurveSolver::Change change =
      solver_.change_between(p.p, p.state.label, p.state.z, q.p, q.state.label, q.state.z);
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
