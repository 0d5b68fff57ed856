// Enclosures of the base over plan boxes: Ferguson patches by bounds of their derivatives, scans by
// the planes of their facets; and the functions of its border.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/tessellate/cell_bounds.h"

namespace diesink {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

// The border of a scan in the box: one function for edges that follow one another, whose direction
// is somewhere among theirs.
void scan_outline(const ScannedSurface& scan, const CellBox& box, FunctionList& outline) {
  constexpr std::size_t kMost = 24;
  std::vector<std::uint32_t> edges;
  scan.border_over({box.x - box.hx, box.x + box.hx, box.y - box.hy, box.y + box.hy}, kMost, edges);
  const std::vector<ScannedSurface::BorderEdge>& border = scan.border_edges();
  std::vector<PlanFunction> runs;
  std::vector<std::vector<std::uint32_t>> ends;  // vertices of each run's edges
  for (const std::uint32_t e : edges) {
    const Vec3 &a = scan.positions()[border[e][0]], &b = scan.positions()[border[e][1]];
    const double length = std::hypot(b.x() - a.x(), b.y() - a.y());
    PlanFunction f;
    f.kind = PlanFunction::Kind::kOutline;
    f.id = e;
    f.cgx = length > 0 ? -(b.y() - a.y()) / length : 0;
    f.cgy = length > 0 ? (b.x() - a.x()) / length : 0;
    const double turned = 0x1p-50;
    f.gx = {f.cgx - turned, f.cgx + turned};
    f.gy = {f.cgy - turned, f.cgy + turned};
    f.v = f.cgx * (box.x - a.x()) + f.cgy * (box.y - a.y());
    f.lo = -kInf;
    f.hi = kInf;
    std::vector<std::uint32_t> own{border[e][0], border[e][1]};
    // Joined with every run it touches.
    for (std::size_t k = 0; k < runs.size();) {
      bool touches = false;
      for (const std::uint32_t v : own) {
        touches = touches || std::find(ends[k].begin(), ends[k].end(), v) != ends[k].end();
      }
      if (!touches) {
        ++k;
        continue;
      }
      f.gx = {std::fmin(runs[k].gx.lo, f.gx.lo), std::fmax(runs[k].gx.hi, f.gx.hi)};
      f.gy = {std::fmin(runs[k].gy.lo, f.gy.lo), std::fmax(runs[k].gy.hi, f.gy.hi)};
      f.bend = kInf;
      own.insert(own.end(), ends[k].begin(), ends[k].end());
      runs.erase(runs.begin() + static_cast<std::ptrdiff_t>(k));
      ends.erase(ends.begin() + static_cast<std::ptrdiff_t>(k));
    }
    runs.push_back(f);
    ends.push_back(std::move(own));
  }
  for (PlanFunction& f : runs) {
    if (edges.size() >= kMost) f.gx = f.gy = {-1, 1};  // there may be more: split
    outline.push(f);
  }
}

// The scan over a box: its triangles' planes.
Coverage scan_over(const ScannedSurface& scan, const CellBox& box, double guard, FaceOver& face,
                   FunctionList& outline) {
  ScannedSurface::Band band;
  const BaseBounds b =
      scan.bounds({box.x - box.hx, box.x + box.hx, box.y - box.hy, box.y + box.hy}, band);
  if (b.coverage == Coverage::kOutside) return b.coverage;
  if (b.coverage == Coverage::kPartly) scan_outline(scan, box, outline);
  face.zx = b.zx;
  face.zy = b.zy;
  face.c = band.c;
  face.gx = band.gx;
  face.gy = band.gy;
  face.lo = band.rest.lo - guard;
  face.hi = band.rest.hi + guard;
  const double reach = std::fabs(band.gx) * box.hx + std::fabs(band.gy) * box.hy;
  if (b.z.hi - b.z.lo < 2 * reach + face.hi - face.lo) {
    face.c = 0.5 * (b.z.lo + b.z.hi);
    face.gx = face.gy = 0;
    face.hi = 0.5 * (b.z.hi - b.z.lo) + guard;
    face.lo = -face.hi;
  }
  return b.coverage;
}

}  // namespace

