// Arcs at the border of the sheet.
// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <unordered_map>

#include "core/base/exact_plan.h"
#include "core/tessellate/scan_arc_cutter.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;

}  // namespace

// The nearest point of the sheet's border, for a node found by halving beside it.
void ArcCutter::snap_to_border(std::uint32_t n) {
  const Vec2 p = at(n);
  std::vector<std::uint32_t> edges;
  const auto& border = scan_.border_edges();
  double best = std::numeric_limits<double>::infinity();
  std::uint32_t u = kNone, w = kNone;
  double s_best = 0;
  if (out_.place[n].kind != ScanPlace::Kind::kUnknown) return;
  for (const double reach : {4 * least_, 64 * least_}) {
    if (u != kNone) break;
    scan_.border_over({p.x() - reach, p.x() + reach, p.y() - reach, p.y() + reach}, 4096, edges);
    for (const std::uint32_t e : edges) {
      const Vec2 a = point(border[e][0]), d = point(border[e][1]) - a;
      const double s = std::clamp(d.dot(p - a) / d.squaredNorm(), 0.0, 1.0);
      const double off = (a + s * d - p).norm();
      if (off < best) {
        best = off;
        u = border[e][0];
        w = border[e][1];
        s_best = s;
      }
    }
  }
  if (u == kNone) return;
  const Vec2 a = point(u), d = point(w) - a;
  const double length = d.norm();
  ScanPlace& where = out_.place[n];
  if (s_best * length <= 2 * least_ || (1 - s_best) * length <= 2 * least_) {
    where = {ScanPlace::Kind::kVertex, s_best < 0.5 ? u : w};
  } else {
    for (std::uint32_t k = begins_[u]; k < begins_[u + 1]; ++k) {
      for (const std::uint32_t h : {around_[k], ScanSheet::previous(around_[k])}) {
        const bool same = (sheet_.from(h) == u && sheet_.to(h) == w) ||
                          (sheet_.from(h) == w && sheet_.to(h) == u);
        if (same) where = {ScanPlace::Kind::kEdge, canonical(h)};
      }
    }
    const Vec2 q = a + s_best * d;
    if (!node(n).border) {
      node(n).x = q.x();
      node(n).y = q.y();
    }
  }
  double base_z = std::numeric_limits<double>::quiet_NaN();
  for (const LabelHeight& h : node(n).heights) {
    if (is_base(surface_, h.label)) base_z = h.z;
  }
  settle(n);
  if (node(n).seam) return;
  // What is beside or over the base there is at its own height over the new place.
  for (LabelHeight& h : node(n).heights) {
    double z = 0;
    if (!is_base(surface_, h.label) && h.z != base_z &&
        solver_.height(h.label, node(n).x, node(n).y, z))
      h.z = z;
  }
}

