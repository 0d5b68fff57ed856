// SPDX-License-Identifier: Apache-2.0
#include "core/compound/compound_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/compound/compound_impl.h"
#include "core/grid/grid_array.h"
#include "core/solids/polyhedron.h"

namespace diesink {
namespace {

// Deepest nesting of groups that the parser lets through.
constexpr std::size_t kMaxNesting = 64;
// Of the domain: faces of solids no wider in plan are upright. Half of what curves may be off, and
// what rounding to six decimals makes of the walls of a solid that leans. Regions so narrow would
// need cells as small all along them.
constexpr double kUprightWidth = 5e-10;

// The cell of a scaled coordinate, clamped before the cast: infinite boxes are usual.
inline int cell_of(double scaled, int cells) {
  return static_cast<int>(std::clamp(scaled, 0.0, static_cast<double>(cells - 1)));
}

// What the program leaves open of the domain and the grid, from the plan of its scan.
Status resolve_domain(const ScannedSurface& scan, PartProgram& program) {
  Machining& m = program.machining;
  const PlanBox& plan = scan.plan_box();
  if (!(m.x_range[0] < m.x_range[1])) m.x_range = {plan.x0, plan.x1};
  if (!(m.y_range[0] < m.y_range[1])) m.y_range = {plan.y0, plan.y1};
  const double side = std::max(m.x_range[1] - m.x_range[0], m.y_range[1] - m.y_range[0]);
  if (!(m.x_interval > 0)) m.x_interval = side / 100;
  if (!(m.y_interval > 0)) m.y_interval = side / 100;
  const double points =
      grid_line_count(m.x_range, m.x_interval) * grid_line_count(m.y_range, m.y_interval);
  if (points <= static_cast<double>(kMaxGridPoints)) return ok();
  return Error{ErrorCode::kLimit,
               "the spacing gives a grid of more than 100 million points over the scan",
               std::get<MeshBase>(program.base).where};
}

double largest_coordinate(const PartProgram& program, const std::vector<BodyLine>& bodies) {
  double size = 0;
  const auto take = [&size](double v) { size = std::fmax(size, std::fabs(v)); };
  const Machining& m = program.machining;
  for (const double v : {m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]}) take(v);
  for (const BodyLine& b : bodies) {
    for (const double v : {b.plan_box().x0, b.plan_box().x1, b.plan_box().y0, b.plan_box().y1,
                           b.z_low(), b.z_high()}) {
      take(v);
    }
  }
  if (const FergusonBase* ferguson = std::get_if<FergusonBase>(&program.base)) {
    for (const Vec3& p : ferguson->points) size = std::fmax(size, p.cwiseAbs().maxCoeff());
  } else if (const PlaneBase* plane = std::get_if<PlaneBase>(&program.base)) {
    take(plane->point.z());
  }
  return size;
}

// The border of the base between two places of a side. It is a piece of a cubic, whose hodograph is
// a quadratic: its values at the ends and the middle control value enclose it. `turn`: how far its
// normal's coordinates range.
BaseBorderPiece border_piece(const FergusonSurface& base, int side, double w0, double w1,
                             double close, double& turn) {
  const double inner = 1e-9;  // of a patch: at a joint the derivative is taken inside the piece
  const FergusonSurface::BorderPoint a = base.border(side, w0), b = base.border(side, w1),
                                     m = base.border(side, 0.5 * (w0 + w1));
  const Vec2 da = base.border(side, w0 + inner).along, db = base.border(side, w1 - inner).along;
  // Middle control vector of the quadratic derivative through da, m.along, db.
  const Vec2 dm = 2 * m.along - 0.5 * (da + db);
  BaseBorderPiece piece;
  piece.side = static_cast<std::uint32_t>(side);
  piece.close = close;
  piece.x = m.at.x();
  piece.y = m.at.y();
  // The cubic's own control points from its ends and end derivatives.
  const double third = (w1 - w0) / 3;
  const Vec2 c1 = a.at + third * da, c2 = b.at - third * db;
  piece.box = {std::fmin(std::fmin(a.at.x(), b.at.x()), std::fmin(c1.x(), c2.x())) - close,
               std::fmax(std::fmax(a.at.x(), b.at.x()), std::fmax(c1.x(), c2.x())) + close,
               std::fmin(std::fmin(a.at.y(), b.at.y()), std::fmin(c1.y(), c2.y())) - close,
               std::fmax(std::fmax(a.at.y(), b.at.y()), std::fmax(c1.y(), c2.y())) + close};
  piece.nx = piece.ny = {1e300, -1e300};
  for (const Vec2& d : {da, dm, db}) {
    const double length = d.norm();
    const double nx = length > 0 ? -d.y() / length : 0, ny = length > 0 ? d.x() / length : 0;
    piece.nx = {std::fmin(piece.nx.lo, nx), std::fmax(piece.nx.hi, nx)};
    piece.ny = {std::fmin(piece.ny.lo, ny), std::fmax(piece.ny.hi, ny)};
  }
  turn = (piece.nx.hi - piece.nx.lo) + (piece.ny.hi - piece.ny.lo);
  piece.straight = turn * (b.at - a.at).norm() <= close;
  // Unit vectors between two unit vectors bulge beyond their coordinate ranges by less than the
  // turn squared.
  const double bulge = piece.straight ? 0 : turn * turn;
  piece.nx = {piece.nx.lo - bulge, piece.nx.hi + bulge};
  piece.ny = {piece.ny.lo - bulge, piece.ny.hi + bulge};
  return piece;
}

// The border cut into stretches that turn little: the cells over one that turns too much to be one
// arc would be split down to the least.
std::vector<BaseBorderPiece> border_pieces(const FergusonSurface& base, double close) {
  constexpr int kPieces = 8;  // a patch side at least
  constexpr int kHalvings = 8;
  constexpr double kMostTurn = 0.25;
  std::vector<BaseBorderPiece> pieces;
  const auto cut = [&](auto&& self, int side, double w0, double w1, int depth) -> void {
    double turn = 0;
    const BaseBorderPiece piece = border_piece(base, side, w0, w1, close, turn);
    if (piece.straight || turn <= kMostTurn || depth == kHalvings) {
      pieces.push_back(piece);
      return;
    }
    const double middle = 0.5 * (w0 + w1);
    self(self, side, w0, middle, depth + 1);
    self(self, side, middle, w1, depth + 1);
  };
  for (int side = 0; side < 4; ++side) {
    const int patches = static_cast<int>(std::lround(base.border_length(side)));
    for (int k = 0; k < patches * kPieces; ++k)
      cut(cut, side, static_cast<double>(k) / kPieces, static_cast<double>(k + 1) / kPieces, 0);
  }
  return pieces;
}

// To the last digit.
bool same_body(const Body& a, const Body& b) {
  if (a.index() != b.index()) return false;
  if (const auto* polyhedron = std::get_if<Polyhedron>(&a)) {
    const auto& other = std::get<Polyhedron>(b);
    const auto same_face = [](const PolyhedronFace& f, const PolyhedronFace& g) {
      return f.number == g.number && f.loop == g.loop;
    };
    return polyhedron->vertices == other.vertices &&
           std::equal(polyhedron->faces.begin(), polyhedron->faces.end(), other.faces.begin(),
                      other.faces.end(), same_face);
  }
  const auto &f = std::get<QuadricBody>(a), &g = std::get<QuadricBody>(b);
  return f.shape == g.shape && f.p == g.p && f.frame == g.frame && f.A == g.A && f.B == g.B &&
         f.C == g.C;
}

// Terms of one sign in a row, in one group: of two that are one and the same body under two names
// the later one shows nowhere, and what is said of it is said of the earlier.
class SameSolids {
 public:
  explicit SameSolids(const std::vector<Solid>& solids) : solids_(solids) {}

