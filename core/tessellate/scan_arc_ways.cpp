// The ways of arcs over the triangles of the sheet.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/scan_arc_cutter.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;
constexpr int kMostHalvings = 44;
// Pieces of one stretch between two cells: more than it has triangles under it.
constexpr std::size_t kMostSteps = 20'000;

}  // namespace

// Heights of both labels at a point of the curve over the base height base_z.
void ArcCutter::set_heights(PlanNode& n, const PlanCurve& curve, double curve_z,
                            double base_z) const {
  n.heights.clear();
  const bool on_base = curve.is_height_of({SurfaceRef::kBase, 0});
  for (const Label label : {left_, right_}) {
    if (label == kNoLabel) continue;
    double z = base_z;
    if (!is_base(surface_, label)) {
      if (curve.is_height_of(solver_.ref_of(label))) {
        z = on_base ? base_z : curve_z;
      } else if (!solver_.height(label, n.x, n.y, z)) {
        z = base_z;
      }
      if (std::fabs(z - base_z) <= 1e-9 * surface_.size) z = base_z;  // a wall too low to be one
    }
    n.heights.push_back({label, z});
  }
}

// Where the curve near the chord from a to b passes over an edge of the sheet.
bool ArcCutter::crossing(std::uint32_t a, std::uint32_t b, const PlanCurve& curve, std::uint32_t h,
                         std::uint32_t triangle, std::uint32_t& made) {
  const Vec3 &u = sheet_.points[sheet_.from(h)], &v = sheet_.points[sheet_.to(h)];
  const Vec2 p = u.head<2>(), d = (v - u).head<2>();
  const Vec2 c = at(a), along = at(b) - c;
  const double det = d.x() * along.y() - d.y() * along.x();
  if (det == 0) return false;
  double t = ((c.x() - p.x()) * along.y() - (c.y() - p.y()) * along.x()) / det;
  double z = u.z() + t * (v.z() - u.z());
  const bool on_curve = curve.type == CurveType::kMeet || curve.type == CurveType::kShadow;
  if (on_curve) {
    t = std::clamp(t, 0.0, 1.0);
    z = u.z() + t * (v.z() - u.z());
    if (curve.type == CurveType::kShadow) {
      z = solver_.shadow_height(curve, p.x() + t * d.x(), p.y() + t * d.y());
    } else if (!curve.is_height_of({SurfaceRef::kBase, 0})) {
      const Label over = base_left_ ? right_ : left_;
      z = 0.5 * (height_in(a, over, z) + height_in(b, over, z));
    }
    if (!solver_.on_line(on_triangle(curve, triangle), p, d, t, z)) return false;
  }
  const double length = d.norm(), slack = near_ / length;
  if (!(t >= -slack && t <= 1 + slack)) return false;
  t = std::clamp(t, 0.0, 1.0);
  const Vec2 q = p + t * d;
  if ((q - 0.5 * (at(a) + at(b))).norm() > 0.75 * along.norm() + near_) return false;
  // A curve may pass over an edge twice: the other crossing is none of this stretch.
  const double way = along.dot(q - c), whole = along.squaredNorm(), beside = near_ * along.norm();
  if (!(way >= -beside && way <= whole + beside)) return false;
  PlanNode n;
  n.x = q.x();
  n.y = q.y();
  n.solved = on_curve;
  const double base_z = u.z() + t * (v.z() - u.z());
  set_heights(n, curve, z, base_z);
  ScanPlace where{ScanPlace::Kind::kEdge, canonical(h)};
  if (t * length <= near_) where = {ScanPlace::Kind::kVertex, sheet_.from(h)};
  if ((1 - t) * length <= near_) where = {ScanPlace::Kind::kVertex, sheet_.to(h)};
  made = add_node(std::move(n), where);
  return made != a && made != b;
}

