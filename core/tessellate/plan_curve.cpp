// Newton's method on the exact equations of curves and of their common points.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/plan_curve.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "core/tessellate/outline.h"

namespace diesink {
namespace {

constexpr int kNewtonSteps = 24;
// Of the size: how far a common point of surfaces may be from each, half of what vertices of curves
// are held to.
constexpr double kCommon = 5e-10;

}  // namespace

CurveSolver::CurveSolver(const CompoundSurface::Impl& surface) : surface_(&surface) {
  for (const CompoundStep& step : surface.steps) {
    if (step.kind == BooleanStep::Kind::kTerm && step.solid < 0)
      base_label_ = make_label(step.first_row, 0);
  }
}

Implicit CurveSolver::implicit(const SurfaceRef& ref) const {
  if (ref.solid == SurfaceRef::kBase) {
    if (ref.facet != SurfaceRef::kWhole) return facet_implicit(*surface_, ref.facet);
    return face_implicit(*surface_, base_label_);
  }
  const BodyLine& body = surface_->bodies[static_cast<std::size_t>(ref.solid)];
  if (ref.face == SurfaceRef::kSilhouetteFace) return silhouette_implicit(body);
  return face_implicit(body, ref.face);
}

std::optional<Implicit> CurveSolver::upright(const PlanCurve& curve) const {
  if (curve.type != CurveType::kShadow || curve.first.solid < 0) return std::nullopt;
  for (const SurfaceRef& ref : {curve.first, curve.second}) {
    if (ref.solid < 0 || ref.face == SurfaceRef::kSilhouetteFace) continue;
    const Implicit f = implicit(ref);
    if (f.kind == Implicit::Kind::kPlane
            ? f.n.z() == 0
            : f.k.z() == 0 && f.l == 0 && f.frame(0, 2) == 0 && f.frame(1, 2) == 0)
      return f;
  }
  const auto* body = std::get_if<QuadricBody>(
      &surface_->bodies[static_cast<std::size_t>(curve.first.solid)].body());
  if (curve.second.face != SurfaceRef::kSilhouetteFace || body == nullptr ||
      body->shape != QuadricShape::kEllipsoid)
    return std::nullopt;
  // r'Q r = 1 has one root over the plan where r'Sr = 1, S what is left of Q without z.
  const Mat3 q =
      body->frame.transpose() *
      Vec3(1 / (body->A * body->A), 1 / (body->B * body->B), 1 / (body->C * body->C)).asDiagonal() *
      body->frame;
  const double xx = q(0, 0) - q(0, 2) * q(0, 2) / q(2, 2),
               xy = q(0, 1) - q(0, 2) * q(1, 2) / q(2, 2),
               yy = q(1, 1) - q(1, 2) * q(1, 2) / q(2, 2);
  const double turn = 0.5 * std::atan2(2 * xy, xx - yy), c = std::cos(turn), s = std::sin(turn);
  Implicit f;
  f.kind = Implicit::Kind::kQuadric;
  f.c = body->p;
  f.frame << c, s, 0, -s, c, 0, 0, 0, 1;
  const double scale = 0.5 * std::fmin(std::fmin(body->A, body->B), body->C);  // a length
  f.k = scale *
        Vec3(xx * c * c + 2 * xy * c * s + yy * s * s, xx * s * s - 2 * xy * c * s + yy * c * c, 0);
  f.m = -scale;
  return f;
}

SurfaceRef CurveSolver::ref_of(Label label) const {
  if (label == kNoLabel) return {};
  const CompoundStep& step =
      surface_->steps[surface_->step_of_row[static_cast<std::size_t>(row_of(label))]];
  if (step.solid < 0) return {SurfaceRef::kBase, 0};
  return {step.solid, static_cast<std::uint8_t>(face_of(label))};
}

bool CurveSolver::height(Label label, double x, double y, double& z) const {
  const CompoundStep& step =
      surface_->steps[surface_->step_of_row[static_cast<std::size_t>(row_of(label))]];
  if (step.solid < 0) {
    BaseHit hit;
    if (!surface_->base_at(x, y, hit)) return false;
    z = hit.z;
    return true;
  }
  const BodyLine& body = surface_->bodies[static_cast<std::size_t>(step.solid)];
  if (!body.face_height(static_cast<std::uint8_t>(face_of(label)), step.sign == Sign::kPlus, x, y,
                        z)) {
    return false;
  }
  // Beside its body a face's surface may run off to anywhere (the other nappe of a cone): no height
  // then.
  const double near = 1e-6 * surface_->size;
  return z >= body.z_low() - near && z <= body.z_high() + near;
}

bool CurveSolver::silhouette_height(Label label, double x, double y, double& z) const {
  const CompoundStep& step =
      surface_->steps[surface_->step_of_row[static_cast<std::size_t>(row_of(label))]];
  if (step.solid < 0 || face_of(label) != kFaceSide) return false;
  const BodyLine& body = surface_->bodies[static_cast<std::size_t>(step.solid)];
  const SideQuadratic& s = body.side();
  if (!body.has_side() || body.side_rule() != SideRule::kBetween || !(s.q2 > 0)) return false;
  z = s.cz - (s.b0 + s.bx * (x - s.cx) + s.by * (y - s.cy)) / s.q2;
  return true;
}

double CurveSolver::shadow_height(const PlanCurve& curve, double x, double y) const {
  const BodyLine& body = surface_->bodies[static_cast<std::size_t>(curve.first.solid)];
  const SideQuadratic& s = body.side();
  double z = 0;
  if (curve.second.face == SurfaceRef::kSilhouetteFace && s.q2 > 0) {
    return s.cz - (s.b0 + s.bx * (x - s.cx) + s.by * (y - s.cy)) / s.q2;
  }
  // A cap is flat: its height is the curve's wherever the curve is. Else the side, on either sheet.
  for (const SurfaceRef& ref : {curve.first, curve.second}) {
    if (body.has_side() && ref.face == kFaceSide) continue;
    for (const bool upper : {true, false}) {
      if (body.face_height(ref.face, upper, x, y, z)) return z;
    }
  }
  for (const bool upper : {curve.upper, !curve.upper}) {
    if (body.face_height(curve.first.face, upper, x, y, z)) return z;
  }
  return 0.5 * (body.z_low() + body.z_high());
}

// A cone ends in its apex; its quadric goes on beyond, with another curve on every surface that its
// own curves lie on.
bool CurveSolver::beyond_apex(const SurfaceRef& ref, const Vec3& p) const {
  if (ref.solid < 0) return false;
  const auto* cone =
      std::get_if<QuadricBody>(&surface_->bodies[static_cast<std::size_t>(ref.solid)].body());
  return cone != nullptr && cone->shape == QuadricShape::kCone &&
         cone->frame.row(2).dot(p - cone->p) > cone->C + kOnFace * surface_->size;
}

bool CurveSolver::on_line(const PlanCurve& curve, const Vec2& p, const Vec2& d, double& t,
                          double& z) const {
  if (curve.type != CurveType::kMeet && curve.type != CurveType::kShadow) return false;
  const Implicit f = implicit(curve.first), g = implicit(curve.second);
  const double unit = d.norm();
  if (!(unit > 0)) return false;
  const double done =
      std::ldexp(surface_->size, -50);  // a step below some ulp of the size is rounding
  const auto is_own = [&] {
    const Vec3 r(p.x() + t * d.x(), p.y() + t * d.y(), z);
    return !beyond_apex(curve.first, r) && !beyond_apex(curve.second, r);
  };
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kNewtonSteps; ++k) {
    const Vec3 r(p.x() + t * d.x(), p.y() + t * d.y(), z);
    Vec3 gf, gg;
    const double vf = f.evaluate(r, gf), vg = g.evaluate(r, gg);
    const double ft = gf.x() * d.x() + gf.y() * d.y(), gt = gg.x() * d.x() + gg.y() * d.y();
    const double det = ft * gg.z() - gf.z() * gt;
    if (!(std::fabs(det) > 1e-14 * unit) || !std::isfinite(vf) || !std::isfinite(vg)) return false;
    const double dt = -(vf * gg.z() - gf.z() * vg) / det;
    const double dz = -(ft * vg - vf * gt) / det;
    const double step = std::fabs(dt) * unit + std::fabs(dz);
    if (!(step < 1e3 * surface_->size)) return false;
    t += dt;
    z += dz;
    if (step <= done || (k > 3 && step >= last && step <= 64 * done)) return is_own();
    last = step;
  }
  return last <= 4096 * done && is_own();
}

