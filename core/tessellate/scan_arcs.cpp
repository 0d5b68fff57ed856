// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/scan_arcs.h"

#include <unordered_map>

#include "core/pair_key.h"
#include "core/tessellate/scan_arc_cutter.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;
constexpr std::uint32_t kNone = ScanSheet::kNone;

}  // namespace

ScanPlace ArcCutter::place_in(std::uint32_t t, const Vec2& p) const {
  ScanPlace where{ScanPlace::Kind::kTriangle, t};
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t v = sheet_.triangles[t][k];
    if ((point(v) - p).norm() <= near_) return {ScanPlace::Kind::kVertex, v};
  }
  double best = near_;
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t h = 3 * t + k;
    const Vec2 a = point(sheet_.from(h)), d = point(sheet_.to(h)) - a;
    const double length = d.norm();
    const double off = std::fabs(d.x() * (p.y() - a.y()) - d.y() * (p.x() - a.x())) / length;
    if (off <= best) {
      best = off;
      where = {ScanPlace::Kind::kEdge, canonical(h)};
    }
  }
  return where;
}

ScanPlace ArcCutter::locate(const Vec2& p) const {
  BaseHit hit;
  if (scan_.at(p.x(), p.y(), hit)) return place_in(hit.face, p);
  return {};
}

const ScanPlace& ArcCutter::place(std::uint32_t n) {
  ScanPlace& where = out_.place[n];
  if (where.kind == ScanPlace::Kind::kUnknown) {
    where = locate(at(n));
    if (where.kind == ScanPlace::Kind::kUnknown) snap_to_border(n);
    settle(n);
  }
  return out_.place[n];
}

// A node at a vertex or on an edge of the sheet is there to the digit, in height too.
void ArcCutter::settle(std::uint32_t n) {
  const ScanPlace& where = out_.place[n];
  PlanNode& p = node(n);
  double z = 0;
  if (where.kind == ScanPlace::Kind::kVertex) {
    const Vec3& v = sheet_.points[where.id];
    // Border nodes keep the border's coordinate: a cut vertex has the same, one of the scan's own
    // may lie a hair inside.
    const PlanBox& box = arrangement_.box;
    if (!p.border || (p.x != box.x0 && p.x != box.x1)) p.x = v.x();
    if (!p.border || (p.y != box.y0 && p.y != box.y1)) p.y = v.y();
    z = v.z();
    if (out_.node_at[where.id] == kNone) out_.node_at[where.id] = n;
  } else if (where.kind == ScanPlace::Kind::kEdge) {
    const Vec3 &a = sheet_.points[sheet_.from(where.id)], &b = sheet_.points[sheet_.to(where.id)];
    const Vec2 d = (b - a).head<2>();
    const double s = std::clamp(d.dot(at(n) - a.head<2>()) / d.squaredNorm(), 0.0, 1.0);
    z = a.z() + s * (b.z() - a.z());
  } else {
    return;
  }
  p.kept = true;
  if (p.seam && where.kind == ScanPlace::Kind::kEdge) return;  // the seam has said how high
  double before = z;
  bool known = false;
  for (const LabelHeight& h : p.heights) {
    if (is_base(surface_, h.label)) {
      before = h.z;
      known = true;
    }
  }
  if (!known) return;
  for (LabelHeight& h : p.heights) {
    if (h.z == before) h.z = z;
  }
}

void ArcCutter::triangles_at(const ScanPlace& place, std::vector<std::uint32_t>& out) const {
  out.clear();
  switch (place.kind) {
    case ScanPlace::Kind::kUnknown:
      break;
    case ScanPlace::Kind::kTriangle:
      out.push_back(place.id);
      break;
    case ScanPlace::Kind::kEdge:
      out.push_back(place.id / 3);
      if (sheet_.twin[place.id] != kNone) out.push_back(sheet_.twin[place.id] / 3);
      break;
    case ScanPlace::Kind::kVertex:
      for (std::uint32_t k = begins_[place.id]; k < begins_[place.id + 1]; ++k)
        out.push_back(around_[k] / 3);
      break;
  }
}

