// The Boolean expression over a box: which faces may win, and which functions may part them.
// Source: equation (5) on enclosures in place of numbers.
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/tessellate/cell_tree.h"
#include "core/tessellate/coincidence.h"
#include "core/tessellate/line_pairs.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// The expression so far over the box.
struct StateOver {
  FaceList faces;
  // Rows cut away for sure by a later `-` that spares others, and cuts filled up for sure by a
  // later `+`: their shadows still part what is left.
  ShortList<std::int32_t, 16> ghosts;
  bool hole = true;  // may be undefined somewhere
};

// Of the height under which surfaces count as one: how high a crease may be that comes and goes
// within a cell unseen. A hundredth of the tolerance.
constexpr double kLost = 100;

// f lies on or above g all over the box for sure (beyond ties), helped by the middle plane of a
// quadric: its upper side is above that plane, its lower side below.
bool surely_above(const Impl& surface, const FaceOver& f, const FaceOver& g, const CellBox& box) {
  const double tie = (1 + kEnclosureSlack) * surface.tie;
  const Range d = difference_over(f, g, box);
  if (d.lo > tie) return true;
  const auto reach = [&](double gx, double gy) {
    return std::fabs(gx) * box.hx + std::fabs(gy) * box.hy;
  };
  if (f.has_mid && f.upper) {
    // Equality only on the silhouette itself.
    if (f.mc - g.c - reach(f.mgx - g.gx, f.mgy - g.gy) - g.hi >= -tie) return true;
  }
  if (g.has_mid && !g.upper) {
    if (f.c + f.lo - g.mc - reach(f.gx - g.mgx, f.gy - g.mgy) >= -tie) return true;
  }
  return (d.hi > tie && f.c - g.c > tie &&
          (sides_run_apart(surface, f, g, box) || rises_above(surface, f, g, box))) ||
         touches_from_above(surface, f, g, box) || covers_steep_face(surface, f, g, box);
}

bool never_above(const Impl& surface, const FaceOver& f, const FaceOver& g, const CellBox& box) {
  const Range d = difference_over(f, g, box);
  // (Of two that touch, ties go to the one that is beyond the other on both sides.)
  return (d.hi <= (1 - kEnclosureSlack) * surface.tie && !touches_from_above(surface, f, g, box)) ||
         (d.lo < -surface.tie && g.c - f.c > surface.tie &&
          (sides_run_apart(surface, f, g, box) || rises_above(surface, g, f, box))) ||
         touches_from_above(surface, g, f, box) || covers_steep_face(surface, g, f, box);
}

bool coincide(const FaceOver& f, const FaceOver& g, const CellBox& box, double tie) {
  const Range d = difference_over(f, g, box);
  return d.lo >= -tie && d.hi <= tie;
}

// `state` with one more term: sign +1 takes the higher, -1 the lower.
void combine(const Impl& surface, StateOver& state, const FaceList& faces, bool faces_hole,
             int sign, const CellBox& box) {
  if (sign < 0 && state.faces.count == 0) return;
  FaceList next;
  ShortList<std::int32_t, 16> cut;
  const auto beats = [&](const FaceOver& f, const FaceOver& g) {
    return sign > 0 ? surely_above(surface, f, g, box) : surely_above(surface, g, f, box);
  };
  const auto is_minus = [&](Label label) {
    return surface.steps[surface.step_of_row[static_cast<std::size_t>(row_of(label))]].sign ==
           Sign::kMinus;
  };
  const auto loses = [&](const FaceOver& f, const FaceOver& g) {  // the later one, ties lost
    return sign > 0 ? never_above(surface, f, g, box) : never_above(surface, g, f, box);
  };
  for (const FaceOver& c : state.faces) {
    // Gone where the term is there for sure and each face it may show is beyond c.
    bool beaten = !faces_hole && faces.count > 0;
    for (const FaceOver& f : faces) beaten = beaten && beats(f, c);
    if (!beaten) {
      next.push(c);
    } else if (sign < 0 || is_minus(c.label)) {
      cut.push(row_of(c.label));  // the more so a cut that is filled up again
    }
  }
  if (next.count == 0 && (sign > 0 || !state.hole)) {
    state.ghosts.clear();  // nothing of the state is left: what was under it does not matter
  } else {
    for (const std::int32_t row : cut) state.ghosts.push(row);
  }
  for (const FaceOver& f : faces) {
    const bool known = std::any_of(next.begin(), next.end(),  // a body that stands twice
                                   [&](const FaceOver& c) { return c.label == f.label; });
    bool lost = !(sign > 0 && state.hole) && state.faces.count > 0;
    for (const FaceOver& c : state.faces) lost = lost && loses(f, c);
    if (known) continue;
    if (!lost) {
      next.push(f);
    } else if (sign > 0 && is_minus(f.label)) {
      state.ghosts.push(row_of(f.label));  // a cut of a group down to below what shows beside it
    }
  }
  next.full = next.full || state.faces.full || faces.full;
  state.faces = next;
  if (sign > 0 && !faces_hole) state.hole = false;
}

