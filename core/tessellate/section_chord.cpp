// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/section_chord.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace diesink {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
// What an end may be off the section, of the chord, and of the radius the section has there: its
// tangent is then known to that part.
constexpr double kOff = 1e-3;

// The section at one end of the chord.
struct End {
  double along = 0, aside = 0;  // of the outward gradient in the plane
  double off = 0;               // from the section
  bool known = false;
};

End end_at(const Implicit& body, const Implicit& plane, const Vec3& p, const Vec3& e,
           const Vec3& s) {
  End end;
  Vec3 gradient, n;
  const double value = body.form(p, gradient), beside = plane.form(p, n);
  end.along = gradient.dot(e);
  end.aside = gradient.dot(s);
  const double steep = std::hypot(end.along, end.aside);
  if (!(steep > 0)) return end;
  const double bend = 2 * body.k.cwiseAbs().maxCoeff() / steep;  // one over the least radius
  end.off = (std::fabs(value) + std::fabs(beside) * gradient.norm()) / steep;
  end.known = end.off * bend < kOff;
  return end;
}

}  // namespace

double section_chord_deviation(const CurvePair& curve, const Vec3& a, const Vec3& b) {
  const bool is_plane_first = curve.f.kind == Implicit::Kind::kPlane;
  const Implicit &plane = is_plane_first ? curve.f : curve.g,
                 &body = is_plane_first ? curve.g : curve.f;
  // A cone's form has the other nappe, too.
  if (plane.kind != Implicit::Kind::kPlane || body.kind != Implicit::Kind::kQuadric ||
      body.k.minCoeff() < 0)
    return kInf;
  const Vec3 chord = b - a;
  const double length = chord.norm(), normal = plane.n.norm();
  if (!(length > 0 && normal > 0)) return kInf;
  const Vec3 e = chord / length;
  const Vec3 s = (plane.n / normal).cross(e).normalized();
  const End p = end_at(body, plane, a, e, s), q = end_at(body, plane, b, e, s);
  const double off = p.off + q.off;
  if (!p.known || !q.known || !(off < kOff * length)) return kInf;
  // The piece lies on the side that both outward normals point to, its tangents rise to that side
  // from a and fall from it to b.
  if (!(p.aside * q.aside > 0)) return kInf;
  const double rise = -p.along / std::fabs(p.aside), fall = q.along / std::fabs(q.aside);
  const double unsure = 4 * kOff;
  if (!(rise > -unsure && fall > -unsure)) return kInf;
  // Tangents known to kOff of a radian, as ends off by a part of the radius have them.
  const double up = std::fmax(rise, 0), down = std::fmax(fall, 0);
  const double most_up = up + unsure * (1 + up * up), most_down = down + unsure * (1 + down * down);
  if (!(unsure * up < 0.5 && unsure * down < 0.5)) return kInf;
  return length * most_up * most_down / (most_up + most_down) + 2 * off * (1 + up + down);
}

}  // namespace diesink
