// The drop at single points: the lowest tip at which a cutter touches a mesh from above, exact to
// rounding.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/machining/offset_surface.h"

namespace diesink {

// Single points in any order: the pieces of the offset surface in the cells of a plan grid.
class PointDrop {
 public:
  // Needs: `offset` outlives it.
  explicit PointDrop(const OffsetSurface& offset);

  // Tip height over a plan point of the offset's frame; where it is `enough` or more, some height
  // from there on. May be called from several threads.
  [[nodiscard]] double at(double x, double y,
                          double enough = std::numeric_limits<double>::infinity()) const;

  // The same, and the point of the mesh that is touched; kNoContact high where there is none.
  struct Touch {
    double z = kNoContact;
    Vec2 point = Vec2::Zero();
    double height = 0;  // of the mesh there
  };
  [[nodiscard]] Touch touch(double x, double y) const;
  // The highest that a point no further from the axis than `reach` holds the cutter, of one such
  // point of each piece: its contact, or the next to that on the edge or the facet.
  [[nodiscard]] Touch touch_within(double x, double y, double reach) const;

  // Appends the pieces that reach the plan segment from a to b and can lift the tip above `floor`,
  // each at least once.
  void pieces_along(const Vec2& a, const Vec2& b, double floor,
                    std::vector<std::uint32_t>& pieces) const;

 private:
  struct Entry {
    float top = 0;  // rounded up
    std::uint32_t piece = 0;
    // The piece's plan box, rounded outward: most are passed over without a look at the piece.
    float x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  };
  void fetch(std::uint32_t piece) const;
  // The highest of the pieces over a point that `counts(piece, height)` holds for, which may lower
  // that.
  template <class Counts>
  double highest(double x, double y, double enough, std::uint32_t& piece,
                 const Counts& counts) const;
  // Where the cutter at (x, y) touches the mesh with a piece over it.
  [[nodiscard]] Vec2 point_of(std::uint32_t piece, double x, double y) const;
  // The next point to that of its edge or facet which is no further from the axis than `reach`.
  [[nodiscard]] std::optional<Vec3> point_within(std::uint32_t piece, const Vec2& c, double z,
                                                 double reach) const;
  const OffsetSurface* offset_;
  PlanBox extent_;
  int nx_ = 1, ny_ = 1;
  double inv_dx_ = 0, inv_dy_ = 0;
  std::vector<std::uint32_t> start_;
  std::vector<Entry> items_;
};

}  // namespace diesink
