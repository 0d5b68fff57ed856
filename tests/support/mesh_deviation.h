// A mesh against its surface by samples that share nothing with the tessellator: distances both
// ways, labels and features, and the equations of the faces that meet in a curve.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "core/compound/compound_impl.h"
#include "tests/support/mesh_checks.h"
#include "tests/support/random_program.h"

namespace diesink::test {

// The triangles of a mesh in bins of the plan.
class MeshInPlan {
 public:
  MeshInPlan(const TriangleMesh& mesh, const std::array<double, 4>& domain)
      : mesh_(mesh), x0_(domain[0]), y0_(domain[2]) {
    side_ =
        std::clamp(static_cast<int>(std::sqrt(static_cast<double>(mesh.triangles.size()))), 1, 400);
    dx_ = (domain[1] - domain[0]) / side_;
    dy_ = (domain[3] - domain[2]) / side_;
    bins_.resize(static_cast<std::size_t>(side_ * side_));
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const ElementRole role = role_of(mesh, t);
      if (role == ElementRole::kSkirt || role == ElementRole::kFloor) continue;
      Vec2 low = at(t, 0).head<2>(), high = low;
      for (const std::size_t k : {1, 2}) {
        low = low.cwiseMin(at(t, k).head<2>());
        high = high.cwiseMax(at(t, k).head<2>());
      }
      each_bin(low, high, [&](std::vector<std::uint32_t>& bin) { bin.push_back(t); });
    }
  }

  // Distance of p to the triangles of one element (or all: kAny) within `reach`, else infinity.
  static constexpr std::uint32_t kAny = 0xFFFFFFFFu;
  [[nodiscard]] double distance(const Vec3& p, double reach, std::uint32_t element = kAny) const {
    double least = std::numeric_limits<double>::infinity();
    const Vec2 r(reach, reach);
    each_bin(p.head<2>() - r, p.head<2>() + r, [&](const std::vector<std::uint32_t>& bin) {
      for (const std::uint32_t t : bin) {
        if (element != kAny && mesh_.triangle_element[t] != element) continue;
        least = std::min(least, to_triangle(p, at(t, 0), at(t, 1), at(t, 2)));
      }
    });
    return least <= reach ? least : std::numeric_limits<double>::infinity();
  }

  // The face triangle over a plan point; empty over a hole.
  [[nodiscard]] std::optional<std::uint32_t> over(double x, double y) const {
    std::optional<std::uint32_t> found;
    const Vec3 p(x, y, 0);
    each_bin(p.head<2>(), p.head<2>(), [&](const std::vector<std::uint32_t>& bin) {
      for (const std::uint32_t t : bin) {
        if (role_of(mesh_, t) != ElementRole::kFace) continue;
        if (plan_area2(at(t, 0), at(t, 1), p) >= 0 && plan_area2(at(t, 1), at(t, 2), p) >= 0 &&
            plan_area2(at(t, 2), at(t, 0), p) >= 0)
          found = t;
      }
    });
    return found;
  }

  [[nodiscard]] const Vec3& at(std::uint32_t t, std::size_t k) const {
    return mesh_.positions[mesh_.triangles[t][k]];
  }

  static double to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 n = (b - a).cross(c - a);
    const Vec3 corner[3] = {a, b, c};
    bool inside = true;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const Vec3 &u = corner[k], &v = corner[(k + 1) % 3];
      const Vec3 e = v - u;
      inside = inside && n.dot(e.cross(p - u)) >= 0;
      const double s = std::clamp(e.dot(p - u) / std::max(e.squaredNorm(), 1e-300), 0.0, 1.0);
      least = std::min(least, (p - u - s * e).norm());
    }
    return inside && n.norm() > 0 ? std::min(least, std::fabs(n.dot(p - a)) / n.norm()) : least;
  }

 private:
  template <class Self, class Do>
  static void bins_of(Self& self, const Vec2& low, const Vec2& high, Do act) {
    const auto clip = [&](double v, double d) {
      return static_cast<int>(std::clamp(std::floor(v / d), 0.0, self.side_ - 1.0));
    };
    const int i0 = clip(low.x() - self.x0_, self.dx_), i1 = clip(high.x() - self.x0_, self.dx_);
    const int j0 = clip(low.y() - self.y0_, self.dy_), j1 = clip(high.y() - self.y0_, self.dy_);
    for (int j = j0; j <= j1; ++j) {
      for (int i = i0; i <= i1; ++i) act(self.bins_[static_cast<std::size_t>(j * self.side_ + i)]);
    }
  }
  template <class Do>
  void each_bin(const Vec2& low, const Vec2& high, Do act) const {
    bins_of(*this, low, high, act);
  }
  template <class Do>
  void each_bin(const Vec2& low, const Vec2& high, Do act) {
    bins_of(*this, low, high, act);
  }

  const TriangleMesh& mesh_;
  double x0_, y0_, dx_ = 1, dy_ = 1;
  int side_ = 1;
  std::vector<std::vector<std::uint32_t>> bins_;
};

