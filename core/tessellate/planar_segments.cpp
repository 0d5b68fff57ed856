// Segments in the triangulation: recovery, crossings, the inside of the region, splits.
// The two polygons beside a recovered segment can be seen from it, so that cutting ears in one pass
// triangulates them: Toussaint and Avis 1982. Flips then restore the empty circles: Lawson 1977.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cassert>

#include "core/pair_key.h"
#include "core/tessellate/planar_triangulation.h"

namespace diesink {
namespace {

constexpr std::size_t kMostMovedOver = 1000;  // triangles that a split may sweep
constexpr std::size_t kMostWrong = 50'000;    // crossings told of segments that overlap all over

// The input segments by their ends, sorted when first asked.
class SegmentNames {
 public:
  explicit SegmentNames(std::span<const PlanarTriangulation::Segment> segments)
      : segments_(segments) {}

  // The first segment from a to b; kNoSegment if none.
  std::uint32_t find(std::uint32_t a, std::uint32_t b) {
    if (keys_.empty()) {
      keys_.reserve(segments_.size());
      for (std::uint32_t i = 0; i < segments_.size(); ++i) {
        keys_.emplace_back(pair_key(segments_[i][0], segments_[i][1]), i);
      }
      std::sort(keys_.begin(), keys_.end());
    }
    const auto at = std::lower_bound(keys_.begin(), keys_.end(), std::pair(pair_key(a, b), 0U));
    return at != keys_.end() && at->first == pair_key(a, b) ? at->second : kNoSegment;
  }

  std::uint32_t find_either(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t i = find(a, b);
    return i != kNoSegment ? i : find(b, a);
  }

