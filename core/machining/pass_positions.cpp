// SPDX-License-Identifier: Apache-2.0
#include "core/machining/pass_positions.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/machining/path_interval.h"
#include "core/machining/strip_rows.h"
#include "core/parallel.h"

namespace diesink {
namespace {

// Passes of a whole row come no closer than half the interval on level ground ...
constexpr double kClosest = 0.5;
// ... and so much of a row's length may ask for less.
constexpr double kLeftOut = 0.15;
constexpr std::size_t kRowsABlock = 8;

// Curvature of the surface under a triangle along its tangent e, from the corner normals; 0 without
// them.
double curvature_along(const TriangleMesh& mesh, std::uint32_t triangle, const Vec3& e) {
  if (mesh.corner_normals.size() != mesh.triangles.size()) return 0;
  const auto& t = mesh.triangles[triangle];
  const auto& n = mesh.corner_normals[triangle];
  const Vec3 a = mesh.positions[t[1]] - mesh.positions[t[0]];
  const Vec3 b = mesh.positions[t[2]] - mesh.positions[t[0]];
  const double aa = a.dot(a), ab = a.dot(b), bb = b.dot(b), det = aa * bb - ab * ab;
  if (!(det > 1e-12 * aa * bb)) return 0;
  const double ea = e.dot(a), eb = e.dot(b);
  const double u = (ea * bb - eb * ab) / det, v = (eb * aa - ea * ab) / det;
  const Vec3 dn =
      u * (mesh.normals[n[1]] - mesh.normals[n[0]]) + v * (mesh.normals[n[2]] - mesh.normals[n[0]]);
  return dn.dot(e);
}

}  // namespace

std::vector<double> even_passes(const FrameDomain& domain, double interval) {
  const double width = domain.high() - domain.low();
  const double steps = std::fmax(1, std::ceil(width / interval - 1e-9));
  std::vector<double> ys;
  for (double k = 0; k < steps; ++k) ys.push_back(domain.low() + width * (k / steps));
  ys.push_back(domain.high());
  return ys;
}

std::vector<double> cusp_passes(const OffsetSurface& offset, const TriangleMesh& mesh,
                                const FrameDomain& domain, const CutterShape& cutter, double cusp,
                                double chord, int threads) {
  const Vec2 along = offset.from_frame(Vec3::UnitX()).head<2>();
  const double level = drop_interval(cutter, Vec3::UnitZ(), along, 0, cusp);
  const double least =
      kClosest * std::fmin(level, cusp_interval(std::fmax(cutter.corner(), cusp), 0, cusp));
  const std::vector<double> rows = even_passes(domain, level);
  std::vector<double> limits(rows.size(), 2 * cutter.radius());
  const StripPieces pieces(offset, rows, kRowsABlock);
  parallel_blocks(rows.size(), kRowsABlock, threads, [&](std::size_t begin, std::size_t end, int) {
    std::vector<ProfileSegment> profile;
    UpperEnvelope envelope;
    struct Wish {
      double interval, length;
    };
    std::vector<Wish> wishes;
    const auto items = pieces.of(std::min(begin, rows.size() - 2) / kRowsABlock);
    for (std::size_t j = begin; j < end; ++j) {
      const Span span = domain.pass(rows[j]);
      profile.clear();
      wishes.clear();
      slice_row(offset, items, rows[j], {span.x0, span.x1}, chord, profile);
      envelope.take(profile);
      double all = 0;
      for (const ProfileSegment& s : profile) {
        if (s.piece >= offset.facets().size()) continue;
        const std::uint32_t triangle = offset.facets()[s.piece].triangle;
        const auto& t = mesh.triangles[triangle];
        const Vec3 n = (mesh.positions[t[1]] - mesh.positions[t[0]])
                           .cross(mesh.positions[t[2]] - mesh.positions[t[0]])
                           .normalized();
        const double curvature = curvature_along(mesh, triangle, across_of(n, along));
        wishes.push_back({drop_interval(cutter, n, along, curvature, cusp), s.x1 - s.x0});
        all += s.x1 - s.x0;
      }
      std::sort(wishes.begin(), wishes.end(),
                [](const Wish& p, const Wish& q) { return p.interval < q.interval; });
      double passed_over = 0;
      for (const Wish& wish : wishes) {
        passed_over += wish.length;
        if (passed_over <= kLeftOut * all) continue;
        limits[j] = std::fmin(limits[j], wish.interval);
        break;
      }
      limits[j] = std::fmax(limits[j], least);
    }
  });
  const auto strip = [&](std::size_t k) { return std::fmin(limits[k], limits[k + 1]); };
  std::vector<double> ys{domain.low()};
  std::size_t row = 0;
  while (ys.back() < domain.high()) {
    const double y = ys.back();
    while (row + 2 < rows.size() && rows[row + 1] <= y) ++row;
    double step = strip(row);
    for (std::size_t k = row + 1; k + 1 < rows.size() && rows[k] < y + step; ++k) {
      step = std::fmin(step, std::fmax(strip(k), rows[k] - y));
    }
    step = std::fmax(step, least);
    ys.push_back(y + step >= domain.high() ? domain.high() : y + step);
  }
  return ys;
}

}  // namespace diesink
