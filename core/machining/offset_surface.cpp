// The Minkowski sum of a mesh and a cutter, as far as it is seen from above. What an edge or a
// vertex adds is bounded by its normal cone: at a highest contact the cutter's normal is a
// non-negative combination of the normals of the facets around it (Clarke's generalized gradient
// contains the superdifferential), and of horizontal normals where the surface ends there.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/offset_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

namespace diesink {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFu;
constexpr double kSlack = 1e-12;  // of lengths: regions are taken larger than rounding

struct HalfEdge {
  std::uint32_t to = 0, face = 0;
  bool reversed = false;  // the face runs along it from `to`
};

// Half-edges by their smaller vertex.
class EdgeTable {
 public:
  EdgeTable(std::size_t vertex_count, const std::vector<std::array<std::uint32_t, 3>>& triangles,
            const std::vector<std::uint8_t>& used)
      : start_(vertex_count + 1, 0) {
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      if (!used[t]) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        ++start_[std::min(triangles[t][k], triangles[t][(k + 1) % 3]) + 1];
      }
    }
    for (std::size_t v = 0; v < vertex_count; ++v) start_[v + 1] += start_[v];
    items_.resize(start_.back());
    std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      if (!used[t]) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
        items_[next[std::min(a, b)]++] = {std::max(a, b), static_cast<std::uint32_t>(t), a > b};
      }
    }
    for (std::size_t v = 0; v < vertex_count; ++v) {
      std::sort(items_.begin() + start_[v], items_.begin() + start_[v + 1],
                [](const HalfEdge& p, const HalfEdge& q) {
                  return p.to != q.to ? p.to < q.to : p.face < q.face;
                });
    }
  }
  [[nodiscard]] std::size_t begin(std::size_t v) const { return start_[v]; }
  [[nodiscard]] std::size_t end(std::size_t v) const { return start_[v + 1]; }
  [[nodiscard]] const HalfEdge& operator[](std::size_t k) const { return items_[k]; }

 private:
  std::vector<std::uint32_t> start_;
  std::vector<HalfEdge> items_;
};

// Position across an edge of the centre whose contact normal leans by sin = sigma to the left.
double across(const CutterShape& cutter, double steep, double sigma) {
  const double lean = std::sqrt(steep * steep + (1 - steep * steep) * sigma * sigma);
  return cutter.corner() * sigma + (lean > 0 ? cutter.flat() * sigma / lean : 0);
}

// Distance along a rising edge from the centre to its contact, by the same normal.
double along(const CutterShape& cutter, double steep, double sigma) {
  const double lean = std::sqrt(steep * steep + (1 - steep * steep) * sigma * sigma);
  const double part = steep * std::sqrt(std::max(0.0, 1 - sigma * sigma));
  return part * (cutter.corner() + (lean > 0 ? cutter.flat() / lean : 0));
}

// Distance along a rising edge from the centre to its contact, w across.
double tau(const CutterShape& cutter, const EdgePiece& edge, double w) {
  const double m = std::fabs(edge.slope);
  w = std::fabs(w);
  if (!(m > 0) || w >= cutter.radius()) return 0;
  const double steep = m / edge.stretch;
  double t;
  if (cutter.flat() <= 0) {
    t = steep * std::sqrt((cutter.corner() - w) * (cutter.corner() + w));
  } else if (cutter.corner() <= 0) {
    t = std::sqrt((cutter.flat() - w) * (cutter.flat() + w));
  } else {
    // across() is increasing and concave in sigma, so Newton's method climbs to the root from
    // below. What is left of its error counts only squared in the tip's height.
    double sigma = std::max(w / (cutter.corner() + cutter.flat() / steep),
                            (w - cutter.flat()) / cutter.corner());
    for (int step = 0; step < 60; ++step) {
      const double lean2 = steep * steep + (1 - steep * steep) * sigma * sigma;
      const double lean = std::sqrt(lean2);
      const double f = cutter.corner() * sigma + cutter.flat() * sigma / lean - w;
      const double df = cutter.corner() + cutter.flat() * steep * steep / (lean2 * lean);
      const double move = -f / df;
      sigma = std::min(sigma + move, 1.0);
      if (!(move > 1e-11)) break;
    }
    t = along(cutter, steep, std::max(sigma, 0.0));
  }
  return edge.slope < 0 ? -t : t;
}

