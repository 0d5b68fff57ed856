// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/implicit.h"

#include <cassert>
#include <cmath>
#include <limits>

#include "core/compound/compound_impl.h"

namespace diesink {
namespace {

Implicit plane_through(const Vec3& point, const Vec3& n) {
  Implicit f;
  f.kind = Implicit::Kind::kPlane;
  f.c = point;
  f.n = n;
  return f;
}

// The quadric in the body's own axes. One matrix in program coordinates would lose the short axes
// of long bodies to rounding.
Implicit quadric_side(const QuadricBody& body) {
  Implicit f;
  f.kind = Implicit::Kind::kQuadric;
  f.frame = body.frame;
  f.c = body.p;
  const double ka = 1 / (body.A * body.A), kb = 1 / (body.B * body.B), kc = 1 / (body.C * body.C);
  double scale = 0.5 * std::fmin(body.A, body.B);
  f.k = Vec3(ka, kb, 0);
  switch (body.shape) {
    case QuadricShape::kEllipsoid:
      scale = 0.5 * std::fmin(std::fmin(body.A, body.B), body.C);
      f.k.z() = kc;
      f.m = -1;
      break;
    case QuadricShape::kCylinder:
      f.m = -1;
      break;
    case QuadricShape::kCone:  // about its apex
      f.c = body.p + body.C * body.frame.row(2).transpose();
      f.k.z() = -kc;
      break;
    case QuadricShape::kParaboloid:  // w is a length already
      scale = 1;
      f.l = -1;
      break;
  }
  f.k *= scale;
  f.m *= scale;
  return f;
}

double base_form(const CompoundSurface::Impl& surface, const Vec3& r, Vec3& gradient) {
  BaseHit hit;
  if (!surface.base_at(r.x(), r.y(), hit)) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    gradient = Vec3(kNan, kNan, kNan);
    return kNan;
  }
  gradient = Vec3(-hit.zx, -hit.zy, 1);
  return r.z() - hit.z;
}

// Unbounded for bases that are not a function with two derivatives.
BaseBounds base_bounds(const CompoundSurface::Impl& surface, const PlanBox& box) {
  if (const FergusonSurface* ferguson = std::get_if<FergusonSurface>(&surface.base)) {
    return ferguson->bounds(box);
  }
  if (const PlaneSurface* plane = std::get_if<PlaneSurface>(&surface.base)) {
    return plane->bounds(box);
  }
  return {};
}

}  // namespace

double Implicit::form(const Vec3& r, Vec3& gradient) const {
  switch (kind) {
    case Kind::kPlane:
      gradient = n;
      return n.dot(r - c) - d;
    case Kind::kQuadric: {
      const Vec3 q = frame * (r - c);
      const Vec3 kq = k.cwiseProduct(q);
      gradient = frame.transpose() * Vec3(2 * kq.x(), 2 * kq.y(), 2 * kq.z() + l);
      return kq.dot(q) + l * q.z() + m;
    }
    case Kind::kBase:
      break;
  }
  return base_form(*surface, r, gradient);
}

double Implicit::evaluate(const Vec3& r, Vec3& gradient) const {
  const double f = form(r, gradient);
  const double length = gradient.norm();
  if (length == 0) return kind == Kind::kPlane ? f : (f > 0) - (f < 0);
  gradient /= length;
  return f / length;
}

HessianBound Implicit::hessian(const Vec3& a, const Vec3& b, double margin) const {
  HessianBound bound;
  if (kind == Kind::kQuadric) {
    bound.middle = 2 * frame.transpose() * k.asDiagonal() * frame;
  } else if (kind == Kind::kBase) {
    const Vec3 low = a.cwiseMin(b), high = a.cwiseMax(b);
    const BaseBounds b_over = base_bounds(
        *surface, {low.x() - margin, high.x() + margin, low.y() - margin, high.y() + margin});
    const auto middle = [](const Range& range) { return 0.5 * (range.lo + range.hi); };
    const auto half = [](const Range& range) { return 0.5 * (range.hi - range.lo); };
    if (b_over.coverage == Coverage::kOutside || !std::isfinite(half(b_over.zxx)) ||
        !std::isfinite(half(b_over.zxy)) || !std::isfinite(half(b_over.zyy))) {
      bound.spread = std::numeric_limits<double>::infinity();
      return bound;
    }
    bound.middle(0, 0) = -middle(b_over.zxx);
    bound.middle(0, 1) = bound.middle(1, 0) = -middle(b_over.zxy);
    bound.middle(1, 1) = -middle(b_over.zyy);
    bound.spread =
        std::sqrt(half(b_over.zxx) * half(b_over.zxx) + 2 * half(b_over.zxy) * half(b_over.zxy) +
                  half(b_over.zyy) * half(b_over.zyy));
  }
  return bound;
}

Implicit face_implicit(const BodyLine& body, std::uint8_t face) {
  if (const Polyhedron* polyhedron = std::get_if<Polyhedron>(&body.body())) {
    for (const PolyhedronFace& f : polyhedron->faces) {
      if (f.number == face) return plane_through(polyhedron->vertices[f.loop[0]], f.plane.n);
    }
    assert(false && "no such face");
    return {};
  }
  const QuadricBody& quadric = std::get<QuadricBody>(body.body());
  const Vec3 a = quadric.frame.row(2);
  if (face == kFaceBottom) return plane_through(quadric.p, -a);
  if (face == kFaceTop) return plane_through(quadric.p + quadric.C * a, a);
  return quadric_side(quadric);
}

Implicit face_implicit(const CompoundSurface::Impl& surface, Label label) {
  const CompoundStep& step =
      surface.steps[surface.step_of_row[static_cast<std::size_t>(row_of(label))]];
  if (step.solid >= 0) {
    return face_implicit(surface.bodies[static_cast<std::size_t>(step.solid)],
                         static_cast<std::uint8_t>(face_of(label)));
  }
  if (const PlaneBase* plane = std::get_if<PlaneBase>(&surface.program.base)) {
    return plane_through(plane->point, plane->normal);
  }
  Implicit f;
  f.kind = Implicit::Kind::kBase;
  f.surface = &surface;
  return f;
}

Implicit facet_implicit(const CompoundSurface::Impl& surface, std::uint32_t facet) {
  const ScannedSurface& scan = std::get<ScannedSurface>(surface.base);
  const std::array<std::uint32_t, 3>& t = scan.triangles()[facet];
  ScannedTriangle plane;
  plane.set(scan.positions()[t[0]], scan.positions()[t[1]], scan.positions()[t[2]]);
  return plane_through({plane.x[0], plane.y[0], plane.z0},
                       Vec3(-plane.zx, -plane.zy, 1).normalized());
}

Implicit silhouette_implicit(const BodyLine& body) {
  // dF/dz is linear: its gradient is the vertical's image under the form's matrix.
  const Implicit f = quadric_side(std::get<QuadricBody>(body.body()));
  const Vec3 vertical = f.frame.col(2);
  const Vec3 n = f.frame.transpose() * (2 * f.k.cwiseProduct(vertical));
  const double d = -f.l * vertical.z();
  Implicit plane = plane_through(f.c, n);
  // Axes nearer to the vertical than BodyLine tells apart count as upright there and here.
  const double reach = f.k.cwiseAbs().maxCoeff();
  const double length = n.norm();
  if (length > 1e-13 * reach) {
    plane.n = n / length;
    plane.d = d / length;
    return plane;
  }
  plane.n = Vec3::Zero();  // value() is -d
  plane.d = static_cast<double>((d > 0) - (d < 0));
  return plane;
}

}  // namespace diesink