 private:
  std::span<const PlanarTriangulation::Segment> segments_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys_;
};

bool is_between(const LatticePoint& a, const LatticePoint& b, const LatticePoint& on_line) {
  return !(on_line == a) && !(on_line == b) && on_line.x >= std::min(a.x, b.x) &&
         on_line.x <= std::max(a.x, b.x) && on_line.y >= std::min(a.y, b.y) &&
         on_line.y <= std::max(a.y, b.y);
}

// Whether x, known to be on the line a-b, lies on b's side of a.
bool is_ahead(const LatticePoint& a, const LatticePoint& b, const LatticePoint& x) {
  return ((b.x > a.x) == (x.x > a.x) && (b.x < a.x) == (x.x < a.x)) &&
         ((b.y > a.y) == (x.y > a.y) && (b.y < a.y) == (x.y < a.y));
}

}  // namespace

// ---- flips ----

void PlanarTriangulation::flip(std::uint32_t h) {
  const std::uint32_t o = twin(h), t = h >> 2, u = o >> 2;
  const std::uint32_t a = origin(h), b = origin(o), c = apex(h), d = apex(o);
  const std::uint32_t bc = next(h), ca = prev(h), ad = next(o), db = prev(o);
  const std::uint32_t bc_twin = twin(bc), ca_twin = twin(ca), ad_twin = twin(ad),
                      db_twin = twin(db);
  const std::uint32_t left = edge_marks(ad) | edge_marks(ca) << 2;
  const std::uint32_t right = edge_marks(bc) | edge_marks(db) << 2;
  const std::uint32_t inside = triangles_[t].marks & kInside;
  rewrite(t, {a, d, c}, left | inside);
  rewrite(u, {b, c, d}, right | inside);
  set_twins(4 * t, ad_twin);
  set_twins(4 * t + 1, 4 * u + 1);
  set_twins(4 * t + 2, ca_twin);
  set_twins(4 * u, bc_twin);
  set_twins(4 * u + 2, db_twin);
  edge_of_[a] = 4 * t;
  edge_of_[d] = 4 * t + 1;
  edge_of_[b] = 4 * u;
  edge_of_[c] = 4 * u + 1;
}

void PlanarTriangulation::legalize() {
  while (!stack_.empty()) {
    const std::uint32_t h = stack_.back();
    stack_.pop_back();
    if (is_constrained(h)) continue;
    const Triangle& t = triangles_[h >> 2];
    const std::uint32_t o = twin(h);
    if (in_circle(lattice_[t.corner[0]], lattice_[t.corner[1]], lattice_[t.corner[2]],
                  lattice_[apex(o)]) <= 0) {
      continue;
    }
    flip(h);
    for (const std::uint32_t u : {h >> 2, o >> 2}) {
      stack_.push_back(4 * u);
      stack_.push_back(4 * u + 2);
    }
  }
}

void PlanarTriangulation::split_edge(std::uint32_t h, std::uint32_t vertex) {
  const std::uint32_t o = twin(h), marks = edge_marks(h);
  stack_.clear();
  // One side after the other: (a, b, c) becomes (a, v, c) and (v, b, c).
  std::array<std::uint32_t, 2> near{}, far{};
  for (int side = 0; side < 2; ++side) {
    const std::uint32_t e = side == 0 ? h : o, t = e >> 2;
    const std::uint32_t a = origin(e), b = origin(next(e)), c = apex(e);
    const std::uint32_t inside = triangles_[t].marks & kInside;
    const std::uint32_t bc_marks = edge_marks(next(e)), ca_marks = edge_marks(prev(e));
    const std::uint32_t bc_twin = twin(next(e)), ca_twin = twin(prev(e));
    const std::uint32_t u = new_triangle();
    rewrite(t, {a, vertex, c}, inside | marks | ca_marks << 2);
    rewrite(u, {vertex, b, c}, inside | marks | bc_marks << 1);
    set_twins(4 * t + 1, 4 * u + 2);
    set_twins(4 * t + 2, ca_twin);
    set_twins(4 * u + 1, bc_twin);
    edge_of_[a] = 4 * t;
    edge_of_[b] = 4 * u + 1;
    edge_of_[c] = 4 * u + 2;
    edge_of_[vertex] = 4 * u;
    near[static_cast<std::size_t>(side)] = 4 * t;
    far[static_cast<std::size_t>(side)] = 4 * u;
    stack_.push_back(4 * t + 2);
    stack_.push_back(4 * u + 1);
  }
  set_twins(near[0], far[1]);
  set_twins(near[1], far[0]);
  legalize();
}

// ---- recovery ----

PlanarTriangulation::Way PlanarTriangulation::trace(std::uint32_t a, std::uint32_t b) {
  obstacles_.clear();
  hole_.clear();
  left_chain_.clear();
  right_chain_.clear();
  const LatticePoint &pa = lattice_[a], &pb = lattice_[b];
  const auto side = [&](std::uint32_t v) { return orientation(pa, pb, lattice_[v]); };
  const auto chain_edge = [&](std::uint32_t vertex, std::uint32_t inner) {
    return ChainEdge{vertex, inner, twin(inner), edge_marks(inner), kNoEdge, false};
  };
  for (std::uint32_t from = a;;) {
    // The triangle at `from` that the segment runs into, or the vertex.
    const std::uint32_t first = edge_of_[from];
    std::uint32_t h = first, ahead = kNoEdge;
    while (true) {
      const std::uint32_t x = origin(next(h));
      if (x == b) return obstacles_.empty() ? Way::kEdge : Way::kBlocked;
      const int s = side(x);
      if (s == 0 && is_ahead(lattice_[from], pb, lattice_[x])) {
        ahead = x;
        break;
      }
      if (s < 0 && side(apex(h)) > 0) break;
      h = twin(prev(h));
      assert(h != first);  // the vertices are all within the frame
    }
    if (ahead == kNoEdge) {
      hole_.push_back(h >> 2);
      right_chain_.push_back(chain_edge(origin(next(h)), h));
      left_chain_.push_back(chain_edge(apex(h), prev(h)));
      for (std::uint32_t e = next(h);;) {
        if (is_constrained(e)) obstacles_.push_back({origin(e), origin(next(e))});
        const std::uint32_t o = twin(e), c = apex(o);
        hole_.push_back(o >> 2);
        const int s = c == b ? 0 : side(c);
        if (s >= 0) left_chain_.push_back(chain_edge(c, prev(o)));
        if (s <= 0) right_chain_.push_back(chain_edge(c, next(o)));
        if (c == b) return obstacles_.empty() ? Way::kClear : Way::kBlocked;
        if (s == 0) {
          ahead = c;
          break;
        }
        e = s > 0 ? next(o) : prev(o);
      }
    }
    obstacles_.push_back({ahead, kNoPoint});
    from = ahead;
  }
}

std::uint32_t PlanarTriangulation::cut_ears(std::uint32_t from, std::vector<ChainEdge>& chain,
                                            std::size_t& used, std::uint32_t inside) {
  struct Open {
    std::uint32_t vertex, edge;  // the half-edge on the far side of the edge before it
    ChainEdge* chain;            // instead of it, an edge of the chain
  };
  std::vector<Open> open{{from, kNoEdge, nullptr}};
  const auto join = [&](std::uint32_t h, const Open& side) {
    stack_.push_back(h);
    if (side.chain == nullptr) {
      set_twins(h, side.edge);
    } else {
      side.chain->made = h;
      set_edge_marks(h, side.chain->marks);
    }
  };
  for (ChainEdge& edge : chain) {
    open.push_back({edge.vertex, kNoEdge, &edge});
    while (open.size() >= 3) {
      const Open n = open.back(), u = open[open.size() - 2];
      const std::uint32_t p = open[open.size() - 3].vertex;
      if (orientation(lattice_[p], lattice_[u.vertex], lattice_[n.vertex]) >= 0) break;
      const std::uint32_t t = hole_[used++];
      rewrite(t, {n.vertex, u.vertex, p}, inside);
      edge_of_[n.vertex] = 4 * t;
      edge_of_[u.vertex] = 4 * t + 1;
      edge_of_[p] = 4 * t + 2;
      join(4 * t, n);
      join(4 * t + 1, u);
      open.pop_back();
      open.back() = {n.vertex, 4 * t + 2, nullptr};
    }
  }
  assert(open.size() == 2 && open[1].edge != kNoEdge);
  return open[1].edge;
}

void PlanarTriangulation::join_chain(std::vector<ChainEdge>& chain) {
  for (ChainEdge& edge : chain) {
    if (!edge.has_both_sides) {
      set_twins(edge.made, edge.outer);
      continue;
    }
    for (const ChainEdge& other : chain) {
      if (other.inner == edge.outer) set_twins(edge.made, other.made);
    }
  }
}

PlanarTriangulation::Way PlanarTriangulation::recover(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t there = find_edge(a, b);
  if (there != kNoEdge) {
    set_edge_marks(there, kConstrained);
    set_edge_marks(twin(there), kConstrained);
    return Way::kEdge;
  }
  const Way way = trace(a, b);
  if (way == Way::kBlocked) return way;
  const std::uint32_t inside = triangles_[hole_[0]].marks & kInside;
  for (const std::uint32_t t : hole_) triangles_[t].marks |= kInHole;
  // Both sides of an edge can lie in the hole, which then runs round its end.
  for (std::vector<ChainEdge>* chain : {&left_chain_, &right_chain_}) {
    for (ChainEdge& edge : *chain) {
      edge.has_both_sides =
          edge.outer != kNoEdge && (triangles_[edge.outer >> 2].marks & kInHole) != 0;
    }
  }
  // The right side is the left side of the way back.
  std::reverse(right_chain_.begin(), right_chain_.end());
  for (std::size_t i = 0; i + 1 < right_chain_.size(); ++i) {
    right_chain_[i].vertex = right_chain_[i + 1].vertex;
  }
  right_chain_.back().vertex = a;
  stack_.clear();
  std::size_t used = 0;
  const std::uint32_t left = cut_ears(a, left_chain_, used, inside);
  const std::uint32_t right = cut_ears(b, right_chain_, used, inside);
  assert(used == hole_.size());
  join_chain(left_chain_);
  join_chain(right_chain_);
  set_twins(left, right);
  set_edge_marks(left, kConstrained);
  set_edge_marks(right, kConstrained);
  legalize();
  return way;
}

void PlanarTriangulation::recover_all(std::span<const Segment> segments,
                                      std::vector<SegmentCrossing>& wrong) {
  SegmentNames names(segments);
  std::vector<std::uint32_t> skipped;
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    const auto [a, b] = segments[i];
    assert(a < points_.size() && b < points_.size());
    if (a == b) {
      wrong.push_back({i, kNoSegment, a, kNoPoint});
      continue;
    }
    const std::uint32_t h = find_edge(a + kFrame, b + kFrame);
    if (h != kNoEdge && is_constrained(h)) {
      const std::uint32_t same = names.find(a, b);
      if (same < i) wrong.push_back({same, i, kNoPoint, kNoPoint});
      continue;
    }
    if (recover(a + kFrame, b + kFrame) == Way::kBlocked) skipped.push_back(i);
  }
  // Those left out are held against all that are in, and against each other.
  for (const std::uint32_t i : skipped) {
    if (wrong.size() > kMostWrong) return;
    const std::uint32_t same = names.find(segments[i][0], segments[i][1]);
    if (same < i) wrong.push_back({same, i, kNoPoint, kNoPoint});
    [[maybe_unused]] const Way way = trace(segments[i][0] + kFrame, segments[i][1] + kFrame);
    for (const Segment& o : obstacles_) {
      if (o[1] == kNoPoint) {
        wrong.push_back({i, kNoSegment, o[0] - kFrame, kNoPoint});
      } else {
        wrong.push_back({i, names.find_either(o[0] - kFrame, o[1] - kFrame), kNoPoint, kNoPoint});
      }
    }
  }
  const auto low_x = [&](std::uint32_t i) {
    return std::min(lattice_[segments[i][0] + kFrame].x, lattice_[segments[i][1] + kFrame].x);
  };
  const auto high_x = [&](std::uint32_t i) {
    return std::max(lattice_[segments[i][0] + kFrame].x, lattice_[segments[i][1] + kFrame].x);
  };
  std::sort(skipped.begin(), skipped.end(), [&](std::uint32_t i, std::uint32_t j) {
    return std::pair(low_x(i), i) < std::pair(low_x(j), j);
  });
  const auto divides = [&](std::uint32_t i, std::uint32_t j) {
    const LatticePoint &a = lattice_[segments[i][0] + kFrame],
                       &b = lattice_[segments[i][1] + kFrame];
    return orientation(a, b, lattice_[segments[j][0] + kFrame]) *
               orientation(a, b, lattice_[segments[j][1] + kFrame]) <
           0;
  };
  for (std::size_t k = 0; k < skipped.size() && wrong.size() <= kMostWrong; ++k) {
    for (std::size_t m = k + 1; m < skipped.size() && low_x(skipped[m]) <= high_x(skipped[k]);
         ++m) {
      const std::uint32_t i = std::min(skipped[k], skipped[m]),
                          j = std::max(skipped[k], skipped[m]);
      if (divides(i, j) && divides(j, i)) wrong.push_back({i, j, kNoPoint, kNoPoint});
    }
  }
}

