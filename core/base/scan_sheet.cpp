// Cut to the box triangle by triangle (Sutherland and Hodgman 1974), with one vertex a cut edge.
// SPDX-License-Identifier: Apache-2.0
#include "core/base/scan_sheet.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/base/exact_plan.h"
#include "core/mesh_tools/topology.h"
#include "core/mesh_tools/weld.h"
#include "core/tessellate/planar_triangulation.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;

// Takes the visible part of the layered triangles into the sheet: their visible vertices, with the
// rims and the edges towards the rest of the sheet as lines, triangulated.
void rejoin_layers(const ScannedSurface& scan, const std::vector<char>& layered,
                   const std::vector<std::array<std::uint32_t, 3>>& under, double lean,
                   ScanSheet& sheet) {
  std::vector<std::uint32_t> number(sheet.points.size(), kNone), global;
  std::vector<Vec2> points;
  const auto take = [&](std::uint32_t v) {
    if (number[v] == kNone) {
      number[v] = static_cast<std::uint32_t>(points.size());
      points.emplace_back(sheet.points[v].head<2>());
      global.push_back(v);
    }
    return number[v];
  };
  const auto visible = [&](std::uint32_t v) {
    BaseHit hit;
    const Vec3& p = sheet.points[v];
    return scan.at(p.x(), p.y(), hit) && hit.z <= p.z() + 1e-12 * std::fabs(p.z());
  };
  // Each edge of the layered triangles: how often it is used on either side, and by the sheet.
  struct Use {
    int left = 0, right = 0;  // of the layered, seen from low to high
    bool joined = false;      // by a triangle of the sheet
  };
  std::unordered_map<std::uint64_t, Use> edges;
  const auto key = [](std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
  };
  for (const auto& t : under) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      ++(a < b ? edges[key(a, b)].left : edges[key(a, b)].right);
    }
  }
  for (const auto& t : sheet.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto it = edges.find(key(t[k], t[(k + 1) % 3]));
      if (it != edges.end()) it->second.joined = true;
    }
  }
  std::vector<PlanarTriangulation::Segment> lines;
  const auto add_line = [&](std::uint32_t a, std::uint32_t b) {
    lines.push_back({take(a), take(b)});
    lines.push_back({lines.back()[1], lines.back()[0]});
  };
  std::vector<char> seen(sheet.points.size(), 2);
  const auto is_seen = [&](std::uint32_t v) {
    if (seen[v] == 2) seen[v] = visible(v) ? 1 : 0;
    return seen[v] == 1;
  };
  std::vector<std::array<std::uint32_t, 2>> cut_lines;  // from what is seen to what is not
  // Outward directions of the rims at their vertices.
  std::unordered_map<std::uint32_t, Vec2> outward;
  std::vector<std::array<std::uint32_t, 2>> rims;
  for (const auto& t : under) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      const Use& use = edges[key(a, b)];
      if (use.joined) {
        add_line(a, b);
        continue;
      }
      if (is_seen(a) != is_seen(b)) {
        if (a < b || (a < b ? use.right : use.left) == 0)
          cut_lines.push_back({is_seen(a) ? a : b, is_seen(a) ? b : a});
        continue;
      }
      if (!is_seen(a)) continue;
      const Vec3 m = 0.5 * (sheet.points[a] + sheet.points[b]);
      BaseHit hit;
      if (scan.at(m.x(), m.y(), hit) && hit.z <= m.z() + 1e-9 * std::fabs(m.z())) add_line(a, b);
      if (use.left != 0 && use.right != 0) continue;
      rims.push_back({a, b});
      const Vec2 d = (sheet.points[b] - sheet.points[a]).head<2>().normalized();
      for (const std::uint32_t v : {a, b})
        outward.try_emplace(v, Vec2::Zero()).first->second += Vec2(d.y(), -d.x());
    }
    for (const std::uint32_t v : t) {
      if (is_seen(v)) take(v);
    }
  }
  // Edges that run in under a rim, up to a little before it.
  for (const auto& [a, b] : cut_lines) {
    const Vec3 from = sheet.points[a], d = sheet.points[b] - from;
    double in = 0, out = 1;
    BaseHit hit;
    for (int k = 0; k < 40; ++k) {
      const double s = 0.5 * (in + out);
      const Vec3 q = from + s * d;
      (scan.at(q.x(), q.y(), hit) && hit.z <= q.z() + 1e-9 * std::fabs(q.z()) ? in : out) = s;
    }
    in -= 2 * lean / d.head<2>().norm();
    if (!(in > 0)) continue;
    sheet.points.emplace_back(from + in * d);
    number.push_back(kNone);
    add_line(a, static_cast<std::uint32_t>(sheet.points.size() - 1));
  }
  // The foot of the wall under each rim vertex.
  std::unordered_map<std::uint32_t, std::uint32_t> foot;
  std::vector<std::uint32_t> order;
  for (const auto& [v, d] : outward) order.push_back(v);
  std::sort(order.begin(), order.end());
  for (const std::uint32_t v : order) {
    const Vec2 d = outward[v];
    if (!(d.norm() > 1e-6)) continue;
    const Vec2 q = sheet.points[v].head<2>() + lean * d.normalized();
    BaseHit hit;
    if (!scan.at(q.x(), q.y(), hit) || !(hit.z < sheet.points[v].z() - 2 * lean)) continue;
    const auto f = static_cast<std::uint32_t>(sheet.points.size());
    sheet.points.emplace_back(q.x(), q.y(), hit.z);
    number.push_back(kNone);
    foot[v] = f;
    sheet.moved = 2 * lean;
    take(f);
  }
  for (const auto& [a, b] : rims) {
    const auto fa = foot.find(a), fb = foot.find(b);
    if (fa != foot.end() && fb != foot.end()) add_line(fa->second, fb->second);
  }
  // A frame round all: what it adds is uncovered and drops out.
  PlanBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  for (const Vec2& p : points) {
    box = {std::fmin(box.x0, p.x()), std::fmax(box.x1, p.x()), std::fmin(box.y0, p.y()),
           std::fmax(box.y1, p.y())};
  }
  const double margin = 0.1 * (box.x1 - box.x0 + box.y1 - box.y0) + 64 * lean;
  const auto frame = static_cast<std::uint32_t>(points.size());
  points.emplace_back(box.x0 - margin, box.y0 - margin);
  points.emplace_back(box.x1 + margin, box.y0 - margin);
  points.emplace_back(box.x1 + margin, box.y1 + margin);
  points.emplace_back(box.x0 - margin, box.y1 + margin);
  // Lines given twice (an edge of two triangles) once; points at one place are one.
  std::vector<std::uint32_t> by_place(points.size());
  for (std::uint32_t k = 0; k < by_place.size(); ++k) by_place[k] = k;
  std::sort(by_place.begin(), by_place.end(), [&](std::uint32_t i, std::uint32_t j) {
    if (points[i].x() != points[j].x()) return points[i].x() < points[j].x();
    if (points[i].y() != points[j].y()) return points[i].y() < points[j].y();
    const double zi = i < frame ? sheet.points[global[i]].z() : 0,
                 zj = j < frame ? sheet.points[global[j]].z() : 0;
    return zi != zj ? zi > zj : i < j;  // the topmost of a wall's
  });
  std::vector<std::uint32_t> same(points.size());
  std::vector<Vec2> sites;
  std::vector<std::uint32_t> site_vertex;
  for (std::size_t k = 0; k < by_place.size(); ++k) {
    if (k == 0 || points[by_place[k]] != points[by_place[k - 1]]) {
      sites.push_back(points[by_place[k]]);
      site_vertex.push_back(by_place[k] < frame ? global[by_place[k]] : kNone);
    }
    same[by_place[k]] = static_cast<std::uint32_t>(sites.size() - 1);
  }
  for (std::uint32_t k = 0; k < 4; ++k) lines.push_back({frame + k, frame + (k + 1) % 4});
  std::vector<PlanarTriangulation::Segment> segments;
  for (const auto& s : lines) {
    if (same[s[0]] != same[s[1]]) segments.push_back({same[s[0]], same[s[1]]});
  }
  std::sort(segments.begin(), segments.end());
  segments.erase(std::unique(segments.begin(), segments.end()), segments.end());
  const auto index_of = [&](std::uint32_t a, std::uint32_t b) {
    return std::lower_bound(segments.begin(), segments.end(), PlanarTriangulation::Segment{a, b}) -
           segments.begin();
  };
  for (int attempt = 0; attempt < 64; ++attempt) {
    PlanarTriangulation triangulation;
    const std::vector<SegmentCrossing> wrong = triangulation.build(sites, segments);
    if (wrong.empty()) {
      BaseHit hit;
      for (const auto& t : triangulation.triangles()) {
        const std::array<std::uint32_t, 3> v{site_vertex[t[0]], site_vertex[t[1]],
                                             site_vertex[t[2]]};
        if (v[0] == kNone || v[1] == kNone || v[2] == kNone) continue;
        const Vec3 &a = sheet.points[v[0]], &b = sheet.points[v[1]], &c = sheet.points[v[2]];
        const Vec3 m = (a + b + c) / 3;
        if (!scan.at(m.x(), m.y(), hit) || !layered[hit.face]) continue;
        sheet.triangles.push_back(v);
        // A piece of the triangle seen at its middle, or a wall as thin as the strip is wide.
        bool proven = true;
        for (const Vec3* p : {&a, &b, &c}) {
          const double z = hit.z + hit.zx * (p->x() - m.x()) + hit.zy * (p->y() - m.y());
          proven = proven && std::fabs(z - p->z()) <= lean;
        }
        const double area =
            0.5 * ((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
        const double longest =
            std::fmax((b - a).head<2>().norm(),
                      std::fmax((c - b).head<2>().norm(), (a - c).head<2>().norm()));
        if (!proven && !(2 * area <= 1.5 * lean * longest)) sheet.unproven_area += area;
      }
      return;
    }
    std::vector<char> drop(segments.size(), 0);
    for (const SegmentCrossing& w : wrong) {
      // The later of two lines, both ways; the frame never crosses anything.
      std::uint32_t s = w.segment_a;
      if (w.segment_b < segments.size() && (s >= segments.size() || w.segment_b > s))
        s = w.segment_b;
      if (s >= segments.size()) continue;
      drop[s] = 1;
      const auto back = static_cast<std::size_t>(index_of(segments[s][1], segments[s][0]));
      if (back < segments.size() && segments[back][0] == segments[s][1] &&
          segments[back][1] == segments[s][0])
        drop[back] = 1;
    }
    std::vector<PlanarTriangulation::Segment> rest;
    for (std::size_t s = 0; s < segments.size(); ++s) {
      if (!drop[s]) rest.push_back(segments[s]);
    }
    if (rest.size() == segments.size()) break;
    segments = std::move(rest);
  }
  // Left open: a hole, counted.
  for (const auto& t : under) {
    const Vec3 &a = sheet.points[t[0]], &b = sheet.points[t[1]], &c = sheet.points[t[2]];
    sheet.unproven_area +=
        0.5 * ((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
  }
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
    const auto [it, fresh] = cuts_[number].try_emplace(
        (std::uint64_t{a} << 32) | b, static_cast<std::uint32_t>(sheet_.points.size()));
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
  const std::vector<char> layered = scan.layered(threads);
  const WeldMap weld = weld_map(scan.positions());
  const std::vector<std::uint32_t>& first = weld.of_vertex;
  sheet.points.reserve(weld.kept.size());
  for (const std::uint32_t v : weld.kept) sheet.points.push_back(scan.positions()[v]);
  sheet.triangles.reserve(scan.triangles().size());
  std::vector<std::array<std::uint32_t, 3>> under;
  for (std::size_t k = 0; k < scan.triangles().size(); ++k) {
    const std::array<std::uint32_t, 3>& of = scan.triangles()[k];
    std::array<std::uint32_t, 3> t{first[of[0]], first[of[1]], first[of[2]]};
    const Vec3 &a = sheet.points[t[0]], &b = sheet.points[t[1]], &c = sheet.points[t[2]];
    const int side = turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y());
    if (side == 0) continue;
    if (side < 0) std::swap(t[1], t[2]);
    (layered[k] ? under : sheet.triangles).push_back(t);
  }
  if (!under.empty()) rejoin_layers(scan, layered, under, lean, sheet);
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
