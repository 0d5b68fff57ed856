// Cut to the box triangle by triangle (Sutherland and Hodgman 1974), with one vertex a cut edge.
// SPDX-License-Identifier: Apache-2.0
#include "core/base/scan_sheet.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/base/exact_plan.h"
#include "core/base/scan_layers.h"
#include "core/base/scan_pinch.h"
#include "core/mesh_tools/topology.h"
#include "core/mesh_tools/weld.h"
#include "core/pair_key.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;

// Of the strips' width: a steep face that is no wider in plan counts as upright. (Walls turned in
// space have coordinates off by rounding.)
constexpr double kWallWidth = 1e-3;
constexpr double kWallSlope = 1e3;

bool is_wall(const Vec3& a, const Vec3& b, const Vec3& c, double width) {
  const Vec3 u = b - a, v = c - a, w = c - b;
  const double longest2 =
      std::max({u.head<2>().squaredNorm(), v.head<2>().squaredNorm(), w.head<2>().squaredNorm()});
  const Vec3 n = u.cross(v);
  const double flat2 = n.z() * n.z();
  return flat2 <= width * width * longest2 && flat2 * (kWallSlope * kWallSlope) < n.squaredNorm();
}

// One side of the box: a coordinate, and which side of it is kept.
struct Side {
  int axis;
  double at;
  bool above;
};

// Cuts a sheet to a box. Each new vertex is a function of the edge of the sheet and the side alone,
// whatever else of the triangle is cut off: boxes that share a side get the same chain along it.
class SheetCutter {
 public:
  explicit SheetCutter(ScanSheet& sheet) : sheet_(sheet) {}

  void cut(const PlanBox& box) {
    const Side sides[4] = {
        {0, box.x0, true}, {0, box.x1, false}, {1, box.y0, true}, {1, box.y1, false}};
    std::vector<std::array<std::uint32_t, 3>> kept;
    kept.reserve(sheet_.triangles.size());
    for (const std::array<std::uint32_t, 3>& t : sheet_.triangles) {
      bool whole = true, none = false;
      for (const Side& side : sides) {
        int inside = 0, outside = 0;
        for (const std::uint32_t v : t) {
          const double d = beyond(side, v);
          inside += d > 0;
          outside += d < 0;
        }
        whole = whole && outside == 0;
        none = none || (inside == 0 && outside > 0);
      }
      if (none) continue;
      if (whole) {
        kept.push_back(t);
        continue;
      }
      polygon_.clear();
      for (std::size_t k = 0; k < 3; ++k) polygon_.push_back({t[k], t[k], t[(k + 1) % 3]});
      for (std::uint32_t s = 0; s < 4; ++s) clip(sides[s], s);
      for (std::size_t k = 1; k + 1 < polygon_.size(); ++k) {
        const std::array<std::uint32_t, 3> part{polygon_[0].v, polygon_[k].v, polygon_[k + 1].v};
        const Vec3 &p = sheet_.points[part[0]], &q = sheet_.points[part[1]],
                   &r = sheet_.points[part[2]];
        if (turn(p.x(), p.y(), q.x(), q.y(), r.x(), r.y()) > 0) kept.push_back(part);
      }
    }
    sheet_.triangles = std::move(kept);
  }

 private:
  struct Corner {
    std::uint32_t v;
    std::uint32_t a, b;  // the line that the polygon's edge from here on is part of
  };
  [[nodiscard]] double beyond(const Side& side, std::uint32_t v) const {
    const double d = sheet_.points[v][side.axis] - side.at;
    return side.above ? d : -d;
  }
  void clip(const Side& side, std::uint32_t number) {
    clipped_.clear();
    for (std::size_t k = 0; k < polygon_.size(); ++k) {
      const Corner &from = polygon_[k], &to = polygon_[(k + 1) % polygon_.size()];
      const double d0 = beyond(side, from.v), d1 = beyond(side, to.v);
      if (d0 >= 0) clipped_.push_back(from);
      if ((d0 > 0 && d1 < 0) || (d0 < 0 && d1 > 0)) {
        const std::uint32_t v = cut_edge(side, number, from.a, from.b);
        clipped_.push_back({v, from.a, from.b});
      }
    }
    // What runs along the side from where the polygon leaves it to where it comes back is a line of
    // its own, between those two.
    for (std::size_t k = 0; k < clipped_.size(); ++k) {
      Corner& from = clipped_[k];
      const Corner& to = clipped_[(k + 1) % clipped_.size()];
      if (beyond(side, from.v) == 0 && beyond(side, to.v) == 0) {
        from.a = from.v;
        from.b = to.v;
      }
    }
    std::swap(polygon_, clipped_);
  }
  std::uint32_t cut_edge(const Side& side, std::uint32_t number, std::uint32_t a, std::uint32_t b) {
    const auto before = [&](std::uint32_t i, std::uint32_t j) {
      const Vec3 &p = sheet_.points[i], &q = sheet_.points[j];
      return std::array{p.x(), p.y(), p.z()} < std::array{q.x(), q.y(), q.z()};
    };
    if (before(b, a)) std::swap(a, b);
    const auto [it, fresh] =
        cuts_[number].try_emplace(pair_key(a, b), static_cast<std::uint32_t>(sheet_.points.size()));
    if (fresh) {
      const Vec3 p = sheet_.points[a], q = sheet_.points[b];
      const double s = (side.at - p[side.axis]) / (q[side.axis] - p[side.axis]);
      Vec3 c = p + s * (q - p);
      c[side.axis] = side.at;
      sheet_.points.push_back(c);
    }
    return it->second;
  }

