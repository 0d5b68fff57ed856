// Delaunay refinement that never splits a segment itself but asks for it.
// Ruppert 1995 (encroached segments first), Shewchuk 2002 (small input angles), Ungor 2004
// (off-centres); Rebay 1993, Engwirda and Ivers 2016 (vertices placed in front of finished
// triangles).
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/tessellate/planar_triangulation.h"

namespace diesink {
namespace {

constexpr double kLeastEdge = 0x1p10;  // on the lattice: nothing is made shorter
// A vertex in front of finished triangles keeps this part of the wanted spacing from all others.
// Where fronts meet, less leaves gaps of narrow triangles (0.6 an eighth more on spheres), more
// leaves gaps that only the centres of circles fill.
constexpr double kNearest = 0.9;
constexpr int kLevels = 128;  // of urgency, for accuracy and for shape each

struct Offset {
  double x, y;
};

Offset operator-(const LatticePoint& p, const LatticePoint& q) { return {p.x - q.x, p.y - q.y}; }
double dot(const Offset& u, const Offset& v) { return u.x * v.x + u.y * v.y; }
double cross(const Offset& u, const Offset& v) { return u.x * v.y - u.y * v.x; }
double square(const Offset& u) { return dot(u, u); }

// A triangle turned so that its shortest edge runs from a to b.
struct Shape {
  LatticePoint a, b, c;
  std::uint32_t shortest;  // half-edge
  double ab, bc, ca;       // squared lengths
};

Shape shape_of(const std::array<LatticePoint, 3>& p, std::uint32_t t) {
  const std::array<double, 3> l{square(p[1] - p[0]), square(p[2] - p[1]), square(p[0] - p[2])};
  const std::uint32_t e = l[0] <= l[1] ? (l[0] <= l[2] ? 0U : 2U) : (l[1] <= l[2] ? 1U : 2U);
  const std::uint32_t f = e == 2 ? 0 : e + 1, g = e == 0 ? 2 : e - 1;
  return {p[e], p[f], p[g], 4 * t + e, l[e], l[f], l[g]};
}

LatticePoint rounded(double x, double y) { return {std::nearbyint(x), std::nearbyint(y)}; }

// The place of a new vertex that does away with the triangle: the centre of its circle, or nearer
// where a triangle on the shortest edge that just has the angle reaches less far.
// Needs: reach = half the cotangent of half the angle.
LatticePoint off_centre(const Shape& t, double reach) {
  const Offset u = t.b - t.a, v = t.c - t.a;
  const double twice_area = cross(u, v);
  const double s = 0.5 / twice_area;
  double x = (v.y * t.ab - u.y * t.ca) * s, y = (u.x * t.ca - v.x * t.ab) * s;
  const double mx = 0.5 * u.x, my = 0.5 * u.y;
  const double height = (x - mx) * (x - mx) + (y - my) * (y - my);
  const double most = reach * reach * t.ab;
  if (!(height <= most)) {  // also where the area is lost in rounding
    x = mx - u.y * reach;
    y = my + u.x * reach;
  }
  return rounded(t.a.x + x, t.a.y + y);
}

std::size_t level(double squared_length) {
  return static_cast<std::size_t>(std::clamp(std::ilogb(squared_length), 0, kLevels - 1));
}

// The larger level is mended first. Accuracy: the larger circle first, which spreads the vertices
// evenly. Shape, after that: the shorter edge first, which spoils the fewest triangles again.
std::size_t accuracy_level(const Shape& t) {
  const double twice_area = cross(t.b - t.a, t.c - t.a);
  const double radius_squared = t.ab * t.bc * t.ca / (4 * twice_area * twice_area);
  return kLevels + (radius_squared < 0x1p120 ? level(radius_squared) : kLevels - 1);
}

std::size_t shape_level(const Shape& t) { return kLevels - 1 - level(t.ab); }

}  // namespace

void PlanarTriangulation::start_round(const RefineRules& rules) {
  bad_.resize(2 * kLevels);
  for (const Segment& s : requests_) {
    const std::uint32_t h = find_edge(s[0] + kFrame, s[1] + kFrame);
    if (h == kNoEdge) continue;
    clear_edge_marks(h, kRequested);
    clear_edge_marks(twin(h), kRequested);
  }
  requests_.clear();
  for (const Ticket& ticket : deferred_) {
    triangles_[ticket.triangle].marks &= ~kDeferred;
    fresh_.push_back(ticket);
  }
  deferred_.clear();
  if (min_angle_ != rules.min_angle || shortest_edge_ != rules.shortest_edge ||
      split_encroached_ != rules.split_encroached) {
    min_angle_ = rules.min_angle;
    shortest_edge_ = rules.shortest_edge;
    split_encroached_ = rules.split_encroached;
    fresh_.clear();
    for (std::vector<Ticket>& list : bad_) list.clear();
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      if (is_inside(t)) fresh_.push_back({t, triangles_[t].stamp});
    }
  }
}