// A silhouette and a crossing of the same face: the wall at the silhouette fades to nothing where
// the other surface reaches the silhouette's height, and from there on the faces meet. With q on
// the other surface phi = q2 l² - disc / q2 (l: middle plane above it), the face shows where l >= 0
// and disc >= 0, or l < 0 and phi <= 0: one arc, if both are graphs over the same axis, rising the
// same way, and it changes from one to the other once at most: l does not vanish, or vanishes on
// the silhouette in one point. (A crease may leave a rim and come back to it within a hair.)
bool joined_by_fading(const PlanFunction& f, const PlanFunction& g, const CellBox& box, double tie,
                      double flat, const CellVerdict& v) {
  const bool f_first = f.kind == PlanFunction::Kind::kSilhouette;
  const PlanFunction& silhouette = f_first ? f : g;
  const PlanFunction& crossing = f_first ? g : f;
  if (silhouette.kind != PlanFunction::Kind::kSilhouette ||
      crossing.kind != PlanFunction::Kind::kCrossing)
    return false;
  if (v.hole || !crossing.implicit_side) return false;
  const FaceOver *own = nullptr, *other = nullptr;
  for (const FaceOver& c : v.candidates) {
    const bool is_own = c.solid == silhouette.solid && c.side && c.label == crossing.implicit_label;
    (is_own ? own : other) = &c;
  }
  const auto opposed = [](const Range& a, const Range& b) {
    return (a.lo > 0 && b.hi < 0) || (a.hi < 0 && b.lo > 0);
  };
  if (own == nullptr || other == nullptr || !own->has_mid ||
      !(opposed(silhouette.gx, crossing.gx) || opposed(silhouette.gy, crossing.gy)))
    return false;
  const double l = own->mc - other->c, reach = std::fabs(own->mgx - other->gx) * box.hx +
                                               std::fabs(own->mgy - other->gy) * box.hy;
  if (l - reach - other->hi >= -tie || l + reach - other->lo <= tie) return true;
  // (Beside a base that runs level with the silhouette, finer cells tell no more: what may be lost
  // of a crease is no higher than this.)
  if (other->solid < 0 && std::fabs(l) + reach + std::fmax(-other->lo, other->hi) <= kLost * flat)
    return true;
  if (other->has_mid) {
    // The other is on its own side of its own middle plane: l has one sign beyond that.
    const double gap = own->mc - other->mc, wide = std::fabs(own->mgx - other->mgx) * box.hx +
                                                   std::fabs(own->mgy - other->mgy) * box.hy;
    if (other->upper ? gap + wide <= tie : gap - wide >= -tie) return true;
  }
  PlanFunction level;
  level.gx = {own->mgx - other->zx.hi, own->mgx - other->zx.lo};
  level.gy = {own->mgy - other->zy.hi, own->mgy - other->zy.lo};
  return is_transverse(level, silhouette);
}

