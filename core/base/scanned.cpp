// SPDX-License-Identifier: Apache-2.0
#include "core/base/scanned.h"

#include <Eigen/Geometry>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "core/base/scan_fill.h"
#include "core/base/scanned_border.h"
#include "core/mesh_tools/weld.h"
#include "core/number.h"

namespace diesink {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kMaxCoordinate = 1e9;
// Smaller magnitudes become 0: their products would leave the range in which signs are exact.
constexpr double kLeastCoordinate = 0x1p-400;

// Cosine and sine, exact at the quarter turns that placements are made of.
std::array<double, 2> turn_of(double degrees) {
  const double whole = std::remainder(degrees, 360.0);
  if (whole == 0) return {1, 0};
  if (whole == 90) return {0, 1};
  if (whole == -90) return {0, -1};
  if (std::fabs(whole) == 180) return {-1, 0};
  const double angle = whole * (std::numbers::pi / 180);
  return {std::cos(angle), std::sin(angle)};
}

void place(std::vector<Vec3>& positions, const MeshPlacement& step) {
  using Kind = MeshPlacement::Kind;
  const auto rotate = [&](int from, int to) {
    const std::array<double, 2> t = turn_of(step.value.x());
    for (Vec3& p : positions) {
      const double a = p[from], b = p[to];
      p[from] = t[0] * a - t[1] * b;
      p[to] = t[1] * a + t[0] * b;
    }
  };
  switch (step.kind) {
    case Kind::kScale:
      for (Vec3& p : positions) p *= step.value.x();
      break;
    case Kind::kMove:
      for (Vec3& p : positions) p += step.value;
      break;
    case Kind::kRotateX:
      rotate(1, 2);
      break;
    case Kind::kRotateY:
      rotate(2, 0);
      break;
    case Kind::kRotateZ:
      rotate(0, 1);
      break;
  }
}

Error bad_scan(const MeshBase& base, std::string message, ErrorCode code = ErrorCode::kInput) {
  return {code, std::move(message), base.where};
}

// False where a number is not finite or beyond the limit.
bool settle(std::vector<Vec3>& positions) {
  for (Vec3& p : positions) {
    for (int k = 0; k < 3; ++k) {
      if (!(std::fabs(p[k]) <= kMaxCoordinate)) return false;
      if (std::fabs(p[k]) < kLeastCoordinate) p[k] = 0;
    }
  }
  return true;
}

}  // namespace

ScannedSurface::ScannedSurface() = default;
ScannedSurface::ScannedSurface(ScannedSurface&&) noexcept = default;
ScannedSurface& ScannedSurface::operator=(ScannedSurface&&) noexcept = default;
ScannedSurface::~ScannedSurface() = default;

Result<ScannedSurface> ScannedSurface::make(TriangleMesh mesh, const MeshBase& base, int threads) {
  ScannedSurface surface;
  if (mesh.triangles.size() > (std::size_t{1} << 29)) {
    return bad_scan(base, "the scan has more than 536870912 triangles", ErrorCode::kLimit);
  }
  surface.positions_ = std::move(mesh.positions);
  surface.triangles_ = std::move(mesh.triangles);
  for (const MeshPlacement& step : base.placement) place(surface.positions_, step);
  if (!settle(surface.positions_)) {
    return bad_scan(base, "a vertex of the scan, placed, is not within the coordinate limit of " +
                              number_text(kMaxCoordinate));
  }
  if (base.fill_size > 0) {
    surface.fill_ = fill_holes(surface.positions_, surface.triangles_, base.fill_size);
    if (!settle(surface.positions_)) {
      return bad_scan(
          base, "a patch of FILL leaves the coordinate limit of " + number_text(kMaxCoordinate));
    }
  }
  surface.threads_ = threads;
  if (!surface.find_extent()) {
    return bad_scan(base, "no triangle of the scan has an area in plan (" +
                              std::to_string(surface.triangles_.size()) + " triangles)");
  }
  if (base.smooth_normals) surface.make_vertex_normals();
  surface.plan_ = std::make_unique<PlanGrid>();
  surface.border_ = std::make_unique<Border>();
  return surface;
}

void ScannedSurface::make_vertex_normals() {
  // Equal positions share their normal, also where the file repeats them for each facet: they
  // become one, which leaves less memory in use than the file's.
  if (const WeldMap map = weld_map(positions_); map.kept.size() < positions_.size()) {
    for (std::size_t k = 0; k < map.kept.size(); ++k) positions_[k] = positions_[map.kept[k]];
    positions_.resize(map.kept.size());
    positions_.shrink_to_fit();
    for (std::array<std::uint32_t, 3>& t : triangles_) {
      for (std::uint32_t& v : t) v = map.of_vertex[v];
    }
  }
  std::vector<Vec3>& sums = vertex_normals_;
  sums.assign(positions_.size(), Vec3::Zero());
  for (const std::array<std::uint32_t, 3>& t : triangles_) {
    const std::array<Vec3, 3> p{positions_[t[0]], positions_[t[1]], positions_[t[2]]};
    Vec3 n = (p[1] - p[0]).cross(p[2] - p[0]);
    const double length = n.norm();
    if (!(length > 0)) continue;
    n /= n.z() < 0 ? -length : length;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 u = p[(k + 1) % 3] - p[k], v = p[(k + 2) % 3] - p[k];
      sums[t[k]] += std::atan2(u.cross(v).norm(), u.dot(v)) * n;
    }
  }
  for (Vec3& n : sums) {
    const double length = n.norm();
    if (length > 0) n /= length;
  }
}