// Of the size: what is narrower in plan no mesh has to show.
inline constexpr double kHair = 1e-9;

// Whether the surface, completed by its walls, comes within `t` of p: the ball about p reaches both
// above and below it, or a point of it lies in the ball. `effort`: directions. Where the ball
// reaches over the surface's outline the last point before it counts, which is steep there at a
// silhouette and would be missed. Beside p it is looked for at every scale: the walls of a shaft
// may stand a thousandth of `t` apart.
inline bool surface_within(const CompoundSurface& surface, const Vec3& p, double t, int effort) {
  bool above = false, below = false;
  const bool over_surface = surface.at(p.x(), p.y()).has_value();
  const auto reaches_outline = [&](const Vec3& beyond) {
    Vec3 in = p, out = beyond;
    for (int k = 0; k < 60; ++k) {
      const Vec3 m = 0.5 * (in + out);
      (surface.at(m.x(), m.y()) ? in : out) = m;
    }
    const std::optional<CcDatum> last = surface.at(in.x(), in.y());
    if (!last) return false;
    above = above || in.z() >= last->z;
    below = below || in.z() <= last->z;
    return (above && below) || (Vec3(in.x(), in.y(), last->z) - p).norm() <= t;
  };
  const auto see = [&](const Vec3& q) {
    const std::optional<CcDatum> hit = surface.at(q.x(), q.y());
    if (!hit) return over_surface && reaches_outline(q);
    above = above || q.z() >= hit->z;
    below = below || q.z() <= hit->z;
    return (above && below) || (Vec3(q.x(), q.y(), hit->z) - p).norm() <= t;
  };
  if (see(p) || see(p + Vec3(0, 0, t)) || see(p - Vec3(0, 0, t))) return true;
  if (effort >= 200) {
    for (double r = 1e-10 * surface.size(); r < t; r *= 3) {
      for (int i = 0; i < 16; ++i) {
        const double turn = 2 * std::numbers::pi * (i + 0.37) / 16;
        if (see(p + r * Vec3(std::cos(turn), std::sin(turn), 0))) return true;
      }
    }
  }
  for (const double r : {1.0, 0.6, 0.2}) {
    for (int i = 0; i < effort; ++i) {
      const double z = 1 - (2 * i + 1.0) / effort, s = std::sqrt(1 - z * z);
      const double turn = std::numbers::pi * (1 + std::sqrt(5.0)) * i;
      if (see(p + r * t * Vec3(s * std::cos(turn), s * std::sin(turn), z))) return true;
    }
    if (effort < 200) break;
  }
  return false;
}