void PlanarTriangulation::name_doubles(std::span<const Segment> segments,
                                       std::vector<SegmentCrossing>& wrong) const {
  std::vector<std::uint32_t> segment_at(points_.size(), kNoSegment);
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    for (const std::uint32_t p : segments[i]) segment_at[p] = std::min(segment_at[p], i);
  }
  for (SegmentCrossing& w : wrong) w.segment_a = segment_at[w.point];
}

void PlanarTriangulation::mark_inside(std::span<const Segment> segments,
                                      std::vector<SegmentCrossing>& wrong) {
  const auto enter = [&](std::uint32_t t) {
    if (is_inside(t)) return;
    triangles_[t].marks |= kInside;
    stack_.push_back(t);
  };
  stack_.clear();
  for (const Segment& s : segments) {
    enter(find_edge(s[0] + kFrame, s[1] + kFrame) >> 2);
    while (!stack_.empty()) {
      const std::uint32_t t = stack_.back();
      stack_.pop_back();
      for (std::uint32_t h = 4 * t; h < 4 * t + 3; ++h) {
        if (!is_constrained(h)) enter(twin(h) >> 2);
      }
    }
  }
  SegmentNames names(segments);
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    const auto [a, b] = segments[i];
    const std::uint32_t right = find_edge(b + kFrame, a + kFrame) >> 2;
    if (is_inside(right) && names.find(b, a) == kNoSegment) {
      wrong.push_back({i, kNoSegment, kNoPoint, kNoPoint});
    }
  }
  // A region that reaches the frame without leaking through its segments is turned inside out.
  if (!wrong.empty()) return;
  for (const Triangle& t : triangles_) {
    if ((t.marks & kInside) == 0 || t.corner[0] >= kFrame) continue;
    wrong.push_back({0, kNoSegment, kNoPoint, kNoPoint});
    return;
  }
}