  void start_anew() { seen_.clear(); }

  // The row of the same body earlier in the run; else the row given, which is kept.
  std::int32_t first_row(std::int32_t solid, std::int32_t row) {
    const Body& body = solids_[static_cast<std::size_t>(solid)].body;
    const auto* polyhedron = std::get_if<Polyhedron>(&body);
    const Vec3& p = polyhedron ? polyhedron->vertices[0] : std::get<QuadricBody>(body).p;
    const std::array<double, 3> key{p.x(), p.y(), p.z()};
    const auto [from, to] = seen_.equal_range(key);
    for (auto it = from; it != to; ++it) {
      if (same_body(solids_[static_cast<std::size_t>(it->second.solid)].body, body))
        return it->second.row;
    }
    seen_.emplace(key, Seen{solid, row});
    return row;
  }

 private:
  struct Seen {
    std::int32_t solid, row;
  };
  const std::vector<Solid>& solids_;
  std::multimap<std::array<double, 3>, Seen> seen_;
};

// Whether two sides are one quadric: coefficients about one centre, scaled to one size.
bool same_quadric(const BodyLine& a, const BodyLine& b) {
  if (!a.has_side() || !b.has_side()) return false;
  const SideQuadratic &p = a.side(), &q = b.side();
  const auto form = [](const SideQuadratic& s) {
    Mat3 m;
    m << s.cxx, 0.5 * s.cxy, s.bx, 0.5 * s.cxy, s.cyy, s.by, s.bx, s.by, s.q2;
    return m;
  };
  const Mat3 mp = form(p), mq = form(q);
  const double np = mp.norm(), nq = mq.norm();
  constexpr double kSame =
      1e-12;  // of the coefficients: rounding of the ways a part program can state one body
  if ((mp / np - mq / nq).norm() > kSame) return false;
  const Vec3 shift(p.cx - q.cx, p.cy - q.cy, p.cz - q.cz);
  const Vec3 lp(0.5 * p.cx1, 0.5 * p.cy1, p.b0), lq(0.5 * q.cx1, 0.5 * q.cy1, q.b0);
  const Vec3 at_p = lq + mq * shift;
  const double reach = a.plan_box().x1 - a.plan_box().x0 + a.plan_box().y1 - a.plan_box().y0 +
                       a.z_high() - a.z_low();
  if ((lp / np - at_p / nq).norm() > kSame * reach) return false;
  const double cq = q.c0 + 2 * lq.dot(shift) + shift.dot(mq * shift);
  return std::fabs(p.c0 / np - cq / nq) <= kSame * reach * reach;
}

}  // namespace

