// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/assemble.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "core/number.h"
#include "core/tessellate/floor_border.h"
#include "core/tessellate/mesh_report.h"
#include "core/tessellate/pinch.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// Walls are divided in height where they are taller than this many widths of their strips, so that
// their triangles keep their least angle.
constexpr double kWallAspect = 3.5;
constexpr double kWallParts = 24;
// Smallest angle of the floor's triangles, radians.
constexpr double kFloorAngle = 0.25;

class Assembler {
 public:
  Assembler(const CompoundSurface& compound, const Arrangement& arrangement,
            const ArcSamples& samples, const std::vector<RegionMesh>& regions,
            const TessellationOptions& options)
      : compound_(compound),
        arrangement_(arrangement),
        samples_(samples),
        regions_(regions),
        options_(options),
        pinched_(arrangement) {}
  Result<Tessellation> run();

 private:
  // The vertices of the mesh over one arc point, by ascending height.
  struct Column {
    std::vector<std::pair<double, std::uint32_t>> levels;
    double spacing = 1e300;  // plan length of the chords at the point: of the longer one of an
                             // arc, the least of several arcs
  };

  std::uint32_t element(const std::string& name, const std::string& solid);
  std::uint32_t vertex(const Vec3& p);
  std::uint32_t vertex_at(std::uint32_t arc_point, double z);
  void add_levels();
  void divide_columns();
  void between(std::uint32_t point, const ArcEnd* end, double from, double to,
               std::vector<std::uint32_t>& chain);
  void add_faces();
  void add_crease(const RegionMesh& region, const std::vector<std::uint32_t>& chain,
                  const std::vector<std::uint32_t>& global, std::uint32_t e);
  void add_walls();
  // One side of a strip: heights of the arc's right and left side over a point, the wall's normal
  // there, and which end of an arc it is where it is one.
  struct StripSide {
    std::uint32_t point;
    double right, left;
    Vec3 normal;
    const ArcEnd* end;
  };
  void strip(const StripSide& p, const StripSide& q, std::uint32_t element);
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t element,
                std::uint32_t na, std::uint32_t nb, std::uint32_t nc);
  Status add_floor();
  void add_curves();
  [[nodiscard]] bool hole_or_border(const PlanArc& arc) const {
    return arc.border || arc.left == kNoLabel || arc.right == kNoLabel;
  }
  std::string wall_solid(const PlanArc& arc) const;

  const CompoundSurface& compound_;
  const Arrangement& arrangement_;
  const ArcSamples& samples_;
  const std::vector<RegionMesh>& regions_;
  const TessellationOptions& options_;
  Tessellation out_;
  std::map<std::string, std::uint32_t> element_of_;
  std::map<std::uint32_t, double> wall_bound_;  // of walls and skirts: of the chords they stand on
  std::vector<std::vector<std::uint32_t>> inner_creases_;
  std::vector<Column> columns_;
  PinchedNodes pinched_;
  // Vertices that part the walls of one wedge of material from those of another on the same line.
  std::map<std::array<std::uint32_t, 3>, std::uint32_t>
      parting_;  // of (level's vertex, next, wedge)
  double floor_ = 0;
};

std::uint32_t Assembler::element(const std::string& name, const std::string& solid) {
  const auto [it, fresh] =
      element_of_.try_emplace(name, static_cast<std::uint32_t>(out_.mesh.elements.size()));
  if (fresh) {
    MeshElement e;
    e.name = name;
    e.solid = solid;
    out_.mesh.elements.push_back(std::move(e));
  }
  return it->second;
}

std::uint32_t Assembler::vertex(const Vec3& p) {
  out_.mesh.positions.push_back(p);
  return static_cast<std::uint32_t>(out_.mesh.positions.size() - 1);
}

std::uint32_t Assembler::vertex_at(std::uint32_t point, double z) {
  Column& column = columns_[point];
  for (const auto& [level, v] : column.levels) {
    if (level == z) return v;
  }
  const std::uint32_t v = vertex({samples_.points[point].x, samples_.points[point].y, z});
  column.levels.insert(
      std::upper_bound(column.levels.begin(), column.levels.end(), std::make_pair(z, v)), {z, v});
  return v;
}

