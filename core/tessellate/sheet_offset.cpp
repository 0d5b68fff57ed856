// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/sheet_offset.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/scanned_triangle.h"

namespace diesink {
namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

// What of the polygon lies to the left of a line.
void cut_off(std::vector<Vec2>& polygon, std::vector<Vec2>& cut, const Vec2& from, const Vec2& to) {
  cut.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double lp = cross(to - from, p - from), lq = cross(to - from, q - from);
    if (lp >= 0) cut.push_back(p);
    if ((lp > 0 && lq < 0) || (lp < 0 && lq > 0)) cut.push_back(p + lp / (lp - lq) * (q - p));
  }
  polygon.swap(cut);
}

}  // namespace

SheetOffset sheet_offset(const ScannedSurface& scan, const std::array<Vec3, 3>& corners) {
  SheetOffset offset;
  std::array<Vec2, 3> plan;
  for (std::size_t k = 0; k < 3; ++k) plan[k] = corners[k].head<2>();
  const double twice = cross(plan[1] - plan[0], plan[2] - plan[0]);
  if (!(twice > 0)) return offset;
  const Vec2 low = plan[0].cwiseMin(plan[1]).cwiseMin(plan[2]);
  const Vec2 high = plan[0].cwiseMax(plan[1]).cwiseMax(plan[2]);
  // (Never beyond the triangle's own heights, however narrow it is.)
  const auto own = [&](const Vec2& p) {
    double z = 0, sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 &a = plan[(k + 1) % 3], &b = plan[(k + 2) % 3];
      const double w = std::fmax(cross(b - a, p - a), 0);
      z += w * corners[k].z();
      sum += w;
    }
    return sum > 0 ? z / sum : corners[0].z();
  };
  // What rounding of the corners' coordinates does to areas is none, and beside a wall far off.
  const double rounding =
      1e-14 * high.cwiseAbs().cwiseMax(low.cwiseAbs()).maxCoeff() * (high - low).maxCoeff();
  const double least = 1e-9 * twice + rounding;
  std::vector<std::uint32_t> over;
  scan.faces_over({low.x(), high.x(), low.y(), high.y()}, over);
  std::vector<Vec2> polygon, cut;
  double covered = 0;
  ScannedTriangle t;
  for (const std::uint32_t f : over) {
    const auto& v = scan.triangles()[f];
    if (!t.set(scan.positions()[v[0]], scan.positions()[v[1]], scan.positions()[v[2]])) continue;
    polygon.assign(plan.begin(), plan.end());
    for (std::size_t k = 0; k < 3 && !polygon.empty(); ++k)
      cut_off(polygon, cut, {t.x[k], t.y[k]}, {t.x[(k + 1) % 3], t.y[(k + 1) % 3]});
    double common = 0;
    for (std::size_t i = 2; i < polygon.size(); ++i)
      common += cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
    covered += common;
    if (common <= least) continue;  // only beside it
    for (const Vec2& p : polygon) {
      offset.height =
          std::fmax(offset.height, std::fabs(t.height(t.along_row(p.y()), p.x()) - own(p)));
    }
  }
  const double left = twice - covered;
  if (left > least) offset.beyond = 0.5 * left;
  return offset;
}

}  // namespace diesink
