// SPDX-License-Identifier: Apache-2.0
#include "core/base/scanned.h"

#include <Eigen/Geometry>
#include <limits>
#include <numbers>
#include <string>

#include "core/base/row_bins.h"
#include "core/base/scan_fill.h"
#include "core/base/scanned_border.h"
#include "core/mesh_tools/vertex_table.h"
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
  surface.make_cells(threads);
  if (surface.upright_ == surface.triangles_.size()) {
    return bad_scan(base, "no triangle of the scan has an area in plan (" +
                              std::to_string(surface.triangles_.size()) + " triangles)");
  }
  if (base.smooth_normals) surface.make_vertex_normals();
  surface.border_ = std::make_unique<Border>();
  return surface;
}

void ScannedSurface::make_cells(int threads) {
  const std::size_t count = triangles_.size();
  constexpr std::size_t kBlock = 1 << 16;
  // Extent of the triangles, each block's apart; the sums of box sizes tell how fine cells can be.
  struct Extent {
    PlanBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
    double z_low = HUGE_VAL, z_high = -HUGE_VAL, width = 0, height = 0, area = 0;
    std::size_t upright = 0;
  };
  std::vector<Extent> extents((count + kBlock - 1) / kBlock);
  // Triangles in random order find their vertices all over: memory is asked for some ahead.
  constexpr std::size_t kAhead = 16;
  const auto ask_for = [&](std::size_t i) {
    for (const std::uint32_t v : triangles_[i]) __builtin_prefetch(&positions_[v]);
  };
  parallel_blocks(count, kBlock, threads, [&](std::size_t begin, std::size_t end, int) {
    Extent& e = extents[begin / kBlock];
    for (std::size_t i = begin; i < end; ++i) {
      if (i + kAhead < count) ask_for(i + kAhead);
      const auto [v0, v1, v2] = triangles_[i];
      const Vec3 &a = positions_[v0], &b = positions_[v1], &c = positions_[v2];
      if (turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y()) == 0) {
        ++e.upright;
        continue;
      }
      const PlanBox box = box_of(static_cast<std::uint32_t>(i));
      e.box = {std::min(e.box.x0, box.x0), std::max(e.box.x1, box.x1), std::min(e.box.y0, box.y0),
               std::max(e.box.y1, box.y1)};
      e.z_low = std::min(e.z_low, std::min(a.z(), std::min(b.z(), c.z())));
      e.z_high = std::max(e.z_high, std::max(a.z(), std::max(b.z(), c.z())));
      const double width = box.x1 - box.x0, height = box.y1 - box.y0;
      e.width += width;
      e.height += height;
      e.area += width * height;
    }
  });
  Extent all;
  for (const Extent& e : extents) {
    all.box = {std::min(all.box.x0, e.box.x0), std::max(all.box.x1, e.box.x1),
               std::min(all.box.y0, e.box.y0), std::max(all.box.y1, e.box.y1)};
    all.z_low = std::min(all.z_low, e.z_low);
    all.z_high = std::max(all.z_high, e.z_high);
    all.width += e.width;
    all.height += e.height;
    all.area += e.area;
    all.upright += e.upright;
  }
  upright_ = all.upright;
  if (upright_ == count) return;
  plan_box_ = all.box;
  z_low_ = all.z_low;
  z_high_ = all.z_high;

  const double width = std::max(all.box.x1 - all.box.x0, 1e-300),
               height = std::max(all.box.y1 - all.box.y0, 1e-300);
  const auto live = static_cast<double>(count - upright_);
  cells_.x0 = all.box.x0;
  cells_.y0 = all.box.y0;
  // Two triangles a cell, fewer cells where large triangles would stand in too many of them.
  for (double cells = std::max(1.0, 0.5 * live);; cells *= 0.25) {
    constexpr double kMostAcross = 1 << 15;  // 16 bits hold a number of them
    const double side = std::sqrt(width * height / cells);
    cells_.nx = static_cast<int>(std::clamp(width / side, 1.0, kMostAcross));
    cells_.ny = static_cast<int>(std::clamp(height / side, 1.0, kMostAcross));
    cells_.per_x = cells_.nx / width;
    cells_.per_y = cells_.ny / height;
    const double entries = live + all.width * cells_.per_x + all.height * cells_.per_y +
                           all.area * cells_.per_x * cells_.per_y;
    constexpr double kEntriesPerTriangle = 7;
    if (entries <= kEntriesPerTriangle * live || cells <= 1) break;
  }

  const auto lines = static_cast<std::size_t>(cells_.ny);
  const auto columns = static_cast<std::size_t>(cells_.nx);
  const RowBins bins(count, lines, threads, [&](std::size_t i) {
    if (i + kAhead < count) ask_for(i + kAhead);
    const auto [v0, v1, v2] = triangles_[i];
    const Vec3 &a = positions_[v0], &b = positions_[v1], &c = positions_[v2];
    if (turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y()) == 0) return CellRange{};
    const PlanBox box = box_of(static_cast<std::uint32_t>(i));
    const auto cell = [](int at) { return static_cast<std::uint16_t>(at); };
    return CellRange{cell(cells_.column(box.x0)), cell(cells_.column(box.x1)),
                     cell(cells_.line(box.y0)), cell(cells_.line(box.y1))};
  });
  // Counts line by line, then places line by line.
  start_.assign(lines * columns + 1, 0);
  constexpr std::size_t kLines = 4;
  parallel_blocks(lines, kLines, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t line = begin; line < end; ++line) {
      std::uint32_t* const after = start_.data() + line * columns + 1;
      for (const RowBins::Entry& e : bins.row(line)) {
        for (std::size_t k = e.x0; k <= e.x1; ++k) ++after[k];
      }
    }
  });
  for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
  items_ = LargeArray<std::uint32_t>(start_.back());
  parallel_blocks(lines, kLines, threads, [&](std::size_t begin, std::size_t end, int) {
    std::vector<std::uint32_t> next(columns);
    for (std::size_t line = begin; line < end; ++line) {
      std::copy_n(start_.begin() + static_cast<std::ptrdiff_t>(line * columns), columns,
                  next.begin());
      for (const RowBins::Entry& e : bins.row(line)) {
        for (std::size_t k = e.x0; k <= e.x1; ++k) items_.data()[next[k]++] = e.item;
      }
    }
  });
}