std::uint32_t ArcCutter::add_node(PlanNode made, const ScanPlace& where) {
  // One node a vertex, whichever arc comes there.
  if (where.kind == ScanPlace::Kind::kVertex && out_.node_at[where.id] != kNone) {
    const std::uint32_t known = out_.node_at[where.id];
    for (const LabelHeight& h : made.heights) {
      if (std::isnan(height_in(known, h.label, std::numeric_limits<double>::quiet_NaN())))
        node(known).heights.push_back(h);
    }
    return known;
  }
  const auto n = static_cast<std::uint32_t>(arrangement_.nodes.size());
  arrangement_.nodes.push_back(std::move(made));
  out_.place.push_back(where);
  settle(n);
  return n;
}

// Arcs no longer than a few least cells are not there: their ends are one corner, and what they go
// round is nothing.
void ArcCutter::drop_specks() {
  const double small = 16 * least_;
  const auto is_speck = [&](const PlanArc& arc) {
    if (arc.border) return false;
    double reach = 0;
    for (const std::uint32_t n : arc.nodes)
      reach = std::fmax(reach, (at(n) - at(arc.nodes[0])).norm());
    const bool ring = (at(arc.nodes.back()) - at(arc.nodes.front())).norm() <= near_;
    return reach <= (ring ? 4 : 1) * small;
  };
  std::vector<char> speck(arrangement_.arcs.size(), 0);
  std::vector<std::uint32_t> one(arrangement_.nodes.size());
  for (std::uint32_t n = 0; n < one.size(); ++n) one[n] = n;
  const auto find = [&](std::uint32_t n) {
    while (one[n] != n) n = one[n];
    return n;
  };
  for (std::size_t k = 0; k < speck.size(); ++k) {
    const PlanArc& arc = arrangement_.arcs[k];
    if (!is_speck(arc)) continue;
    std::uint32_t a = find(arc.nodes.front()), b = find(arc.nodes.back());
    // The domain's border keeps its own nodes.
    if (node(a).border && node(b).border && a != b) continue;
    speck[k] = 1;
    if (a == b) continue;
    if (node(b).border || (node(b).solved && !node(a).solved && !node(a).border)) std::swap(a, b);
    one[b] = a;
    for (const LabelHeight& h : node(b).heights) {
      if (std::isnan(height_in(a, h.label, std::numeric_limits<double>::quiet_NaN())))
        node(a).heights.push_back(h);
    }
    node(a).corner = true;
  }
  for (std::size_t k = 0; k < speck.size(); ++k) {
    PlanArc& arc = arrangement_.arcs[k];
    if (speck[k] != 0) arc.left = arc.right = kNoLabel;
    for (std::uint32_t& n : arc.nodes) n = find(n);
  }
  for (PlanRegion& region : arrangement_.regions) {
    for (std::vector<ArcUse>& loop : region.loops)
      std::erase_if(loop, [&](const ArcUse& use) { return speck[use.arc] != 0; });
    if (!region.loops.empty() && region.loops[0].empty()) region.label = kNoLabel;
    std::erase_if(region.loops, [](const std::vector<ArcUse>& loop) { return loop.empty(); });
  }
}