// Along the sheet's own border, vertex by vertex.
void ArcCutter::follow_border(std::uint32_t a, std::uint32_t b, const PlanCurve& curve) {
  const auto next_border = [&](std::uint32_t h) {  // the border goes on after h's end
    h = ScanSheet::next(h);
    while (sheet_.twin[h] != kNone) h = ScanSheet::next(sheet_.twin[h]);
    return h;
  };
  const auto previous_border = [&](std::uint32_t h) {
    h = ScanSheet::previous(h);
    while (sheet_.twin[h] != kNone) h = ScanSheet::previous(sheet_.twin[h]);
    return h;
  };
  // The border's half-edges at a node: which it lies on, going the arc's way.
  const auto edges_at = [&](std::uint32_t n, bool leaving) {
    std::vector<std::uint32_t> found;
    const ScanPlace& where = place(n);
    if (where.kind == ScanPlace::Kind::kEdge && sheet_.twin[where.id] == kNone)
      found.push_back(where.id);
    if (where.kind == ScanPlace::Kind::kVertex) {
      for (std::uint32_t k = begins_[where.id]; k < begins_[where.id + 1]; ++k) {
        const std::uint32_t h =
            leaving == base_left_ ? around_[k] : ScanSheet::previous(around_[k]);
        if (sheet_.twin[h] == kNone) found.push_back(h);
      }
    }
    return found;
  };
  const std::vector<std::uint32_t> starts = edges_at(a, true), ends = edges_at(b, false);
  // A way much longer than the stretch is the way round: the ends were only told to the least cell.
  const double straight = (at(b) - at(a)).norm();
  const double longest = a != b ? 64 * (straight + 16 * least_) : HUGE_VAL;
  const std::size_t limit = scan_.border_edges().size() + 2;
  std::vector<std::uint32_t> way, shortest;
  bool found = false;
  for (const std::uint32_t start : starts) {
    way = {start};
    double length = 0;  // as far as the end of the last edge but one
    Vec2 last = at(a);
    while (way.size() < limit && length <= longest) {
      const std::uint32_t h = way.back();
      if (std::find(ends.begin(), ends.end(), h) != ends.end()) {
        bool ahead = true;  // on the start's own edge b may lie behind a: once round then
        if (way.size() == 1) {
          const Vec2 d = point(sheet_.to(h)) - point(sheet_.from(h));
          ahead = (d.dot(at(b) - at(a)) >= 0) == base_left_;
        }
        if (ahead && length + (at(b) - last).norm() <= longest) {
          if (!found || way.size() < shortest.size()) shortest = way;
          found = true;
          break;
        }
      }
      const Vec2 next = point(base_left_ ? sheet_.to(h) : sheet_.from(h));
      length += (next - last).norm();
      last = next;
      way.push_back(base_left_ ? next_border(h) : previous_border(h));
    }
  }
  if (!found) {
    if (straight <= 16 * least_) {
      std::vector<std::uint32_t> t;
      triangles_at(place(a), t);
      emit(b, curve, t.empty() ? kNone : t[0]);
    } else if (base_ == kNoLabel) {
      emit(b, curve, kNone);
      // (What parts nothing from nothing is in no way off.)
      if (left_ != kNoLabel || right_ != kNoLabel) out_.unsolved_length += straight;
    } else {
      trace_steps_ = 0;
      trace(a, b, curve, 0);
    }
    return;
  }
  for (std::size_t k = 0; k < shortest.size(); ++k) {
    const std::uint32_t h = shortest[k];
    out_.touched[h / 3] = 1;
    if (k + 1 == shortest.size()) {
      emit(b, curve, h / 3);
      break;
    }
    const std::uint32_t v = base_left_ ? sheet_.to(h) : sheet_.from(h);
    PlanNode n;
    n.x = sheet_.points[v].x();
    n.y = sheet_.points[v].y();
    set_heights(n, curve, sheet_.points[v].z(), sheet_.points[v].z());
    emit(add_node(std::move(n), {ScanPlace::Kind::kVertex, v}), curve, h / 3);
  }
}

bool ArcCutter::is_near_border(const Vec2& p) const {
  const double reach = 4 * least_;
  std::vector<std::uint32_t> edges;
  scan_.border_over({p.x() - reach, p.x() + reach, p.y() - reach, p.y() + reach}, 1, edges);
  return !edges.empty();
}

// Where the end of the base parts two labels that are not its own it is known by its place alone.
void ArcCutter::name_outlines() {
  for (PlanArc& arc : arrangement_.arcs) {
    if (arc.border || (arc.left == kNoLabel && arc.right == kNoLabel)) continue;
    for (std::size_t k = 0; k < arc.curves.size(); ++k) {
      PlanCurve& curve = arc.curves[k];
      if (curve.type != CurveType::kUnsolved || !is_near_border(at(arc.nodes[k])) ||
          !is_near_border(at(arc.nodes[k + 1])))
        continue;
      curve.type = CurveType::kOutline;
      curve.first = {SurfaceRef::kBase, 0};
      curve.second = {SurfaceRef::kOutline, 0};
    }
  }
}

// Where another curve ends on the border of the base: its point on the border's own edge.
void ArcCutter::solve_border_corners() {
  for (const PlanArc& arc : arrangement_.arcs) {
    if (arc.border || arc.closed) continue;
    for (const bool last : {false, true}) {
      const std::uint32_t n = last ? arc.nodes.back() : arc.nodes.front();
      const PlanCurve& curve = last ? arc.curves.back() : arc.curves.front();
      if (curve.type != CurveType::kMeet && curve.type != CurveType::kShadow) continue;
      const ScanPlace where = out_.place[n];
      if (node(n).seam || where.kind != ScanPlace::Kind::kEdge || sheet_.twin[where.id] != kNone)
        continue;
      const Vec3 &u = sheet_.points[sheet_.from(where.id)], &v = sheet_.points[sheet_.to(where.id)];
      const Vec2 p = u.head<2>(), d = (v - u).head<2>();
      const double before = d.dot(at(n) - p) / d.squaredNorm();
      double t = before, z = u.z() + t * (v.z() - u.z());
      if (curve.type == CurveType::kShadow) z = solver_.shadow_height(curve, at(n).x(), at(n).y());
      if (!solver_.on_line(on_triangle(curve, where.id / 3), p, d, t, z)) continue;
      if (!(t >= 0 && t <= 1) || std::fabs(t - before) * d.norm() > 64 * least_) continue;
      PlanNode& node_here = node(n);
      node_here.x = p.x() + t * d.x();
      node_here.y = p.y() + t * d.y();
      node_here.solved = true;
      for (LabelHeight& h : node_here.heights) {
        if (is_base(surface_, h.label)) {
          h.z = u.z() + t * (v.z() - u.z());
        } else if (curve.is_height_of(solver_.ref_of(h.label))) {
          h.z = z;
        } else {
          solver_.height(h.label, node_here.x, node_here.y, h.z);
        }
      }
      for (LabelHeight& h : node_here.heights) {  // walls too low to be one
        for (const LabelHeight& g : node_here.heights) {
          if (std::fabs(h.z - g.z) <= 1e-9 * surface_.size) h.z = g.z;
        }
      }
    }
  }
}