// Whether an upright line between the two heights of a change of label comes within `t` of p: so is
// the rim of a knife's edge found, over which the ball reaches for a millionth of its width.
inline bool change_within(const CompoundSurface& surface, const Vec3& p, double t) {
  const std::optional<CcDatum> here = surface.at(p.x(), p.y());
  if (!here) return false;
  constexpr int kDirections = 256;
  for (int i = 0; i < kDirections; ++i) {
    const double turn = 2 * std::numbers::pi * (i + 0.37) / kDirections;
    Vec2 in = p.head<2>(), out = in + t * Vec2(std::cos(turn), std::sin(turn));
    std::optional<CcDatum> one = here, other = surface.at(out.x(), out.y());
    if (other && other->row == here->row && other->face == here->face) continue;
    for (int k = 0; k < 60; ++k) {
      const Vec2 m = 0.5 * (in + out);
      const std::optional<CcDatum> hit = surface.at(m.x(), m.y());
      const bool same = hit && hit->row == here->row && hit->face == here->face;
      (same ? in : out) = m;
      (same ? one : other) = hit;
    }
    // A hair of another face may run along the change: the height behind it counts as well.
    const std::optional<CcDatum> behind =
        surface.at(out.x() + kHair * surface.size() * std::cos(turn),
                   out.y() + kHair * surface.size() * std::sin(turn));
    if (!other || !behind) continue;
    const double low = std::min({one->z, other->z, behind->z});
    const double high = std::max({one->z, other->z, behind->z});
    const Vec3 nearest(out.x(), out.y(), std::clamp(p.z(), low, high));
    if ((nearest - p).norm() <= t) return true;
  }
  return false;
}

inline bool surface_within(const CompoundSurface& surface, const Vec3& p, double t) {
  return surface_within(surface, p, t, 40) || surface_within(surface, p, t, 3000) ||
         change_within(surface, p, t);
}

// Random points of the mesh within `t` of the surface, random points of the surface and points on
// either side of its label changes within `t` of the mesh; labels of plan points the same, but for
// the plan within reach of their curves.
inline void check_deviation(const CompoundSurface& surface, const Tessellation& made, double t,
                            int samples, std::uint64_t seed, Faults& faults) {
  const TriangleMesh& mesh = made.mesh;
  const auto& d = made.report.domain;
  const MeshInPlan plan(mesh, d);
  const double slack = t * (1 + 1e-6) + 1e-11 * surface.size();
  Random random(seed);
  Tally off, far, hole, label, change;
  for (int k = 0; k < samples && off.count < 4; ++k) {  // proving a fault is slow
    const auto triangle =
        static_cast<std::uint32_t>(random.below(static_cast<int>(mesh.triangles.size())));
    double u = random.uniform(0, 1), v = random.uniform(0, 1);
    const ElementRole role = role_of(mesh, triangle);
    if (role == ElementRole::kSkirt || role == ElementRole::kFloor) continue;
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const Vec3 a = plan.at(triangle, 0);
    const Vec3 p = a + u * (plan.at(triangle, 1) - a) + v * (plan.at(triangle, 2) - a);
    if (!surface_within(surface, p, slack)) off(p);
  }
  std::map<std::string, std::uint32_t> element_of;
  for (std::uint32_t e = 0; e < mesh.elements.size(); ++e) element_of[mesh.elements[e].name] = e;
  const auto element = [&](const CcDatum& hit) {
    const auto it = element_of.find(
        surface.element_name(make_label(hit.row, static_cast<std::uint32_t>(hit.face))));
    return it == element_of.end() ? MeshCurve::kNoElement : it->second;
  };
  Vec2 last(0, 0);
  std::optional<CcDatum> last_hit;
  for (int k = 0; k < samples; ++k) {
    const double x = random.uniform(d[0], d[1]), y = random.uniform(d[2], d[3]);
    const std::optional<CcDatum> hit = surface.at(x, y);
    const std::optional<std::uint32_t> triangle = plan.over(x, y);
    if (hit) {
      const Vec3 p(x, y, hit->z);
      if (!(plan.distance(p, slack) <= slack)) {
        triangle ? far(p) : hole(p);
      } else if (triangle && mesh.triangle_element[*triangle] != element(*hit)) {
        // Its own element has to be within reach, or another that cannot be told from it.
        const std::uint32_t own = element(*hit);
        const bool near = own != MeshCurve::kNoElement && plan.distance(p, slack, own) <= slack;
        if (!near) label(p);
      }
    } else if (triangle) {
      const Vec3 a = plan.at(*triangle, 0), b = plan.at(*triangle, 1), c = plan.at(*triangle, 2);
      const double whole = plan_area2(a, b, c), wb = plan_area2(a, Vec3(x, y, 0), c) / whole,
                   wc = plan_area2(a, b, Vec3(x, y, 0)) / whole;
      const Vec3 p = a + wb * (b - a) + wc * (c - a);
      if (!surface_within(surface, p, slack)) off(p);
    }
    // Where labels change between this point and the last: both ends of the change are on the mesh.
    if (hit && last_hit && (hit->row != last_hit->row || hit->face != last_hit->face)) {
      Vec2 p = last, q(x, y);
      CcDatum ph = *last_hit;
      bool broken = false;
      for (int i = 0; i < 60 && !broken; ++i) {
        const Vec2 m = 0.5 * (p + q);
        const std::optional<CcDatum> h = surface.at(m.x(), m.y());
        if (!h) {
          broken = true;
        } else if (h->row == ph.row && h->face == ph.face) {
          p = m;
          ph = *h;
        } else {
          q = m;
        }
      }
      const Vec2 hair = kHair * surface.size() * (Vec2(x, y) - last).normalized();
      for (const Vec2& end : {Vec2(p - hair), Vec2(q + hair)}) {
        const std::optional<CcDatum> beside = surface.at(end.x(), end.y());
        if (broken || !beside) continue;
        const Vec3 place(end.x(), end.y(), beside->z);
        if (!(plan.distance(place, slack) <= slack)) change(place);
      }
    }
    last = Vec2(x, y);
    last_hit = hit;
  }
  faults.add("points of the mesh off the surface", off.count, off.first);
  faults.add("points of the surface off the mesh", far.count, far.first);
  faults.add("plan points with a surface and no mesh", hole.count, hole.first);
  faults.add("points far from any triangle of their element", label.count, label.first);
  faults.add("label changes off the mesh", change.count, change.first);
}

