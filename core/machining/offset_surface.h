// The surface on which the cutter's tip may move: the mesh dilated by the cutter, as a set of
// pieces. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/base_surface.h"
#include "core/machining/cutter.h"
#include "core/mesh.h"

namespace diesink {

// The tip's height over a plan point is the largest over all mesh points p within the cutter's
// radius of p.z - height(distance). A largest value is met inside a facet, on an edge or at a
// vertex; each of them gives a piece, reduced to the contacts that the facets around it leave
// possible. Every piece evaluated anywhere gives a true contact with the mesh, so the largest over
// the pieces is exact even where the plan regions of the pieces are taken a little too large.

// The facet moved by corner·n + flat·(n in plan, made unit), less the corner's height.
struct FacetPiece {
  std::array<Vec3, 3> v;
  std::uint32_t triangle = 0;
};

// The contacts along an edge. Along it a centre is at u = (c - start)·(dx, dy), across it, to the
// left, at w. The region is u in [u0, u1], w in [w0, w1].
struct EdgePiece {
  double x = 0, y = 0, z = 0;  // start
  double dx = 1, dy = 0;       // unit direction in plan
  double length = 0;           // in plan, > 0
  double slope = 0;            // dz a plan length
  double stretch = 1;          // length in space a plan length, sqrt(1 + slope²)
  double u0 = 0, u1 = 0, w0 = 0, w1 = 0;
  bool border = false;  // the surface ends here: the top of a wall, or of nothing
};

// The contacts at a vertex: the region is a box, cut by two half-planes a·(c - v) >= -slack.
struct VertexPiece {
  double x = 0, y = 0, z = 0;
  double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  std::array<double, 2> a{0, 0}, b{0, 0};  // zero: no cut
  double slack = 0;                        // rounding of the place and of the facets' normals
  bool border = false;                     // as of an edge
};

class OffsetSurface {
 public:
  // The pieces of a mesh seen from above, in a plan frame turned so that its x axis lies along
  // (cos angle, sin angle); multiples of a quarter turn are exact. Triangles that stand upright or
  // face down make no facet; their edges count as the border of their neighbours. Vertices should
  // be shared between triangles that meet: a split vertex costs time, not exactness. Units: the
  // mesh's; angle in radians.
  OffsetSurface(const TriangleMesh& mesh, const CutterShape& cutter, double angle);

  [[nodiscard]] const CutterShape& cutter() const { return cutter_; }
  [[nodiscard]] const std::vector<FacetPiece>& facets() const { return facets_; }
  [[nodiscard]] const std::vector<EdgePiece>& edges() const { return edges_; }
  [[nodiscard]] const std::vector<VertexPiece>& vertices() const { return vertices_; }
  [[nodiscard]] std::size_t piece_count() const {
    return facets_.size() + edges_.size() + vertices_.size();
  }

  // Plan box of piece k; k counts facets, then edges, then vertices.
  [[nodiscard]] PlanBox box(std::size_t k) const;
  // An upper bound of the tip's height over piece k.
  [[nodiscard]] double top(std::size_t k) const;

  // Into the turned frame and back.
  [[nodiscard]] Vec3 to_frame(const Vec3& p) const {
    return {cos_ * p.x() + sin_ * p.y(), -sin_ * p.x() + cos_ * p.y(), p.z()};
  }
  [[nodiscard]] Vec3 from_frame(const Vec3& p) const {
    return {cos_ * p.x() - sin_ * p.y(), sin_ * p.x() + cos_ * p.y(), p.z()};
  }

 private:
  CutterShape cutter_;
  double cos_ = 1, sin_ = 0;
  std::vector<FacetPiece> facets_;
  std::vector<EdgePiece> edges_;
  std::vector<VertexPiece> vertices_;
};

// Whether a triangle with this normal, of that length, is seen from above; others are walls.
inline bool faces_up(const Vec3& normal, double length) {
  constexpr double kUpright = 1e-7;
  return length > 0 && normal.z() > kUpright * length;
}

inline constexpr double kNoContact = -std::numeric_limits<double>::infinity();

// A run of x, empty where x0 > x1.
struct Span {
  double x0 = std::numeric_limits<double>::infinity();
  double x1 = -std::numeric_limits<double>::infinity();
  [[nodiscard]] bool empty() const { return !(x0 <= x1); }
};

// The part of the row y inside a piece's region; for edges and vertices also inside the cutter's
// reach.
struct FacetSpan {
  Span span;
  double z0 = 0, z1 = 0;  // tip heights at its ends
};
FacetSpan row_span(const FacetPiece& facet, double y);
Span row_span(const EdgePiece& edge, const CutterShape& cutter, double y);
Span row_span(const VertexPiece& vertex, const CutterShape& cutter, double y);
// The same along the line from + t d, |d| = 1, in t.
Span line_span(const VertexPiece& vertex, const CutterShape& cutter, const Vec2& from,
               const Vec2& d);

// Tip height of the cutter on the whole edge or on the vertex, centre at (x, y), and the contact's
// plan position; kNoContact out of reach. `reach` is the squared distance that still counts as in
// reach.
struct Contact {
  double z = kNoContact;
  double x = 0, y = 0;
};
Contact contact(const EdgePiece& edge, const CutterShape& cutter, double x, double y);
Contact contact(const VertexPiece& vertex, const CutterShape& cutter, double x, double y);

}  // namespace diesink
