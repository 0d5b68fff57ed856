// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/scan_arcs.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;
constexpr std::uint32_t kNone = ScanSheet::kNone;
constexpr int kMostHalvings = 44;
// Pieces of one stretch between two cells: more than it has triangles under it.
constexpr std::size_t kMostSteps = 20'000;

class ArcCutter {
 public:
  ArcCutter(const Impl& surface, const ScanSheet& sheet, double least, Arrangement& arrangement)
      : surface_(surface),
        sheet_(sheet),
        scan_(std::get<ScannedSurface>(surface.base)),
        arrangement_(arrangement),
        solver_(surface),
        near_(1e-10 * surface.size),
        least_(std::fmax(least, 16 * near_)) {
    sheet.fans(begins_, around_);
    out_.touched.assign(sheet.triangles.size(), 0);
    out_.node_at.assign(sheet.points.size(), kNone);
    out_.place.resize(arrangement.nodes.size());
  }

  ScanArcs run() {
    drop_specks();
    // Ends of the base first: where its border meets other curves.
    name_outlines();
    for (const PlanArc& arc : arrangement_.arcs) {
      for (std::size_t k = 0; k < arc.curves.size(); ++k) {
        if (arc.curves[k].type != CurveType::kOutline) continue;
        snap_to_border(arc.nodes[k]);
        snap_to_border(arc.nodes[k + 1]);
      }
    }
    solve_border_corners();
    drop_specks();
    for (PlanArc& arc : arrangement_.arcs) {
      if (base_label(arc) != kNoLabel || has_outline(arc)) cut(arc);
    }
    // Nodes at one vertex of the sheet are one node.
    for (PlanArc& arc : arrangement_.arcs) {
      for (std::uint32_t& n : arc.nodes) {
        if (out_.place[n].kind != ScanPlace::Kind::kVertex) continue;
        const std::uint32_t kept = out_.node_at[out_.place[n].id];
        if (kept == n) continue;
        for (const LabelHeight& h : node(n).heights) {
          if (std::isnan(height_in(kept, h.label, std::numeric_limits<double>::quiet_NaN())))
            node(kept).heights.push_back(h);
        }
        node(kept).corner = node(kept).corner || node(n).corner;
        n = kept;
      }
    }
    return std::move(out_);
  }

 private:
  [[nodiscard]] Label base_label(const PlanArc& arc) const {
    if (is_base(surface_, arc.left)) return arc.left;
    if (!arc.border && is_base(surface_, arc.right)) return arc.right;
    return kNoLabel;
  }
  [[nodiscard]] PlanNode& node(std::uint32_t n) { return arrangement_.nodes[n]; }
  [[nodiscard]] Vec2 at(std::uint32_t n) const {
    return {arrangement_.nodes[n].x, arrangement_.nodes[n].y};
  }
  [[nodiscard]] Vec2 point(std::uint32_t v) const { return sheet_.points[v].head<2>(); }
  [[nodiscard]] std::uint32_t canonical(std::uint32_t h) const {
    return std::min(h, sheet_.twin[h]);  // kNone is the highest
  }

  ScanPlace place_in(std::uint32_t t, const Vec2& p) const;
  ScanPlace locate(const Vec2& p) const;
  const ScanPlace& place(std::uint32_t n);
  void triangles_at(const ScanPlace& place, std::vector<std::uint32_t>& out) const;
  std::uint32_t add_node(PlanNode made, const ScanPlace& where);
  void settle(std::uint32_t n);
  void snap_to_border(std::uint32_t n);

  void drop_specks();
  [[nodiscard]] bool is_near_border(const Vec2& p) const;
  void name_outlines();
  void solve_border_corners();
  [[nodiscard]] static bool has_outline(const PlanArc& arc) {
    return std::any_of(arc.curves.begin(), arc.curves.end(),
                       [](const PlanCurve& c) { return c.type == CurveType::kOutline; });
  }
  void cut(PlanArc& arc);
  void trace(std::uint32_t a, std::uint32_t b, const PlanCurve& curve, int depth);
  void follow_border(std::uint32_t a, std::uint32_t b, const PlanCurve& curve);
  void emit(std::uint32_t n, PlanCurve curve, std::uint32_t triangle);
  [[nodiscard]] PlanCurve on_triangle(PlanCurve curve, std::uint32_t triangle) const {
    if (curve.first.solid == SurfaceRef::kBase) curve.first.facet = triangle;
    if (curve.second.solid == SurfaceRef::kBase) curve.second.facet = triangle;
    return curve;
  }
  bool crossing(std::uint32_t a, std::uint32_t b, const PlanCurve& curve, std::uint32_t h,
                std::uint32_t triangle, std::uint32_t& made);
  std::uint32_t middle(std::uint32_t a, std::uint32_t b, const PlanCurve& curve);
  std::uint32_t beyond_edge(std::uint32_t a, std::uint32_t b, const PlanCurve& curve,
                            std::uint32_t triangle);
  void set_heights(PlanNode& n, const PlanCurve& curve, double curve_z, double base_z) const;
  [[nodiscard]] double height_in(std::uint32_t n, Label label, double otherwise) const {
    for (const LabelHeight& h : arrangement_.nodes[n].heights) {
      if (h.label == label) return h.z;
    }
    return otherwise;
  }