// ---- splits ----

bool PlanarTriangulation::may_move_over(std::uint32_t h, const LatticePoint& q,
                                        std::uint32_t& holds_q) {
  // Every triangle that shares some of the inside of (a, b, q), from the edge a-b outwards.
  const std::array<LatticePoint, 3> swept{lattice_[origin(h)], lattice_[origin(next(h))], q};
  const auto sides = [&](const LatticePoint& p) {
    return std::array<int, 3>{orientation(swept[0], swept[1], p), orientation(swept[1], q, p),
                              orientation(q, swept[0], p)};
  };
  const auto shares_inside = [&](const LatticePoint& u, const LatticePoint& v) {
    const std::array<int, 3> of_u = sides(u), of_v = sides(v);
    for (std::size_t k = 0; k < 3; ++k) {
      if (of_u[k] <= 0 && of_v[k] <= 0) return false;
    }
    int low = 1, high = -1;
    for (const LatticePoint& p : swept) {
      const int s = orientation(u, v, p);
      low = std::min(low, s);
      high = std::max(high, s);
    }
    return low < 0 && high > 0;
  };
  holds_q = kNoEdge;
  hole_.clear();  // the triangles met
  stack_.clear();
  const auto visit = [&](std::uint32_t entry) {
    const std::uint32_t t = entry >> 2;
    if (std::find(hole_.begin(), hole_.end(), t) != hole_.end()) return true;
    hole_.push_back(t);
    const std::uint32_t c = apex(entry);
    const std::array<int, 3> at = sides(lattice_[c]);
    if (lattice_[c] == q) return false;
    if (at[0] >= 0 && at[1] >= 0 && at[2] >= 0 && c != origin(h) && c != origin(next(h))) {
      if (at[1] == 0 || at[2] == 0 || c < kFrame || !is_movable_[c - kFrame]) return false;
    }
    bool holds = true;
    for (std::uint32_t e = 4 * t; e < 4 * t + 3; ++e) {
      holds = holds && orientation(lattice_[origin(e)], lattice_[origin(next(e))], q) >= 0;
    }
    if (holds) holds_q = t;
    for (const std::uint32_t e : {next(entry), prev(entry)}) {
      if (!shares_inside(lattice_[origin(e)], lattice_[origin(next(e))])) continue;
      if (is_constrained(e)) return false;
      stack_.push_back(twin(e));
    }
    return true;
  };
  stack_.push_back(h);
  while (!stack_.empty()) {
    const std::uint32_t entry = stack_.back();
    stack_.pop_back();
    if (!visit(entry) || hole_.size() > kMostMovedOver) return false;
  }
  return holds_q != kNoEdge && !is_on_segment(holds_q, q);
}