bool contains(const CellBox& box, const Vec3& p) {
  return std::fabs(p.x() - box.x) <= box.hx && std::fabs(p.y() - box.y) <= box.hy;
}

// The two silhouette lines of a cone in a box with its apex: its equations are of no use there, but
// it is known as a body's vertex.
bool has_apex(const std::vector<BodyVertices>& vertices, const FunctionList& fs,
              const CellBox& box) {
  if (fs[0].kind != PlanFunction::Kind::kSilhouette || fs[1].kind != fs[0].kind ||
      fs[0].solid != fs[1].solid)
    return false;
  const std::vector<Vec3>& points = vertices[static_cast<std::size_t>(fs[0].solid)].points;
  return std::any_of(points.begin(), points.end(), [&](const Vec3& p) { return contains(box, p); });
}

// Where a silhouette ends at a rim of its body, and the silhouette of a side in contact with it
// goes on from there: a bar with a ball at its end. All three touch in the one vertex, and meet
// nowhere else in the box, as conics in contact do not.
bool goes_on_beyond_rim(const Impl& surface, const std::vector<BodyVertices>& vertices,
                        const FunctionList& fs, const CellBox& box, Vec3& vertex) {
  using Kind = PlanFunction::Kind;
  if (fs.count != 3) return false;
  for (const PlanFunction& own : fs) {
    if (own.kind != Kind::kSilhouette) continue;
    const PlanFunction *rim = nullptr, *beyond = nullptr;
    for (const PlanFunction& f : fs) {
      if (&f == &own) continue;
      if (f.solid == own.solid && (f.kind == Kind::kRim || f.kind == Kind::kShadow)) rim = &f;
      if (f.solid != own.solid && f.kind == Kind::kSilhouette) beyond = &f;
    }
    if (rim == nullptr || beyond == nullptr || !own.regular() || !rim->regular() ||
        !beyond->regular() ||
        !(surface.contacts.is_inside(beyond->solid, own.solid) ||
          surface.contacts.is_inside(own.solid, beyond->solid)))
      continue;
    int inside = 0;
    for (const Vec3& p : vertices[static_cast<std::size_t>(own.solid)].points) {
      if (!contains(box, p)) continue;
      ++inside;
      vertex = p;
    }
    if (inside != 1) continue;
    // Both silhouettes run through it: their discriminants and the slope of the other's vanish
    // there to what rounding leaves of a point.
    const BodyLine& other = surface.bodies[static_cast<std::size_t>(beyond->solid)];
    const SideQuadratic& s = other.side();
    const double x = vertex.x() - s.cx, y = vertex.y() - s.cy;
    const double form = s.d0 + x * (s.dx1 + s.dxx * x + s.dxy * y) + y * (s.dy1 + s.dyy * y);
    const double steep =
        std::hypot(s.dx1 + 2 * s.dxx * x + s.dxy * y, s.dy1 + 2 * s.dyy * y + s.dxy * x);
    if (std::fabs(form) <= 64 * other.slack() * steep) return true;
  }
  return false;
}