  const Impl& surface_;
  const ScanSheet& sheet_;
  const ScannedSurface& scan_;
  Arrangement& arrangement_;
  CurveSolver solver_;
  double near_, least_;
  std::vector<std::uint32_t> begins_, around_;
  ScanArcs out_;
  // The arc at work.
  Label left_ = kNoLabel, right_ = kNoLabel, base_ = kNoLabel;
  bool base_left_ = true;
  std::vector<std::uint32_t> nodes_;
  std::vector<PlanCurve> curves_;
  std::size_t trace_steps_ = 0;
};

ScanPlace ArcCutter::place_in(std::uint32_t t, const Vec2& p) const {
  ScanPlace where{ScanPlace::Kind::kTriangle, t};
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t v = sheet_.triangles[t][k];
    if ((point(v) - p).norm() <= near_) return {ScanPlace::Kind::kVertex, v};
  }
  double best = near_;
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t h = 3 * t + k;
    const Vec2 a = point(sheet_.from(h)), d = point(sheet_.to(h)) - a;
    const double length = d.norm();
    const double off = std::fabs(d.x() * (p.y() - a.y()) - d.y() * (p.x() - a.x())) / length;
    if (off <= best) {
      best = off;
      where = {ScanPlace::Kind::kEdge, canonical(h)};
    }
  }
  return where;
}

ScanPlace ArcCutter::locate(const Vec2& p) const {
  BaseHit hit;
  if (scan_.at(p.x(), p.y(), hit)) return place_in(hit.face, p);
  return {};
}

const ScanPlace& ArcCutter::place(std::uint32_t n) {
  ScanPlace& where = out_.place[n];
  if (where.kind == ScanPlace::Kind::kUnknown) {
    where = locate(at(n));
    if (where.kind == ScanPlace::Kind::kUnknown) snap_to_border(n);
    settle(n);
  }
  return out_.place[n];
}

// A node at a vertex or on an edge of the sheet is there to the digit, in height too.
void ArcCutter::settle(std::uint32_t n) {
  const ScanPlace& where = out_.place[n];
  PlanNode& p = node(n);
  double z = 0;
  if (where.kind == ScanPlace::Kind::kVertex) {
    const Vec3& v = sheet_.points[where.id];
    // Border nodes keep the border's coordinate: a cut vertex has the same.
    p.x = v.x();
    p.y = v.y();
    z = v.z();
    if (out_.node_at[where.id] == kNone) out_.node_at[where.id] = n;
  } else if (where.kind == ScanPlace::Kind::kEdge) {
    const Vec3 &a = sheet_.points[sheet_.from(where.id)], &b = sheet_.points[sheet_.to(where.id)];
    const Vec2 d = (b - a).head<2>();
    const double s = std::clamp(d.dot(at(n) - a.head<2>()) / d.squaredNorm(), 0.0, 1.0);
    z = a.z() + s * (b.z() - a.z());
  } else {
    return;
  }
  p.kept = true;
  if (p.seam && where.kind == ScanPlace::Kind::kEdge) return;  // the seam has said how high
  double before = z;
  bool known = false;
  for (const LabelHeight& h : p.heights) {
    if (is_base(surface_, h.label)) {
      before = h.z;
      known = true;
    }
  }
  if (!known) return;
  for (LabelHeight& h : p.heights) {
    if (h.z == before) h.z = z;
  }
}