bool CurveSolver::corner(const PlanCurve& one, const PlanCurve& two, Vec2& at, double& z1,
                         double& z2) const {
  if (one.type == CurveType::kUnsolved || two.type == CurveType::kUnsolved) return false;
  if (one.type == CurveType::kOutline || two.type == CurveType::kOutline) {
    if (one.type == two.type) {
      Vec3 vertex;
      if (!outline_vertex(*surface_, one.second.face, two.second.face, vertex)) return false;
      at = vertex.head<2>();
      z1 = z2 = vertex.z();
      return true;
    }
    const bool first = one.type == CurveType::kOutline;
    const PlanCurve& curve = first ? two : one;
    return outline_corner(*surface_, implicit(curve.first), implicit(curve.second), at,
                          first ? z2 : z1, first ? z1 : z2);
  }
  const Implicit f[4] = {implicit(one.first), implicit(one.second), implicit(two.first),
                         implicit(two.second)};
  const SurfaceRef refs[4] = {one.first, one.second, two.first, two.second};
  // A surface that both curves lie on: three equations in (x, y, z).
  int shared = -1;
  for (int i = 0; i < 2; ++i) {
    for (int j = 2; j < 4; ++j) {
      if (refs[i] == refs[j]) shared = j;
    }
  }
  // Surfaces that have no common point, as a bar's silhouette and a plane level with it but for
  // last digits, have a best one.
  const auto holds = [&] {
    for (int i = 0; i < 4; ++i) {
      const Vec3 p(at.x(), at.y(), i < 2 ? z1 : z2);
      if (!(std::fabs(f[i].value(p)) <= kCommon * surface_->size) || beyond_apex(refs[i], p))
        return false;
    }
    return true;
  };
  const double done = std::ldexp(surface_->size, -50);
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 2 * kNewtonSteps; ++k) {
    Vec3 g[4];
    double v[4];
    for (int i = 0; i < 4; ++i) v[i] = f[i].evaluate(Vec3(at.x(), at.y(), i < 2 ? z1 : z2), g[i]);
    double step = 0;
    if (shared >= 0) {
      const int other = shared == 2 ? 3 : 2;
      Mat3 m;
      m << g[0].transpose(), g[1].transpose(), g[other].transpose();
      const Vec3 delta = m.fullPivLu().solve(-Vec3(v[0], v[1], v[other]));
      if (!delta.allFinite()) return false;
      at += delta.head<2>();
      z1 += delta.z();
      z2 = z1;
      step = delta.cwiseAbs().maxCoeff();
    } else {
      Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
      for (int i = 0; i < 4; ++i) {
        m(i, 0) = g[i].x();
        m(i, 1) = g[i].y();
        m(i, i < 2 ? 2 : 3) = g[i].z();
      }
      const Eigen::Vector4d delta = m.fullPivLu().solve(-Eigen::Vector4d(v[0], v[1], v[2], v[3]));
      if (!delta.allFinite()) return false;
      at += delta.head<2>();
      z1 += delta[2];
      z2 += delta[3];
      step = delta.cwiseAbs().maxCoeff();
    }
    if (!(step < 1e3 * surface_->size)) return false;
    if (step <= done || (k > 3 && step >= last && step <= 64 * done)) return holds();
    last = step;
  }
  return last <= 4096 * done && holds();
}