Coverage base_over(const CompoundSurface::Impl& surface, const CompoundStep& step,
                   const CellBox& box, FaceOver& face, FunctionList& outline) {
  face = FaceOver{};
  face.label = make_label(step.first_row, 0);
  if (const PlaneSurface* plane = std::get_if<PlaneSurface>(&surface.base)) {
    BaseHit hit;
    plane->at(box.x, box.y, hit);
    face.c = hit.z;
    face.gx = hit.zx;
    face.gy = hit.zy;
    face.zx = {hit.zx, hit.zx};
    face.zy = {hit.zy, hit.zy};
    return Coverage::kInside;
  }
  if (const ScannedSurface* scan = std::get_if<ScannedSurface>(&surface.base)) {
    return scan_over(*scan, box, std::ldexp(surface.size, -44), face, outline);
  }
  const FergusonSurface* ferguson = std::get_if<FergusonSurface>(&surface.base);
  if (ferguson == nullptr) return Coverage::kOutside;
  BaseBounds b = ferguson->bounds({box.x - box.hx, box.x + box.hx, box.y - box.hy, box.y + box.hy});
  if (b.coverage == Coverage::kOutside) return b.coverage;
  if (b.coverage == Coverage::kPartly) {
    // The enclosure is wider than the patch it encloses: the border itself tells.
    const int before = outline.count;
    for (const BaseBorderPiece& piece : surface.base_border) {
      if (piece.box.x0 > box.x + box.hx || piece.box.x1 < box.x - box.hx ||
          piece.box.y0 > box.y + box.hy || piece.box.y1 < box.y - box.hy) {
        continue;
      }
      PlanFunction f;
      f.kind = PlanFunction::Kind::kOutline;
      f.id = piece.side;
      f.gx = piece.nx;
      f.gy = piece.ny;
      f.cgx = 0.5 * (piece.nx.lo + piece.nx.hi);
      f.cgy = 0.5 * (piece.ny.lo + piece.ny.hi);
      f.v = f.cgx * (box.x - piece.x) + f.cgy * (box.y - piece.y);
      f.lo = -kInf;
      f.hi = kInf;
      f.bend = piece.straight ? 0 : kInf;
      if (piece.straight) {
        const double reach = std::fabs(f.cgx) * box.hx + std::fabs(f.cgy) * box.hy;
        if (f.v - reach > piece.close || f.v + reach < -piece.close) continue;
      }
      bool merged = false;
      for (int i = before; i < outline.count; ++i) {
        PlanFunction& g = outline[i];
        if (g.id != f.id) continue;  // pieces of one side follow one another: one curve
        g.gx = {std::fmin(g.gx.lo, f.gx.lo), std::fmax(g.gx.hi, f.gx.hi)};
        g.gy = {std::fmin(g.gy.lo, f.gy.lo), std::fmax(g.gy.hi, f.gy.hi)};
        merged = true;
      }
      if (!merged) outline.push(f);
    }
    if (outline.count == before) {
      BaseHit hit;
      FergusonHint hint;
      b.coverage = ferguson->at(box.x, box.y, hit, hint) ? Coverage::kInside : Coverage::kOutside;
      if (b.coverage == Coverage::kOutside) return b.coverage;
    }
  }
  face.zx = b.zx;
  face.zy = b.zy;
  BaseHit hit;
  FergusonHint hint;
  const double guard = std::ldexp(surface.size, -44);
  if (b.coverage == Coverage::kInside && ferguson->at(box.x, box.y, hit, hint)) {
    face.c = hit.z;
    face.gx = hit.zx;
    face.gy = hit.zy;
    const double bend =
        0.5 * std::fmax(std::fabs(b.zxx.lo), std::fabs(b.zxx.hi)) * box.hx * box.hx +
        0.5 * std::fmax(std::fabs(b.zyy.lo), std::fabs(b.zyy.hi)) * box.hy * box.hy +
        std::fmax(std::fabs(b.zxy.lo), std::fabs(b.zxy.hi)) * box.hx * box.hy;
    face.lo = -bend - guard;
    face.hi = bend + guard;
    if (!(bend < kInf)) {
      face.c = 0.5 * (b.z.lo + b.z.hi);
      face.gx = face.gy = 0;
      face.hi = 0.5 * (b.z.hi - b.z.lo) + guard;
      face.lo = -face.hi;
    }
    return b.coverage;
  }
  face.c = 0.5 * (b.z.lo + b.z.hi);
  face.hi = 0.5 * (b.z.hi - b.z.lo) + guard;
  face.lo = -face.hi;
  return b.coverage;
}

}  // namespace diesink
