// A scanned mesh as a base surface: the topmost triangle on every vertical line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "core/base/base_surface.h"
#include "core/base/scan_fill.h"
#include "core/base/scanned_triangle.h"
#include "core/large_array.h"
#include "core/mesh.h"
#include "core/part_program/part_program.h"
#include "core/result.h"
#include "core/vec.h"

namespace diesink {

// The face of a point without a surface.
inline constexpr std::uint32_t kNoFace = 0xFFFFFFFFu;

// What a grid of vertical lines finds: each array has a value a point, row after row, x fastest.
// Where there is no surface z is NaN, the normal 0 and the face kNoFace.
struct ScannedGrid {
  double* z = nullptr;
  double *nx = nullptr, *ny = nullptr, *nz = nullptr;  // of the facet, unit, upward
  std::uint32_t* face = nullptr;
};

// The scan is where it stands after its placement; a triangle counts whichever way it turns. The
// surface is closed: a line through an edge or a vertex meets it, by exact signs, so that there is
// no gap between triangles that share vertices. Of several layers the topmost counts; of equal
// heights the triangle with the lowest number. Triangles that stand upright, to the last digit, or
// have no area have no part of their own. Immutable after make(); every const function may be
// called from several threads.
class ScannedSurface {
 public:
  ScannedSurface(ScannedSurface&&) noexcept;
  ScannedSurface& operator=(ScannedSurface&&) noexcept;
  ~ScannedSurface();

  // Lengths in the part program's unit, Z up; `base` gives the steps of the placement.
  // Errors: kInput where no triangle has an area in plan, a position is not finite or leaves the
  //         coordinate limit of 1e9 in its place; kLimit above 2^29 triangles.
  static Result<ScannedSurface> make(TriangleMesh mesh, const MeshBase& base, int threads = 0);

  // The surface over (x, y); false where no triangle is. face is the triangle's number in the mesh,
  // the slopes are its own.
  // Bound: |dz| is at most what moving the point by 2^-50 of the largest coordinate does.
  bool at(double x, double y, BaseHit& hit) const;

  // Whether at() finds something higher than z: sooner than it where there are many layers.
  [[nodiscard]] bool is_above(double x, double y, double z) const;

  // A run along x at one y, the same digits as at(); z is NaN and slopes 0 where no triangle is.
  // Shape: the arrays have the length of xs, which ascends; face may be null.
  void row(double y, std::span<const double> xs, double* z, double* zx, double* zy,
           std::uint32_t* face) const;

  // All crossings of ascending lines, by scan conversion of the triangles, binned by rows first:
  // the same digits as at(). Time grows with triangles and points, in any order of the triangles.
  // Memory: 12 bytes a triangle for the time of the call, and 4 a band a tall one reaches into.
  void grid(std::span<const double> xs, std::span<const double> ys, const ScannedGrid& out,
            int threads) const;

  // A plane over a plan box and how far the triangles that reach into it lie above it at most, and
  // below: z - (c + gx dx + gy dy) is in `rest`, d from the box's centre. Much narrower than
  // bounds().z where the scan is nearly flat.
  struct Band {
    double c = 0, gx = 0, gy = 0;
    Range rest;
  };
  // Certain enclosures over a plan box: of all layers there, the heights and slopes of the
  // triangles that reach into it; and the band where there is anything.
  BaseBounds bounds(const PlanBox& box, Band& band) const;

  // The border edges that reach into the box, by number, not more than `most` of them.
  void border_over(const PlanBox& box, std::size_t most, std::vector<std::uint32_t>& edges) const;

  // The unit normal, upward, for CC-data at a point of a triangle: the facet's, or with
  // NORMALS,SMOOTH the one blended over the facet from its vertices.
  [[nodiscard]] Vec3 normal(std::uint32_t face, double x, double y) const;
  [[nodiscard]] bool smooth() const { return !vertex_normals_.empty(); }

  // Triangles over one another. Exact where they only touch: those have no mark.
  struct Layers {
    static constexpr char kOver = 1, kUnder = 2, kCrosses = 4;
    std::vector<char> marks;  // of each triangle: what there is below it, above it, or through it
    std::vector<std::array<Vec3, 2>> meets;  // where triangles pass through one another
    [[nodiscard]] bool any() const {
      return std::any_of(marks.begin(), marks.end(), [](char m) { return m != 0; });
    }
  };
  [[nodiscard]] Layers layers(int threads = 0) const;

  // The triangles whose boxes in plan reach into the box, ascending; upright ones left out.
  void faces_over(const PlanBox& box, std::vector<std::uint32_t>& faces) const;