// One vertex a height and arc point, in the order of arcs.
void Assembler::add_levels() {
  columns_.resize(samples_.points.size());
  std::vector<std::uint32_t> chain;
  for (std::uint32_t a = 0; a < arrangement_.arcs.size(); ++a) {
    const PlanArc& arc = arrangement_.arcs[a];
    if (arc.left == kNoLabel && (arc.border || arc.right == kNoLabel)) continue;
    samples_.chain(a, chain);
    for (std::size_t k = 0; k < chain.size(); ++k) {
      for (const Label label : {arc.left, arc.right}) {
        if (label == kNoLabel) continue;
        vertex_at(chain[k], samples_.z(chain[k], label));
      }
      if (options_.solid && hole_or_border(arc)) vertex_at(chain[k], floor_);
    }
    const auto length = [&](std::size_t k) {
      const ArcPoint &p = samples_.points[chain[k]], &q = samples_.points[chain[k + 1]];
      return std::hypot(p.x - q.x, p.y - q.y);
    };
    const std::size_t last = chain.size() - 1;
    for (std::size_t k = 0; k <= last; ++k) {
      // One short chord makes a needle whatever is done; it shall not make many.
      double longer = 0;
      for (std::size_t j = k > 1 ? k - 1 : 0; j < std::min(k + 1, last); ++j)
        longer = std::fmax(longer, length(j));
      if (k == 0 && last > 1) longer = std::fmax(longer, length(1));
      if (k == last && last > 1) longer = std::fmax(longer, length(last - 2));
      // On a cut between tiles the chords along it decide: both tiles have those.
      const std::uint32_t node = samples_.points[chain[k]].node;
      if (node != ArcPoint::kNoNode && arrangement_.nodes[node].seam &&
          (!arc.fixed || arrangement_.nodes[node].corner))
        continue;
      double& spacing = columns_[chain[k]].spacing;
      spacing = std::fmin(spacing, longer);
    }
  }
}

// Points between the levels of tall walls. Every strip at a column uses the same ones.
void Assembler::divide_columns() {
  // Over a scan strips are as narrow as its triangles: tall ones would cost many times the rest.
  if (std::holds_alternative<MeshBase>(compound_.program().base)) return;
  std::vector<double> extra;
  for (std::uint32_t p = 0; p < columns_.size(); ++p) {
    Column& column = columns_[p];
    if (column.levels.size() < 2) continue;
    extra.clear();
    for (std::size_t k = 0; k + 1 < column.levels.size(); ++k) {
      const double z0 = column.levels[k].first, z1 = column.levels[k + 1].first;
      const int parts =
          static_cast<int>(std::clamp((z1 - z0) / (kWallAspect * column.spacing), 1.0, kWallParts));
      for (int i = 1; i < parts; ++i) extra.push_back(z0 + (z1 - z0) * i / parts);
    }
    for (const double z : extra) vertex_at(p, z);
  }
}

// The column's vertices from one height to another, both included, upwards or downwards. Where more
// than two walls stand on the line, each wedge of material but the first has vertices of its own
// between the levels: no edge is in more than two triangles.
void Assembler::between(std::uint32_t point, const ArcEnd* end, double from, double to,
                        std::vector<std::uint32_t>& chain) {
  chain.clear();
  const Column& column = columns_[point];
  const double low = std::fmin(from, to), high = std::fmax(from, to);
  const std::uint32_t node = samples_.points[point].node;
  const bool pinched = end != nullptr && node != ArcPoint::kNoNode && pinched_.has(node);
  const auto height = [&](Label label) {
    return label == kNoLabel ? floor_ : samples_.z(point, label);
  };
  double below = 0;
  for (const auto& [z, v] : column.levels) {
    if (z < low || z > high) continue;
    if (pinched && !chain.empty()) {
      const PinchedNodes::Wedge wedge = pinched_.wedge_of(node, *end, z, height);
      if (wedge.number > 0) {
        const auto [it, fresh] =
            parting_.try_emplace({chain.back(), v, static_cast<std::uint32_t>(wedge.number)}, 0u);
        if (fresh) {
          const ArcPoint& at = samples_.points[point];
          it->second = vertex({at.x, at.y, below + (z - below) * wedge.number / wedge.wedges});
        }
        chain.push_back(it->second);
      }
    }
    chain.push_back(v);
    below = z;
  }
  if (from > to) std::reverse(chain.begin(), chain.end());
}

void Assembler::triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t e,
                         std::uint32_t na, std::uint32_t nb, std::uint32_t nc) {
  if (a == b || b == c || c == a) return;
  out_.mesh.triangles.push_back({a, b, c});
  out_.mesh.triangle_element.push_back(e);
  out_.mesh.corner_normals.push_back({na, nb, nc});
}