bool PlanarTriangulation::request(std::uint32_t h, bool for_shape) {
  const std::uint32_t marks = edge_marks(h);
  if ((marks & kKept) != 0) return false;
  if ((marks & kRequested) != 0) return true;
  const std::uint32_t a = origin(h), b = origin(next(h));
  if (a < kFrame || b < kFrame) return false;
  const double least =
      for_shape ? std::max(kLeastEdge, shortest_edge_ * to_lattice_scale_) : kLeastEdge;
  if (square(lattice_[b] - lattice_[a]) < 4 * least * least) return false;
  if (for_shape && is_held_at_corner(h)) return false;
  set_edge_marks(h, kRequested);
  set_edge_marks(twin(h), kRequested);
  requests_.push_back({std::min(a, b) - kFrame, std::max(a, b) - kFrame});
  return true;
}

// A segment at a small angle of the input is only split where a neighbour there is less than half
// as long: the shortest segment of a fan stays, or splits on both sides of a corner would call for
// each other without end.
bool PlanarTriangulation::is_held_at_corner(std::uint32_t segment) const {
  bool held = false;
  for (const std::uint32_t h : {segment, twin(segment)}) {
    if (!is_inside(h >> 2)) continue;
    const double length = square(lattice_[origin(next(h))] - lattice_[origin(h)]);
    for (const std::uint32_t far : {next(h), prev(h)}) {  // the tip is opposite
      if (!is_small_corner(far)) continue;
      const std::uint32_t side = far == next(h) ? prev(h) : next(h);
      if (length > 4 * square(lattice_[origin(next(side))] - lattice_[origin(side)])) return false;
      held = true;
    }
  }
  return held;
}

bool PlanarTriangulation::is_small_corner(std::uint32_t h) const {
  if (!is_constrained(next(h)) || !is_constrained(prev(h))) return false;
  const LatticePoint& tip = lattice_[apex(h)];
  const Offset u = lattice_[origin(h)] - tip, v = lattice_[origin(next(h))] - tip;
  const double uv = dot(u, v);
  return uv > 0 && 4 * uv * uv > square(u) * square(v);
}

bool PlanarTriangulation::is_closing(std::uint32_t a, std::uint32_t b, const RefineRules& rules) {
  return rules.closing && a >= kFrame && b >= kFrame && rules.closing(a - kFrame, b - kFrame);
}

void PlanarTriangulation::push_bad(std::size_t level, const Ticket& ticket) {
  bad_[level].push_back(ticket);
  top_ = std::max(top_, level);
}

// Once a round: the front, accuracy and shape may all wait for segments at one triangle, and each
// would double it from round to round.
void PlanarTriangulation::defer(const Ticket& ticket) {
  Triangle& t = triangles_[ticket.triangle];
  if (t.stamp != ticket.stamp || (t.marks & kDeferred) != 0) return;
  t.marks |= kDeferred;
  deferred_.push_back(ticket);
}

void PlanarTriangulation::examine(const Ticket& ticket, const RefineRules& rules) {
  const std::uint32_t t = ticket.triangle;
  if (triangles_[t].stamp != ticket.stamp || !is_inside(t)) return;
  if (rules.spacing && examine_accuracy(ticket, rules)) return;
  const std::array<std::uint32_t, 3> corner = triangles_[t].corner;
  const Shape shape = shape_of({lattice_[corner[0]], lattice_[corner[1]], lattice_[corner[2]]}, t);
  if (min_angle_ > 0) {
    if (split_encroached_) {
      for (std::uint32_t h = 4 * t; h < 4 * t + 3; ++h) {
        if (!is_constrained(h) || is_constrained(next(h)) || is_constrained(prev(h))) continue;
        const LatticePoint& c = lattice_[apex(h)];
        if (dot(lattice_[origin(h)] - c, lattice_[origin(next(h))] - c) < 0 &&
            !is_closing(apex(h), origin(h), rules) &&
            !is_closing(apex(h), origin(next(h)), rules) && request(h, true)) {
          defer(ticket);
        }
      }
    }
    // The least angle is opposite the shortest edge.
    const double cosine = std::cos(min_angle_);
    const double uv = dot(shape.a - shape.c, shape.b - shape.c);
    const std::uint32_t h = shape.shortest;
    if (uv > 0 && uv * uv > cosine * cosine * shape.bc * shape.ca &&
        !(is_constrained(next(h)) && is_constrained(prev(h))) &&
        !(!is_constrained(h) && is_small_corner(twin(h))) &&
        !is_closing(origin(h), origin(next(h)), rules)) {
      push_bad(shape_level(shape), ticket);
      return;
    }
  }
  if (rules.spacing || !examine_accuracy(ticket, rules)) examine_fold(ticket, rules);
}