void PlanIndex::build(const std::vector<CompoundStep>& steps, const std::vector<PlanBox>& boxes,
                      const PlanBox& extent) {
  boxes_ = boxes;
  extent_ = extent;
  // About one cell a step, so that a cell of an evenly filled plan holds a handful.
  const double w = std::fmax(extent.x1 - extent.x0, 1e-300),
               h = std::fmax(extent.y1 - extent.y0, 1e-300);
  const double cells = std::clamp(static_cast<double>(steps.size()), 1.0, 1e6);
  const double side = std::sqrt(w * h / cells);
  nx_ = static_cast<int>(std::clamp(w / side, 1.0, 2048.0));
  ny_ = static_cast<int>(std::clamp(h / side, 1.0, 2048.0));
  inv_dx_ = nx_ / w;
  inv_dy_ = ny_ / h;
  start_.assign(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) + 1, 0);
  items_.clear();
  const auto column = [&](double x) { return cell_of((x - extent_.x0) * inv_dx_, nx_); };
  const auto line = [&](double y) { return cell_of((y - extent_.y0) * inv_dy_, ny_); };
  // Two passes of counting sort; points outside the extent fall into the border cells, whose lists
  // hold every step that reaches beyond them because the clamp is monotone.
  for (int pass = 0; pass < 2; ++pass) {
    for (std::uint32_t i = 0; i < steps.size(); ++i) {
      const PlanBox& b = boxes_[i];
      if (!(b.x0 <= b.x1)) continue;
      for (int j = line(b.y0); j <= line(b.y1); ++j) {
        for (int k = column(b.x0); k <= column(b.x1); ++k) {
          const std::size_t cell = static_cast<std::size_t>(j) * static_cast<std::size_t>(nx_) +
                                   static_cast<std::size_t>(k);
          if (pass == 0) {
            ++start_[cell + 1];
          } else {
            items_[start_[cell]++] = i;
          }
        }
      }
    }
    if (pass == 0) {
      for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
      items_.resize(start_.back());
    } else {
      for (std::size_t c = start_.size() - 1; c > 0; --c) start_[c] = start_[c - 1];
      start_[0] = 0;
    }
  }
}