// The nearest point of the sheet's border, for a node found by halving beside it.
void ArcCutter::snap_to_border(std::uint32_t n) {
  const Vec2 p = at(n);
  std::vector<std::uint32_t> edges;
  const auto& border = scan_.border_edges();
  double best = std::numeric_limits<double>::infinity();
  std::uint32_t u = kNone, w = kNone;
  double s_best = 0;
  if (out_.place[n].kind != ScanPlace::Kind::kUnknown) return;
  for (const double reach : {4 * least_, 64 * least_}) {
    if (u != kNone) break;
    scan_.border_over({p.x() - reach, p.x() + reach, p.y() - reach, p.y() + reach}, 4096, edges);
    for (const std::uint32_t e : edges) {
      const Vec2 a = point(border[e][0]), d = point(border[e][1]) - a;
      const double s = std::clamp(d.dot(p - a) / d.squaredNorm(), 0.0, 1.0);
      const double off = (a + s * d - p).norm();
      if (off < best) {
        best = off;
        u = border[e][0];
        w = border[e][1];
        s_best = s;
      }
    }
  }
  if (u == kNone) return;
  const Vec2 a = point(u), d = point(w) - a;
  const double length = d.norm();
  ScanPlace& where = out_.place[n];
  if (s_best * length <= 2 * least_ || (1 - s_best) * length <= 2 * least_) {
    where = {ScanPlace::Kind::kVertex, s_best < 0.5 ? u : w};
  } else {
    for (std::uint32_t k = begins_[u]; k < begins_[u + 1]; ++k) {
      for (const std::uint32_t h : {around_[k], ScanSheet::previous(around_[k])}) {
        const bool same = (sheet_.from(h) == u && sheet_.to(h) == w) ||
                          (sheet_.from(h) == w && sheet_.to(h) == u);
        if (same) where = {ScanPlace::Kind::kEdge, canonical(h)};
      }
    }
    const Vec2 q = a + s_best * d;
    if (!node(n).border) {
      node(n).x = q.x();
      node(n).y = q.y();
    }
  }
  double base_z = std::numeric_limits<double>::quiet_NaN();
  for (const LabelHeight& h : node(n).heights) {
    if (is_base(surface_, h.label)) base_z = h.z;
  }
  settle(n);
  if (node(n).seam) return;
  // What is beside or over the base there is at its own height over the new place.
  for (LabelHeight& h : node(n).heights) {
    double z = 0;
    if (!is_base(surface_, h.label) && h.z != base_z &&
        solver_.height(h.label, node(n).x, node(n).y, z))
      h.z = z;
  }
}

void ArcCutter::triangles_at(const ScanPlace& place, std::vector<std::uint32_t>& out) const {
  out.clear();
  switch (place.kind) {
    case ScanPlace::Kind::kUnknown:
      break;
    case ScanPlace::Kind::kTriangle:
      out.push_back(place.id);
      break;
    case ScanPlace::Kind::kEdge:
      out.push_back(place.id / 3);
      if (sheet_.twin[place.id] != kNone) out.push_back(sheet_.twin[place.id] / 3);
      break;
    case ScanPlace::Kind::kVertex:
      for (std::uint32_t k = begins_[place.id]; k < begins_[place.id + 1]; ++k)
        out.push_back(around_[k] / 3);
      break;
  }
}

std::uint32_t ArcCutter::add_node(PlanNode made, const ScanPlace& where) {
  // One node a vertex, whichever arc comes there.
  if (where.kind == ScanPlace::Kind::kVertex && out_.node_at[where.id] != kNone) {
    const std::uint32_t known = out_.node_at[where.id];
    for (const LabelHeight& h : made.heights) {
      if (std::isnan(height_in(known, h.label, std::numeric_limits<double>::quiet_NaN())))
        node(known).heights.push_back(h);
    }
    return known;
  }
  const auto n = static_cast<std::uint32_t>(arrangement_.nodes.size());
  arrangement_.nodes.push_back(std::move(made));
  out_.place.push_back(where);
  settle(n);
  return n;
}

