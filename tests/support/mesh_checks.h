// What has to hold of every mesh of a die, told in words where it does not: topology, orientation,
// shape of the triangles, cover of the plan, borders, and the report's figures counted again.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/tessellate/tessellate.h"

namespace diesink::test {

// Sentences, one a fault; empty where all is well.
class Faults {
 public:
  void add(const std::string& what) { text_ += what + '\n'; }
  // "what: COUNT" and where the first was.
  void add(const std::string& what, std::size_t count, const Vec3& first) {
    if (count == 0) return;
    char place[120];
    std::snprintf(place, sizeof place, ": %zu, first at (%.9g, %.9g, %.9g)", count, first.x(),
                  first.y(), first.z());
    add(what + place);
  }
  void add(const std::string& what, double value, double limit) {
    char figures[80];
    std::snprintf(figures, sizeof figures, ": %.9g against %.9g", value, limit);
    add(what + figures);
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// Counts and keeps the place of the first.
struct Tally {
  std::size_t count = 0;
  Vec3 first = Vec3::Zero();
  void operator()(const Vec3& at) {
    if (count++ == 0) first = at;
  }
};

enum class ElementRole : std::uint8_t { kFace, kWall, kSkirt, kFloor };

inline ElementRole role_of(const std::string& name) {
  if (name == "skirt") return ElementRole::kSkirt;
  if (name == "floor") return ElementRole::kFloor;
  return name.ends_with(".wall") ? ElementRole::kWall : ElementRole::kFace;
}

inline ElementRole role_of(const TriangleMesh& mesh, std::size_t triangle) {
  return role_of(mesh.elements[mesh.triangle_element[triangle]].name);
}

// Twice the signed area in plan, exact to rounding of the differences.
inline double plan_area2(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// Indices in range; every side of a triangle run along once each way at most; one fan of triangles
// round a vertex. `solid`: no side without its counterpart.
inline void check_topology(const TriangleMesh& mesh, bool solid, Faults& faults) {
  const auto count = static_cast<std::uint32_t>(mesh.positions.size());
  struct Side {
    std::uint32_t from, to, triangle, corner;
    bool operator<(const Side& o) const { return from != o.from ? from < o.from : to < o.to; }
  };
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  if (mesh.triangles.empty()) return faults.add("no triangles");
  if (mesh.triangle_element.size() != mesh.triangles.size() ||
      mesh.corner_normals.size() != mesh.triangles.size())
    return faults.add("elements or normals do not go with the triangles");
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (v[k] >= count || mesh.corner_normals[t][k] >= mesh.normals.size() ||
          mesh.triangle_element[t] >= mesh.elements.size())
        return faults.add("an index out of range");
      if (v[k] == v[(k + 1) % 3]) return faults.add("a triangle with one vertex twice");
      sides.push_back({v[k], v[(k + 1) % 3], t, k});
    }
  }
  std::sort(sides.begin(), sides.end());
  Tally twice, open;
  for (std::size_t k = 1; k < sides.size(); ++k) {
    if (!(sides[k - 1] < sides[k])) twice(mesh.positions[sides[k].from]);
  }
  faults.add("sides that two triangles run along the same way", twice.count, twice.first);
  // The triangles round a vertex: corners joined over the sides they share.
  std::vector<std::uint32_t> root(3 * mesh.triangles.size());
  for (std::uint32_t k = 0; k < root.size(); ++k) root[k] = k;
  const auto find = [&](std::uint32_t k) {
    while (root[k] != k) k = root[k] = root[root[k]];
    return k;
  };
  for (const Side& s : sides) {
    const auto it = std::lower_bound(sides.begin(), sides.end(), Side{s.to, s.from, 0, 0});
    if (it == sides.end() || it->from != s.to || it->to != s.from) {
      open(mesh.positions[s.from]);
      continue;
    }
    // This side's start is the other's end.
    root[find(3 * s.triangle + s.corner)] = find(3 * it->triangle + (it->corner + 1) % 3);
  }
  if (solid) faults.add("open sides of a solid", open.count, open.first);
  std::vector<std::uint32_t> fan(count, 0xFFFFFFFFu);
  Tally pinched;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[t][k], f = find(3 * t + k);
      if (fan[v] == 0xFFFFFFFFu) fan[v] = f;
      if (fan[v] != f) pinched(mesh.positions[v]);
    }
  }
  faults.add("vertices with more than one fan", pinched.count, pinched.first);
  Tally unused;
  for (std::uint32_t v = 0; v < count; ++v) {
    if (fan[v] == 0xFFFFFFFFu) unused(mesh.positions[v]);
    if (!mesh.positions[v].allFinite()) return faults.add("a vertex that is not finite");
  }
  faults.add("vertices of no triangle", unused.count, unused.first);
}