// First-order distance of a point to the whole plane or quadric of a face, from the definitions of
// the bodies alone (of the base: from its height).
inline double face_distance(const CompoundSurface& surface, Label label, const Vec3& r) {
  const int number = surface.surface_of_row(row_of(label));
  if (number == 0) {
    if (const auto* plane = std::get_if<PlaneBase>(&surface.program().base))
      return std::fabs(plane->normal.dot(r - plane->point));
    BaseHit hit;
    if (!surface.impl().base_at(r.x(), r.y(), hit)) return 0;  // its border, within rounding
    return std::fabs(r.z() - hit.z) / std::sqrt(1 + hit.zx * hit.zx + hit.zy * hit.zy);
  }
  const Body& body = surface.program().solids[static_cast<std::size_t>(number - 1)].body;
  const int face = face_of(label);
  if (const auto* polyhedron = std::get_if<Polyhedron>(&body)) {
    for (const PolyhedronFace& f : polyhedron->faces) {
      if (f.number == face) return std::fabs(f.plane.n.dot(r - polyhedron->vertices[f.loop[0]]));
    }
    return std::numeric_limits<double>::infinity();
  }
  const QuadricBody& q = std::get<QuadricBody>(body);
  const Vec3 local = q.frame * (r - q.p);
  if (face != kFaceSide) return std::fabs(local.z() - (face == kFaceTop ? q.C : 0));
  const double u = local.x() / q.A, v = local.y() / q.B, w = local.z() / q.C;
  double value = 0;
  Vec3 gradient(2 * u / q.A, 2 * v / q.B, 0);
  switch (q.shape) {
    case QuadricShape::kEllipsoid:
      value = u * u + v * v + w * w - 1;
      gradient.z() = 2 * w / q.C;
      break;
    case QuadricShape::kCylinder:
      value = u * u + v * v - 1;
      break;
    case QuadricShape::kCone:
      if (std::hypot(local.x(), local.y(), local.z() - q.C) < 1e-9 * q.C) return 0;
      value = u * u + v * v - (1 - w) * (1 - w);
      gradient.z() = 2 * (1 - w) / q.C;
      break;
    case QuadricShape::kParaboloid: {
      const double s = local.x() / q.A, t = local.y() / q.A;
      value = s * s + t * t - local.z();
      gradient = Vec3(2 * s / q.A, 2 * t / q.A, -1);
      break;
    }
  }
  return std::fabs(value) / std::max(gradient.norm(), 1e-300);
}