// A point of the curve half way from a to b.
std::uint32_t ArcCutter::middle(std::uint32_t a, std::uint32_t b, const PlanCurve& curve) {
  PlanNode n;
  BaseHit hit;
  bool solved = false;
  if (curve.type == CurveType::kMeet || curve.type == CurveType::kShadow) {
    std::vector<std::uint32_t> near_a, near_b;
    triangles_at(out_.place[a], near_a);
    triangles_at(out_.place[b], near_b);
    near_a.insert(near_a.end(), near_b.begin(), near_b.end());
    near_a.push_back(SurfaceRef::kWhole);
    for (const std::uint32_t t : near_a) {
      solved = point_on_stretch(surface_, solver_, on_triangle(curve, t), left_, right_, node(a),
                                node(b), 0.5, n) &&
               scan_.at(n.x, n.y, hit);
      for (const LabelHeight& h : n.heights) {
        if (h.label == base_ && curve.type == CurveType::kMeet)
          solved = solved && std::fabs(h.z - hit.z) <= 1e-9 * surface_.size;
      }
      if (solved) break;
    }
  }
  if (!solved) {
    n = PlanNode{};
    const Vec2 m = 0.5 * (at(a) + at(b));
    n.x = node(a).x == node(b).x ? node(a).x : m.x();
    n.y = node(a).y == node(b).y ? node(a).y : m.y();
    n.solved = false;
    const double between =
        0.5 * (height_in(a, base_, node(a).heights.empty() ? 0 : node(a).heights[0].z) +
               height_in(b, base_, node(b).heights.empty() ? 0 : node(b).heights[0].z));
    set_heights(n, curve, between, scan_.at(n.x, n.y, hit) ? hit.z : between);
  }
  return add_node(std::move(n), locate({n.x, n.y}));
}

// Both ends of a stretch touch a triangle, and the curve in its plane runs out over an edge and
// back in between: a node out there, or kNone where it does not. (Looked for at the quarters and at
// the peaks of the parabolas through them; what stays unseen is as low as a conic is off a
// parabola.)
std::uint32_t ArcCutter::beyond_edge(std::uint32_t a, std::uint32_t b, const PlanCurve& curve,
                                     std::uint32_t triangle) {
  if (curve.type != CurveType::kMeet && curve.type != CurveType::kShadow) return kNone;
  const PlanCurve here = on_triangle(curve, triangle);
  const auto point_at = [&](double s, PlanNode& n) {
    return point_on_stretch(surface_, solver_, here, left_, right_, node(a), node(b), s, n);
  };
  // How far a point lies out over each edge.
  const auto out_of = [&](const Vec2& p) {
    std::array<double, 3> out{};
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t h = 3 * triangle + k;
      const Vec2 u = point(sheet_.from(h)), d = point(sheet_.to(h)) - u;
      out[k] = (d.y() * (p.x() - u.x()) - d.x() * (p.y() - u.y())) / d.norm();
    }
    return out;
  };
  std::array<std::array<double, 3>, 5> out{out_of(at(a)), {}, {}, {}, out_of(at(b))};  // quarters
  PlanNode n;
  if (!point_at(0.5, n)) return kNone;
  out[2] = out_of({n.x, n.y});
  bool may_leave = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const double bulge = out[2][k] - 0.5 * (out[0][k] + out[4][k]);
    may_leave = may_leave || (bulge > near_ && std::fmax(out[0][k], out[4][k]) + 2 * bulge > 0);
  }
  if (!may_leave) return kNone;
  for (const std::size_t i : {1, 3}) {
    if (!point_at(0.25 * static_cast<double>(i), n)) return kNone;
    out[i] = out_of({n.x, n.y});
  }
  double best = 4 * near_, s_best = 0;
  const auto consider = [&](double s) {
    if (!point_at(s, n)) return;
    for (const double o : out_of({n.x, n.y})) {
      if (o <= best) continue;
      best = o;
      s_best = s;
    }
  };
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 1; i <= 3; ++i) {
      const double curved = out[i - 1][k] - 2 * out[i][k] + out[i + 1][k];
      const double peak = curved < 0 ? 0.5 * (out[i - 1][k] - out[i + 1][k]) / curved : 0;
      if (std::fabs(peak) <= 1) consider(0.25 * (static_cast<double>(i) + peak));
    }
  }
  if (s_best == 0 || !point_at(s_best, n)) return kNone;
  BaseHit hit;
  if (!scan_.at(n.x, n.y, hit)) return kNone;
  // In the plane of the triangle out there the curve is another.
  PlanNode over;
  if (!point_on_stretch(surface_, solver_, on_triangle(curve, hit.face), left_, right_, node(a),
                        node(b), s_best, over) ||
      !scan_.at(over.x, over.y, hit))
    return kNone;
  for (const LabelHeight& h : over.heights) {
    if (h.label == base_ && !(std::fabs(h.z - hit.z) <= 1e-9 * surface_.size)) return kNone;
  }
  const ScanPlace there = place_in(hit.face, {over.x, over.y});
  std::vector<std::uint32_t> touched;
  triangles_at(there, touched);
  if (std::find(touched.begin(), touched.end(), triangle) != touched.end()) return kNone;
  return add_node(std::move(over), there);
}