// Nodes at one vertex of the sheet are one node.
void ArcCutter::join_at_vertices() {
  for (PlanArc& arc : arrangement_.arcs) {
    for (std::uint32_t& n : arc.nodes) {
      if (out_.place[n].kind != ScanPlace::Kind::kVertex) continue;
      const std::uint32_t kept = out_.node_at[out_.place[n].id];
      if (kept == n) continue;
      for (const LabelHeight& h : node(n).heights) {
        if (std::isnan(height_in(kept, h.label, std::numeric_limits<double>::quiet_NaN())))
          node(kept).heights.push_back(h);
      }
      node(kept).corner = node(kept).corner || node(n).corner;
      n = kept;
    }
  }
}

// Where the rim of a hole touches another or the border of the domain in a vertex of the sheet, the
// arrangement has seen no junction. All arcs end there, so that what goes apart at it is told. (Not
// on cuts between tiles: the tile beyond closes the way round.)
void ArcCutter::part_at_shared_nodes() {
  std::vector<char> used(arrangement_.arcs.size(), 0);
  for (const PlanRegion& region : arrangement_.regions) {
    for (const std::vector<ArcUse>& loop : region.loops) {
      for (const ArcUse& use : loop) used[use.arc] = 1;
    }
  }
  std::vector<std::uint32_t> passes(arrangement_.nodes.size(), 0);
  for (std::size_t a = 0; a < used.size(); ++a) {
    const PlanArc& arc = arrangement_.arcs[a];
    for (std::size_t k = arc.closed ? 1 : 0; used[a] && k < arc.nodes.size(); ++k)
      ++passes[arc.nodes[k]];
  }
  for (std::size_t n = 0; n < passes.size(); ++n) {
    if (arrangement_.nodes[n].seam) passes[n] = 0;
  }
  std::vector<char> shared(passes.size(), 0);
  std::vector<std::vector<std::uint32_t>> pieces(used.size());
  bool any = false;
  for (std::uint32_t a = 0; a < used.size(); ++a) {
    if (!used[a]) continue;
    const PlanArc& arc = arrangement_.arcs[a];
    bool through = arc.closed && passes[arc.nodes[0]] > 1;
    if (through) shared[arc.nodes[0]] = 1;
    for (std::size_t k = 1; k + 1 < arc.nodes.size(); ++k) {
      if (passes[arc.nodes[k]] <= 1) continue;
      shared[arc.nodes[k]] = 1;
      through = true;
    }
    any = any || through;
    if (through) part_arc(a, passes, pieces[a]);
  }
  if (!any) return;
  for (PlanRegion& region : arrangement_.regions) {
    for (std::vector<ArcUse>& loop : region.loops) {
      std::vector<ArcUse> parted;
      for (const ArcUse& use : loop) {
        if (pieces[use.arc].empty()) {
          parted.push_back(use);
          continue;
        }
        const std::size_t n = pieces[use.arc].size();
        for (std::size_t k = 0; k < n; ++k)
          parted.push_back({pieces[use.arc][use.forward ? k : n - 1 - k], use.forward});
      }
      loop = std::move(parted);
    }
    if (region.label == kNoLabel || is_base(surface_, region.label)) turn_at(shared, region);
  }
}