struct Cone {
  struct Normal {
    Vec3 n;
    double noise = 0;  // by how much rounding may have moved it
  };
  std::vector<Normal> normals;
  double lost = 0;           // of a contact's place, by rounding of the normals
  bool convex_edge = false;  // at least one edge around it is convex or a border
  bool border = false;
  bool nonmanifold = false;
};

VertexPiece vertex_piece(const Vec3& v, const Cone& cone, const CutterShape& cutter) {
  VertexPiece piece;
  piece.border = cone.border;
  piece.x = v.x();
  piece.y = v.y();
  piece.z = v.z();
  const double r = cutter.radius();
  piece.slack = 2 * cone.lost + kSlack * (std::fabs(v.x()) + std::fabs(v.y()) + r);
  piece.x0 = v.x() - r;
  piece.x1 = v.x() + r;
  piece.y0 = v.y() - r;
  piece.y1 = v.y() + r;
  if (cone.nonmanifold) return piece;
  Vec3 middle = Vec3::Zero();
  for (const auto& [n, noise] : cone.normals) middle += n;
  const double size = middle.norm();
  if (!(size > 1e-6)) return piece;
  middle /= size;
  double least = 1;
  Vec2 low(1, 1), high(-1, -1);
  bool upright = false;  // some normal is vertical: contacts anywhere under the flat end
  bool any_way = false;  // of some normal rounding leaves no heading
  Vec2 heading = Vec2::Zero();
  for (const auto& [n, noise] : cone.normals) {
    least = std::min(least, n.dot(middle) - noise);
    low = low.cwiseMin(n.head<2>() - Vec2(noise, noise));
    high = high.cwiseMax(n.head<2>() + Vec2(noise, noise));
    const double flat = n.head<2>().norm();
    if (flat > noise)
      heading += n.head<2>() / flat;
    else if (noise > 0)
      any_way = true;
    else
      upright = true;
  }
  if (!(least > 0.05)) return piece;
  // n = sum w_i n_i / |sum w_i n_i| and the norm is at least `least`.
  const auto span = [&](double lo, double hi, double& out0, double& out1, double at, double flat_lo,
                        double flat_hi) {
    lo = cutter.corner() * std::max(-1.0, std::min(lo, lo / least)) + cutter.flat() * flat_lo;
    hi = cutter.corner() * std::min(1.0, std::max(hi, hi / least)) + cutter.flat() * flat_hi;
    out0 = std::max(out0, at + lo - piece.slack);
    out1 = std::min(out1, at + hi + piece.slack);
  };
  double dir_x0 = -1, dir_x1 = 1, dir_y0 = -1, dir_y1 = 1;
  const double heading_size = heading.norm();
  double narrow = -1;  // cosine of the widest lean from the middle heading
  double left = 0, right = 0;
  if (heading_size > 1e-9 && !any_way) {
    heading /= heading_size;
    narrow = 1;
    for (const auto& [n, noise] : cone.normals) {
      const double flat = n.head<2>().norm();
      if (!(flat > 0)) continue;
      // Rounding turns the heading by no more than the angle of this sine.
      const double sine = noise / flat, cosine = std::sqrt((1 - sine) * (1 + sine));
      const Vec2 dir = n.head<2>() / flat;
      const double with = dir.dot(heading);
      const double lean = heading.x() * dir.y() - heading.y() * dir.x();
      narrow = std::min(narrow, with * cosine - std::fabs(lean) * sine);
      left = std::max(left, lean * cosine + with * sine);
      right = std::min(right, lean * cosine - with * sine);
    }
  }
  if (narrow > 0.05) {
    // All headings lie within less than a half turn, so the contacts' headings do too.
    const auto turned = [&](double s) {
      const double c = std::sqrt(std::max(0.0, 1 - s * s));
      return Vec2(heading.x() * c - heading.y() * s, heading.x() * s + heading.y() * c);
    };
    const Vec2 l = turned(std::min(1.0, left + 1e-9)), q = turned(std::max(-1.0, right - 1e-9));
    piece.a = {l.y(), -l.x()};
    piece.b = {-q.y(), q.x()};
    if (!upright) {
      // The unit headings between l and q, by the same argument as for the normals.
      const auto least_of = [&](double p, double s) {
        return std::min(p, s) < 0 ? std::max(-1.0, std::min(p, s) / narrow - 1e-9) : std::min(p, s);
      };
      dir_x0 = least_of(l.x(), q.x());
      dir_x1 = -least_of(-l.x(), -q.x());
      dir_y0 = least_of(l.y(), q.y());
      dir_y1 = -least_of(-l.y(), -q.y());
    }
  }
  span(low.x(), high.x(), piece.x0, piece.x1, v.x(), dir_x0, dir_x1);
  span(low.y(), high.y(), piece.y0, piece.y1, v.y(), dir_y0, dir_y1);
  return piece;
}