bool CurveSolver::double_point(const PlanCurve& curve, Vec2& at, double& z) const {
  if (curve.type != CurveType::kMeet) return false;
  const Implicit f[2] = {implicit(curve.first), implicit(curve.second)};
  constexpr double kLeastUpright = 1e-3;  // of a normal: beside silhouettes slopes say nothing
  const double done = std::ldexp(surface_->size, -50);
  double heights[2] = {z, z};
  const auto slope = [&](int i, const Vec2& p, Vec2& out) {
    Vec3 g;
    for (int k = 0; k < kNewtonSteps; ++k) {
      const double v = f[i].evaluate({p.x(), p.y(), heights[i]}, g);
      if (!(std::fabs(g.z()) > kLeastUpright) || !std::isfinite(v)) return false;
      heights[i] -= v / g.z();
      if (std::fabs(v) <= done) break;
    }
    out = -g.head<2>() / g.z();
    return true;
  };
  // How the difference of slopes changes, by differences over so much of the plan.
  const double apart = 1e-6 * surface_->size;
  const auto difference = [&](const Vec2& p, Vec2& out) {
    Vec2 one, two;
    if (!slope(0, p, one) || !slope(1, p, two)) return false;
    out = one - two;
    return true;
  };
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kNewtonSteps; ++k) {
    Vec2 beside_x, beside_y, here;
    if (!difference(at + Vec2(apart, 0), beside_x) || !difference(at + Vec2(0, apart), beside_y) ||
        !difference(at, here)) {
      return false;
    }
    Eigen::Matrix2d m;
    m << (beside_x - here) / apart, (beside_y - here) / apart;
    const Vec2 delta = m.fullPivLu().solve(-here);
    const double step = delta.cwiseAbs().maxCoeff();
    if (!(step < 1e-2 * surface_->size)) return false;
    at += delta;
    if (step <= done || (k > 3 && step >= last)) {
      Vec2 unused;
      if (step > 4096 * done || !slope(0, at, unused) || !slope(1, at, unused)) return false;
      z = heights[0];
      return std::fabs(heights[0] - heights[1]) <= 1e-9 * surface_->size;
    }
    last = step;
  }
  return false;
}