  ScanSheet& sheet_;
  std::vector<Corner> polygon_, clipped_;
  std::array<std::unordered_map<std::uint64_t, std::uint32_t>, 4> cuts_;  // a side
};

// Numbers only the vertices that are used.
void compact(ScanSheet& sheet) {
  std::vector<std::uint32_t> number(sheet.points.size(), ScanSheet::kNone);
  std::vector<Vec3> points;
  for (std::array<std::uint32_t, 3>& t : sheet.triangles) {
    for (std::uint32_t& v : t) {
      if (number[v] == ScanSheet::kNone) {
        number[v] = static_cast<std::uint32_t>(points.size());
        points.push_back(sheet.points[v]);
      }
      v = number[v];
    }
  }
  sheet.points = std::move(points);
}

}  // namespace

void ScanSheet::make_twins() {
  twin.assign(triangles.size() * 3, kNone);
  const std::vector<EdgeUse> uses = edge_uses(triangles, points.size());
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 2 || edge[0].forward == edge[1].forward) return;
    twin[edge[0].corner] = edge[1].corner;
    twin[edge[1].corner] = edge[0].corner;
  });
}

void ScanSheet::fans(std::vector<std::uint32_t>& begins, std::vector<std::uint32_t>& around) const {
  begins.assign(points.size() + 2, 0);
  around.resize(triangles.size() * 3);
  for (const auto& t : triangles) {
    for (const std::uint32_t v : t) ++begins[v + 2];
  }
  for (std::size_t v = 2; v < begins.size(); ++v) begins[v] += begins[v - 1];
  for (std::uint32_t h = 0; h < around.size(); ++h) around[begins[from(h) + 1]++] = h;
  begins.pop_back();
}

ScanSheet top_sheet(const ScannedSurface& scan, const PlanBox& box, double lean, int threads) {
  ScanSheet sheet;
  const WeldMap weld = weld_map(scan.positions());
  const std::vector<std::uint32_t>& first = weld.of_vertex;
  sheet.points.reserve(weld.kept.size());
  for (const std::uint32_t v : weld.kept) sheet.points.push_back(scan.positions()[v]);
  std::vector<std::array<std::uint32_t, 3>> faces(scan.triangles().size(), {kNone, kNone, kNone});
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const std::array<std::uint32_t, 3>& of = scan.triangles()[k];
    const std::array<std::uint32_t, 3> t{first[of[0]], first[of[1]], first[of[2]]};
    const Vec3 &a = sheet.points[t[0]], &b = sheet.points[t[1]], &c = sheet.points[t[2]];
    const int side = turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y());
    if (side != 0 && is_wall(a, b, c, kWallWidth * lean)) continue;
    if (side > 0) faces[k] = t;
    if (side < 0) faces[k] = {t[0], t[2], t[1]};
  }
  join_layers(scan, faces, lean, threads, sheet);
  part_pinches(sheet, lean);
  SheetCutter cutter(sheet);
  cutter.cut(box);
  compact(sheet);
  sheet.make_twins();
  return sheet;
}

ScanCover scan_cover(const ScannedSurface& scan, const PlanBox& box, int threads) {
  ScanCover cover;
  const double domain = (box.x1 - box.x0) * (box.y1 - box.y0);
  const ScanSheet sheet = top_sheet(scan, box, 1e-9 * std::sqrt(domain), threads);
  const auto cross = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  double covered = 0, all = 0;
  for (const auto& t : sheet.triangles)
    covered += 0.5 * cross(sheet.points[t[0]], sheet.points[t[1]], sheet.points[t[2]]);
  // Every triangle, cut to the box.
  ScanSheet whole;
  whole.points = scan.positions();
  whole.triangles = scan.triangles();
  SheetCutter cutter(whole);
  for (auto& t : whole.triangles) {
    if (cross(whole.points[t[0]], whole.points[t[1]], whole.points[t[2]]) < 0)
      std::swap(t[1], t[2]);
  }
  cutter.cut(box);
  for (const auto& t : whole.triangles)
    all += 0.5 * cross(whole.points[t[0]], whole.points[t[1]], whole.points[t[2]]);
  const double slack = 1e-9 * domain;
  cover.open_area = domain - covered > slack ? domain - covered : 0;
  cover.layered_area = all - covered > slack ? all - covered : 0;
  // Loops of the border that run clockwise go round a hole.
  std::vector<char> seen(sheet.twin.size(), 0);
  for (std::uint32_t start = 0; start < sheet.twin.size(); ++start) {
    if (sheet.twin[start] != kNone || seen[start]) continue;
    double area = 0;
    for (std::uint32_t h = start; !seen[h];) {
      seen[h] = 1;
      area += cross(sheet.points[sheet.from(start)], sheet.points[sheet.from(h)],
                    sheet.points[sheet.to(h)]);
      h = ScanSheet::next(h);
      while (sheet.twin[h] != kNone) h = ScanSheet::next(sheet.twin[h]);
    }
    if (area < 0) ++cover.open_loops;
  }
  return cover;
}

}  // namespace diesink