void PlanarTriangulation::examine_fold(const Ticket& ticket, const RefineRules& rules) {
  const std::array<std::uint32_t, 3> corner = triangles_[ticket.triangle].corner;
  if (!rules.folded || !rules.folded(corner[0] - kFrame, corner[1] - kFrame, corner[2] - kFrame)) {
    return;
  }
  const Shape shape =
      shape_of({lattice_[corner[0]], lattice_[corner[1]], lattice_[corner[2]]}, ticket.triangle);
  push_bad(accuracy_level(shape), ticket);
}

bool PlanarTriangulation::examine_accuracy(const Ticket& ticket, const RefineRules& rules) {
  const std::uint32_t t = ticket.triangle;
  const std::array<std::uint32_t, 3> corner = triangles_[t].corner;
  if (!rules.too_coarse ||
      !rules.too_coarse(corner[0] - kFrame, corner[1] - kFrame, corner[2] - kFrame)) {
    triangles_[t].marks &= ~kCoarse;
    if (!rules.spacing) return false;
    for (std::uint32_t h = 4 * t; h < 4 * t + 3; ++h) {
      if (is_constrained(h)) continue;
      const std::uint32_t beyond = twin(h) >> 2;
      if ((triangles_[beyond].marks & kCoarse) != 0)
        front_.push_back({beyond, triangles_[beyond].stamp});
    }
    return false;
  }
  triangles_[t].marks |= kCoarse;
  const Shape shape = shape_of({lattice_[corner[0]], lattice_[corner[1]], lattice_[corner[2]]}, t);
  push_bad(accuracy_level(shape), ticket);
  if (rules.spacing) front_.push_back(ticket);
  return true;
}

// A new vertex where a regular triangle on an edge beside what is fine enough has the size wanted
// there. What lies in the way of it is left to mend().
void PlanarTriangulation::advance(const Ticket& coarse, const RefineRules& rules) {
  const std::uint32_t t = coarse.triangle;
  if (triangles_[t].stamp != coarse.stamp || !is_inside(t)) return;
  std::uint32_t edge = kNoEdge;
  double shortest = std::numeric_limits<double>::infinity();
  for (std::uint32_t h = 4 * t; h < 4 * t + 3; ++h) {
    if (!is_constrained(h) && (triangles_[twin(h) >> 2].marks & kCoarse) != 0) continue;
    const LatticePoint& tip = lattice_[apex(h)];
    // The centre of the circle lies behind an edge that faces an obtuse corner.
    if (dot(lattice_[origin(h)] - tip, lattice_[origin(next(h))] - tip) <= 0) continue;
    const double length = square(lattice_[origin(next(h))] - lattice_[origin(h)]);
    if (length < shortest) {
      shortest = length;
      edge = h;
    }
  }
  if (edge == kNoEdge) return;
  const std::uint32_t a = origin(edge), b = origin(next(edge));
  const double wanted = 0.5 * (rules.spacing(a - kFrame) + rules.spacing(b - kFrame));
  if (!(wanted < std::numeric_limits<double>::infinity())) return;
  const double size = wanted * to_lattice_scale_;
  const Offset u = lattice_[b] - lattice_[a], v = lattice_[apex(edge)] - lattice_[a];
  const double half = 0.5 * std::sqrt(shortest);
  // Of the circle's centre above the edge.
  const double centre = half * (dot(v, v) - dot(u, v)) / cross(u, v);
  const double radius = std::fmax(size / std::numbers::sqrt3, half);
  const double height = std::fmin(radius + std::sqrt(radius * radius - half * half), centre);
  const double s = 0.5 * height / half;
  const LatticePoint q =
      rounded(lattice_[a].x + 0.5 * u.x - s * u.y, lattice_[a].y + 0.5 * u.y + s * u.x);
  if (mend_at(q, t, {.apart = kNearest * size}, rules) == Mended::kWaits) defer(coarse);
}