void ArcCutter::emit(std::uint32_t n, PlanCurve curve, std::uint32_t triangle) {
  if (n == nodes_.back()) return;
  if (triangle != kNone) {
    curve = on_triangle(curve, triangle);
    out_.touched[triangle] = 1;
  }
  nodes_.push_back(n);
  curves_.push_back(curve);
}

void ArcCutter::trace(std::uint32_t a, std::uint32_t b, const PlanCurve& curve, int depth) {
  if (a == b) return;
  std::vector<std::uint32_t> ta, tb;
  triangles_at(place(a), ta);
  triangles_at(place(b), tb);
  // A triangle that both ends touch; of two the one on the base's side of the chord.
  std::uint32_t common = kNone;
  double best = -std::numeric_limits<double>::infinity();
  const Vec2 p = at(a), d = at(b) - p;
  for (const std::uint32_t t : ta) {
    if (std::find(tb.begin(), tb.end(), t) == tb.end()) continue;
    const auto& of = sheet_.triangles[t];
    const Vec2 centre = (point(of[0]) + point(of[1]) + point(of[2])) / 3 - p;
    const double side = (d.x() * centre.y() - d.y() * centre.x()) * (base_left_ ? 1 : -1);
    out_.touched[t] = 1;
    if (side > best) {
      best = side;
      common = t;
    }
  }
  if (common != kNone) {
    const std::uint32_t m = depth > kMostHalvings ? kNone : beyond_edge(a, b, curve, common);
    if (m == kNone || m == a || m == b) {
      emit(b, curve, common);
      return;
    }
    trace(a, m, curve, depth + 1);
    trace(m, b, curve, depth + 1);
    return;
  }
  for (const std::uint32_t t : ta) out_.touched[t] = 1;
  for (const std::uint32_t t : tb) out_.touched[t] = 1;
  // Beside the scan there is nothing to pass over; and a way that never ends in one triangle is cut
  // short.
  const bool lost = (ta.empty() && tb.empty()) || ++trace_steps_ > kMostSteps;
  if (lost || d.norm() <= near_ || depth > kMostHalvings) {
    out_.unsolved_length += d.norm();
    emit(b, curve, ta.empty() ? (tb.empty() ? kNone : tb[0]) : ta[0]);
    return;
  }
  for (const std::uint32_t t : ta) {
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      const std::uint32_t twin = sheet_.twin[h];
      if (twin == kNone || std::find(tb.begin(), tb.end(), twin / 3) == tb.end()) continue;
      std::uint32_t x = kNone;
      if (!crossing(a, b, curve, h, t, x)) continue;
      trace(a, x, curve, depth + 1);
      trace(x, b, curve, depth + 1);
      return;
    }
  }
  const std::uint32_t m = middle(a, b, curve);
  if (m == a || m == b) {
    out_.unsolved_length += d.norm();
    emit(b, curve, kNone);
    return;
  }
  trace(a, m, curve, depth + 1);
  trace(m, b, curve, depth + 1);
}

}  // namespace diesink