// Cuts the span by a·(x - at) >= -slack.
void cut(Span& span, double a, double b) {
  // a x + b >= 0
  if (a > 0)
    span.x0 = std::max(span.x0, -b / a);
  else if (a < 0)
    span.x1 = std::min(span.x1, -b / a);
  else if (b < 0)
    span.x1 = -std::numeric_limits<double>::infinity();
}

// The row's part within `r` of the point.
Span disk(double px, double py, double r, double y) {
  const double d = y - py;
  if (std::fabs(d) > r) return {};
  const double half = std::sqrt((r - d) * (r + d));
  return {px - half, px + half};
}

}  // namespace

OffsetSurface::OffsetSurface(const TriangleMesh& mesh, const CutterShape& cutter, double angle)
    : cutter_(cutter) {
  const double quarter = angle / (std::numbers::pi / 2);
  if (std::fabs(quarter - std::round(quarter)) < 1e-12) {
    const int turns = static_cast<int>(std::lround(quarter)) & 3;
    constexpr std::array<int, 4> kCos{1, 0, -1, 0};
    cos_ = kCos[static_cast<std::size_t>(turns)];
    sin_ = kCos[static_cast<std::size_t>((turns + 3) & 3)];
  } else {
    cos_ = std::cos(angle);
    sin_ = std::sin(angle);
  }
  std::vector<Vec3> points(mesh.positions.size());
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = to_frame(mesh.positions[i]);

  double largest = 0;
  for (const Vec3& p : points) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  std::vector<Vec3> normals(mesh.triangles.size(), Vec3::Zero());
  // By how much rounding may turn the normal of a sliver, in radians; less than kFine moves no
  // contact by more than the regions' slack.
  constexpr double kFine = 1e-11;
  std::vector<double> noise(mesh.triangles.size(), 0);
  std::vector<std::uint8_t> used(mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3 n = (points[j] - points[i]).cross(points[k] - points[i]);
    const double size = n.norm();
    if (!faces_up(n, size)) continue;
    used[t] = 1;
    normals[t] = n / size;
    const double side = std::max({(points[j] - points[i]).norm(), (points[k] - points[j]).norm(),
                                  (points[i] - points[k]).norm()});
    const double turned = 4 * std::numeric_limits<double>::epsilon() * largest * side / size;
    if (turned > kFine) noise[t] = std::min(turned, 1.0);
    Vec3 shift(0, 0, -cutter_.corner());
    const double flat = normals[t].head<2>().norm();
    if (flat > kLevel) {
      shift += cutter_.corner() * normals[t];
      shift.head<2>() += cutter_.flat() * normals[t].head<2>() / flat;
    } else {
      normals[t] =
          Vec3::UnitZ();  // level for its neighbours too, or a gap of width flat() may open
      shift.z() = 0;
    }
    facets_.push_back(
        {{points[i] + shift, points[j] + shift, points[k] + shift}, static_cast<std::uint32_t>(t)});
  }

  // Of a contact's place, by rounding of a facet's normal.
  const auto lost_by = [&](std::uint32_t face) {
    const double lean = normals[face].head<2>().norm();
    return noise[face] * (cutter_.corner() + cutter_.flat() / std::max(lean, noise[face] + 1e-300));
  };

  const EdgeTable table(points.size(), mesh.triangles, used);
  std::vector<Cone> cones(points.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!used[t]) continue;
    for (const std::uint32_t v : mesh.triangles[t]) {
      cones[v].normals.push_back({normals[t], noise[t]});
      cones[v].lost = std::max(cones[v].lost, lost_by(static_cast<std::uint32_t>(t)));
    }
  }
  for (std::size_t from = 0; from < points.size(); ++from) {
    for (std::size_t k = table.begin(from); k < table.end(from);) {
      const std::uint32_t to = table[k].to;
      std::uint32_t left = kNone, right = kNone;
      bool many = false;
      for (; k < table.end(from) && table[k].to == to; ++k) {
        std::uint32_t& side = table[k].reversed ? right : left;
        if (side != kNone) many = true;
        side = table[k].face;
      }
      const Vec3 d = points[to] - points[from];
      const double length = d.head<2>().norm();
      if (many) cones[from].nonmanifold = cones[to].nonmanifold = true;
      if (!(length > 0)) continue;  // no edge of a facet that is seen from above
      EdgePiece edge;
      edge.border = left == kNone || right == kNone;
      edge.x = points[from].x();
      edge.y = points[from].y();
      edge.z = points[from].z();
      edge.dx = d.x() / length;
      edge.dy = d.y() / length;
      edge.length = length;
      edge.slope = d.z() / length;
      edge.stretch = std::sqrt(1 + edge.slope * edge.slope);
      const Vec3 leftward(-edge.dy, edge.dx, 0);
      double sigma1 = 1, sigma0 = -1;
      double lost = 0;  // of a contact's place, by rounding of the facets' normals
      if (!many) {
        if (left != kNone) {
          sigma1 = std::min(1.0, normals[left].dot(leftward) + noise[left]);
          lost = lost_by(left);
        }
        if (right != kNone) {
          sigma0 = std::max(-1.0, normals[right].dot(leftward) - noise[right]);
          lost = std::max(lost, lost_by(right));
        }
      }
      // Borders add a horizontal normal to the cones of both ends.
      for (const std::uint32_t v : {static_cast<std::uint32_t>(from), to}) {
        if (left == kNone) cones[v].normals.push_back({leftward});
        if (right == kNone) cones[v].normals.push_back({-leftward});
        if (left == kNone || right == kNone) cones[v].border = true;
      }
      if (sigma1 < sigma0) continue;  // concave: the facets hold the cutter off
      cones[from].convex_edge = cones[to].convex_edge = true;
      const double m = edge.slope;
      const double steep = std::fabs(m) / edge.stretch;
      const double slack =
          2 * lost + kSlack * (std::fabs(edge.x) + std::fabs(edge.y) + length + cutter_.radius());
      if (sigma1 == sigma0) continue;
      edge.w0 = across(cutter_, steep, sigma0) - slack;
      edge.w1 = across(cutter_, steep, sigma1) + slack;
      // u = s - sign(m) along(sigma); along() falls with |sigma|.
      const double near0 = along(cutter_, steep, sigma0), near1 = along(cutter_, steep, sigma1);
      double most = std::max(near0, near1);
      if (sigma0 <= 0 && sigma1 >= 0) most = along(cutter_, steep, 0);
      const double least = std::min(near0, near1);
      edge.u0 = (m > 0 ? -most : least) - slack;
      edge.u1 = length + (m > 0 ? -least : most) + slack;
      edges_.push_back(edge);
    }
  }
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (cones[v].normals.empty() || !cones[v].convex_edge) continue;
    vertices_.push_back(vertex_piece(points[v], cones[v], cutter_));
  }
}