// A crease within one element.
void Assembler::add_crease(const RegionMesh& region, const std::vector<std::uint32_t>& chain,
                           const std::vector<std::uint32_t>& global, std::uint32_t e) {
  MeshCurve curve;
  curve.kind = CurveKind::kCrease;
  curve.between = {e, e};
  curve.closed = chain.size() > 2 && chain.front() == chain.back();
  CurveReport report;
  report.kind = CurveKind::kCrease;
  report.closed = curve.closed;
  report.between = {out_.mesh.elements[e].name, out_.mesh.elements[e].name};
  for (std::size_t k = 0; k < chain.size(); ++k) {
    if (k > 0) report.length += (region.position[chain[k]] - region.position[chain[k - 1]]).norm();
    if (k + 1 < chain.size() || !curve.closed) curve.vertices.push_back(global[chain[k]]);
  }
  inner_creases_.push_back(curve.vertices);
  out_.mesh.curves.push_back(std::move(curve));
  out_.report.curves.push_back(std::move(report));
}

void Assembler::add_faces() {
  std::vector<std::uint32_t> global;
  for (const RegionMesh& region : regions_) {
    const int surface = compound_.surface_of_row(row_of(region.label));
    const std::string name = compound_.element_name(region.label);
    const std::uint32_t e = element(
        name,
        surface == 0 ? "B" : compound_.program().solids[static_cast<std::size_t>(surface - 1)].id);
    const FaceChart chart(compound_.impl(), region.label);
    global.resize(region.position.size());
    const auto first_normal = static_cast<std::uint32_t>(out_.mesh.normals.size());
    for (std::size_t k = 0; k < region.position.size(); ++k) {
      global[k] = region.arc_point[k] == ArcSamples::kNone
                      ? vertex(region.position[k])
                      : vertex_at(region.arc_point[k], region.position[k].z());
      if (region.corner_normals.empty())
        out_.mesh.normals.push_back(chart.normal(region.position[k]));
    }
    out_.mesh.normals.insert(out_.mesh.normals.end(), region.normals.begin(), region.normals.end());
    for (std::size_t k = 0; k < region.triangles.size(); ++k) {
      const std::array<std::uint32_t, 3>& t = region.triangles[k];
      const std::array<std::uint32_t, 3>& n =
          region.corner_normals.empty() ? t : region.corner_normals[k];
      triangle(global[t[0]], global[t[1]], global[t[2]], e, first_normal + n[0],
               first_normal + n[1], first_normal + n[2]);
    }
    if (!region.upright.empty()) {
      const std::string& solid = out_.mesh.elements[e].solid;
      const std::uint32_t wall = element(solid + ".wall", solid);
      for (const std::array<std::uint32_t, 3>& t : region.upright) {
        triangle(global[t[0]], global[t[1]], global[t[2]], wall, first_normal + t[0],
                 first_normal + t[1], first_normal + t[2]);
      }
    }
    for (const std::vector<std::uint32_t>& crease : region.creases)
      add_crease(region, crease, global, e);
  }
}

// A vertical strip between two columns. Seen from its right side it is anticlockwise where the left
// side is the higher; where the right one is, the same order faces left: always towards the lower
// side.
void Assembler::strip(const StripSide& p, const StripSide& q, std::uint32_t e) {
  std::vector<std::uint32_t> cp, cq;
  between(p.point, p.end, p.right, p.left, cp);
  between(q.point, q.end, q.right, q.left, cq);
  const auto n0 = static_cast<std::uint32_t>(out_.mesh.normals.size());
  out_.mesh.normals.push_back(p.normal);
  out_.mesh.normals.push_back(q.normal);
  // Where the sides change places between p and q, triangles on either column look another way.
  std::uint32_t turned = n0;  // the normals on the column that the strip's do not go with
  bool turned_p = false, turned_q = false;
  if ((p.left - p.right) * (q.left - q.right) < 0) {
    turned_p = (p.left - p.right + q.left - q.right >= 0) != (p.left > p.right);
    turned_q = !turned_p;
    turned = n0 + 2;
    out_.mesh.normals.push_back(-p.normal);
    out_.mesh.normals.push_back(-q.normal);
  }
  const std::uint32_t np = turned_p ? turned : n0, nq = turned_q ? turned : n0;
  const auto& at = out_.mesh.positions;
  std::size_t i = 0, j = 0;
  while (i + 1 < cp.size() || j + 1 < cq.size()) {
    bool up_q = i + 1 >= cp.size();
    if (!up_q && j + 1 < cq.size()) {
      up_q = (at[cp[i]] - at[cq[j + 1]]).squaredNorm() < (at[cq[j]] - at[cp[i + 1]]).squaredNorm();
    }
    if (up_q) {
      triangle(cp[i], cq[j], cq[j + 1], e, nq, nq + 1, nq + 1);
      ++j;
    } else {
      triangle(cp[i], cq[j], cp[i + 1], e, np, np + 1, np);
      ++i;
    }
  }
}