std::span<const std::uint32_t> PlanIndex::at(double x, double y) const {
  const int k = cell_of((x - extent_.x0) * inv_dx_, nx_);
  const int j = cell_of((y - extent_.y0) * inv_dy_, ny_);
  const std::size_t cell =
      static_cast<std::size_t>(j) * static_cast<std::size_t>(nx_) + static_cast<std::size_t>(k);
  return std::span(items_).subspan(start_[cell], start_[cell + 1] - start_[cell]);
}

void PlanIndex::over(const PlanBox& box, std::vector<std::uint32_t>& out) const {
  out.clear();
  const auto take = [&](std::uint32_t i) {
    const PlanBox& b = boxes_[i];
    if (b.x0 <= box.x1 && b.x1 >= box.x0 && b.y0 <= box.y1 && b.y1 >= box.y0) out.push_back(i);
  };
  const int k0 = cell_of((box.x0 - extent_.x0) * inv_dx_, nx_);
  const int k1 = cell_of((box.x1 - extent_.x0) * inv_dx_, nx_);
  const int j0 = cell_of((box.y0 - extent_.y0) * inv_dy_, ny_);
  const int j1 = cell_of((box.y1 - extent_.y0) * inv_dy_, ny_);
  const std::size_t cells =
      static_cast<std::size_t>(k1 - k0 + 1) * static_cast<std::size_t>(j1 - j0 + 1);
  // A cell costs about as much as a handful of boxes: its list, and the sorting out of repeats.
  constexpr std::size_t kCellCost = 8;
  if (cells * kCellCost > boxes_.size()) {
    for (std::uint32_t i = 0; i < boxes_.size(); ++i) take(i);
    return;
  }
  for (int j = j0; j <= j1; ++j) {
    for (int k = k0; k <= k1; ++k) {
      const std::size_t cell =
          static_cast<std::size_t>(j) * static_cast<std::size_t>(nx_) + static_cast<std::size_t>(k);
      for (std::uint32_t at = start_[cell]; at < start_[cell + 1]; ++at) take(items_[at]);
    }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
}

bool CompoundSurface::Impl::base_at(double x, double y, BaseHit& hit) const {
  if (const PlaneSurface* plane = std::get_if<PlaneSurface>(&base)) return plane->at(x, y, hit);
  if (const FergusonSurface* ferguson = std::get_if<FergusonSurface>(&base)) {
    FergusonHint hint;
    return ferguson->at(x, y, hit, hint);
  }
  if (const ScannedSurface* scan = std::get_if<ScannedSurface>(&base)) return scan->at(x, y, hit);
  return false;
}

namespace {

// Equation (5) over one line. `outlasts(newer, older)` is asked where the two are a tie or less
// apart: true where the newer term takes the point. `grazes(newer, older)` is asked where the newer
// one is ahead by more, but no more than kLineSlack ties: true where that is rounding, and the
// older stays.
template <class Outlasts, class Grazes>
LineState evaluate_by(const CompoundSurface::Impl& surface,
                      std::span<const std::uint32_t> steps_here, double x, double y,
                      const Outlasts& outlasts, const Grazes& grazes) {
  const double tie = surface.tie;
  const auto takes = [&](double ahead, const LineState& newer, const LineState& older) {
    if (ahead > kLineSlack * tie) return true;
    if (ahead > tie) return !grazes(newer, older);
    return ahead >= -tie && outlasts(newer, older);
  };
  LineState stack[kMaxNesting + 1];
  std::size_t depth = 0;
  LineState state;
  LineHit hit;
  BaseHit base_hit;
  for (const std::uint32_t i : steps_here) {
    const CompoundStep& step = surface.steps[i];
    LineState e;
    if (step.kind == BooleanStep::Kind::kTerm) {
      const bool plus = step.sign == Sign::kPlus;
      if (!plus && state.label == kNoLabel) continue;
      if (step.solid < 0) {
        if (!surface.base_at(x, y, base_hit)) continue;
        e = {base_hit.z, make_label(step.row, 0)};
      } else {
        if (!surface.bodies[static_cast<std::size_t>(step.solid)].meet(x, y, hit)) continue;
        e = plus ? LineState{hit.upper, make_label(step.row, hit.upper_face)}
                 : LineState{hit.lower, make_label(step.row, hit.lower_face)};
      }
      if (!plus) {
        if (takes(state.z - e.z, e, state)) state = e;
        continue;
      }
    } else if (step.kind == BooleanStep::Kind::kGroupOpen) {
      stack[depth++] = state;
      state = {};
      continue;
    } else {
      e = state;
      state = stack[--depth];
      if (e.label == kNoLabel) continue;
    }
    if (state.label == kNoLabel || takes(e.z - state.z, e, state)) state = e;
  }
  return state;
}

}  // namespace

LineState CompoundSurface::Impl::evaluate(std::span<const std::uint32_t> steps_here, double x,
                                          double y) const {
  const auto never = [](const LineState&, const LineState&) { return false; };
  return evaluate_by(*this, steps_here, x, y, never, never);
}

LineState CompoundSurface::Impl::evaluate_face(double x, double y) const {
  const auto is_plus = [&](Label label) {
    return steps[step_of_row[static_cast<std::size_t>(row_of(label))]].sign == Sign::kPlus;
  };
  LineState state = evaluate_by(
      *this, index.at(x, y), x, y,
      [&](const LineState& newer, const LineState& older) {
        return is_plus(newer.label) ? touches_from_above(newer.label, older.label, x, y, false)
                                    : touches_from_above(older.label, newer.label, x, y, false);
      },
      [&](const LineState& newer, const LineState& older) {
        return is_plus(newer.label) ? touches_from_above(older.label, newer.label, x, y, true)
                                    : touches_from_above(newer.label, older.label, x, y, true);
      });
  state.label = face_label(state.label);
  return state;
}

bool CompoundSurface::Impl::touches_from_above(Label f, Label g, double x, double y,
                                               bool planes_alone) const {
  struct Seen {
    const BodyLine* body = nullptr;
    std::int32_t solid = -1;
    std::uint8_t face = 0;
    bool upper = true, side = false;
  };
  const auto seen = [&](Label label) {
    const CompoundStep& step = steps[step_of_row[static_cast<std::size_t>(row_of(label))]];
    Seen s;
    s.solid = step.solid;
    s.face = static_cast<std::uint8_t>(face_of(label));
    s.upper = step.sign == Sign::kPlus;
    if (step.solid < 0) return s;
    s.body = &bodies[static_cast<std::size_t>(step.solid)];
    s.side = s.body->has_side() && s.face == kFaceSide &&
             s.body->side_rule() == SideRule::kBetween && s.body->side().q2 > 0;
    return s;
  };
  const Seen above = seen(f), below = seen(g);
  if (above.side && below.side) {
    return !planes_alone && contacts.is_above({above.solid, above.upper, !above.upper},
                                              {below.solid, below.upper, !below.upper});
  }
  if (above.side == below.side) return false;
  // The plane of the other one.
  const Seen& flat = above.side ? below : above;
  Vec3 at(x, y, 0);
  double zx = 0, zy = 0;
  if (flat.body == nullptr) {
    BaseHit hit;
    if (!std::holds_alternative<PlaneSurface>(base) || !base_at(x, y, hit)) return false;
    at.z() = hit.z;
    zx = hit.zx;
    zy = hit.zy;
  } else {
    const std::vector<PlanarCap>& caps =
        flat.upper ? flat.body->upper_caps() : flat.body->lower_caps();
    const auto cap = std::find_if(caps.begin(), caps.end(),
                                  [&](const PlanarCap& c) { return c.face == flat.face; });
    if (cap == caps.end()) return false;
    zx = cap->zx;
    zy = cap->zy;
    at.z() = cap->z0 + zx * (x - flat.body->center_x()) + zy * (y - flat.body->center_y());
  }
  // Ties are that near to where the two touch, for any that bend at all. (Of the line they touch
  // along only what is beside the point counts: a cell, too, knows no more of it than its own
  // part.)
  const double reach = 1e-3 * size;
  const int sign = side_of_tangent_plane(*(above.side ? above : below).body, at, zx, zy, {reach, 0},
                                         kLineSlack * tie);
  return above.side ? sign < 0 : sign > 0;
}

Vec3 CompoundSurface::Impl::normal(Label label, const Vec3& point) const {
  const CompoundStep& step = steps[step_of_row[static_cast<std::size_t>(row_of(label))]];
  Vec3 n;
  if (step.solid < 0) {
    BaseHit hit;
    if (!base_at(point.x(), point.y(), hit)) return Vec3::UnitZ();
    const ScannedSurface* scan = std::get_if<ScannedSurface>(&base);
    n = scan != nullptr ? scan->normal(hit.face, point.x(), point.y())
                        : Vec3(-hit.zx, -hit.zy, 1).normalized();
  } else {
    n = bodies[static_cast<std::size_t>(step.solid)].normal(
        static_cast<std::uint8_t>(face_of(label)), point);
  }
  return n.z() < 0 ? Vec3(-n) : n;
}

Result<CompoundSurface> CompoundSurface::make(const PartProgram& program,
                                              std::optional<TriangleMesh> scan) {
  auto impl = std::make_unique<Impl>();
  impl->program = program;
  const PartProgram& own = impl->program;
  if (const MeshBase* mesh = std::get_if<MeshBase>(&own.base)) {
    if (!scan) return Error{ErrorCode::kInput, "the scan of the base is missing", mesh->where};
    Result<ScannedSurface> surface = ScannedSurface::make(std::move(*scan), *mesh);
    if (!surface) return surface.error();
    if (Status done = resolve_domain(*surface, impl->program); !done) return done.error();
    const PlanBox& plan = surface->plan_box();
    for (const double v : {plan.x0, plan.x1, plan.y0, plan.y1, surface->z_low(), surface->z_high()})
      impl->size = std::fmax(impl->size, std::fabs(v));
    impl->base.emplace<ScannedSurface>(std::move(*surface));
  }
  // A first pass without slack gives the size that the slack follows from.
  for (const Solid& solid : own.solids) impl->bodies.emplace_back(solid.body, 0.0);
  impl->size = std::fmax(impl->size, largest_coordinate(own, impl->bodies));
  impl->tie = std::ldexp(impl->size, -42);
  impl->bodies.clear();
  const Machining& plan = impl->program.machining;
  const double side =
      std::fmax(plan.x_range[1] - plan.x_range[0], plan.y_range[1] - plan.y_range[0]);
  for (Solid& solid : impl->program.solids) {
    if (auto* polyhedron = std::get_if<Polyhedron>(&solid.body))
      stand_upright(*polyhedron, kUprightWidth * std::fmin(side, impl->size));
    impl->bodies.emplace_back(solid.body, impl->tie);
  }

  // Sides that are one quadric, found among neighbours in plan (64 of them: more in one place are
  // not told).
  std::vector<std::size_t> order(impl->bodies.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return impl->bodies[i].side().cx < impl->bodies[j].side().cx;
  });
  impl->side_class.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) impl->side_class[i] = static_cast<std::int32_t>(i);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const BodyLine& a = impl->bodies[order[k]];
    for (std::size_t n = k + 1; n < order.size() && n < k + 64; ++n) {
      if (!same_quadric(a, impl->bodies[order[n]])) continue;
      const std::int32_t first = std::min(impl->side_class[order[k]], impl->side_class[order[n]]);
      impl->side_class[order[k]] = impl->side_class[order[n]] = first;
    }
  }

  impl->contacts.build(impl->bodies, kLineSlack * impl->tie);

  if (const PlaneBase* plane = std::get_if<PlaneBase>(&own.base)) {
    impl->base.emplace<PlaneSurface>(*plane);
  } else if (const FergusonBase* ferguson = std::get_if<FergusonBase>(&own.base)) {
    Result<FergusonSurface> surface = FergusonSurface::make(*ferguson);
    if (!surface) return surface.error();
    impl->base.emplace<FergusonSurface>(std::move(*surface));
    impl->base_border =
        border_pieces(std::get<FergusonSurface>(impl->base), std::ldexp(impl->size, -40));
  }

  // Boxes of the steps; a group's opening and closing reach over all its members.
  constexpr double kInf = std::numeric_limits<double>::infinity();
  std::vector<PlanBox> boxes;
  std::vector<std::size_t> open;
  std::map<std::pair<int, Sign>, std::int32_t> first_rows;
  SameSolids same(own.solids);
  Sign last_sign = Sign::kPlus;
  for (const BooleanStep& step : own.boole) {
    const auto index = static_cast<std::uint32_t>(impl->steps.size());
    PlanBox box{kInf, -kInf, kInf, -kInf};
    switch (step.kind) {
      case BooleanStep::Kind::kTerm:
        box = step.surface == 0
                  ? PlanBox{-kInf, kInf, -kInf, kInf}
                  : impl->bodies[static_cast<std::size_t>(step.surface - 1)].plan_box();
        impl->step_of_row.push_back(index);
        break;
      case BooleanStep::Kind::kGroupOpen:
        open.push_back(index);
        break;
      case BooleanStep::Kind::kGroupClose: {
        for (std::size_t i = open.back() + 1; i < index; ++i) {
          box = {std::fmin(box.x0, boxes[i].x0), std::fmax(box.x1, boxes[i].x1),
                 std::fmin(box.y0, boxes[i].y0), std::fmax(box.y1, boxes[i].y1)};
        }
        boxes[open.back()] = box;
        open.pop_back();
        break;
      }
    }
    std::int32_t first_row = step.row;
    if (step.kind != BooleanStep::Kind::kTerm || step.sign != last_sign) same.start_anew();
    last_sign = step.sign;
    if (step.kind == BooleanStep::Kind::kTerm) {
      const auto key = std::make_pair(step.surface, step.sign);
      first_row = first_rows.try_emplace(key, step.row).first->second;
      if (step.surface > 0) first_row = same.first_row(step.surface - 1, first_row);
    }
    impl->steps.push_back({step.kind, step.sign, step.surface - 1, step.row, first_row});
    boxes.push_back(box);
  }
  const Machining& m = own.machining;
  impl->index.build(impl->steps, boxes, {m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]});
  return CompoundSurface(std::move(impl));
}