PlanarTriangulation::Mended PlanarTriangulation::mend_at(const LatticePoint& q, std::uint32_t t,
                                                         const Manner& manner,
                                                         const RefineRules& rules) {
  const bool for_shape = manner.for_shape;
  const Located at = locate(q, t, false);
  if (at.blocked != kNoEdge) return request(at.blocked, for_shape) ? Mended::kWaits : Mended::kHeld;
  if (!at.found || is_on_corner(at.triangle, q)) return Mended::kHeld;
  dig_cavity(q, at.triangle);
  bool waits = false, held = false;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < rim_.size(); ++i) {
    const Offset u = lattice_[rim_[i].origin] - q;
    nearest = std::min(nearest, square(u));
    if ((rim_[i].marks & kConstrained) == 0) continue;
    const Offset v = lattice_[rim_[i + 1 == rim_.size() ? 0 : i + 1].origin] - q;
    const double uv = dot(u, v);
    if (uv >= 0) continue;
    if (request(twin(rim_[i].outer), for_shape)) {
      waits = true;
    } else {
      // A segment that stays: near it only where no flat triangle would come to lie on it.
      held = held || for_shape || uv * uv > manner.flattest * square(u) * square(v);
    }
  }
  if (waits) return Mended::kWaits;
  const double least =
      std::max(manner.apart,
               for_shape ? std::max(kLeastEdge, shortest_edge_ * to_lattice_scale_) : kLeastEdge);
  if (held || nearest < least * least) return Mended::kHeld;
  const Vec2 p = to_chart(q);
  if (rules.add_vertex && !rules.add_vertex(p, std::sqrt(nearest) / to_lattice_scale_))
    return Mended::kDone;
  append_vertex(p, q);
  fill_cavity(static_cast<std::uint32_t>(lattice_.size() - 1));
  return Mended::kDone;
}

void PlanarTriangulation::mend(const Ticket& bad, bool for_shape, const RefineRules& rules) {
  const std::uint32_t t = bad.triangle;
  if (triangles_[t].stamp != bad.stamp || !is_inside(t)) return;
  const std::array<std::uint32_t, 3> corner = triangles_[t].corner;
  const Shape shape = shape_of({lattice_[corner[0]], lattice_[corner[1]], lattice_[corner[2]]}, t);
  // A little less far than the angle allows, so that rounding leaves no triangle just below it.
  constexpr double kNearer = 0.475, kWidest = 0.1;
  const double angle = for_shape ? min_angle_ : kWidest;
  Mended mended = mend_at(off_centre(shape, kNearer / std::tan(0.5 * angle)), t,
                          {.for_shape = for_shape}, rules);
  if (mended == Mended::kHeld && for_shape) {
    if (rules.spacing || !examine_accuracy(bad, rules)) examine_fold(bad, rules);
    return;
  }
  if (mended == Mended::kHeld) {
    // Accuracy without that segment: the middle of the longest edge, or within the triangle; at the
    // last with flat triangles on segments that stay (which would not help what is folded).
    const std::uint32_t h = shape.bc >= shape.ca ? next(shape.shortest) : prev(shape.shortest);
    const LatticePoint &a = lattice_[origin(h)], &b = lattice_[origin(next(h))];
    const LatticePoint middle = rounded(0.5 * (a.x + b.x), 0.5 * (a.y + b.y));
    const LatticePoint centre =
        rounded((shape.a.x + shape.b.x + shape.c.x) / 3, (shape.a.y + shape.b.y + shape.c.y) / 3);
    const bool on_segment = is_constrained(h);
    if (on_segment && request(h, false)) mended = Mended::kWaits;
    const bool is_coarse = (triangles_[t].marks & kCoarse) != 0;
    for (const double flattest : {kFlat, kFlattest}) {
      if (flattest > kFlat && !is_coarse) break;
      if (mended == Mended::kHeld && !on_segment)
        mended = mend_at(middle, t, {.flattest = flattest}, rules);
      if (mended == Mended::kHeld) mended = mend_at(centre, t, {.flattest = flattest}, rules);
    }
  }
  if (mended == Mended::kWaits) defer(bad);
}

std::vector<PlanarTriangulation::Segment> PlanarTriangulation::refine(const RefineRules& rules) {
  if (triangles_.empty()) return {};
  start_round(rules);
  while (points_.size() < rules.max_vertices) {
    while (!fresh_.empty()) {
      const Ticket ticket = fresh_.back();
      fresh_.pop_back();
      examine(ticket, rules);
    }
    if (front_begin_ < front_.size()) {
      const Ticket ticket = front_[front_begin_++];
      advance(ticket, rules);
      continue;
    }
    front_.clear();
    front_begin_ = 0;
    while (top_ > 0 && bad_[top_].empty()) --top_;
    if (bad_[top_].empty()) break;
    const Ticket ticket = bad_[top_].back();
    bad_[top_].pop_back();
    mend(ticket, top_ < kLevels, rules);
  }
  return requests_;
}

}  // namespace diesink