void decide(const Impl& surface, const std::vector<BodyVertices>& vertices, const CellBox& box,
            double flat, CellVerdict& v) {
  FunctionList& fs = v.functions;
  if (fs.full || v.candidates.full) {
    v.kind = CellKind::kUnknown;
    return;
  }
  const int labels = v.candidates.count + (v.hole ? 1 : 0);
  if (labels <= 1) {
    v.kind = CellKind::kPlain;
    return;
  }
  v.kind = CellKind::kUnknown;
  if (fs.count == 1) {
    if (fs[0].regular() && fs[0].two == TwoGraphs::kNo) v.kind = CellKind::kArc;
    // The apex of a tilted cone on its own silhouette is a body vertex below.
    if (v.kind == CellKind::kArc) return;
  }
  using Meeting = LinePairs::Meeting;
  Meeting least = fs.count > 0 ? Meeting::kNever : Meeting::kUnknown;  // of any two
  for (const PlanFunction& f : fs) {
    if (!f.passes()) least = Meeting::kUnknown;
    v.branched = v.branched || f.two != TwoGraphs::kNo;
  }
  const LinePairs pairs(v, box, surface.tie);
  for (int i = 0; i < fs.count && least != Meeting::kUnknown; ++i) {
    for (int j = 0; j < i && least != Meeting::kUnknown; ++j)
      least = std::min(least, pairs.of(j, i));
  }
  // Arcs side by side, joined curve by curve, or two that meet.
  if (least == Meeting::kNever || (least == Meeting::kOnceAtMost && fs.count == 2 && !v.branched &&
                                   !has_apex(vertices, fs, box))) {
    v.kind = CellKind::kCorner;
    return;
  }
  v.branched = false;
  if (fs.count == 2 && labels == 2 && joined_by_fading(fs[0], fs[1], box, surface.tie, flat, v)) {
    v.kind = CellKind::kCorner;
    return;
  }
  if (goes_on_beyond_rim(surface, vertices, fs, box, v.vertex)) {
    v.has_vertex = true;
    v.kind = CellKind::kCorner;
    return;
  }
  if (fs.count == 3 && v.candidates.count == 3 && !v.hole) {
    // Three surfaces pairwise crossing: at most one common point where two of the differences are
    // independent.
    bool triple = true;
    for (const PlanFunction& f : fs) {
      triple = triple && f.a != kNoLabel && f.regular();
    }
    if (triple && is_transverse(fs[0], fs[1]) && is_transverse(fs[1], fs[2]) &&
        is_transverse(fs[0], fs[2])) {
      v.kind = CellKind::kCorner;
      return;
    }
  }
  // One body's own vertex: every function is that body's own and passes through the vertex.
  // Every one regular: what it bounds enters and leaves.
  if (fs.count > 0 && fs[0].solid >= 0) {
    const std::int32_t solid = fs[0].solid;
    for (const PlanFunction& f : fs) {
      if (f.solid != solid || f.kind == PlanFunction::Kind::kCrossing ||
          f.kind == PlanFunction::Kind::kOutline)
        return;
    }
    int inside = 0;
    for (const Vec3& p : vertices[static_cast<std::size_t>(solid)].points) {
      if (contains(box, p)) {
        ++inside;
        v.vertex = p;
      }
    }
    if (inside != 1) return;
    const double slack = surface.bodies[static_cast<std::size_t>(solid)].slack();
    int silhouettes = 0, rims = 0;
    for (const PlanFunction& f : fs) {
      if (f.kind == PlanFunction::Kind::kSilhouette) {
        ++silhouettes;
        if (f.bend != 0) {  // a conic: with one other function only
          if (!f.regular() || fs.count != 2) return;
          continue;
        }
      }
      if (f.kind == PlanFunction::Kind::kRim) {
        ++rims;
        if (!f.regular()) return;
        continue;
      }
      if (f.bend != 0) return;
      const double at = f.v + f.cgx * (v.vertex.x() - box.x) + f.cgy * (v.vertex.y() - box.y);
      if (std::fabs(at) > 64 * slack * (1 + std::hypot(f.cgx, f.cgy))) return;
    }
    // A silhouette touching a rim (both regular), or the two silhouettes of a cone at its apex.
    if (silhouettes > 0 && rims > 0) {
      if (rims > 1 || fs.count != 2) return;
      for (const PlanFunction& f : fs) {
        if (!f.regular()) return;
      }
    }
    v.has_vertex = true;
    v.kind = CellKind::kCorner;
  }
}

// The common point of the planes of the faces that meet in a vertex: corners given to six decimals
// lie beside their faces' planes by the last of them.
Vec3 common_point(const Polyhedron& body, std::size_t vertex) {
  const Vec3& p = body.vertices[vertex];
  Mat3 m = Mat3::Zero();
  Vec3 r = Vec3::Zero();
  for (const PolyhedronFace& face : body.faces) {
    if (std::find(face.loop.begin(), face.loop.end(), vertex) == face.loop.end()) continue;
    const Vec3& n = face.plane.n;
    m += n * n.transpose();
    r += n * n.dot(body.vertices[face.loop[0]] - p);
  }
  // Faces that are nearly one plane tell no point.
  constexpr double kFlat = 1e-6;
  if (!(m.determinant() > kFlat)) return p;
  return p + m.inverse() * r;
}