// The solid whose end most of the arc is: beside a point where ends of two touch, which cannot be
// told apart there, a few stretches may be the other's.
std::string Assembler::wall_solid(const PlanArc& arc) const {
  std::map<std::int32_t, double> lengths;
  for (std::size_t k = 0; k < arc.curves.size(); ++k) {
    if (arc.curves[k].type != CurveType::kShadow) continue;
    const PlanNode &p = arrangement_.nodes[arc.nodes[k]], &q = arrangement_.nodes[arc.nodes[k + 1]];
    lengths[arc.curves[k].first.solid] += std::hypot(q.x - p.x, q.y - p.y);
  }
  const auto longest =
      std::max_element(lengths.begin(), lengths.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (longest != lengths.end())
    return compound_.program().solids[static_cast<std::size_t>(longest->first)].id;
  const Label later = row_of(arc.left) > row_of(arc.right) ? arc.left : arc.right;
  const int surface = compound_.surface_of_row(row_of(later));
  return surface == 0 ? "B" : compound_.program().solids[static_cast<std::size_t>(surface - 1)].id;
}

void Assembler::add_walls() {
  const double tolerance =
      options_.tolerance > 0 ? options_.tolerance : compound_.program().machining.tolerance;
  std::vector<std::uint32_t> chain;
  for (std::uint32_t a = 0; a < arrangement_.arcs.size(); ++a) {
    const PlanArc& arc = arrangement_.arcs[a];
    const bool skirt = hole_or_border(arc);
    if (skirt &&
        (!options_.solid || (arc.left == kNoLabel && (arc.border || arc.right == kNoLabel))))
      continue;
    samples_.chain(a, chain);
    const std::size_t n = chain.size();
    const auto left_z = [&](std::uint32_t p) {
      return arc.left == kNoLabel ? floor_ : samples_.z(p, arc.left);
    };
    const auto right_z = [&](std::uint32_t p) {
      return arc.border || arc.right == kNoLabel ? floor_ : samples_.z(p, arc.right);
    };
    bool any = false;
    for (const std::uint32_t p : chain) any = any || left_z(p) != right_z(p);
    if (!any) continue;
    const std::string solid = skirt ? "skirt" : wall_solid(arc);
    const std::uint32_t e = skirt ? element("skirt", "skirt") : element(solid + ".wall", solid);
    // Normals across the arc, smooth along it: the mean of the chords before and behind.
    const bool closed = chain.front() == chain.back();
    const auto chord = [&](std::size_t k) {
      const ArcPoint &p = samples_.points[chain[k]], &q = samples_.points[chain[k + 1]];
      return Vec2(q.x - p.x, q.y - p.y).normalized();
    };
    const auto normal_at = [&](std::size_t k) {
      Vec2 t = Vec2::Zero();
      if (k > 0) t += chord(k - 1);
      if (k + 1 < n) t += chord(k);
      if (closed && k == 0) t += chord(n - 2);
      if (closed && k + 1 == n) t += chord(0);
      const double l = t.norm();
      if (!(l > 0))
        t = k + 1 < n ? chord(k) : chord(k - 1);
      else
        t /= l;
      return t;
    };
    for (std::size_t k = 0; k + 1 < n; ++k) {
      const std::uint32_t p = chain[k], q = chain[k + 1];
      const double pl = left_z(p), pr = right_z(p), ql = left_z(q), qr = right_z(q);
      if (p == q || (pl == pr && ql == qr)) continue;
      // A corner between them is not there: small beside the tolerance, or told.
      const double low = std::fmin(std::fabs(pl - pr), std::fabs(ql - qr));
      if ((pl - pr) * (ql - qr) < 0 && low > kUnseen * tolerance) {
        const ArcPoint &from = samples_.points[p], &to = samples_.points[q];
        out_.report.add_doubt(
            {0.5 * (from.x + to.x), 0.5 * (from.y + to.y), 0.25 * (pl + pr + ql + qr)},
            out_.mesh.elements[e].name, "the sides of a wall change places",
            std::hypot(to.x - from.x, to.y - from.y) * tolerance);
      }
      double& bound = wall_bound_[e];
      bound = std::fmax(bound, samples_.chord_bound(p, q));
      const double s = pl - pr + ql - qr >= 0 ? 1 : -1;
      Vec2 tp = normal_at(k), tq = normal_at(k + 1);
      // Round a hairpin the mean looks away from a chord: the chord's own then.
      for (Vec2* t : {&tp, &tq}) {
        if (!(t->dot(chord(k)) > 0)) *t = chord(k);
      }
      const ArcEnd first{a, false}, last{a, true};
      strip({p, pr, pl, Vec3(s * tp.y(), -s * tp.x(), 0), k == 0 ? &first : nullptr},
            {q, qr, ql, Vec3(s * tq.y(), -s * tq.x(), 0), k + 2 == n ? &last : nullptr}, e);
    }
  }
}

Status Assembler::add_floor() {
  // The area over which there is a surface, bounded by the border and by holes.
  const FloorBorder border = floor_border(arrangement_, samples_);
  PlanarTriangulation t;
  if (!t.build(border.points, border.segments).empty()) {
    return Error{
        ErrorCode::kInput, "the border of the floor crosses itself", {compound_.program().file}};
  }
  std::vector<std::uint32_t> global;
  for (const std::uint32_t p : border.arc_point) global.push_back(vertex_at(p, floor_));
  RefineRules rules;
  // (Over a scan as few as its border needs.)
  rules.min_angle = std::holds_alternative<MeshBase>(compound_.program().base) ? 0 : kFloorAngle;
  rules.split_encroached = false;
  rules.shortest_edge = 1e-3 * compound_.size();
  rules.add_vertex = [&](const Vec2& p, double) {
    global.push_back(vertex({p.x(), p.y(), floor_}));
    return true;
  };
  for (;;) {
    const std::vector<PlanarTriangulation::Segment> wanted = t.refine(rules);
    if (wanted.empty()) break;
    for (const PlanarTriangulation::Segment& s : wanted)
      t.keep_segment(s[0], s[1]);  // they belong to the skirts
  }
  const std::uint32_t e = element("floor", "floor");
  const auto n = static_cast<std::uint32_t>(out_.mesh.normals.size());
  out_.mesh.normals.emplace_back(0, 0, -1);
  for (const auto& c : t.triangles())
    triangle(global[c[0]], global[c[2]], global[c[1]], e, n, n, n);
  return ok();
}

void Assembler::add_curves() {
  std::vector<std::uint32_t> chain;
  std::vector<char> crease(out_.mesh.positions.size(), 0), jump = crease, corner = crease;
  for (const auto& inner : inner_creases_) {
    for (const std::uint32_t v : inner) crease[v] = 1;
  }
  const auto element_index = [&](Label label) {
    return label == kNoLabel ? MeshCurve::kNoElement : element(compound_.element_name(label), "");
  };
  for (std::uint32_t a = 0; a < arrangement_.arcs.size(); ++a) {
    const PlanArc& arc = arrangement_.arcs[a];
    if (arc.border || (arc.left == kNoLabel && arc.right == kNoLabel)) continue;
    samples_.chain(a, chain);
    bool walled = false;
    const bool both = arc.left != kNoLabel && arc.right != kNoLabel;
    for (const std::uint32_t p : chain) {
      walled = walled || (both && samples_.z(p, arc.left) != samples_.z(p, arc.right));
    }
    const CurveKind kind = !both    ? CurveKind::kEdge
                           : walled ? CurveKind::kJump
                                    : CurveKind::kCrease;
    CurveReport report;
    report.kind = kind;
    report.closed = arc.closed;
    report.between = {arc.left == kNoLabel ? "" : compound_.element_name(arc.left),
                      arc.right == kNoLabel ? "" : compound_.element_name(arc.right)};
    for (int side = 0; side < 2; ++side) {
      const Label label = side == 0 ? arc.left : arc.right;
      if (label == kNoLabel || (side == 1 && kind == CurveKind::kCrease)) continue;
      MeshCurve curve;
      curve.kind = kind;
      curve.closed = arc.closed;
      curve.between = {element_index(arc.left), element_index(arc.right)};
      for (const std::uint32_t p : chain) {
        const std::uint32_t v = vertex_at(p, samples_.z(p, label));
        curve.vertices.push_back(v);
        (kind == CurveKind::kCrease ? crease : jump)[v] = 1;
        if (samples_.points[p].node != ArcPoint::kNoNode && !arc.closed &&
            (arrangement_.nodes[samples_.points[p].node].corner ||
             !arrangement_.nodes[samples_.points[p].node].kept))
          corner[v] = 1;
      }
      double length = 0;
      for (std::size_t k = 0; k + 1 < curve.vertices.size(); ++k) {
        length +=
            (out_.mesh.positions[curve.vertices[k]] - out_.mesh.positions[curve.vertices[k + 1]])
                .norm();
      }
      report.length = std::fmax(report.length, length);
      if (arc.closed) curve.vertices.pop_back();
      out_.mesh.curves.push_back(std::move(curve));
    }
    out_.report.curves.push_back(std::move(report));
  }
  const auto count = [](const std::vector<char>& marks) {
    return static_cast<std::size_t>(std::count(marks.begin(), marks.end(), 1));
  };
  out_.report.crease_vertices = count(crease);
  out_.report.jump_vertices = count(jump);
  out_.report.corner_vertices = count(corner);
}

// Vertices of no triangle: splits of a border have moved over them, or every wall at their height
// stands on a wedge with vertices of its own.
void drop_unused(TriangleMesh& mesh) {
  constexpr std::uint32_t kUnused = 0xFFFFFFFFu;
  std::vector<std::uint32_t> now(mesh.positions.size(), kUnused);
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t) now[v] = 0;
  }
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < now.size(); ++v) {
    if (now[v] == kUnused) continue;
    mesh.positions[count] = mesh.positions[v];
    now[v] = count++;
  }
  if (count == mesh.positions.size()) return;
  mesh.positions.resize(count);
  for (auto& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = now[v];
  }
  for (MeshCurve& curve : mesh.curves) {
    for (std::uint32_t& v : curve.vertices) v = now[v];
    std::erase(curve.vertices, kUnused);
  }
}

