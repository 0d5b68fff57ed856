// Newton's method on the exact equations of a curve, from a pair of points that a few halvings have
// brought near.
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
// Halvings before the curve is looked for, and at most.
constexpr int kHalvings = 5, kAllHalvings = 60;
// Of the size: rounding of heights; on a steep face a tie in plan counts by the slope.
constexpr double kOnFace = 1e-10;

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

bool CurveSolver::on_line(const PlanCurve& curve, const Vec2& p, const Vec2& d, double& t,
                          double& z) const {
  if (curve.type != CurveType::kMeet && curve.type != CurveType::kShadow) return false;
  const Implicit f = implicit(curve.first), g = implicit(curve.second);
  const double unit = d.norm();
  if (!(unit > 0)) return false;
  const double done =
      std::ldexp(surface_->size, -50);  // a step below some ulp of the size is rounding
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
    if (step <= done || (k > 3 && step >= last && step <= 64 * done)) return true;
    last = step;
  }
  return last <= 4096 * done;
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
    if (step <= done || (k > 3 && step >= last && step <= 64 * done)) return true;
    last = step;
  }
  return last <= 4096 * done;
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

bool CurveSolver::touch_along_curve(const SurfaceRef& one, const SurfaceRef& two) const {
  const auto is_side = [&](const SurfaceRef& ref) {
    return ref.solid >= 0 && ref.face == kFaceSide &&
           surface_->bodies[static_cast<std::size_t>(ref.solid)].has_side();
  };
  return is_side(one) && is_side(two) &&
         (surface_->contacts.is_inside(one.solid, two.solid) ||
          surface_->contacts.is_inside(two.solid, one.solid));
}

bool CurveSolver::rim_between(Label a, Label b, const Vec2& p, const Vec2& d, double z_near,
                              Change& change) const {
  for (const bool first : {true, false}) {
    const SurfaceRef own = ref_of(first ? a : b);
    if (own.solid < 0 || own.face != kFaceSide) continue;
    const BodyLine& body = surface_->bodies[static_cast<std::size_t>(own.solid)];
    if (!body.has_side()) continue;
    for (const bool upper : {true, false}) {
      for (const PlanarCap& cap : upper ? body.upper_caps() : body.lower_caps()) {
        const PlanCurve rim{CurveType::kMeet, own, {own.solid, cap.face}};
        double t = 0, z = 0, other = 0;
        if (!try_curve(rim, p, d, z_near, t, z)) continue;
        const Vec2 at = p + t * d;
        const double close = 1e-6 * surface_->size;  // of a height beside a silhouette, and more
        if (!height(first ? b : a, at.x(), at.y(), other) || std::fabs(other - z) > close) continue;
        change.curve = rim;
        change.at = {at.x(), at.y(), z};
        change.za = change.zb = z;
        return true;
      }
    }
  }
  return false;
}

bool CurveSolver::touch_at(const PlanCurve& curve, const Vec2& at, double z) const {
  Vec3 a, b;
  implicit(curve.first).evaluate(Vec3(at.x(), at.y(), z), a);
  implicit(curve.second).evaluate(Vec3(at.x(), at.y(), z), b);
  // A sine below which half the digits of the common curve are lost.
  constexpr double kAlong = 1e-6;
  return a.cross(b).norm() <= kAlong * a.norm() * b.norm();
}

bool CurveSolver::try_curve(const PlanCurve& curve, const Vec2& p, const Vec2& d, double z0,
                            double& t, double& z) const {
  t = 0.5;
  z = z0;
  if (!on_line(curve, p, d, t, z)) return false;
  // The halvings may have ended beside the root: by rounding, of the bracket, or because what lies
  // beside a body by a tie still meets it.
  const double beside = 1e-9 + 4 * surface_->tie / d.norm();
  return t >= -beside && t <= 1 + beside;
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
  // A cone ends in its apex; its quadric goes on beyond.
  const auto* cone = std::get_if<QuadricBody>(&body.body());
  if (cone != nullptr && cone->shape == QuadricShape::kCone &&
      cone->frame.row(2).dot(Vec3(p.x(), p.y(), z) - cone->p) > cone->C + close) {
    return false;
  }
  if (!body.has_side() || own.face == kFaceSide) return on_sheet(label, p, z);
  Vec3 gradient;
  return implicit({own.solid, kFaceSide}).evaluate({p.x(), p.y(), z}, gradient) <= close;
}

