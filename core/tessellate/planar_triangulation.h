// Constrained Delaunay triangulation of a region of the plane, and its Delaunay refinement in
// rounds. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "core/tessellate/planar_predicates.h"
#include "core/vec.h"

namespace diesink {

inline constexpr std::uint32_t kNoSegment = 0xFFFFFFFFU;
inline constexpr std::uint32_t kNoPoint = 0xFFFFFFFFU;

// Why a region could not be triangulated; all numbers are indices of the input.
//   a and b             two segments cross, or are given twice in one direction
//   a and point         segment a runs over that point, or is that point alone
//   point, other_point  both lie at one place (a: a segment that ends at the first, if any)
//   point               its coordinates are not finite
//   a                   no region: left and right of the segment are connected
struct SegmentCrossing {
  std::uint32_t segment_a = kNoSegment, segment_b = kNoSegment;
  std::uint32_t point = kNoPoint, other_point = kNoPoint;
};

struct RefineRules {
  // Radians; 0 = no refinement for shape; about 20 to 25 degrees is usual. Angles between segments
  // of the input that are smaller stay, and so may some of the angles near them.
  double min_angle = 0;
  // True where the triangle (anticlockwise) must be refined by a new vertex for accuracy; may be
  // empty. Its answer is remembered until the triangle is gone.
  std::function<bool(std::uint32_t, std::uint32_t, std::uint32_t)> too_coarse;
  // The same for what only matters of triangles that are accurate and not too narrow, and is asked
  // of those alone; may be empty.
  std::function<bool(std::uint32_t, std::uint32_t, std::uint32_t)> folded;
  // Chart length of the edges that a vertex would have about it for accuracy, infinite where any
  // will do; may be empty. With it, new vertices for accuracy are placed so that regular triangles
  // of that size grow inwards from what is fine enough already, which takes fewer than centres of
  // circles (a quarter fewer on spheres).
  std::function<double(std::uint32_t)> spacing;
  // Called for each new interior vertex in order of creation with its chart position and the
  // distance of its nearest neighbour, before it gets the next index; false refuses it, and the
  // triangle it should mend is left as it is.
  std::function<bool(const Vec2&, double)> add_vertex;
  // Chart length: refinement for shape makes no edge shorter, nor asks for a segment to be split
  // whose halves would be. (What too_coarse asks for is not held by it.)
  double shortest_edge = 0;
  // True where the borders on which two vertices lie close in on each other at a corner, so that
  // nothing but an end would make the triangles between them less narrow; may be empty. They stay.
  std::function<bool(std::uint32_t, std::uint32_t)> closing;
  // With min_angle > 0: also ask for segments to be split that have a vertex in their diametral
  // circle without a bad triangle beside them.
  bool split_encroached = true;
  std::size_t max_vertices = std::numeric_limits<std::size_t>::max();
};

// Triangulates one region and refines it. Deterministic; one object is used by one thread.
//
// Coordinates are kept on a lattice of 2^-50 of the largest extent of the input (or the spacing of
// doubles at that place, if wider), where all decisions are exact: there are no tolerances, and no
// input makes a fold or an endless loop. New vertices lie on the lattice exactly; points of the
// input are returned as given. Later vertices may lie outside the square around the input by half
// its size.
// Bound:  random points: O(n log n) expected; memory about 100 bytes a vertex.
// Source: Bowyer and Watson (cavity insertion); Amenta, Choi and Rote 2003 (order of insertion);
//         Ruppert 1995, Shewchuk 2002, Ungor 2004 (refinement, off-centres).
class PlanarTriangulation {
 public:
  using Segment = std::array<std::uint32_t, 2>;
  using Corners = std::array<std::uint32_t, 3>;

  // Needs:  points in chart coordinates; segments as pairs of their indices, with the region on
  //         their LEFT (outer loops anticlockwise, holes clockwise). A segment given once in each
  //         direction has the region on both sides. Points off the segments are vertices too.
  // Returns what is wrong with the input, each named; empty = built.
  std::vector<SegmentCrossing> build(std::span<const Vec2> points,
                                     std::span<const Segment> segments);

  // Splits the segment with the end vertices a and b (in any order) at a new vertex near it, not
  // exactly on the line: the arc bulges. The new vertex gets the next index. Vertices of insert()
  // and refine() that the segment moves over drop out of the triangles.
  // Returns false and changes nothing where there is no such segment, where the triangle (a, b, p)
  // would fold or hold other vertices of the input, or touch another segment.
  bool split_segment(std::uint32_t a, std::uint32_t b, const Vec2& p);

  // Adds a vertex with the next index; false outside the region, on a vertex or on a segment.
  bool insert(const Vec2& p);

  // Says that the segment must not be split: refine() asks for it no more and does what can be done
  // without. False where there is no such segment.
  bool keep_segment(std::uint32_t a, std::uint32_t b);