  // An edge, of vertex numbers, that may be border of the plan: in plan it has triangles on its
  // left alone. Other layers may cover it all the same.
  using BorderEdge = std::array<std::uint32_t, 2>;
  // All of them; worked out on the first call.
  [[nodiscard]] const std::vector<BorderEdge>& border_edges() const;

  [[nodiscard]] const PlanBox& plan_box() const { return plan_box_; }
  [[nodiscard]] double z_low() const { return z_low_; }
  [[nodiscard]] double z_high() const { return z_high_; }
  // Triangles that have no plan area.
  [[nodiscard]] std::size_t upright() const { return plan().upright; }
  // What FILL closed: its triangles are the last.
  [[nodiscard]] const ScanFill& fill() const { return fill_; }
  [[nodiscard]] const std::vector<Vec3>& positions() const { return positions_; }
  [[nodiscard]] const std::vector<std::array<std::uint32_t, 3>>& triangles() const {
    return triangles_;
  }

 private:
  // The cells of a uniform plan grid; every point of the plan has one, the border cells take what
  // lies beyond.
  struct Cells {
    int nx = 1, ny = 1;
    double x0 = 0, y0 = 0, per_x = 0, per_y = 0;
    [[nodiscard]] int column(double x) const { return cell_of((x - x0) * per_x, nx); }
    [[nodiscard]] int line(double y) const { return cell_of((y - y0) * per_y, ny); }

   private:
    static int cell_of(double scaled, int cells) {
      return scaled > 0 ? static_cast<int>(scaled < cells ? scaled : cells - 1) : 0;
    }
  };

  // The triangles over each cell.
  struct PlanGrid {
    std::once_flag once;
    std::atomic<bool> made = false;
    Cells cells;
    std::size_t upright = 0;
    std::vector<std::uint32_t> start;  // of each cell in items
    // The triangles of each cell: ascending, or in cells of more than kDeep from the one that
    // reaches highest down, so that what is under the topmost need not be looked at.
    static constexpr std::size_t kDeep = 24;
    LargeArray<std::uint32_t> items;
    [[nodiscard]] std::span<const std::uint32_t> in_cell(int column, int line) const {
      const std::size_t cell = static_cast<std::size_t>(line) * static_cast<std::size_t>(cells.nx) +
                               static_cast<std::size_t>(column);
      return {items.data() + start[cell], start[cell + 1] - start[cell]};
    }
  };
  struct Border;
  struct Extent;

  ScannedSurface();
  // False where no triangle has an area in plan.
  bool find_extent();
  [[nodiscard]] Extent measure() const;
  // Made when the first point, row or box asks for it: whole grids do without.
  [[nodiscard]] const PlanGrid& plan() const {
    if (!plan_->made.load(std::memory_order_acquire)) make_plan();
    return *plan_;
  }
  void make_plan() const;
  void make_vertex_normals();
  [[nodiscard]] const Border& border() const;
  template <class See>
  void each_triangle_over(const PlanBox& box, const See& see) const;
  bool triangle(std::uint32_t face, ScannedTriangle& out) const {
    const std::array<std::uint32_t, 3>& t = triangles_[face];
    return out.set(positions_[t[0]], positions_[t[1]], positions_[t[2]]);
  }
  [[nodiscard]] double top_of(std::uint32_t face) const {
    const std::array<std::uint32_t, 3>& t = triangles_[face];
    return std::max(positions_[t[0]].z(), std::max(positions_[t[1]].z(), positions_[t[2]].z()));
  }
  // Asks memory for a triangle's vertices.
  void ask_for(std::size_t face) const {
    for (const std::uint32_t v : triangles_[face]) __builtin_prefetch(&positions_[v]);
  }
  [[nodiscard]] PlanBox box_of(std::uint32_t face) const {
    const std::array<std::uint32_t, 3>& t = triangles_[face];
    const Vec3 &a = positions_[t[0]], &b = positions_[t[1]], &c = positions_[t[2]];
    return {std::min(a.x(), std::min(b.x(), c.x())), std::max(a.x(), std::max(b.x(), c.x())),
            std::min(a.y(), std::min(b.y(), c.y())), std::max(a.y(), std::max(b.y(), c.y()))};
  }

  std::vector<Vec3> positions_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<Vec3>
      vertex_normals_;  // with NORMALS,SMOOTH, of positions that are then all different
  PlanBox plan_box_;
  double z_low_ = 0, z_high_ = 0;
  ScanFill fill_;
  int threads_ = 0;
  mutable std::unique_ptr<PlanGrid> plan_;
  mutable std::unique_ptr<Border> border_;
};

}  // namespace diesink