// Several lines no two of which meet more than once: one corner, if all of them run through it.
bool is_star(const CellVerdict& v, const CellBox& box, double tie) {
  const FunctionList& fs = v.functions;
  const LinePairs pairs(v, box, tie);
  for (int i = 0; i < fs.count; ++i) {
    if (!fs[i].regular() || fs[i].two != TwoGraphs::kNo) return false;
    for (int j = 0; j < i; ++j) {
      // (Lines that run side by side have no corner.)
      if (!is_transverse(fs[i], fs[j]) && pairs.of(i, j) != LinePairs::Meeting::kOnceAtMost)
        return false;
    }
  }
  return fs.count >= 3;
}

}  // namespace

std::vector<BodyVertices> body_vertices(const Impl& surface) {
  std::vector<BodyVertices> all(surface.bodies.size());
  for (std::size_t k = 0; k < surface.bodies.size(); ++k) {
    const BodyLine& line = surface.bodies[k];
    std::vector<Vec3>& points = all[k].points;
    if (const Polyhedron* polyhedron = std::get_if<Polyhedron>(&line.body())) {
      for (std::size_t i = 0; i < polyhedron->vertices.size(); ++i) {
        const Vec3 v = common_point(*polyhedron, i);
        // Vertices over one another (upright edges) are one point of the plan; coincident ones too.
        bool known = false;
        for (const Vec3& p : points)
          known = known || std::hypot(p.x() - v.x(), p.y() - v.y()) <= 4 * line.slack();
        if (!known) points.push_back(v);
      }
      continue;
    }
    const QuadricBody& body = std::get<QuadricBody>(line.body());
    const Vec3 a = body.frame.row(2), n = body.frame.row(0), o = body.frame.row(1);
    if (body.shape == QuadricShape::kCone && line.side_rule() == SideRule::kBetween)
      points.push_back(body.p + body.C * a);
    // Where the silhouette touches a rim: rim point c + r(cos n A + sin o B) with q_z = 0 there.
    if (body.shape == QuadricShape::kEllipsoid || line.side_rule() == SideRule::kColumn) continue;
    const auto rim = [&](double w) {
      double ra = body.A, rb = body.B, constant = 0;
      if (body.shape == QuadricShape::kCone) constant = a.z() * (body.C - w) / (body.C * body.C);
      if (body.shape == QuadricShape::kParaboloid) {
        ra = rb = body.A * std::sqrt(w);
        constant = -0.5 * a.z();
      }
      // q_z / 2 = n.z u / A² + o.z v / B² + constant with u = ra cos, v = rb sin; for a cone at its
      // base w = 0.
      const double x = n.z() * ra / (body.A * body.A), y = o.z() * rb / (body.B * body.B);
      const double r = std::hypot(x, y);
      if (!(r > std::fabs(constant)) || r < 1e-12) return;
      const double base = std::atan2(y, x), turn = std::acos(-constant / r);
      for (const double t : {base + turn, base - turn}) {
        points.push_back(body.p + w * a + ra * std::cos(t) * n + rb * std::sin(t) * o);
      }
    };
    if (body.shape != QuadricShape::kParaboloid) rim(0);
    if (body.shape != QuadricShape::kCone) rim(body.C);
  }
  return all;
}