  // Refines inside the region until no triangle is bad, never moving or splitting a segment.
  // Returns the segments that have to be split before refinement can go on, each once, in a fixed
  // order: those in the way of the mending of a bad triangle, and those with a vertex in their
  // diametral circle (not the vertex of an adjacent segment). Call again after the splits: the work
  // goes on where it stopped, and only what has changed is looked at again.
  // Needs:  build() without crossings.
  std::vector<Segment> refine(const RefineRules& rules);

  // The triangles of the region, anticlockwise, in a fixed order.
  [[nodiscard]] std::vector<Corners> triangles() const;
  [[nodiscard]] std::span<const Vec2> points() const { return points_; }

 private:
  // Vertices 0..3 are the corners of a square around all; a vertex of the user is 4 more than its
  // index. The whole square is triangulated; the region is the triangles marked as inside.
  static constexpr std::uint32_t kFrame = 4;

  // Half-edge = 4 * triangle + 0..2, from corner e to corner e + 1.
  struct Triangle {
    std::array<std::uint32_t, 3> corner;
    std::array<std::uint32_t, 3> twin;
    std::uint32_t stamp = 0;  // changes when the place is used for another triangle
    std::uint32_t marks = 0;  // edge marks shifted by e, and kInside
  };
  static constexpr std::uint32_t kConstrained = 1U << 0, kRequested = 1U << 4, kKept = 1U << 8;
  static constexpr std::uint32_t kEdgeMarks = kConstrained | kRequested | kKept;
  static constexpr std::uint32_t kInside = 1U << 3, kInHole = 1U << 7;
  static constexpr std::uint32_t kCoarse = 1U << 11;    // looked at, and not accurate enough
  static constexpr std::uint32_t kDeferred = 1U << 12;  // waits for a segment to be split
  static constexpr std::uint32_t kNoEdge = 0xFFFFFFFFU;

  // One edge of the border of a hole in the triangulation, seen from within.
  struct RimEdge {
    std::uint32_t origin;
    std::uint32_t outer;  // the half-edge outside that becomes its twin
    std::uint32_t marks;
  };
  // One edge of the upper or lower border of the triangles that a segment runs through.
  struct ChainEdge {
    std::uint32_t vertex;  // its end farther along
    std::uint32_t inner;   // the half-edge of the triangle that is taken away
    std::uint32_t outer;
    std::uint32_t marks;
    std::uint32_t made;   // its half-edge in the new triangles
    bool has_both_sides;  // outer is taken away as well
  };
  enum class Way : std::uint8_t {
    kEdge,     // there is an edge already
    kClear,    // the chains hold what is on both sides
    kBlocked,  // obstacles_ holds the segments crossed and the vertices run over
  };
  struct Located {
    std::uint32_t triangle = 0;
    std::uint32_t blocked = kNoEdge;  // half-edge of the segment met on the way, if any
    bool found = false;
  };
  // A triangle as it was at some time.
  struct Ticket {
    std::uint32_t triangle, stamp;
  };

  // Topology and coordinates.
  [[nodiscard]] static std::uint32_t next(std::uint32_t h) { return (h & 3U) == 2 ? h - 2 : h + 1; }
  [[nodiscard]] static std::uint32_t prev(std::uint32_t h) { return (h & 3U) == 0 ? h + 2 : h - 1; }
  [[nodiscard]] std::uint32_t twin(std::uint32_t h) const {
    return triangles_[h >> 2].twin[h & 3U];
  }
  [[nodiscard]] std::uint32_t origin(std::uint32_t h) const {
    return triangles_[h >> 2].corner[h & 3U];
  }
  [[nodiscard]] std::uint32_t apex(std::uint32_t h) const { return origin(prev(h)); }
  [[nodiscard]] std::uint32_t edge_marks(std::uint32_t h) const {
    return (triangles_[h >> 2].marks >> (h & 3U)) & kEdgeMarks;
  }
  [[nodiscard]] bool is_constrained(std::uint32_t h) const {
    return (edge_marks(h) & kConstrained) != 0;
  }
  [[nodiscard]] bool is_inside(std::uint32_t t) const {
    return (triangles_[t].marks & kInside) != 0;
  }
  void set_edge_marks(std::uint32_t h, std::uint32_t marks);
  void clear_edge_marks(std::uint32_t h, std::uint32_t marks);
  void set_twins(std::uint32_t h, std::uint32_t o);
  [[nodiscard]] std::uint32_t find_edge(std::uint32_t a, std::uint32_t b) const;
  void place_lattice(std::span<const Vec2> points);
  [[nodiscard]] LatticePoint to_lattice(const Vec2& p) const;
  [[nodiscard]] Vec2 to_chart(const LatticePoint& q) const;
  [[nodiscard]] bool is_in_frame(const LatticePoint& q) const;
  std::uint32_t new_triangle();
  void rewrite(std::uint32_t t, const std::array<std::uint32_t, 3>& corner, std::uint32_t marks);
  void append_vertex(const Vec2& p, const LatticePoint& q);