bool CurveSolver::cross_at(const PlanCurve& one, const PlanCurve& two, const Vec2& at, double z1,
                           double z2) const {
  const auto has_equations = [](const PlanCurve& curve) {
    return curve.type == CurveType::kMeet || curve.type == CurveType::kShadow;
  };
  if (!has_equations(one) || !has_equations(two)) return true;
  const auto way = [&](const PlanCurve& curve, double z) {
    Vec3 a, b;
    implicit(curve.first).evaluate(Vec3(at.x(), at.y(), z), a);
    implicit(curve.second).evaluate(Vec3(at.x(), at.y(), z), b);
    return Vec2(a.cross(b).head<2>());
  };
  // A sine below which half the digits of the common point are lost.
  constexpr double kAlong = 1e-6;
  const Vec2 u = way(one, z1), v = way(two, z2);
  return std::fabs(u.x() * v.y() - u.y() * v.x()) > kAlong * u.norm() * v.norm();
}

bool CurveSolver::on_sheet(Label label, const Vec2& p, double z) const {
  double middle = 0;
  if (!silhouette_height(label, p.x(), p.y(), middle)) return true;
  const bool plus =
      surface_->steps[surface_->step_of_row[static_cast<std::size_t>(row_of(label))]].sign ==
      Sign::kPlus;
  return plus ? z >= middle - 4 * surface_->tie : z <= middle + 4 * surface_->tie;
}

// Where a face is all but upright its surface passes through everything far below its body within a
// hair of where the body ends: a meeting with those is none.
bool CurveSolver::on_face(Label label, const Vec2& p, double z) const {
  const SurfaceRef own = ref_of(label);
  if (own.solid < 0) return true;
  const BodyLine& body = surface_->bodies[static_cast<std::size_t>(own.solid)];
  const double dx = p.x() - body.center_x(), dy = p.y() - body.center_y();
  const double close = kOnFace * surface_->size;
  for (const bool upper : {true, false}) {
    for (const PlanarCap& cap : upper ? body.upper_caps() : body.lower_caps()) {
      const double above = z - (cap.z0 + cap.zx * dx + cap.zy * dy);
      const double slack = close + std::hypot(cap.zx, cap.zy) * surface_->tie;
      if (cap.face != own.face && (upper ? above > slack : above < -slack)) return false;
    }
  }
  if (beyond_apex(own, {p.x(), p.y(), z})) return false;
  if (!body.has_side() || own.face == kFaceSide) return on_sheet(label, p, z);
  Vec3 gradient;
  return implicit({own.solid, kFaceSide}).evaluate({p.x(), p.y(), z}, gradient) <= close;
}

void join_heights(std::vector<LabelHeight>& heights, double close) {
  for (std::size_t i = 0; i < heights.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (std::fabs(heights[i].z - heights[j].z) <= close) heights[i].z = heights[j].z;
    }
  }
}

}  // namespace diesink