// No triangle without area, none that looks the wrong way, unit normals on the triangles' side.
// `size`: of the part; `width`: of its domain. Far from the origin altitudes are as small beside
// the size as the domain is, but for eight ulps of the coordinates.
inline void check_triangles(const TriangleMesh& mesh, double size, double width, Faults& faults) {
  const double least = std::max(1e-12 * std::min(size, 64 * width), 0x1p-49 * size);
  Tally flat, inverted, leaning, down, crooked, turned;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    const Vec3 &a = mesh.positions[v[0]], &b = mesh.positions[v[1]], &c = mesh.positions[v[2]];
    const Vec3 n = (b - a).cross(c - a);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const Vec3 middle = (a + b + c) / 3;
    if (!(n.norm() > least * longest)) {
      flat(middle);
      continue;
    }
    const double up = n.z() / n.norm();
    const double slack = 1e-14 * size / (n.norm() / longest);  // what rounding may turn it
    switch (role_of(mesh, t)) {
      case ElementRole::kFace:
        if (up < -1e-9 - slack) inverted(middle);
        break;
      case ElementRole::kFloor:
        if (!(up < -0.999999)) down(middle);
        break;
      default:
        if (std::fabs(up) > 1e-9 + slack) leaning(middle);
    }
    for (const std::uint32_t k : mesh.corner_normals[t]) {
      if (std::fabs(mesh.normals[k].norm() - 1) > 1e-9) crooked(middle);
      // (Not so of curved faces, which a coarse grid may meet aslant; triangles no thicker than
      // rounding look anywhere.)
      if (role_of(mesh, t) != ElementRole::kFace && slack < 1e-6 &&
          mesh.normals[k].dot(n) < -1e-6 * n.norm())
        turned(middle);
    }
  }
  faults.add("triangles without area", flat.count, flat.first);
  faults.add("face triangles that look down", inverted.count, inverted.first);
  faults.add("walls out of the vertical", leaning.count, leaning.first);
  faults.add("floor triangles that do not look down", down.count, down.first);
  faults.add("normals that are no unit vectors", crooked.count, crooked.first);
  faults.add("normals on the other side of their wall", turned.count, turned.first);
}

// Plan areas of the faces add up to the domain where the surface has no holes, to no more else.
inline void check_cover(const CompoundSurface& surface, const Tessellation& made, bool holes,
                        Faults& faults) {
  const TriangleMesh& mesh = made.mesh;
  const auto& d = made.report.domain;
  const double domain = (d[1] - d[0]) * (d[3] - d[2]);
  double sum = 0, absolute = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (role_of(mesh, t) != ElementRole::kFace) continue;
    const auto& v = mesh.triangles[t];
    const double twice =
        plan_area2(mesh.positions[v[0]], mesh.positions[v[1]], mesh.positions[v[2]]);
    sum += 0.5 * twice;
    absolute += 0.5 * std::fabs(twice);
  }
  const double slack = 1e-11 * domain + 1e-14 * surface.size() * (d[1] - d[0] + d[3] - d[2]);
  if (std::fabs(absolute - sum) > slack)
    faults.add("plan area of what is turned over", absolute - sum, slack);
  if (sum > domain + slack) faults.add("plan area beyond the domain", sum, domain);
  if (!holes && sum < domain - slack) faults.add("plan area short of the domain", sum, domain);
}

// Whether a hole of the surface comes within 4e-9 of the size of a plan point. (Two rims of R = 8
// that touch are one to the evaluator, a tie apart, for 2e-9 of a size of 1e6.)
inline bool is_beside_hole(const CompoundSurface& surface, const Vec2& p) {
  for (double r = 1e-12 * surface.size(); r < 4e-9 * surface.size(); r *= 2) {
    for (int k = 0; k < 64; ++k) {
      const double turn = 2 * std::numbers::pi * k / 64;
      if (!surface.at(p.x() + r * std::cos(turn), p.y() + r * std::sin(turn))) return true;
    }
  }
  return false;
}