CompoundSurface::CompoundSurface(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}
CompoundSurface::CompoundSurface(CompoundSurface&&) noexcept = default;
CompoundSurface& CompoundSurface::operator=(CompoundSurface&&) noexcept = default;
CompoundSurface::~CompoundSurface() = default;

std::optional<CcDatum> CompoundSurface::at(double x, double y) const {
  const LineState state = impl_->evaluate(x, y);
  if (state.label == kNoLabel) return std::nullopt;
  CcDatum datum;
  datum.z = state.z;
  datum.row = row_of(state.label);
  datum.face = face_of(state.label);
  datum.surface = surface_of_row(datum.row);
  datum.n = impl_->normal(state.label, Vec3(x, y, state.z));
  return datum;
}

const PartProgram& CompoundSurface::program() const { return impl_->program; }
double CompoundSurface::size() const { return impl_->size; }
double CompoundSurface::tie_tolerance() const { return impl_->tie; }
int CompoundSurface::row_count() const { return static_cast<int>(impl_->step_of_row.size()); }

int CompoundSurface::surface_of_row(int row) const {
  return impl_->steps[impl_->step_of_row[static_cast<std::size_t>(row)]].solid + 1;
}

Sign CompoundSurface::sign_of_row(int row) const {
  return impl_->steps[impl_->step_of_row[static_cast<std::size_t>(row)]].sign;
}

std::string CompoundSurface::element_name(Label label) const {
  const int surface = surface_of_row(row_of(label));
  if (surface == 0) return "B";
  const Solid& solid = impl_->program.solids[static_cast<std::size_t>(surface - 1)];
  return solid.id + '.' + face_name(solid.body, static_cast<std::uint8_t>(face_of(label)));
}

}  // namespace diesink
