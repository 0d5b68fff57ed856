// SPDX-License-Identifier: Apache-2.0
#include "picture/surface_lines.h"

namespace diesink {
namespace {

constexpr Rgb kInk{0.12F, 0.13F, 0.16F};

// A point of a curve is seen unless everything around its pixel is nearer: beside a silhouette one
// of the pixels around belongs to the curve's own surface.
bool seen_at(const Film& film, const Vec3& p, double slack) {
  const auto x = static_cast<std::ptrdiff_t>(std::floor(p.x()));
  const auto y = static_cast<std::ptrdiff_t>(std::floor(p.y()));
  for (std::ptrdiff_t j = y - 1; j <= y + 1; ++j) {
    for (std::ptrdiff_t i = x - 1; i <= x + 1; ++i) {
      if (i < 0 || j < 0 || i >= static_cast<std::ptrdiff_t>(film.width) ||
          j >= static_cast<std::ptrdiff_t>(film.height)) {
        continue;
      }
      const FilmPixel& pixel = film.at(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
      if (p.z() + slack >= static_cast<double>(pixel.depth)) return true;
    }
  }
  return false;
}

void add_curve(const TriangleMesh& mesh, const MeshCurve& curve, const Camera& camera,
               const Film& film, double wide, StrokeMask& mask) {
  const std::size_t count = curve.vertices.size();
  const double slack = 0.75 / camera.scale;
  for (std::size_t k = 0; k + (curve.closed ? 0 : 1) < count; ++k) {
    const Vec3 from = camera.project(mesh.positions[curve.vertices[k]]);
    const Vec3 to = camera.project(mesh.positions[curve.vertices[(k + 1) % count]]);
    mask.add(from.head<2>(), to.head<2>(), wide,
             [&](double t) { return seen_at(film, from + t * (to - from), slack); });
  }
}

}  // namespace

void draw_curves(const TriangleMesh& mesh, std::span<const MeshCurve> curves, const Camera& camera,
                 const Film& film, Canvas& canvas) {
  const double unit =
      std::clamp(static_cast<double>(std::min(film.width, film.height)) / 900, 0.6, 4.0);
  StrokeMask thin(film.width, film.height), strong(film.width, film.height);
  for (const MeshCurve& each : curves) {
    const bool step = each.kind == CurveKind::kJump || each.kind == CurveKind::kEdge;
    add_curve(mesh, each, camera, film, unit * (step ? 1.7 : 1.1), step ? strong : thin);
  }
  canvas.stroke(thin, kInk, 0.75F);
  canvas.stroke(strong, kInk, 0.9F);
}

}  // namespace diesink
