// Straight chords over a sheet: which of its vertices, edges and triangles their nodes lie on.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/tessellate/scan_arcs.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;

double distance_to(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double s = std::clamp(d.dot(p - a) / d.squaredNorm(), 0.0, 1.0);
  return (a + s * d - p).norm();
}

class ChordPlacer {
 public:
  ChordPlacer(const CompoundSurface::Impl& surface, const ScanSheet& sheet, double reach,
              const Arrangement& chords)
      : scan_(std::get<ScannedSurface>(surface.base)),
        sheet_(sheet),
        chords_(chords),
        reach_(reach) {}

  void place(ScanArcs& out, const std::vector<std::uint32_t>& nodes) {
    // A vertex is one node's: the nearest.
    for (const std::uint32_t n : nodes) {
      const std::uint32_t v = nearest_vertex(n);
      if (v == kNone) continue;
      std::uint32_t& at = out.node_at[v];
      if (at == kNone || distance(n, v) < distance(at, v)) at = n;
    }
    for (const std::uint32_t n : nodes) {
      const Vec2 p = plan(n);
      const std::uint32_t v = nearest_vertex(n);
      if (v != kNone && out.node_at[v] == n) out.place[n] = {ScanPlace::Kind::kVertex, v};
      double best = reach_;
      for (const std::uint32_t t : faces_) {
        bool within = true;
        double off = HUGE_VAL;
        for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
          const Vec2 a = point(sheet_.from(h)), b = point(sheet_.to(h)), d = b - a;
          within = within && d.x() * (p.y() - a.y()) - d.y() * (p.x() - a.x()) >= 0;
          const double beside = distance_to(p, a, b);
          off = std::fmin(off, beside);
          if (out.place[n].kind == ScanPlace::Kind::kVertex || !(beside <= best)) continue;
          best = beside;
          out.place[n] = {ScanPlace::Kind::kEdge, std::min(h, sheet_.twin[h])};
        }
        if (!within && off > reach_) continue;
        out.touched[t] = 1;
        if (within && out.place[n].kind == ScanPlace::Kind::kUnknown)
          out.place[n] = {ScanPlace::Kind::kTriangle, t};
      }
    }
  }

 private:
  [[nodiscard]] Vec2 plan(std::uint32_t n) const {
    return {chords_.nodes[n].x, chords_.nodes[n].y};
  }
  [[nodiscard]] Vec2 point(std::uint32_t v) const { return sheet_.points[v].head<2>(); }
  [[nodiscard]] double distance(std::uint32_t n, std::uint32_t v) const {
    return (plan(n) - point(v)).norm();
  }
  // Leaves the triangles about the node in faces_.
  std::uint32_t nearest_vertex(std::uint32_t n) {
    const Vec2 p = plan(n);
    scan_.faces_over({p.x() - reach_, p.x() + reach_, p.y() - reach_, p.y() + reach_}, faces_);
    std::uint32_t nearest = kNone;
    double best = reach_;
    for (const std::uint32_t t : faces_) {
      for (const std::uint32_t v : sheet_.triangles[t]) {
        if (!(distance(n, v) <= best)) continue;
        best = distance(n, v);
        nearest = v;
      }
    }
    return nearest;
  }

  const ScannedSurface& scan_;
  const ScanSheet& sheet_;
  const Arrangement& chords_;
  double reach_;
  std::vector<std::uint32_t> faces_;
};

}  // namespace

ScanArcs place_chords(const CompoundSurface::Impl& surface, const ScanSheet& sheet,
                      const ScanArcs& cut, double reach, const Arrangement& chords) {
  ScanArcs out;
  out.touched = cut.touched;
  out.unsolved_length = cut.unsolved_length;
  out.node_at.assign(sheet.points.size(), kNone);
  out.place.resize(chords.nodes.size());
  std::vector<std::uint32_t> nodes;
  for (const PlanArc& arc : chords.arcs) {
    const bool beside = is_base(surface, arc.left) || (!arc.border && is_base(surface, arc.right));
    if (beside) nodes.insert(nodes.end(), arc.nodes.begin(), arc.nodes.end());
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  ChordPlacer(surface, sheet, reach, chords).place(out, nodes);
  return out;
}

}  // namespace diesink