Vec3 ScannedSurface::normal(std::uint32_t face, double x, double y) const {
  ScannedTriangle plane;
  if (!triangle(face, plane)) return Vec3::UnitZ();
  // The operations of rows and grids.
  const double up = 1 / std::sqrt((plane.zx * plane.zx + plane.zy * plane.zy) + 1);
  const Vec3 facet(-plane.zx * up, -plane.zy * up, up);
  if (!smooth()) return facet;
  const std::array<std::uint32_t, 3>& t = triangles_[face];
  const Vec3 &a = positions_[t[0]], &b = positions_[t[1]], &c = positions_[t[2]];
  const auto area = [](double px, double py, double qx, double qy) { return px * qy - py * qx; };
  const double whole = area(b.x() - a.x(), b.y() - a.y(), c.x() - a.x(), c.y() - a.y());
  const double second =
      std::clamp(area(x - a.x(), y - a.y(), c.x() - a.x(), c.y() - a.y()) / whole, 0.0, 1.0);
  const double third =
      std::clamp(area(b.x() - a.x(), b.y() - a.y(), x - a.x(), y - a.y()) / whole, 0.0, 1.0);
  const Vec3 blended = (1 - second - third) * vertex_normals_[t[0]] +
                       second * vertex_normals_[t[1]] + third * vertex_normals_[t[2]];
  const double length = blended.norm();
  return length > 0 && blended.z() > 0 ? Vec3(blended / length) : facet;
}

bool ScannedSurface::at(double x, double y, BaseHit& hit) const {
  if (!(x >= plan_box_.x0 && x <= plan_box_.x1 && y >= plan_box_.y0 && y <= plan_box_.y1)) {
    return false;
  }
  bool found = false;
  ScannedTriangle t;
  const PlanGrid& plan = this->plan();
  const std::span<const std::uint32_t> cell =
      plan.in_cell(plan.cells.column(x), plan.cells.line(y));
  const bool from_top = cell.size() > PlanGrid::kDeep;
  for (const std::uint32_t face : cell) {
    if (from_top && found && top_of(face) < hit.z) break;
    const PlanBox b = box_of(face);
    if (x < b.x0 || x > b.x1 || y < b.y0 || y > b.y1) continue;
    if (!triangle(face, t) || !t.covers(x, y)) continue;
    const double z = t.height(t.along_row(y), x);
    if (found && (z < hit.z || (z == hit.z && face > hit.face))) continue;
    hit = {z, t.zx, t.zy, face};
    found = true;
  }
  return found;
}

bool ScannedSurface::is_above(double x, double y, double z) const {
  ScannedTriangle t;
  const PlanGrid& plan = this->plan();
  const std::span<const std::uint32_t> cell =
      plan.in_cell(plan.cells.column(x), plan.cells.line(y));
  const bool from_top = cell.size() > PlanGrid::kDeep;
  for (const std::uint32_t face : cell) {
    if (!(top_of(face) > z)) {
      if (from_top) break;
      continue;
    }
    const PlanBox b = box_of(face);
    if (x < b.x0 || x > b.x1 || y < b.y0 || y > b.y1) continue;
    if (triangle(face, t) && t.covers(x, y) && t.height(t.along_row(y), x) > z) return true;
  }
  return false;
}

void ScannedSurface::row(double y, std::span<const double> xs, double* z, double* zx, double* zy,
                         std::uint32_t* face) const {
  std::fill_n(z, xs.size(), kNaN);
  std::fill_n(zx, xs.size(), 0.0);
  std::fill_n(zy, xs.size(), 0.0);
  if (face != nullptr) std::fill_n(face, xs.size(), kNoFace);
  if (xs.empty() || !(y >= plan_box_.y0 && y <= plan_box_.y1)) return;
  const LineSearch lines(xs);
  const PlanGrid& plan = this->plan();
  const Cells& cells = plan.cells;
  const int line = cells.line(y);
  const std::size_t last = lines.first_above(plan_box_.x1);
  ScannedTriangle t;
  std::vector<std::uint32_t> ascending;
  // Each cell of the line answers for the points whose cell it is.
  for (std::size_t from = lines.first_from(plan_box_.x0), to = from; from < last; from = to) {
    const int column = cells.column(xs[from]);
    while (to < last && cells.column(xs[to]) == column) ++to;
    std::span<const std::uint32_t> cell = plan.in_cell(column, line);
    if (cell.size() > PlanGrid::kDeep) {
      ascending.assign(cell.begin(), cell.end());
      std::sort(ascending.begin(), ascending.end());
      cell = ascending;
    }
    for (const std::uint32_t f : cell) {
      const PlanBox b = box_of(f);
      if (y < b.y0 || y > b.y1 || xs[from] > b.x1 || xs[to - 1] < b.x0) continue;
      if (!triangle(f, t)) continue;
      std::size_t begin = from, end = to;
      t.narrow(y, lines, begin, end);
      const double along = t.along_row(y);
      for (std::size_t i = begin; i < end; ++i) {
        const double height = t.height(along, xs[i]);
        if (z[i] >= height) continue;
        z[i] = height;
        zx[i] = t.zx;
        zy[i] = t.zy;
        if (face != nullptr) face[i] = f;
      }
    }
  }
}

}  // namespace diesink
