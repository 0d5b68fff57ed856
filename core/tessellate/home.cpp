// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/home.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace diesink {
namespace {

// Farther from the origin than so many widths is far.
constexpr double kFar = 64;

double width_of(const Machining& m) {
  return std::fmax(m.x_range[1] - m.x_range[0], m.y_range[1] - m.y_range[0]);
}

// Minus the middle of a range, to a power of two near its width: so differences to it are
// exact.
double way_home(const std::array<double, 2>& range, double width) {
  const double step = std::exp2(std::floor(std::log2(width)));
  return -step * std::nearbyint(0.5 * (range[0] + range[1]) / step);
}

void move(Polyhedron& body, const Vec3& by) {
  for (Vec3& v : body.vertices) v += by;
  // From the corners, not by n·by: that has lost the digits that moving is for.
  for (PolyhedronFace& face : body.faces) {
    const Vec3& first = body.vertices[face.loop[0]];
    Vec3 offset = Vec3::Zero();
    for (const std::uint8_t v : face.loop) offset += body.vertices[v] - first;
    const Vec3 middle = first + offset / static_cast<double>(face.loop.size());
    face.plane.d = -face.plane.n.dot(middle) + 0.0;
  }
}

void move(QuadricBody& body, const Vec3& by) { body.p += by; }

// The same surface elsewhere in plan. A coordinate v moves without rounding where v + by is nearer
// to 0 and `by` is a multiple of an ulp of v.
Result<CompoundSurface> moved(const CompoundSurface& surface, const Vec2& by) {
  const Vec3 step(by.x(), by.y(), 0);
  PartProgram program = surface.program();
  for (Solid& solid : program.solids) std::visit([&](auto& body) { move(body, step); }, solid.body);
  if (PlaneBase* plane = std::get_if<PlaneBase>(&program.base)) {
    plane->point += step;
  } else if (FergusonBase* ferguson = std::get_if<FergusonBase>(&program.base)) {
    for (Vec3& p : ferguson->points) p += step;
  }
  for (double& v : program.machining.x_range) v += by.x();
  for (double& v : program.machining.y_range) v += by.y();
  return CompoundSurface::make(program);
}

}  // namespace

double least_altitude(const CompoundSurface& surface) {
  const Machining& m = surface.program().machining;
  constexpr double kUlps = 0x1p-49;  // eight of the largest coordinate
  return std::fmax(1e-12 * std::fmin(surface.size(), kFar * width_of(m)), kUlps * surface.size());
}

Home::Home(const CompoundSurface& given) : given_(given) {
  if (std::holds_alternative<MeshBase>(given.program().base)) return;
  const Machining& m = given.program().machining;
  const double width = width_of(m);
  const double far = std::max({std::fabs(m.x_range[0]), std::fabs(m.x_range[1]),
                               std::fabs(m.y_range[0]), std::fabs(m.y_range[1])});
  if (!(far > kFar * width)) return;
  const Vec2 by(way_home(m.x_range, width), way_home(m.y_range, width));
  Result<CompoundSurface> near = moved(given, by);
  // What lies elsewhere may make its coordinates no smaller; a base may be folded by rounding.
  if (!near || !(near->size() < given.size())) return;
  moved_.emplace(std::move(*near));
  way_ = by;
}

}  // namespace diesink
