// The triangles of a square around a region, and the insertion of points into them.
// Insertion by the cavity of triangles whose circles hold the point: Bowyer 1981, Watson 1981.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/planar_triangulation.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/tessellate/planar_order.h"

namespace diesink {
namespace {

constexpr double kLargest = 1e100;  // coordinate of the input

}  // namespace

// ---- topology and coordinates ----

void PlanarTriangulation::set_edge_marks(std::uint32_t h, std::uint32_t marks) {
  triangles_[h >> 2].marks |= marks << (h & 3U);
}

void PlanarTriangulation::clear_edge_marks(std::uint32_t h, std::uint32_t marks) {
  triangles_[h >> 2].marks &= ~(marks << (h & 3U));
}

void PlanarTriangulation::set_twins(std::uint32_t h, std::uint32_t o) {
  triangles_[h >> 2].twin[h & 3U] = o;
  if (o != kNoEdge) triangles_[o >> 2].twin[o & 3U] = h;
}

std::uint32_t PlanarTriangulation::find_edge(std::uint32_t a, std::uint32_t b) const {
  // Round both ends at once: one of them may be the hub of a thousand edges.
  const std::uint32_t first = edge_of_[a], last = edge_of_[b];
  std::uint32_t h = first, g = last;
  do {
    if (origin(next(h)) == b) return h;
    if (origin(next(g)) == a) return twin(g);
    h = twin(prev(h));
    g = twin(prev(g));
  } while (h != first && g != last);
  return kNoEdge;
}

void PlanarTriangulation::place_lattice(std::span<const Vec2> points) {
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();
  if (!points.empty()) low = high = points[0];
  for (const Vec2& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double reach = 0.5 * std::max(high.x() - low.x(), high.y() - low.y());
  const double largest = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  // A power of two not below the spacing of doubles at the far side of the frame, so that every
  // place of the lattice is a double in the chart too.
  int step = -900, exponent = 0;
  if (reach > 0) {
    std::frexp(reach, &exponent);
    step = std::max(step, exponent - 50);
  }
  if (largest > 0) {
    std::frexp(largest, &exponent);
    step = std::max(step, exponent - 51);
  }
  to_chart_scale_ = std::ldexp(1.0, step);
  to_lattice_scale_ = std::ldexp(1.0, -step);
  for (int k = 0; k < 2; ++k) {
    const double middle = 0.5 * low[k] + 0.5 * high[k];
    centre_[k] = std::nearbyint(middle * to_lattice_scale_) * to_chart_scale_;
  }
}

LatticePoint PlanarTriangulation::to_lattice(const Vec2& p) const {
  return {std::nearbyint((p.x() - centre_.x()) * to_lattice_scale_),
          std::nearbyint((p.y() - centre_.y()) * to_lattice_scale_)};
}

Vec2 PlanarTriangulation::to_chart(const LatticePoint& q) const {
  return {centre_.x() + q.x * to_chart_scale_, centre_.y() + q.y * to_chart_scale_};
}

bool PlanarTriangulation::is_in_frame(const LatticePoint& q) const {
  return std::abs(q.x) <= 2 * reach_ && std::abs(q.y) <= 2 * reach_;  // false for NaN
}

std::uint32_t PlanarTriangulation::new_triangle() {
  triangles_.emplace_back();
  return static_cast<std::uint32_t>(triangles_.size() - 1);
}

void PlanarTriangulation::rewrite(std::uint32_t t, const std::array<std::uint32_t, 3>& corner,
                                  std::uint32_t marks) {
  Triangle& triangle = triangles_[t];
  triangle.corner = corner;
  triangle.marks = marks;
  ++triangle.stamp;
  if (keeps_fresh_ && (marks & kInside) != 0) fresh_.push_back({t, triangle.stamp});
}

void PlanarTriangulation::append_vertex(const Vec2& p, const LatticePoint& q) {
  points_.push_back(p);
  lattice_.push_back(q);
  edge_of_.push_back(kNoEdge);
  is_movable_.push_back(true);
}

// ---- points ----

void PlanarTriangulation::make_frame() {
  triangles_.clear();
  new_triangle();
  new_triangle();
  // The border counts as segments: nothing is ever dug across it.
  rewrite(0, {0, 1, 2}, kConstrained << 0 | kConstrained << 1);
  rewrite(1, {0, 2, 3}, kConstrained << 1 | kConstrained << 2);
  for (const std::uint32_t h : {0U, 1U, 5U, 6U}) set_twins(h, kNoEdge);
  set_twins(2, 4);
  last_ = 0;
  random_ = 1;
}

PlanarTriangulation::Located PlanarTriangulation::locate(const LatticePoint& q, std::uint32_t start,
                                                         bool across_segments) {
  std::uint32_t t = start, entry = kNoEdge;
  // A walk that always tries the edges in one order can go round in a circle in a constrained
  // triangulation; one that draws the order ends, soon in all likelihood.
  for (std::size_t steps = 4 * triangles_.size() + 64; steps > 0; --steps) {
    random_ ^= random_ << 13;
    random_ ^= random_ >> 17;
    random_ ^= random_ << 5;
    std::uint32_t h = 4 * t + ((random_ >> 8) * 3U >> 24);
    bool moved = false;
    for (int k = 0; k < 3 && !moved; ++k, h = next(h)) {
      if (h == entry) continue;
      if (orientation(lattice_[origin(h)], lattice_[origin(next(h))], q) >= 0) continue;
      if (!across_segments && is_constrained(h)) return {t, h, true};
      entry = twin(h);
      t = entry >> 2;
      moved = true;
    }
    if (!moved) return {t, kNoEdge, true};
  }
  return {t, kNoEdge, false};
}

bool PlanarTriangulation::is_on_corner(std::uint32_t t, const LatticePoint& q) const {
  for (const std::uint32_t v : triangles_[t].corner) {
    if (lattice_[v] == q) return true;
  }
  return false;
}

bool PlanarTriangulation::is_on_segment(std::uint32_t t, const LatticePoint& q) const {
  for (std::uint32_t h = 4 * t; h < 4 * t + 3; ++h) {
    if (is_constrained(h) && orientation(lattice_[origin(h)], lattice_[origin(next(h))], q) == 0) {
      return true;
    }
  }
  return false;
}

void PlanarTriangulation::dig_cavity(const LatticePoint& q, std::uint32_t start) {
  // The triangles of the cavity form a tree (all its corners are on its rim), so each is met once,
  // and depth first in anticlockwise order leaves the rim in anticlockwise order.
  hole_.clear();
  rim_.clear();
  stack_.clear();
  hole_.push_back(start);
  stack_.push_back(4 * start + 2);
  stack_.push_back(4 * start + 1);
  stack_.push_back(4 * start);
  while (!stack_.empty()) {
    const std::uint32_t h = stack_.back();
    stack_.pop_back();
    const std::uint32_t o = twin(h);
    const std::uint32_t marks = edge_marks(h);
    if ((marks & kConstrained) == 0) {
      const Triangle& beyond = triangles_[o >> 2];
      if (in_circle(lattice_[beyond.corner[0]], lattice_[beyond.corner[1]],
                    lattice_[beyond.corner[2]], q) > 0) {
        hole_.push_back(o >> 2);
        stack_.push_back(prev(o));
        stack_.push_back(next(o));
        continue;
      }
    }
    rim_.push_back({origin(h), o, marks});
  }
}

void PlanarTriangulation::fill_cavity(std::uint32_t vertex) {
  const std::uint32_t inside = triangles_[hole_[0]].marks & kInside;
  while (hole_.size() < rim_.size()) hole_.push_back(new_triangle());
  const std::size_t count = rim_.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t after = i + 1 == count ? 0 : i + 1;
    const std::size_t before = i == 0 ? count - 1 : i - 1;
    const std::uint32_t t = hole_[i];
    rewrite(t, {rim_[i].origin, rim_[after].origin, vertex}, inside | rim_[i].marks);
    Triangle& triangle = triangles_[t];
    triangle.twin[1] = 4 * hole_[after] + 2;
    triangle.twin[2] = 4 * hole_[before] + 1;
    set_twins(4 * t, rim_[i].outer);
    edge_of_[rim_[i].origin] = 4 * t;
  }
  edge_of_[vertex] = 4 * hole_[0] + 2;
  last_ = hole_[0];
}

bool PlanarTriangulation::insert(const Vec2& p) {
  const LatticePoint q = to_lattice(p);
  if (triangles_.empty() || !is_in_frame(q)) return false;
  const Located at = locate(q, last_, true);
  if (!at.found || !is_inside(at.triangle) || is_on_corner(at.triangle, q) ||
      is_on_segment(at.triangle, q)) {
    return false;
  }
  append_vertex(p, q);
  dig_cavity(q, at.triangle);
  fill_cavity(static_cast<std::uint32_t>(lattice_.size() - 1));
  return true;
}

// ---- the whole ----

std::vector<SegmentCrossing> PlanarTriangulation::build(std::span<const Vec2> points,
                                                        std::span<const Segment> segments) {
  std::vector<SegmentCrossing> wrong;
  points_.assign(points.begin(), points.end());
  triangles_.clear();
  fresh_.clear();
  bad_.clear();
  top_ = 0;
  front_.clear();
  front_begin_ = 0;
  deferred_.clear();
  requests_.clear();
  keeps_fresh_ = false;
  is_movable_.assign(points.size(), false);
  edge_of_.assign(points.size() + kFrame, kNoEdge);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (!(points[i].cwiseAbs().maxCoeff() <= kLargest) || points[i].hasNaN()) {
      wrong.push_back({kNoSegment, kNoSegment, i, kNoPoint});
    }
  }
  if (!wrong.empty()) return wrong;