bool PlanarTriangulation::split_segment(std::uint32_t a, std::uint32_t b, const Vec2& p) {
  if (triangles_.empty() || a >= points_.size() || b >= points_.size()) return false;
  a += kFrame;
  b += kFrame;
  const LatticePoint q = to_lattice(p);
  std::uint32_t h = find_edge(a, b);
  if (h == kNoEdge || !is_constrained(h) || !is_in_frame(q)) return false;
  const auto vertex = static_cast<std::uint32_t>(lattice_.size());
  const int side = orientation(lattice_[a], lattice_[b], q);
  if (side == 0) {
    if (!is_between(lattice_[a], lattice_[b], q)) return false;
    append_vertex(p, q);
    is_movable_.back() = false;
    for (const std::uint32_t e : {h, twin(h)}) clear_edge_marks(e, kKept | kRequested);
    split_edge(h, vertex);
    return true;
  }
  // In three steps that each leave a valid triangulation: the vertex beside the segment, the two
  // new segments, and the sliver between them and the old one going over to the other side.
  std::uint32_t at = kNoEdge;
  if (!may_move_over(side > 0 ? h : twin(h), q, at)) return false;
  append_vertex(p, q);
  is_movable_.back() = false;
  dig_cavity(q, at);
  fill_cavity(vertex);
  [[maybe_unused]] const Way first = recover(a, vertex), second = recover(vertex, b);
  assert(first != Way::kBlocked && second != Way::kBlocked);
  h = find_edge(a, b);
  const std::uint32_t swept = side > 0 ? h : twin(h);
  const std::uint32_t new_side = triangles_[twin(swept) >> 2].marks & kInside;
  if ((triangles_[swept >> 2].marks & kInside) != new_side) {
    stack_.assign(1, swept >> 2);
    while (!stack_.empty()) {
      const std::uint32_t t = stack_.back();
      stack_.pop_back();
      Triangle& triangle = triangles_[t];
      if ((triangle.marks & kInside) == new_side) continue;
      triangle.marks ^= kInside;
      if (new_side != 0) fresh_.push_back({t, triangle.stamp});
      for (std::uint32_t e = 4 * t; e < 4 * t + 3; ++e) {
        if (!is_constrained(e)) stack_.push_back(twin(e) >> 2);
      }
    }
  }
  for (const std::uint32_t e : {h, twin(h)}) clear_edge_marks(e, kEdgeMarks);
  stack_.assign(1, h);
  legalize();
  return true;
}

bool PlanarTriangulation::keep_segment(std::uint32_t a, std::uint32_t b) {
  if (triangles_.empty() || a >= points_.size() || b >= points_.size()) return false;
  const std::uint32_t h = find_edge(a + kFrame, b + kFrame);
  if (h == kNoEdge || !is_constrained(h)) return false;
  set_edge_marks(h, kKept);
  set_edge_marks(twin(h), kKept);
  return true;
}

}  // namespace diesink