Result<Tessellation> Assembler::run() {
  const PartProgram& program = compound_.program();
  out_.mesh.name = program.name;
  out_.mesh.unit = program.unit;
  out_.mesh.up = UpAxis::kZ;
  double lowest = 1e300, highest = -1e300;
  for (const RegionMesh& r : regions_) {
    for (const Vec3& p : r.position) {
      lowest = std::fmin(lowest, p.z());
      highest = std::fmax(highest, p.z());
    }
  }
  const double longer = std::fmax(arrangement_.box.x1 - arrangement_.box.x0,
                                  arrangement_.box.y1 - arrangement_.box.y0);
  floor_ = lowest;
  if (options_.solid) {
    floor_ = options_.floor ? *options_.floor : lowest - 0.1 * longer;
    if (!(floor_ < lowest)) {
      return Error{ErrorCode::kInput,
                   "the floor at " + number_text(floor_) +
                       " is not below the surface, whose lowest point is at " + number_text(lowest),
                   {program.file}};
    }
  }
  add_levels();
  divide_columns();
  add_faces();
  add_walls();
  if (options_.solid) {
    const Status done = add_floor();
    if (!done) return done.error();
  }
  add_curves();
  std::vector<std::uint32_t> pinches;
  for (std::uint32_t p = 0; p < columns_.size(); ++p) {
    const std::uint32_t node = samples_.points[p].node;
    if (node == ArcPoint::kNoNode || !pinched_.has(node)) continue;
    for (const auto& [z, v] : columns_[p].levels) pinches.push_back(v);
  }
  split_fans(out_.mesh, pinches);
  drop_unused(out_.mesh);
  fill_report(compound_, out_, floor_, out_.report);
  for (const auto& [e, bound] : wall_bound_) out_.report.elements[e].max_deviation = bound;
  out_.report.domain = {arrangement_.box.x0, arrangement_.box.x1, arrangement_.box.y0,
                        arrangement_.box.y1};
  return std::move(out_);
}

}  // namespace

Result<Tessellation> assemble(const CompoundSurface& surface, const Arrangement& arrangement,
                              const ArcSamples& samples, const std::vector<RegionMesh>& regions,
                              const TessellationOptions& options) {
  return Assembler(surface, arrangement, samples, regions, options).run();
}

Tessellation empty_tile(const PlanBox& box) {
  Tessellation made;
  made.report.domain = {box.x0, box.x1, box.y0, box.y1};
  return made;
}

}  // namespace diesink