  place_lattice(points);
  lattice_.assign(points.size() + kFrame, {});
  for (std::size_t i = 0; i < points.size(); ++i) lattice_[i + kFrame] = to_lattice(points[i]);
  reach_ = 1;
  for (const LatticePoint& q : lattice_) {
    reach_ = std::max({reach_, std::abs(q.x), std::abs(q.y)});
  }
  const double frame = 3 * reach_;
  lattice_[0] = {-frame, -frame};
  lattice_[1] = {frame, -frame};
  lattice_[2] = {frame, frame};
  lattice_[3] = {-frame, frame};
  triangles_.reserve(2 * lattice_.size() + 2);
  make_frame();

  const std::span<const LatticePoint> placed = std::span(lattice_).subspan(kFrame);
  for (const std::uint32_t i : insertion_order(placed)) {
    const Located at = locate(placed[i], last_, true);
    assert(at.found);  // the walk ends in a Delaunay triangulation
    if (is_on_corner(at.triangle, placed[i])) {
      for (const std::uint32_t v : triangles_[at.triangle].corner) {
        if (lattice_[v] == placed[i]) wrong.push_back({kNoSegment, kNoSegment, v - kFrame, i});
      }
      continue;
    }
    dig_cavity(placed[i], at.triangle);
    fill_cavity(i + kFrame);
  }
  if (wrong.empty()) {
    recover_all(segments, wrong);
    if (wrong.empty()) mark_inside(segments, wrong);
  } else {
    name_doubles(segments, wrong);
  }
  if (!wrong.empty()) {
    triangles_.clear();
    return wrong;
  }
  keeps_fresh_ = true;
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    if (is_inside(t)) fresh_.push_back({t, triangles_[t].stamp});
  }
  return wrong;
}

std::vector<PlanarTriangulation::Corners> PlanarTriangulation::triangles() const {
  std::vector<Corners> out;
  out.reserve(triangles_.size());
  for (const Triangle& t : triangles_) {
    if ((t.marks & kInside) == 0) continue;
    out.push_back({t.corner[0] - kFrame, t.corner[1] - kFrame, t.corner[2] - kFrame});
  }
  return out;
}

}  // namespace diesink