// Near where a silhouette touches a rim both curves run on beyond the point of contact, inside the
// shadow: the silhouette is its border only between the caps, the rim only beyond the silhouette.
bool CurveSolver::borders(const BodyLine& body, const PlanCurve& shadow, const Vec2& at,
                          double z) const {
  const SideQuadratic& s = body.side();
  if (!body.has_side() || body.side_rule() != SideRule::kBetween || !(s.q2 > 0)) return true;
  const double dx = at.x() - s.cx, dy = at.y() - s.cy;
  const double close = kOnFace * surface_->size;
  const double middle = s.cz - (s.b0 + s.bx * dx + s.by * dy) / s.q2;
  const std::uint8_t cap_face =
      shadow.first.face == kFaceSide ? shadow.second.face : shadow.first.face;
  const bool silhouette = shadow.second.face == SurfaceRef::kSilhouetteFace;
  for (const bool upper : {true, false}) {
    for (const PlanarCap& cap : upper ? body.upper_caps() : body.lower_caps()) {
      const double above = (silhouette ? z : middle) - (cap.z0 + cap.zx * dx + cap.zy * dy);
      if (silhouette && (upper ? above > close : above < -close)) return false;
      if (!silhouette && cap.face == cap_face && (upper ? above < -close : above > close))
        return false;
    }
  }
  return true;
}

void join_heights(std::vector<LabelHeight>& heights, double close) {
  for (std::size_t i = 0; i < heights.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (std::fabs(heights[i].z - heights[j].z) <= close) heights[i].z = heights[j].z;
    }
  }
}