// An open sheet ends on the domain's border or beside a hole. In the adaptive scheme that holds of
// its open sides; in the grid scheme, whose chords run from grid line to grid line, of their ends.
inline void check_borders(const CompoundSurface& surface, const TessellationOptions& options,
                          const Tessellation& made, Faults& faults) {
  const TriangleMesh& mesh = made.mesh;
  const auto& d = made.report.domain;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> sides;  // (edge, directed edge)
  for (const auto& v : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = v[k], b = v[(k + 1) % 3];
      sides.emplace_back(a < b ? a << 32 | b : b << 32 | a, a << 32 | b);
    }
  }
  std::sort(sides.begin(), sides.end());
  Tally stray;
  for (std::size_t k = 0; k < sides.size(); ++k) {
    const std::uint64_t edge = sides[k].first;
    if ((k > 0 && sides[k - 1].first == edge) ||
        (k + 1 < sides.size() && sides[k + 1].first == edge))
      continue;
    const Vec3 &a = mesh.positions[sides[k].second >> 32],
               &b = mesh.positions[sides[k].second & 0xFFFFFFFFu];
    const bool border = (a.x() == d[0] && b.x() == d[0]) || (a.x() == d[1] && b.x() == d[1]) ||
                        (a.y() == d[2] && b.y() == d[2]) || (a.y() == d[3] && b.y() == d[3]);
    if (border) continue;
    if (options.scheme == MeshScheme::kGrid) {
      if (!is_beside_hole(surface, a.head<2>()) || !is_beside_hole(surface, b.head<2>())) stray(a);
      continue;
    }
    // The surface is on the left of the side: some point on its right has none.
    const Vec3 m = 0.5 * (a + b);
    Vec2 out(b.y() - a.y(), a.x() - b.x());
    bool ended = !(out.norm() > 0);
    if (!ended) out.normalize();
    // Where two parts all but touch the gap is narrow: every scale from rounding up.
    for (double step = 1e-9 * surface.size(); !ended && step < 4 * made.report.tolerance;
         step *= 1.5) {
      const Vec2 p = m.head<2>() + step * out;
      ended = !surface.at(p.x(), p.y());
    }
    if (!ended) stray(m);
  }
  faults.add("open sides that are neither border nor beside a hole", stray.count, stray.first);
}

// The report counted again from the mesh. Volume is compared for a solid, whose triangles enclose
// it.
inline void check_report(const Tessellation& made, bool solid, Faults& faults) {
  const TriangleMesh& mesh = made.mesh;
  const TessellationReport& report = made.report;
  if (report.uncertified_area == 0 && !(report.certified_deviation <= report.tolerance))
    faults.add("a deviation beyond the tolerance without a word", report.certified_deviation,
               report.tolerance);
  if (!(report.certified_deviation >= 0) || !(report.uncertified_area >= 0))
    faults.add("a bound below nothing");
  std::vector<std::size_t> count(mesh.elements.size(), 0);
  double area = 0, six_volumes = 0;
  Vec3 low = mesh.positions[0], high = low;
  for (const Vec3& p : mesh.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    ++count[mesh.triangle_element[t]];
    const auto& v = mesh.triangles[t];
    const Vec3 a = mesh.positions[v[0]] - low, b = mesh.positions[v[1]] - low,
               c = mesh.positions[v[2]] - low;
    area += 0.5 * (b - a).cross(c - a).norm();
    six_volumes += a.dot(b.cross(c));
  }
  if (std::fabs(area - report.area) > 1e-9 * area) faults.add("area", report.area, area);
  if (solid && std::fabs(six_volumes / 6 - report.volume) > 1e-9 * std::fabs(six_volumes))
    faults.add("volume", report.volume, six_volumes / 6);
  if (report.watertight != solid) faults.add("watertight is told wrongly");
  if (report.bounds[0] != low || report.bounds[1] != high) faults.add("bounds");
  if (report.elements.size() != mesh.elements.size())
    return faults.add("elements of report and mesh differ");
  for (std::size_t e = 0; e < count.size(); ++e) {
    if (report.elements[e].triangles != count[e] ||
        report.elements[e].name != mesh.elements[e].name)
      faults.add("the report of element " + mesh.elements[e].name);
    if (count[e] == 0) faults.add("an element without triangles: " + mesh.elements[e].name);
    if (report.elements[e].max_deviation > report.certified_deviation)
      faults.add("an element's deviation above that of the whole: " + mesh.elements[e].name);
  }
}

inline double domain_width(const CompoundSurface& surface) {
  const Machining& m = surface.program().machining;
  return std::max(m.x_range[1] - m.x_range[0], m.y_range[1] - m.y_range[0]);
}

// All of the above.
inline void check_mesh(const CompoundSurface& surface, const TessellationOptions& options,
                       const Tessellation& made, bool holes, Faults& faults) {
  check_topology(made.mesh, options.solid, faults);
  if (!faults.text().empty() && made.mesh.triangles.empty()) return;
  check_triangles(made.mesh, surface.size(), domain_width(surface), faults);
  check_cover(surface, made, holes, faults);
  if (!options.solid) check_borders(surface, options, made, faults);
  check_report(made, options.solid, faults);
}

}  // namespace diesink::test