void ScannedSurface::make_vertex_normals() {
  // Equal positions share their normal, also where the file repeats them for each facet.
  VertexTable table(positions_.size() / 2);
  std::vector<std::uint32_t> place(positions_.size());
  for (std::size_t v = 0; v < positions_.size(); ++v) place[v] = table.add(positions_[v]);
  std::vector<Vec3> sums(table.size(), Vec3::Zero());
  for (const std::array<std::uint32_t, 3>& t : triangles_) {
    const std::array<Vec3, 3> p{positions_[t[0]], positions_[t[1]], positions_[t[2]]};
    Vec3 n = (p[1] - p[0]).cross(p[2] - p[0]);
    const double length = n.norm();
    if (!(length > 0)) continue;
    n /= n.z() < 0 ? -length : length;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 u = p[(k + 1) % 3] - p[k], v = p[(k + 2) % 3] - p[k];
      sums[place[t[k]]] += std::atan2(u.cross(v).norm(), u.dot(v)) * n;
    }
  }
  for (Vec3& n : sums) {
    const double length = n.norm();
    if (length > 0) n /= length;
  }
  vertex_normals_.resize(positions_.size());
  for (std::size_t v = 0; v < positions_.size(); ++v) vertex_normals_[v] = sums[place[v]];
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
  for (const std::uint32_t face : in_cell(cells_.column(x), cells_.line(y))) {
    const PlanBox b = box_of(face);
    if (x < b.x0 || x > b.x1 || y < b.y0 || y > b.y1) continue;
    if (!triangle(face, t) || !t.covers(x, y)) continue;
    const double z = t.height(t.along_row(y), x);
    if (found && !(z > hit.z)) continue;
    hit = {z, t.zx, t.zy, face};
    found = true;
  }
  return found;
}

void ScannedSurface::row(double y, std::span<const double> xs, double* z, double* zx, double* zy,
                         std::uint32_t* face) const {
  std::fill_n(z, xs.size(), kNaN);
  std::fill_n(zx, xs.size(), 0.0);
  std::fill_n(zy, xs.size(), 0.0);
  if (face != nullptr) std::fill_n(face, xs.size(), kNoFace);
  if (xs.empty() || !(y >= plan_box_.y0 && y <= plan_box_.y1)) return;
  const LineSearch lines(xs);
  const int line = cells_.line(y);
  const std::size_t last = lines.first_above(plan_box_.x1);
  ScannedTriangle t;
  // Each cell of the line answers for the points whose cell it is.
  for (std::size_t from = lines.first_from(plan_box_.x0), to = from; from < last; from = to) {
    const int column = cells_.column(xs[from]);
    while (to < last && cells_.column(xs[to]) == column) ++to;
    for (const std::uint32_t f : in_cell(column, line)) {
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