// Ends an arc at every node that is passed more than once; its pieces in their order.
void ArcCutter::part_arc(std::uint32_t a, const std::vector<std::uint32_t>& passes,
                         std::vector<std::uint32_t>& pieces) {
  PlanArc whole = arrangement_.arcs[a];
  if (whole.closed) {
    // A ring begins at the first of them.
    std::size_t first = 0;
    while (passes[whole.nodes[first]] <= 1) ++first;
    const auto at_first = static_cast<std::ptrdiff_t>(first);
    whole.nodes.pop_back();
    std::rotate(whole.nodes.begin(), whole.nodes.begin() + at_first, whole.nodes.end());
    std::rotate(whole.curves.begin(), whole.curves.begin() + at_first, whole.curves.end());
    whole.nodes.push_back(whole.nodes.front());
    whole.closed = false;
  }
  std::size_t from = 0;
  PlanArc bare = whole;  // what all pieces have
  bare.nodes.clear();
  bare.curves.clear();
  for (std::size_t k = 1; k < whole.nodes.size(); ++k) {
    if (k + 1 < whole.nodes.size() && passes[whole.nodes[k]] <= 1) continue;
    PlanArc piece = bare;
    const auto begin = static_cast<std::ptrdiff_t>(from), end = static_cast<std::ptrdiff_t>(k);
    piece.nodes.assign(whole.nodes.begin() + begin, whole.nodes.begin() + end + 1);
    piece.curves.assign(whole.curves.begin() + begin, whole.curves.begin() + end);
    node(whole.nodes[from]).corner = node(whole.nodes[k]).corner = true;
    if (pieces.empty()) {
      pieces.push_back(a);
      arrangement_.arcs[a] = std::move(piece);
    } else {
      pieces.push_back(static_cast<std::uint32_t>(arrangement_.arcs.size()));
      arrangement_.arcs.push_back(std::move(piece));
    }
    from = k;
  }
}

// The region's loops turn at shared nodes into the next arc clockwise, so that what they leave to
// their left there is one sector.
void ArcCutter::turn_at(const std::vector<char>& shared, PlanRegion& region) const {
  std::vector<ArcUse> uses;
  std::vector<std::uint32_t> next;
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> leaving;  // of shared nodes
  const auto arc_of = [&](std::uint32_t u) -> const PlanArc& {
    return arrangement_.arcs[uses[u].arc];
  };
  const auto start = [&](std::uint32_t u) {
    return uses[u].forward ? arc_of(u).nodes.front() : arc_of(u).nodes.back();
  };
  const auto end = [&](std::uint32_t u) {
    return uses[u].forward ? arc_of(u).nodes.back() : arc_of(u).nodes.front();
  };
  for (const std::vector<ArcUse>& loop : region.loops) {
    const auto first = static_cast<std::uint32_t>(uses.size());
    for (const ArcUse& use : loop) {
      uses.push_back(use);
      next.push_back(static_cast<std::uint32_t>(uses.size()));
    }
    if (!loop.empty()) next.back() = first;
  }
  bool turns = false;
  for (std::uint32_t u = 0; u < uses.size(); ++u) {
    if (!shared[start(u)]) continue;
    std::vector<std::uint32_t>& here = leaving[start(u)];
    here.push_back(u);
    turns = turns || here.size() > 1;
  }
  if (!turns) return;
  for (std::uint32_t u = 0; u < uses.size(); ++u) {
    const std::uint32_t n = end(u);
    const auto found = leaving.find(n);
    if (found == leaving.end() || found->second.size() < 2) continue;
    const std::vector<std::uint32_t>& nodes = arc_of(u).nodes;
    const Vec2 back = at(uses[u].forward ? nodes[nodes.size() - 2] : nodes[1]);
    std::optional<Vec2> nearest;
    for (const std::uint32_t w : found->second) {
      const std::vector<std::uint32_t>& of = arc_of(w).nodes;
      const Vec2 ahead = at(uses[w].forward ? of[1] : of[of.size() - 2]);
      if (nearest && !clockwise_before({at(n).x(), at(n).y()}, {back.x(), back.y()},
                                       {ahead.x(), ahead.y()}, {nearest->x(), nearest->y()}))
        continue;
      nearest = ahead;
      next[u] = w;
    }
  }
  std::vector<char> walked(uses.size(), 0);
  region.loops.clear();
  for (std::uint32_t u = 0; u < uses.size(); ++u) {
    if (walked[u]) continue;
    std::vector<ArcUse>& loop = region.loops.emplace_back();
    for (std::uint32_t w = u; !walked[w]; w = next[w]) {
      walked[w] = 1;
      loop.push_back(uses[w]);
    }
  }
}

}  // namespace diesink