CurveSolver::Change CurveSolver::change_between(Vec2 p, Label a, double za, Vec2 q, Label b,
                                                double zb, bool asks_for_third) const {
  Change change;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SurfaceRef ra = ref_of(a), rb = ref_of(b);
  for (int k = 0; k < kAllHalvings; ++k) {
    const Vec2 mid = 0.5 * (p + q);
    if (mid == p || mid == q) break;
    if (k >= kHalvings && (k - kHalvings) % 12 == 0) {
      const Vec2 d = q - p;
      double t = 0, z = 0;
      const auto accept = [&](CurveType type, const SurfaceRef& first, const SurfaceRef& second,
                              bool upper) {
        change.curve = {type, first, second, upper};
        change.at = {p.x() + t * d.x(), p.y() + t * d.y(), z};
      };
      // Two faces at one height. Where they touch, the end of one of them is the better curve: the
      // ball at the end of a bar begins where the bar ends.
      const PlanCurve meet{CurveType::kMeet, ra, rb};
      const bool meets = a != kNoLabel && b != kNoLabel &&
                         try_curve(meet, p, d, 0.5 * (za + zb), t, z) &&
                         on_face(a, p + t * d, z) && on_face(b, p + t * d, z);
      const double t_meet = t, z_meet = z;
      const bool touch = touch_along_curve(ra, rb);
      const bool touch_here = meets && !touch && touch_at(meet, p + t * d, z);
      if (meets && !touch && !touch_here) {
        accept(CurveType::kMeet, ra, rb, true);
        change.za = change.zb = z;
        return change;
      }
      const auto is_where_they_meet = [&] {
        const double close = 1e-6 * surface_->size;  // of a double root, and more
        return ((t - t_meet) * d).norm() <= close && std::fabs(z - z_meet) <= close;
      };
      // A body's own end, seen from the side where it is.
      const auto ends = [&](const SurfaceRef& own, bool plus, const Vec2& inside, Label beyond) {
        if (own.solid < 0) return false;
        const BodyLine& body = surface_->bodies[static_cast<std::size_t>(own.solid)];
        // Two lines that meet in an apex, or never, are two curves.
        const auto line_of = [&](const Vec2& on) {
          std::uint8_t nearest = 0, number = 0;
          double least = std::numeric_limits<double>::infinity();
          for (const PlanHalf& h : body.silhouette_lines()) {
            const double away = std::fabs(h.a * (on.x() - body.center_x()) +
                                          h.b * (on.y() - body.center_y()) + h.c) /
                                std::hypot(h.a, h.b);
            if (away < least) {
              least = away;
              nearest = number;
            }
            ++number;
          }
          return nearest;
        };
        const auto attempt = [&](std::uint8_t face) {
          const SurfaceRef other{own.solid, face};
          if (other == own) return false;
          const PlanCurve shadow{CurveType::kShadow, own, other, plus};
          const Vec2 mid_way = 0.5 * (p + q);
          if (!try_curve(shadow, p, d, shadow_height(shadow, mid_way.x(), mid_way.y()), t, z))
            return false;
          if (!borders(body, shadow, p + t * d, z)) return false;
          if (touch_here && !is_where_they_meet()) return false;
          accept(CurveType::kShadow, own, other, plus);
          if (face == SurfaceRef::kSilhouetteFace) change.curve.line = line_of(p + t * d);
          return true;
        };
        if (body.has_side() && own.face == kFaceSide && body.side_rule() == SideRule::kBetween &&
            attempt(SurfaceRef::kSilhouetteFace)) {
          return true;
        }
        for (const PlanHalf& half : body.halves()) {
          if (attempt(half.face)) return true;
        }
        if (body.has_side() && body.side_rule() == SideRule::kColumn && attempt(kFaceSide))
          return true;
        LineHit hit;
        if (body.meet(inside.x(), inside.y(), hit) &&
            attempt(plus ? hit.lower_face : hit.upper_face))
          return true;
        for (const PlanarCap& cap : plus ? body.lower_caps() : body.upper_caps()) {
          if (attempt(cap.face)) return true;
        }
        if (body.has_side() && attempt(kFaceSide)) return true;
        // A face that shows, but is so steep that down to what is seen beyond it has no width of
        // its own in plan.
        for (const PlanarCap& cap : plus ? body.upper_caps() : body.lower_caps()) {
          double below = 0;
          if (beyond != kNoLabel && attempt(cap.face) &&
              height(beyond, change.at.x, change.at.y, below) &&
              std::fabs(change.at.z - below) <=
                  kLineSlack * surface_->tie * std::hypot(cap.zx, cap.zy))
            return true;
        }
        return false;
      };
      const auto plus_of = [&](Label label) {
        return surface_->steps[surface_->step_of_row[static_cast<std::size_t>(row_of(label))]]
                   .sign == Sign::kPlus;
      };
      bool ended = (a != kNoLabel && ends(ra, plus_of(a), p, b)) ||
                   (b != kNoLabel && ends(rb, plus_of(b), q, a));
      if (!ended) {
        // A body that neither label belongs to: its end spares one of them a cut.
        for (const std::uint32_t i : surface_->index.at(mid.x(), mid.y())) {
          const CompoundStep& step = surface_->steps[i];
          if (ended || step.kind != BooleanStep::Kind::kTerm || step.solid < 0) continue;
          const BodyLine& body = surface_->bodies[static_cast<std::size_t>(step.solid)];
          LineHit hit_p, hit_q;
          const bool in_p = body.meet(p.x(), p.y(), hit_p), in_q = body.meet(q.x(), q.y(), hit_q);
          if (in_p == in_q) continue;
          const bool plus = step.sign == Sign::kPlus;
          const LineHit& hit = in_p ? hit_p : hit_q;
          ended = ends({step.solid, plus ? hit.upper_face : hit.lower_face}, plus, in_p ? p : q,
                       kNoLabel);
        }
      }
      if (!ended && (touch || touch_here)) {
        // Or the rim of a cap that is seen beside the other; else as good as can be told.
        if (rim_between(a, b, p, d, 0.5 * (za + zb), change)) return change;
        if (meets) {
          t = t_meet;
          z = z_meet;
          accept(CurveType::kMeet, ra, rb, true);
          change.za = change.zb = z;
          return change;
        }
      }
      if (ended) {
        const auto at_change = [&](Label label, const SurfaceRef& ref, double z_near) {
          if (label == kNoLabel) return nan;
          if (ref == change.curve.first) return z;
          double own = 0;
          return height(label, change.at.x, change.at.y, own) ? own : z_near;
        };
        change.za = at_change(a, ra, za);
        change.zb = at_change(b, rb, zb);
        if (std::fabs(change.za - change.zb) <=
            1e-9 * surface_->size) {  // a wall too low to be one
          (ra == change.curve.first ? change.zb : change.za) =
              ra == change.curve.first ? change.za : change.zb;
        }
        return change;
      }
    }
    const LineState state = surface_->evaluate_face(mid.x(), mid.y());
    // (Not one of faces that touch, which show by turns for as far as a tie reaches.)
    const auto is_told_from = [&](Label label) {
      double own = 0;
      return label == kNoLabel || state.label == kNoLabel ||
             !height(label, mid.x(), mid.y(), own) ||
             std::fabs(own - state.z) > 64 * surface_->tie;
    };
    if (asks_for_third && state.label != a && state.label != b &&
        (q - p).norm() > kLineSlack * surface_->tie && is_told_from(a) && is_told_from(b)) {
      change.third = true;
      change.third_at = mid;
      return change;
    }
    // (A third label where ties blur: the change from a is what is looked for.)
    if (state.label == a) {
      p = mid;
      za = state.z;
    } else {
      q = mid;
      if (state.label == b) zb = state.z;
    }
  }
  change.at = {p.x(), p.y(), za};
  change.za = a == kNoLabel ? nan : za;
  change.zb = b == kNoLabel ? nan : zb;
  change.curve.type = CurveType::kUnsolved;
  // The base's own end: of itself, or of what is cut out of it or lies under it.
  BaseHit hit_p, hit_q;
  const bool base_at_p = surface_->base_at(p.x(), p.y(), hit_p);
  const bool base_at_q = surface_->base_at(q.x(), q.y(), hit_q);
  if (base_at_p != base_at_q) {
    const Vec2 at = base_at_p ? p : q;
    change.curve = {CurveType::kOutline,
                    {SurfaceRef::kBase, 0},
                    {SurfaceRef::kOutline, static_cast<std::uint8_t>(outline_side(*surface_, at))}};
    change.at = {at.x(), at.y(), base_at_p ? hit_p.z : hit_q.z};
    const auto at_change = [&](Label label, const SurfaceRef& ref, double& z) {
      double own = 0;
      if (label == kNoLabel) return;
      if (ref.solid == SurfaceRef::kBase) {
        z = change.at.z;
      } else if (height(label, at.x(), at.y(), own)) {
        z = own;
      }
    };
    at_change(a, ra, change.za);
    at_change(b, rb, change.zb);
  } else if (a != kNoLabel && b != kNoLabel && std::fabs(za - zb) <= 1e-9 * surface_->size) {
    change.zb = change.za;
    // Where two faces cross at next to no angle a tie reaches far beyond their common curve, and
    // with it the face of the earlier term. The place stays the one at which the labels change: it
    // is on both faces to a tie.
    const PlanCurve meet{CurveType::kMeet, ra, rb};
    if (std::fabs(za - zb) <= 2 * surface_->tie && !touch_along_curve(ra, rb) &&
        on_face(a, p, za) && on_face(b, p, za))
      change.curve = meet;
  }
  return change;
}

}  // namespace diesink