void ArcCutter::cut(PlanArc& arc) {
  base_ = base_label(arc);
  left_ = arc.left;
  right_ = arc.border ? kNoLabel : arc.right;
  base_left_ = base_ == arc.left;
  if (base_ == kNoLabel) {
    // The base is under one side all the same: a border half-edge has it on its left.
    double ahead = 0;
    for (std::size_t k = 0; k < arc.curves.size(); ++k) {
      if (arc.curves[k].type != CurveType::kOutline) continue;
      const Vec2 d = at(arc.nodes[k + 1]) - at(arc.nodes[k]);
      for (const std::uint32_t n : {arc.nodes[k], arc.nodes[k + 1]}) {
        const ScanPlace& where = place(n);
        if (where.kind == ScanPlace::Kind::kEdge && sheet_.twin[where.id] == kNone)
          ahead += d.dot((point(sheet_.to(where.id)) - point(sheet_.from(where.id))).normalized());
      }
    }
    base_left_ = ahead >= 0;
  }
  // Ends are told to the least cell at first and better later: nodes as close to them go.
  std::vector<std::uint32_t> nodes{arc.nodes[0]};
  std::vector<PlanCurve> curves;
  for (std::size_t k = 1; k < arc.nodes.size(); ++k) {
    const Vec2 p = at(arc.nodes[k]);
    const bool close = (p - at(arc.nodes.front())).norm() <= 8 * least_ ||
                       (p - at(arc.nodes.back())).norm() <= 8 * least_;
    if (k + 1 < arc.nodes.size() && close && !arc.border) continue;
    nodes.push_back(arc.nodes[k]);
    curves.push_back(arc.curves[k - 1]);
  }
  nodes_ = {nodes[0]};
  curves_.clear();
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (base_ != kNoLabel || curves[std::min(k, curves.size() - 1)].type == CurveType::kOutline)
      place(nodes[k]);
  }
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    const std::uint32_t from = nodes_.back();
    if (curves[k].type == CurveType::kOutline) {
      follow_border(from, nodes[k + 1], curves[k]);
    } else if (base_ == kNoLabel) {
      emit(nodes[k + 1], curves[k], kNone);
    } else {
      trace_steps_ = 0;
      trace(from, nodes[k + 1], curves[k], 0);
    }
    // Nothing between two nodes at one place: the arc goes on from the second.
    if (nodes_.back() != nodes[k + 1]) {
      nodes_.push_back(nodes[k + 1]);
      curves_.push_back(curves[k]);
    }
  }
  // Inner nodes at the place of the one before them, or of the arc's end, say nothing.
  // (Told apart to what decides that a point lies on an edge; the domain's border keeps its own,
  // which are the neighbouring tile's, too.)
  const double apart = arc.border ? 0 : near_;
  const auto same_place = [&](std::uint32_t i, std::uint32_t j) {
    return (at(i) - at(j)).norm() <= apart;
  };
  arc.nodes = {nodes_[0]};
  arc.curves.clear();
  for (std::size_t k = 1; k < nodes_.size(); ++k) {
    const bool last = k + 1 == nodes_.size();
    if (!last && (same_place(nodes_[k], arc.nodes.back()) || same_place(nodes_[k], nodes_.back())))
      continue;
    arc.nodes.push_back(nodes_[k]);
    arc.curves.push_back(curves_[k - 1]);
  }
  if (arc.nodes.size() == 1) {  // shrunk to a point: from it to itself, so that it has a curve
    arc.nodes.push_back(arc.nodes[0]);
    arc.curves.push_back(curves.back());
  }
  leave_once_round(arc);
}

// Round a hole of a few least cells every stretch may have gone once round: an arc that comes to an
// edge of the sheet's border again goes on as after the first time.
void ArcCutter::leave_once_round(PlanArc& arc) const {
  std::unordered_map<std::uint64_t, std::size_t> first;  // by the edge's ends: the node before it
  std::vector<std::pair<std::size_t, std::uint64_t>> edges;  // those kept: that node, and the ends
  std::vector<std::uint32_t> nodes;
  std::vector<PlanCurve> curves;
  std::size_t before = kNone;  // the last node at a vertex, but for other curves since
  for (std::size_t k = 0; k < arc.nodes.size(); ++k) {
    const std::uint32_t n = arc.nodes[k];
    if (k > 0 && arc.curves[k - 1].type != CurveType::kOutline) {
      first.clear();
      edges.clear();
      before = kNone;
    }
    const bool at_vertex = out_.place[n].kind == ScanPlace::Kind::kVertex;
    if (at_vertex && before != kNone) {
      const std::uint64_t edge = pair_key(out_.place[nodes[before]].id, out_.place[n].id);
      const auto known = first.find(edge);
      if (known != first.end()) {
        before = known->second;
        nodes.resize(before + 1);
        curves.resize(before);
        while (!edges.empty() && edges.back().first > before) {
          first.erase(edges.back().second);
          edges.pop_back();
        }
      } else {
        first.emplace(edge, before);
        edges.emplace_back(before, edge);
      }
    }
    if (!nodes.empty()) curves.push_back(arc.curves[k - 1]);
    nodes.push_back(n);
    if (at_vertex) before = nodes.size() - 1;
  }
  arc.nodes = std::move(nodes);
  arc.curves = std::move(curves);
}

bool is_base(const Impl& surface, Label label) {
  return label != kNoLabel &&
         surface.steps[surface.step_of_row[static_cast<std::size_t>(row_of(label))]].solid < 0;
}

ScanArcs cut_arcs(const Impl& surface, const ScanSheet& sheet, double least,
                  Arrangement& arrangement) {
  return ArcCutter(surface, sheet, least, arrangement).run();
}

}  // namespace diesink