PlanBox OffsetSurface::box(std::size_t k) const {
  if (k < facets_.size()) {
    const auto& v = facets_[k].v;
    return {std::min({v[0].x(), v[1].x(), v[2].x()}), std::max({v[0].x(), v[1].x(), v[2].x()}),
            std::min({v[0].y(), v[1].y(), v[2].y()}), std::max({v[0].y(), v[1].y(), v[2].y()})};
  }
  k -= facets_.size();
  if (k < edges_.size()) {
    const EdgePiece& e = edges_[k];
    PlanBox box{e.x, e.x, e.y, e.y};
    bool first = true;
    for (const double u : {e.u0, e.u1}) {
      for (const double w : {e.w0, e.w1}) {
        const double x = e.x + u * e.dx - w * e.dy, y = e.y + u * e.dy + w * e.dx;
        if (first) box = {x, x, y, y};
        first = false;
        box.x0 = std::min(box.x0, x);
        box.x1 = std::max(box.x1, x);
        box.y0 = std::min(box.y0, y);
        box.y1 = std::max(box.y1, y);
      }
    }
    return box;
  }
  const VertexPiece& v = vertices_[k - edges_.size()];
  return {v.x0, v.x1, v.y0, v.y1};
}

double OffsetSurface::top(std::size_t k) const {
  if (k < facets_.size()) {
    const auto& v = facets_[k].v;
    return std::max({v[0].z(), v[1].z(), v[2].z()});
  }
  k -= facets_.size();
  if (k < edges_.size()) return edges_[k].z + std::max(0.0, edges_[k].slope * edges_[k].length);
  return vertices_[k - edges_.size()].z;
}