// Whether an upright wall of the base stands within `reach` of p: it is above and below there.
inline bool base_wall_within(const CompoundSurface& surface, const Vec3& p, double reach) {
  bool above = false, below = false;
  for (int k = 0; k < 48; ++k) {
    const double turn = std::numbers::pi * k / 24;
    BaseHit hit;
    if (!surface.impl().base_at(p.x() + reach * std::cos(turn), p.y() + reach * std::sin(turn),
                                hit))
      continue;
    above = above || p.z() >= hit.z - reach;
    below = below || p.z() <= hit.z + reach;
  }
  return above && below;
}

// The vertices of every curve on the faces that meet there, to 1e-9 of the size; curves run along
// sides of triangles. A scanned base is met to `base_slack`, its upright walls to
// `wall_reach` sideways, and what lies there to the least cell. Returns the largest distance.
inline double check_curves(const CompoundSurface& surface, const Tessellation& made, Faults& faults,
                           double base_slack = 0, double wall_reach = 0) {
  const TriangleMesh& mesh = made.mesh;
  std::multimap<std::string, Label> labels;  // a solid may stand in several rows
  for (int row = 0; row < surface.row_count(); ++row) {
    for (std::uint32_t face = 0; face < 16; ++face) {
      const int number = surface.surface_of_row(row);
      if (number == 0) {
        if (face == 0) labels.emplace(surface.element_name(make_label(row, 0)), make_label(row, 0));
        continue;
      }
      const Body& body = surface.program().solids[static_cast<std::size_t>(number - 1)].body;
      for (const std::uint8_t n : face_numbers(body)) {
        if (n == face)
          labels.emplace(surface.element_name(make_label(row, face)), make_label(row, face));
      }
    }
  }
  const auto distance = [&](std::uint32_t element, const Vec3& r) {
    const auto [first, last] = labels.equal_range(mesh.elements[element].name);
    double least = std::numeric_limits<double>::infinity();
    for (auto it = first; it != last; ++it) {
      const bool base = surface.surface_of_row(row_of(it->second)) == 0;
      const double away = face_distance(surface, it->second, r);
      if (base && wall_reach > 0 && away > 0 && base_wall_within(surface, r, wall_reach))
        return 0.0;
      least = std::min(least, base ? std::max(away - base_slack, 0.0) : away);
    }
    return least;
  };
  std::vector<std::uint64_t> sides;
  for (const auto& v : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = v[k], b = v[(k + 1) % 3];
      sides.push_back(a < b ? a << 32 | b : b << 32 | a);
    }
  }
  std::sort(sides.begin(), sides.end());
  const double limit = 1e-9 * surface.size();
  Tally off, loose;
  double worst = 0;
  for (const MeshCurve& curve : mesh.curves) {
    const std::size_t n = curve.vertices.size();
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3& r = mesh.positions[curve.vertices[k]];
      double residual = 0, nearer = std::numeric_limits<double>::infinity();
      for (const std::uint32_t e : curve.between) {
        if (e == MeshCurve::kNoElement) continue;
        const double away = distance(e, r);
        residual = std::max(residual, away);
        nearer = std::min(nearer, away);
      }
      if (curve.kind == CurveKind::kJump) residual = nearer;  // one side of a wall
      worst = std::max(worst, residual);
      const bool at_wall = wall_reach > 0 && base_wall_within(surface, r, wall_reach);
      if (!(residual <= (at_wall ? 0x1p-21 * surface.size() : limit))) off(r);
      if (k + 1 == n && !curve.closed) break;
      const std::uint64_t a = curve.vertices[k], b = curve.vertices[(k + 1) % n];
      if (a == b) {
        loose(r);
      } else if (!std::binary_search(sides.begin(), sides.end(),
                                     a < b ? a << 32 | b : b << 32 | a)) {
        loose(r);
      }
    }
  }
  if (off.count > 0) faults.add("largest distance of a curve's vertex to its faces", worst, limit);
  faults.add("vertices of curves off their faces", off.count, off.first);
  faults.add("curves that run off the sides of triangles", loose.count, loose.first);
  return worst;
}

}  // namespace diesink::test
