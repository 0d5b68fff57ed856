// Which curve parts two labels: a few halvings bring it near, Newton's method finds its point.
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/tessellate/outline.h"
#include "core/tessellate/plan_curve.h"

namespace diesink {
namespace {

// Halvings before the curve is looked for, and at most.
constexpr int kHalvings = 5, kAllHalvings = 60;
// Ties of height by which a third face is told from two that it shows between: of fewer rounding
// makes slivers that come and go.
constexpr double kApart = 64;

}  // namespace

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

CurveSolver::Change CurveSolver::change_between(Vec2 p, Label a, double za, Vec2 q, Label b,
                                                double zb, ThirdLabel third) const {
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
                         try_curve(meet, p, d, 0.5 * (za + zb), t, z) && on_face(a, p + t * d, z) &&
                         on_face(b, p + t * d, z);
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
                  kLineSlack * surface_->tie * std::hypot(cap.zx, cap.zy)) {
            // (As it is called where it is wide enough to be seen.)
            change.curve.type = CurveType::kMeet;
            return true;
          }
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
             std::fabs(own - state.z) > kApart * surface_->tie;
    };
    if (third != ThirdLabel::kNone && state.label != a && state.label != b &&
        (third == ThirdLabel::kAny ||
         ((q - p).norm() > kLineSlack * surface_->tie && is_told_from(a) && is_told_from(b)))) {
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