  // Points.
  void make_frame();
  [[nodiscard]] Located locate(const LatticePoint& q, std::uint32_t start, bool across_segments);
  [[nodiscard]] bool is_on_corner(std::uint32_t t, const LatticePoint& q) const;
  [[nodiscard]] bool is_on_segment(std::uint32_t t, const LatticePoint& q) const;
  void dig_cavity(const LatticePoint& q, std::uint32_t start);
  void fill_cavity(std::uint32_t vertex);

  // Segments.
  void flip(std::uint32_t h);
  void legalize();
  void split_edge(std::uint32_t h, std::uint32_t vertex);
  [[nodiscard]] Way trace(std::uint32_t a, std::uint32_t b);
  [[nodiscard]] std::uint32_t cut_ears(std::uint32_t from, std::vector<ChainEdge>& chain,
                                       std::size_t& used, std::uint32_t inside);
  void join_chain(std::vector<ChainEdge>& chain);
  Way recover(std::uint32_t a, std::uint32_t b);
  void recover_all(std::span<const Segment> segments, std::vector<SegmentCrossing>& wrong);
  void name_doubles(std::span<const Segment> segments, std::vector<SegmentCrossing>& wrong) const;
  void mark_inside(std::span<const Segment> segments, std::vector<SegmentCrossing>& wrong);
  [[nodiscard]] bool may_move_over(std::uint32_t h, const LatticePoint& q, std::uint32_t& holds_q);

  // Refinement.
  enum class Mended : std::uint8_t { kDone, kWaits, kHeld };
  void start_round(const RefineRules& rules);
  void push_bad(std::size_t level, const Ticket& ticket);
  void defer(const Ticket& ticket);
  void examine(const Ticket& ticket, const RefineRules& rules);
  bool examine_accuracy(const Ticket& ticket, const RefineRules& rules);
  void examine_fold(const Ticket& ticket, const RefineRules& rules);
  void advance(const Ticket& coarse, const RefineRules& rules);
  void mend(const Ticket& bad, bool for_shape, const RefineRules& rules);
  struct Manner {
    bool for_shape = false;
    double apart = 0;         // from all other vertices, at the least, lattice length
    double flattest = kFlat;  // squared cosine of the angle over a segment that stays, at the most
  };
  static constexpr double kFlat = 0.75, kFlattest = 0.9998;  // 150 and 179 degrees
  [[nodiscard]] Mended mend_at(const LatticePoint& q, std::uint32_t t, const Manner& manner,
                               const RefineRules& rules);
  [[nodiscard]] bool request(std::uint32_t h, bool for_shape);
  // Whether segments enclose the corner opposite h at less than 60 degrees.
  [[nodiscard]] bool is_small_corner(std::uint32_t h) const;
  static bool is_closing(std::uint32_t a, std::uint32_t b, const RefineRules& rules);
  [[nodiscard]] bool is_held_at_corner(std::uint32_t segment) const;

  std::vector<Vec2> points_;
  std::vector<LatticePoint> lattice_;   // of all vertices, frame first
  std::vector<std::uint32_t> edge_of_;  // a half-edge leaving each vertex
  std::vector<bool> is_movable_;        // by user index: added by insert or refine
  std::vector<Triangle> triangles_;
  Vec2 centre_ = Vec2::Zero();
  double to_lattice_scale_ = 1, to_chart_scale_ = 1;
  double reach_ = 1;        // of the input from the centre, on the lattice
  std::uint32_t last_ = 0;  // where the next search starts
  std::uint32_t random_ = 1;

  // Working room, kept between calls.
  std::vector<std::uint32_t> hole_;
  std::vector<RimEdge> rim_;
  std::vector<std::uint32_t> stack_;
  std::vector<ChainEdge> left_chain_, right_chain_;
  std::vector<Segment> obstacles_;

  // Work left for refine().
  std::vector<Ticket> fresh_;             // made and not yet looked at
  std::vector<std::vector<Ticket>> bad_;  // by urgency
  std::size_t top_ = 0;                   // no level above it has any
  std::vector<Ticket> front_;             // coarse, and perhaps beside what is not; in turn
  std::size_t front_begin_ = 0;
  std::vector<Ticket> deferred_;  // wait for the split of a segment
  std::vector<Segment> requests_;
  double min_angle_ = 0, shortest_edge_ = 0;  // radians; chart
  bool split_encroached_ = true;
  bool keeps_fresh_ = false;
};

}  // namespace diesink