// Heights of both labels at a point of the curve over the base height base_z.
void ArcCutter::set_heights(PlanNode& n, const PlanCurve& curve, double curve_z,
                            double base_z) const {
  n.heights.clear();
  for (const Label label : {left_, right_}) {
    if (label == kNoLabel) continue;
    double z = base_z;
    if (!is_base(surface_, label) && curve.type != CurveType::kMeet) {
      const bool own = curve.type == CurveType::kShadow && solver_.ref_of(label) == curve.first;
      if (own) {
        z = curve_z;
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
    if (curve.type == CurveType::kShadow)
      z = solver_.shadow_height(curve, p.x() + t * d.x(), p.y() + t * d.y());
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

// Along the sheet's own border, vertex by vertex.
void ArcCutter::follow_border(std::uint32_t a, std::uint32_t b, const PlanCurve& curve) {
  const auto next_border = [&](std::uint32_t h) {  // the border goes on after h's end
    h = ScanSheet::next(h);
    while (sheet_.twin[h] != kNone) h = ScanSheet::next(sheet_.twin[h]);
    return h;
  };
  const auto previous_border = [&](std::uint32_t h) {
    h = ScanSheet::previous(h);
    while (sheet_.twin[h] != kNone) h = ScanSheet::previous(sheet_.twin[h]);
    return h;
  };
  // The border's half-edges at a node: which it lies on, going the arc's way.
  const auto edges_at = [&](std::uint32_t n, bool leaving) {
    std::vector<std::uint32_t> found;
    const ScanPlace& where = place(n);
    if (where.kind == ScanPlace::Kind::kEdge && sheet_.twin[where.id] == kNone)
      found.push_back(where.id);
    if (where.kind == ScanPlace::Kind::kVertex) {
      for (std::uint32_t k = begins_[where.id]; k < begins_[where.id + 1]; ++k) {
        const std::uint32_t h =
            leaving == base_left_ ? around_[k] : ScanSheet::previous(around_[k]);
        if (sheet_.twin[h] == kNone) found.push_back(h);
      }
    }
    return found;
  };
  const std::vector<std::uint32_t> starts = edges_at(a, true), ends = edges_at(b, false);
  const std::size_t limit = scan_.border_edges().size() + 2;
  std::vector<std::uint32_t> way, shortest;
  bool found = false;
  for (const std::uint32_t start : starts) {
    way = {start};
    while (way.size() < limit) {
      const std::uint32_t h = way.back();
      if (std::find(ends.begin(), ends.end(), h) != ends.end()) {
        bool ahead = true;  // on the start's own edge b may lie behind a: once round then
        if (way.size() == 1) {
          const Vec2 d = point(sheet_.to(h)) - point(sheet_.from(h));
          ahead = (d.dot(at(b) - at(a)) >= 0) == base_left_;
        }
        if (ahead) {
          if (!found || way.size() < shortest.size()) shortest = way;
          found = true;
          break;
        }
      }
      way.push_back(base_left_ ? next_border(h) : previous_border(h));
    }
  }
  // A way much longer than the stretch is the way round: the ends were only told to the least cell.
  double length = 0;
  Vec2 last = at(a);
  for (std::size_t k = 0; found && k + 1 < shortest.size(); ++k) {
    const Vec2 next = point(base_left_ ? sheet_.to(shortest[k]) : sheet_.from(shortest[k]));
    length += (next - last).norm();
    last = next;
  }
  length += (at(b) - last).norm();
  const double straight = (at(b) - at(a)).norm();
  if (found && a != b && length > 64 * (straight + 16 * least_)) found = false;
  if (!found) {
    if (straight <= 16 * least_) {
      std::vector<std::uint32_t> t;
      triangles_at(place(a), t);
      emit(b, curve, t.empty() ? kNone : t[0]);
    } else if (base_ == kNoLabel) {
      emit(b, curve, kNone);
      out_.unsolved_length += straight;
    } else {
      trace_steps_ = 0;
      trace(a, b, curve, 0);
    }
    return;
  }
  for (std::size_t k = 0; k < shortest.size(); ++k) {
    const std::uint32_t h = shortest[k];
    out_.touched[h / 3] = 1;
    if (k + 1 == shortest.size()) {
      emit(b, curve, h / 3);
      break;
    }
    const std::uint32_t v = base_left_ ? sheet_.to(h) : sheet_.from(h);
    PlanNode n;
    n.x = sheet_.points[v].x();
    n.y = sheet_.points[v].y();
    set_heights(n, curve, sheet_.points[v].z(), sheet_.points[v].z());
    emit(add_node(std::move(n), {ScanPlace::Kind::kVertex, v}), curve, h / 3);
  }
}

bool ArcCutter::is_near_border(const Vec2& p) const {
  const double reach = 4 * least_;
  std::vector<std::uint32_t> edges;
  scan_.border_over({p.x() - reach, p.x() + reach, p.y() - reach, p.y() + reach}, 1, edges);
  return !edges.empty();
}

// Where the end of the base parts two labels that are not its own it is known by its place alone.
void ArcCutter::name_outlines() {
  for (PlanArc& arc : arrangement_.arcs) {
    if (arc.border || (arc.left == kNoLabel && arc.right == kNoLabel)) continue;
    for (std::size_t k = 0; k < arc.curves.size(); ++k) {
      PlanCurve& curve = arc.curves[k];
      if (curve.type != CurveType::kUnsolved || !is_near_border(at(arc.nodes[k])) ||
          !is_near_border(at(arc.nodes[k + 1])))
        continue;
      curve.type = CurveType::kOutline;
      curve.first = {SurfaceRef::kBase, 0};
      curve.second = {SurfaceRef::kOutline, 0};
    }
  }
}

// Where another curve ends on the border of the base: its point on the border's own edge.
void ArcCutter::solve_border_corners() {
  for (const PlanArc& arc : arrangement_.arcs) {
    if (arc.border || arc.closed) continue;
    for (const bool last : {false, true}) {
      const std::uint32_t n = last ? arc.nodes.back() : arc.nodes.front();
      const PlanCurve& curve = last ? arc.curves.back() : arc.curves.front();
      if (curve.type != CurveType::kMeet && curve.type != CurveType::kShadow) continue;
      const ScanPlace where = out_.place[n];
      if (node(n).seam || where.kind != ScanPlace::Kind::kEdge || sheet_.twin[where.id] != kNone)
        continue;
      const Vec3 &u = sheet_.points[sheet_.from(where.id)], &v = sheet_.points[sheet_.to(where.id)];
      const Vec2 p = u.head<2>(), d = (v - u).head<2>();
      const double before = d.dot(at(n) - p) / d.squaredNorm();
      double t = before, z = u.z() + t * (v.z() - u.z());
      if (curve.type == CurveType::kShadow) z = solver_.shadow_height(curve, at(n).x(), at(n).y());
      if (!solver_.on_line(on_triangle(curve, where.id / 3), p, d, t, z)) continue;
      if (!(t >= 0 && t <= 1) || std::fabs(t - before) * d.norm() > 64 * least_) continue;
      PlanNode& node_here = node(n);
      node_here.x = p.x() + t * d.x();
      node_here.y = p.y() + t * d.y();
      node_here.solved = true;
      for (LabelHeight& h : node_here.heights) {
        if (is_base(surface_, h.label)) {
          h.z = u.z() + t * (v.z() - u.z());
        } else if (solver_.ref_of(h.label) == curve.first ||
                   (curve.type == CurveType::kMeet && solver_.ref_of(h.label) == curve.second)) {
          h.z = z;
        } else {
          solver_.height(h.label, node_here.x, node_here.y, h.z);
        }
      }
      for (LabelHeight& h : node_here.heights) {  // walls too low to be one
        for (const LabelHeight& g : node_here.heights) {
          if (std::fabs(h.z - g.z) <= 1e-9 * surface_.size) h.z = g.z;
        }
      }
    }
  }
}

// Arcs no longer than a few least cells are not there: their ends are one corner, and what they go
// round is nothing.
void ArcCutter::drop_specks() {
  const double small = 16 * least_;
  const auto is_speck = [&](const PlanArc& arc) {
    if (arc.border) return false;
    double reach = 0;
    for (const std::uint32_t n : arc.nodes)
      reach = std::fmax(reach, (at(n) - at(arc.nodes[0])).norm());
    const bool ring = (at(arc.nodes.back()) - at(arc.nodes.front())).norm() <= near_;
    return reach <= (ring ? 4 : 1) * small;
  };
  std::vector<char> speck(arrangement_.arcs.size(), 0);
  std::vector<std::uint32_t> one(arrangement_.nodes.size());
  for (std::uint32_t n = 0; n < one.size(); ++n) one[n] = n;
  const auto find = [&](std::uint32_t n) {
    while (one[n] != n) n = one[n];
    return n;
  };
  for (std::size_t k = 0; k < speck.size(); ++k) {
    const PlanArc& arc = arrangement_.arcs[k];
    if (!is_speck(arc)) continue;
    std::uint32_t a = find(arc.nodes.front()), b = find(arc.nodes.back());
    // The domain's border keeps its own nodes.
    if (node(a).border && node(b).border && a != b) continue;
    speck[k] = 1;
    if (a == b) continue;
    if (node(b).border || (node(b).solved && !node(a).solved && !node(a).border)) std::swap(a, b);
    one[b] = a;
    for (const LabelHeight& h : node(b).heights) {
      if (std::isnan(height_in(a, h.label, std::numeric_limits<double>::quiet_NaN())))
        node(a).heights.push_back(h);
    }
    node(a).corner = true;
  }
  for (std::size_t k = 0; k < speck.size(); ++k) {
    PlanArc& arc = arrangement_.arcs[k];
    if (speck[k] != 0) arc.left = arc.right = kNoLabel;
    for (std::uint32_t& n : arc.nodes) n = find(n);
  }
  for (PlanRegion& region : arrangement_.regions) {
    for (std::vector<ArcUse>& loop : region.loops)
      std::erase_if(loop, [&](const ArcUse& use) { return speck[use.arc] != 0; });
    if (!region.loops.empty() && region.loops[0].empty()) region.label = kNoLabel;
    std::erase_if(region.loops, [](const std::vector<ArcUse>& loop) { return loop.empty(); });
  }
}

void ArcCutter::cut(PlanArc& arc) {
  base_ = base_label(arc);
  left_ = arc.left;
  right_ = arc.border ? kNoLabel : arc.right;
  base_left_ = base_ == arc.left;
  if (base_ == kNoLabel) {
    // The base is under one side all the same: a border half-edge has it on its left.
    double ahead = 0;
    for (std::size_t k = 0; k < arc.curves.size(); ++k) {
      if (arc.curves[k].type != CurveType::kOutline) continue;
      const Vec2 d = at(arc.nodes[k + 1]) - at(arc.nodes[k]);
      for (const std::uint32_t n : {arc.nodes[k], arc.nodes[k + 1]}) {
        const ScanPlace& where = place(n);
        if (where.kind == ScanPlace::Kind::kEdge && sheet_.twin[where.id] == kNone)
          ahead += d.dot((point(sheet_.to(where.id)) - point(sheet_.from(where.id))).normalized());
      }
    }
    base_left_ = ahead >= 0;
  }
  // Ends are told to the least cell at first and better later: nodes as close to them go.
  std::vector<std::uint32_t> nodes{arc.nodes[0]};
  std::vector<PlanCurve> curves;
  for (std::size_t k = 1; k < arc.nodes.size(); ++k) {
    const Vec2 p = at(arc.nodes[k]);
    const bool close = (p - at(arc.nodes.front())).norm() <= 8 * least_ ||
                       (p - at(arc.nodes.back())).norm() <= 8 * least_;
    if (k + 1 < arc.nodes.size() && close && !arc.border) continue;
    nodes.push_back(arc.nodes[k]);
    curves.push_back(arc.curves[k - 1]);
  }
  nodes_ = {nodes[0]};
  curves_.clear();
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (base_ != kNoLabel || curves[std::min(k, curves.size() - 1)].type == CurveType::kOutline)
      place(nodes[k]);
  }
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    const std::uint32_t from = nodes_.back();
    if (curves[k].type == CurveType::kOutline) {
      follow_border(from, nodes[k + 1], curves[k]);
    } else if (base_ == kNoLabel) {
      emit(nodes[k + 1], curves[k], kNone);
    } else {
      trace_steps_ = 0;
      trace(from, nodes[k + 1], curves[k], 0);
    }
    // Nothing between two nodes at one place: the arc goes on from the second.
    if (nodes_.back() != nodes[k + 1]) {
      nodes_.push_back(nodes[k + 1]);
      curves_.push_back(curves[k]);
    }
  }
  // Inner nodes at the place of the one before them, or of the arc's end, say nothing.
  // (Told apart to what decides that a point lies on an edge; the domain's border keeps its own,
  // which are the neighbouring tile's, too.)
  const double apart = arc.border ? 0 : near_;
  const auto same_place = [&](std::uint32_t i, std::uint32_t j) {
    return (at(i) - at(j)).norm() <= apart;
  };
  arc.nodes = {nodes_[0]};
  arc.curves.clear();
  for (std::size_t k = 1; k < nodes_.size(); ++k) {
    const bool last = k + 1 == nodes_.size();
    if (!last && (same_place(nodes_[k], arc.nodes.back()) || same_place(nodes_[k], nodes_.back())))
      continue;
    arc.nodes.push_back(nodes_[k]);
    arc.curves.push_back(curves_[k - 1]);
  }
}

}  // namespace

bool is_base(const Impl& surface, Label label) {
  return label != kNoLabel &&
         surface.steps[surface.step_of_row[static_cast<std::size_t>(row_of(label))]].solid < 0;
}

ScanArcs cut_arcs(const Impl& surface, const ScanSheet& sheet, double least,
                  Arrangement& arrangement) {
  return ArcCutter(surface, sheet, least, arrangement).run();
}

}  // namespace diesink