void classify(const Impl& surface, const std::vector<BodyVertices>& vertices, const CellBox& box,
              std::vector<std::uint32_t>& steps, double flat, CellVerdict& verdict) {
  const double tie = surface.tie;
  verdict = CellVerdict{};
  struct Seen {  // a body that is partly there or shows several faces: its functions may matter
    std::int32_t row;
    int first_shadow, shadows, first_rim, rims;
  };
  ShortList<Seen, 24> seen;
  ShortList<PlanFunction, 96> shadows, rims;
  FunctionList outline;
  StateOver state;
  std::vector<StateOver> stack;  // groups only: empty and free of cost without them
  std::size_t kept = 0;
  bool crowded = false;  // more faces than a list holds: the cell is split whatever else it holds
  BodyOver body;
  FaceList base_faces;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const std::uint32_t i = steps[n];
    const CompoundStep& step = surface.steps[i];
    if (step.kind == BooleanStep::Kind::kGroupOpen) {
      stack.push_back(state);
      state = StateOver{};
      steps[kept++] = i;
      continue;
    }
    if (step.kind == BooleanStep::Kind::kGroupClose) {
      const StateOver group = state;
      state = stack.back();
      stack.pop_back();
      crowded = crowded || group.faces.full;
      steps[kept++] = i;
      if (group.faces.count > 0) combine(surface, state, group.faces, group.hole, 1, box);
      for (const std::int32_t row : group.ghosts) state.ghosts.push(row);
      continue;
    }
    const int sign = step.sign == Sign::kPlus ? 1 : -1;
    if (sign < 0 && state.faces.count == 0 && !crowded) continue;
    if (step.solid < 0) {
      FaceOver face;
      const Coverage coverage = base_over(surface, step, box, face, outline);
      if (coverage == Coverage::kOutside) continue;
      base_faces.clear();
      base_faces.push(face);
      combine(surface, state, base_faces, coverage != Coverage::kInside, sign, box);
      steps[kept++] = i;
      continue;
    }
    body_over(surface, step, sign > 0, box, body);
    if (body.coverage == Coverage::kOutside) continue;
    if (crowded) {
      steps[kept++] = i;
      continue;
    }
    combine(surface, state, body.faces, body.coverage != Coverage::kInside, sign, box);
    crowded = state.faces.full;
    // A step whose faces can never be the value so far anywhere in the box is of no more use below
    // it. A list that overflowed cannot tell.
    bool shows = state.faces.full;
    for (const FaceOver& f : state.faces) shows = shows || row_of(f.label) == step.first_row;
    if (!shows) continue;
    steps[kept++] = i;
    if (body.shadow.count == 0 && body.rims.count == 0) continue;
    // (A body that stands in the expression again has nothing new to say.)
    if (std::any_of(seen.begin(), seen.end(),
                    [&](const Seen& b) { return b.row == step.first_row; }))
      continue;
    seen.push({step.first_row, shadows.count, body.shadow.count, rims.count, body.rims.count});
    for (const PlanFunction& f : body.shadow) shadows.push(f);
    for (const PlanFunction& f : body.rims) rims.push(f);
  }
  steps.resize(kept);
  if (crowded) {
    verdict.candidates.full = true;
    return;
  }
  verdict.candidates = state.faces;
  verdict.hole = state.hole;
  FunctionList& fs = verdict.functions;
  fs.full = seen.full || state.ghosts.full || shadows.full || rims.full;
  if (fs.full) return;

  const auto candidate = [&](Label label) {
    for (const FaceOver& f : state.faces) {
      if (f.label == label) return true;
    }
    return false;
  };
  const auto shows_row = [&](std::int32_t row) {
    for (const FaceOver& f : state.faces) {
      if (row_of(f.label) == row) return true;
    }
    return false;
  };
  const auto push = [&](const PlanFunction& f) {
    for (const PlanFunction& g : fs) {
      if (same_line(f, g, box, tie)) return;
    }
    fs.push(f);
  };
  double top = -1e300, bottom = 1e300;
  for (const FaceOver& f : state.faces) {
    const double reach = std::fabs(f.gx) * box.hx + std::fabs(f.gy) * box.hy;
    top = std::fmax(top, f.c + reach + f.hi);
    bottom = std::fmin(bottom, f.c - reach + f.lo);
  }
  verdict.depth = state.faces.count > 0 ? top - bottom : 0;

  for (const Seen& b : seen) {
    bool relevant = shows_row(b.row);
    for (const std::int32_t row : state.ghosts) relevant = relevant || row == b.row;
    if (!relevant) continue;
    for (int i = b.first_shadow; i < b.first_shadow + b.shadows; ++i) {
      const PlanFunction& f = shadows[i];
      if (f.has_height && shows_row(b.row)) {
        // Hidden where the body's height on the line is below everything else for sure. (At one
        // height the two meet in the silhouette itself: it is the line, and surely_above() drops
        // the crossing.)
        const bool plus =
            surface.steps[surface.step_of_row[static_cast<std::size_t>(b.row)]].sign == Sign::kPlus;
        bool hidden = !verdict.hole;
        int others = 0;
        for (const FaceOver& c : state.faces) {
          if (row_of(c.label) == b.row) continue;
          ++others;
          const double reach = std::fabs(f.hgx - c.gx) * box.hx + std::fabs(f.hgy - c.gy) * box.hy;
          hidden =
              hidden && (plus ? f.hc - c.c + reach - c.lo < -tie : f.hc - c.c - reach - c.hi > tie);
        }
        if (hidden && others > 0) continue;
      }
      push(f);
    }
    for (int i = b.first_rim; i < b.first_rim + b.rims; ++i) {
      if (candidate(rims[i].a) && candidate(rims[i].b)) push(rims[i]);
    }
  }
  // Two bodies whose shadows lie on either side of one line share no plan point but its own.
  const auto only_touch = [&](std::int32_t one, std::int32_t two) {
    for (const Seen& a : seen) {
      for (const Seen& b : seen) {
        if (a.row != one || b.row != two) continue;
        for (int i = a.first_shadow; i < a.first_shadow + a.shadows; ++i) {
          for (int k = b.first_shadow; k < b.first_shadow + b.shadows; ++k) {
            const PlanFunction &f = shadows[i], &g = shadows[k];
            if (f.cgx * g.cgx + f.cgy * g.cgy < 0 && same_line(f, g, box, tie)) return true;
          }
        }
      }
    }
    return false;
  };
  for (const PlanFunction& f : outline) push(f);
  for (int i = 0; i < state.faces.count; ++i) {
    for (int j = i + 1; j < state.faces.count; ++j) {
      const FaceOver &f = state.faces[i], &g = state.faces[j];
      if (row_of(f.label) == row_of(g.label)) continue;
      if (surely_above(surface, f, g, box) || surely_above(surface, g, f, box) ||
          coincide(f, g, box, tie)) {
        continue;
      }
      if (only_touch(row_of(f.label), row_of(g.label))) continue;
      const PlanFunction p = crossing_over(surface, f, g, box);
      if (p.lo > 0 || p.hi < 0) continue;
      push(p);
    }
  }
  decide(surface, vertices, box, flat, verdict);
  if (verdict.kind == CellKind::kUnknown && !fs.full && !verdict.candidates.full &&
      drop_crossings_along_lines(surface, box, verdict))
    decide(surface, vertices, box, flat, verdict);
  if (verdict.kind == CellKind::kUnknown && !verdict.candidates.full &&
      is_star(verdict, box, tie)) {
    verdict.kind = CellKind::kCorner;
    verdict.star = true;
  }
  if (verdict.kind == CellKind::kUnknown && fs.count > 0 && is_shallow(verdict, box, flat))
    verdict.kind = CellKind::kLeast;
}

bool is_shallow(const CellVerdict& verdict, const CellBox& box, double flat) {
  if (verdict.hole) return false;
  const FaceList& faces = verdict.candidates;
  for (int i = 0; i < faces.count; ++i) {
    for (int j = i + 1; j < faces.count; ++j) {
      const Range d = difference_over(faces[i], faces[j], box);
      if (!(d.lo >= -flat && d.hi <= flat)) return false;
    }
  }
  return true;
}

}  // namespace diesink