FacetSpan row_span(const FacetPiece& facet, double y) {
  FacetSpan out;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3* p = &facet.v[k];
    const Vec3* q = &facet.v[(k + 1) % 3];
    // Always from the same end, so that neighbours get the same crossing.
    if (q->y() < p->y() || (q->y() == p->y() && q->x() < p->x())) std::swap(p, q);
    if (y < p->y() || y > q->y()) continue;
    const double height = q->y() - p->y();
    const auto add = [&](double x, double z) {
      if (x < out.span.x0 || (x == out.span.x0 && z > out.z0)) {
        out.span.x0 = x;
        out.z0 = z;
      }
      if (x > out.span.x1 || (x == out.span.x1 && z > out.z1)) {
        out.span.x1 = x;
        out.z1 = z;
      }
    };
    if (height > 0) {
      const double t = (y - p->y()) / height;
      add(p->x() + t * (q->x() - p->x()), p->z() + t * (q->z() - p->z()));
    } else {
      add(p->x(), p->z());
      add(q->x(), q->z());
    }
  }
  return out;
}

Span row_span(const EdgePiece& e, const CutterShape& cutter, double y) {
  const double r = cutter.radius();
  // Where the cutter reaches the edge at all: a stadium.
  Span reach = disk(e.x, e.y, r, y);
  const Span end = disk(e.x + e.length * e.dx, e.y + e.length * e.dy, r, y);
  reach.x0 = std::min(reach.x0, end.x0);
  reach.x1 = std::max(reach.x1, end.x1);
  const double oy = y - e.y;
  Span middle{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  const double at_u = oy * e.dy - e.x * e.dx, at_w = oy * e.dx + e.x * e.dy;  // u, w at x = 0
  cut(middle, e.dx, at_u);
  cut(middle, -e.dx, e.length - at_u);
  cut(middle, -e.dy, at_w + r);
  cut(middle, e.dy, r - at_w);
  if (!middle.empty()) {
    reach.x0 = std::min(reach.x0, middle.x0);
    reach.x1 = std::max(reach.x1, middle.x1);
  }
  cut(reach, e.dx, at_u - e.u0);
  cut(reach, -e.dx, e.u1 - at_u);
  cut(reach, -e.dy, at_w - e.w0);
  cut(reach, e.dy, e.w1 - at_w);
  return reach;
}

Span row_span(const VertexPiece& v, const CutterShape& cutter, double y) {
  if (y < v.y0 || y > v.y1) return {};
  Span span = disk(v.x, v.y, cutter.radius(), y);
  span.x0 = std::max(span.x0, v.x0);
  span.x1 = std::min(span.x1, v.x1);
  cut(span, v.a[0], v.a[1] * (y - v.y) - v.a[0] * v.x + v.slack);
  cut(span, v.b[0], v.b[1] * (y - v.y) - v.b[0] * v.x + v.slack);
  return span;
}

Span line_span(const VertexPiece& v, const CutterShape& cutter, const Vec2& from, const Vec2& d) {
  const double ox = from.x() - v.x, oy = from.y() - v.y;
  Span span = disk(-(ox * d.x() + oy * d.y()), 0, cutter.radius(), oy * d.x() - ox * d.y());
  cut(span, d.x(), from.x() - v.x0);
  cut(span, -d.x(), v.x1 - from.x());
  cut(span, d.y(), from.y() - v.y0);
  cut(span, -d.y(), v.y1 - from.y());
  cut(span, v.a[0] * d.x() + v.a[1] * d.y(), v.a[0] * ox + v.a[1] * oy + v.slack);
  cut(span, v.b[0] * d.x() + v.b[1] * d.y(), v.b[0] * ox + v.b[1] * oy + v.slack);
  return span;
}

Contact contact(const EdgePiece& e, const CutterShape& cutter, double x, double y) {
  const double ox = x - e.x, oy = y - e.y;
  const double u = ox * e.dx + oy * e.dy, w = oy * e.dx - ox * e.dy;
  if (cutter.flat() <= 0) {
    // A ball meets the line at tau = m / stretch sqrt(r² - w²), its tip at z0 + m u + stretch
    // sqrt(r² - w²) - r.
    const double r = cutter.radius(), below = (r - w) * (r + w);
    const double half = std::sqrt(std::max(below, 0.0)), s = u + e.slope / e.stretch * half;
    if (below >= 0 && s >= 0 && s <= e.length) {
      return {e.z + e.slope * u + e.stretch * half - r, e.x + s * e.dx, e.y + s * e.dy};
    }
  }
  const double s = std::clamp(u + tau(cutter, e, w), 0.0, e.length);
  const double rho = std::sqrt(w * w + (s - u) * (s - u));
  if (rho > cutter.radius() * (1 + 1e-12)) {
    // The best point of the whole line lies beyond an end, or the edge is out of reach.
    const double reach = cutter.radius() * cutter.radius() - w * w;
    if (reach < 0) return {};
    const double half = std::sqrt(reach);
    const double nearest = std::clamp(u, 0.0, e.length);
    if (std::fabs(nearest - u) > half) return {};
    const double rim = std::clamp(s, u - half, u + half);
    return {e.z + e.slope * rim - cutter.height(std::sqrt(w * w + (rim - u) * (rim - u))),
            e.x + rim * e.dx, e.y + rim * e.dy};
  }
  return {e.z + e.slope * s - cutter.height(rho), e.x + s * e.dx, e.y + s * e.dy};
}

Contact contact(const VertexPiece& v, const CutterShape& cutter, double x, double y) {
  const double rho = std::sqrt((x - v.x) * (x - v.x) + (y - v.y) * (y - v.y));
  if (rho > cutter.radius() * (1 + 1e-12)) return {};
  return {v.z - cutter.height(rho), v.x, v.y};
}

}  // namespace diesink
