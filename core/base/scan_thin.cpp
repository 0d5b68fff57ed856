// SPDX-License-Identifier: Apache-2.0
#include "core/base/scan_thin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/exact_plan.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;
constexpr double kInf = std::numeric_limits<double>::infinity();
// Parts of the tolerance that the passes allow: small steps first leave a better mesh.
constexpr double kPasses[] = {0.06, 0.15, 0.3, 0.5, 0.75, 1, 1, 1};
// Vertices of a tile, about: what belongs to them is some 400 KB.
constexpr std::size_t kTile = 1024;
// Below this share of a regular triangle's the shape of a new triangle counts as bad, unless those
// it replaces were worse.
constexpr double kLeastShape = 0.08;

// Sum of squared heights of a point above planes, each weighted: a form in (x, y, z, 1).
struct HeightQuadric {
  double xx = 0, xy = 0, yy = 0, x = 0, y = 0, c = 0, w = 0, xz = 0, yz = 0, z = 0;
  // Plane z = a x + b y + d.
  void add(double a, double b, double d, double weight) {
    xx += weight * a * a;
    xy += weight * a * b;
    yy += weight * b * b;
    x += weight * a * d;
    y += weight * b * d;
    c += weight * d * d;
    w += weight;
    xz += weight * a;
    yz += weight * b;
    z += weight * d;
  }
  void add(const HeightQuadric& q) {
    xx += q.xx, xy += q.xy, yy += q.yy, x += q.x, y += q.y, c += q.c;
    w += q.w, xz += q.xz, yz += q.yz, z += q.z;
  }
  [[nodiscard]] double at(const Vec3& p) const {
    return p.x() * (xx * p.x() + 2 * xy * p.y() + 2 * x) + p.y() * (yy * p.y() + 2 * y) + c +
           p.z() * (w * p.z() - 2 * (xz * p.x() + yz * p.y() + z));
  }
};

class Thinner {
 public:
  Thinner(ScanSheet& sheet, const ThinOptions& options);
  double run(std::vector<std::uint32_t>* kept);

 private:
  [[nodiscard]] int side(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Vec3 &p = points_[a], &q = points_[b], &r = points_[c];
    return turn(p.x(), p.y(), q.x(), q.y(), r.x(), r.y());
  }
  [[nodiscard]] double area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Vec3 &p = points_[a], &q = points_[b], &r = points_[c];
    return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
  }
  void take_part();
  void gather(std::uint32_t v);
  [[nodiscard]] double shape(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] double edge_error(std::uint32_t a, std::uint32_t b, double most) const;
  bool may_go_to(std::uint32_t v, std::size_t j) const;
  double try_target(std::uint32_t v, std::size_t j, double most);
  void collapse(std::uint32_t v, std::size_t j);
  bool thin(std::uint32_t v, double most);

  ScanSheet& sheet_;
  const ThinOptions& options_;
  const std::vector<Vec3>& points_;
  ScanSheet old_;  // as it was
  std::vector<std::uint32_t> begins_, around_;
  std::vector<std::uint32_t> leaving_;  // a half-edge of each vertex that is left
  std::vector<char> feature_;           // of each half-edge
  std::vector<char> locked_, gone_;
  std::vector<char> on_chain_;           // on a border that may be straightened
  std::vector<std::uint32_t> fan_size_;  // of each vertex at first
  std::vector<HeightQuadric> quadric_;
  std::vector<std::uint32_t> head_, next_;  // vertices gone, by the triangle they lie in
  double largest_ = 0;
  // The triangles round the vertex at work.
  std::vector<std::uint32_t> fan_;   // their half-edges that leave it, anticlockwise
  std::vector<std::uint32_t> ring_;  // the vertices round it
  bool closed_ = false;
  std::vector<std::uint32_t> inside_;                            // vertices gone in the fan
  std::vector<std::pair<std::uint32_t, std::uint32_t>> placed_;  // and their fan triangle
  std::vector<std::pair<double, std::size_t>> targets_;
};

// Leaves the part that stays: the rest has no triangles.
void Thinner::take_part() {
  if (options_.part.empty()) return;
  for (std::size_t t = 0; t < sheet_.triangles.size(); ++t) {
    if (!options_.part[t]) sheet_.triangles[t] = {kNone, kNone, kNone};
  }
  for (std::uint32_t& twin : sheet_.twin) {
    if (twin != kNone && !options_.part[twin / 3]) twin = kNone;
  }
}

Thinner::Thinner(ScanSheet& sheet, const ThinOptions& options)
    : sheet_(sheet), options_(options), points_(sheet.points), old_(sheet) {
  old_.fans(begins_, around_);
  take_part();
  const std::size_t n = points_.size();
  leaving_.assign(n, kNone);
  locked_.assign(n, 0);
  gone_.assign(n, 0);
  on_chain_.assign(n, 0);
  quadric_.resize(n);
  fan_size_.assign(n, 0);
  head_.assign(sheet.triangles.size(), kNone);
  next_.assign(n, kNone);
  feature_.assign(sheet.twin.size(), 0);
  const Vec3 origin = n > 0 ? points_[0] : Vec3(0, 0, 0);
  std::vector<Vec3> normals(sheet.triangles.size());
  for (std::uint32_t t = 0; t < sheet.triangles.size(); ++t) {
    const auto& v = sheet.triangles[t];
    if (v[0] == kNone) continue;
    const Vec3 &a = points_[v[0]], &b = points_[v[1]], &c = points_[v[2]];
    const Vec3 normal = (b - a).cross(c - a);
    normals[t] = normal.normalized();
    for (std::uint32_t k = 0; k < 3; ++k) {
      leaving_[v[k]] = 3 * t + k;
      ++fan_size_[v[k]];
    }
    if (!(normal.z() > 0)) continue;
    const double zx = -normal.x() / normal.z(), zy = -normal.y() / normal.z();
    const Vec3 p = a - origin;
    for (const std::uint32_t w : v)
      quadric_[w].add(zx, zy, p.z() - zx * p.x() - zy * p.y(), normal.z());
  }
  const double least = std::cos(options.feature_angle);
  std::vector<std::uint8_t> lines(n, 0), borders(n, 0);
  for (std::uint32_t h = 0; h < sheet.twin.size(); ++h) {
    if (sheet.triangles[h / 3][0] == kNone) continue;
    const std::uint32_t twin = sheet.twin[h];
    const std::uint32_t a = sheet.from(h), b = sheet.to(h);
    if (twin == kNone) {
      for (const std::uint32_t v : {a, b})
        borders[v] = static_cast<std::uint8_t>(std::min(borders[v] + 1, 9));
    } else if (normals[h / 3].dot(normals[twin / 3]) < least) {
      feature_[h] = 1;
      lines[a] =
          static_cast<std::uint8_t>(std::min(lines[a] + 1, 9));  // each edge from both its sides
    }
  }
  for (std::uint32_t v = 0; v < n; ++v) {
    if (leaving_[v] == kNone) {
      gone_[v] = 1;
      continue;
    }
    if (lines[v] != 0 && (lines[v] != 2 || borders[v] != 0)) locked_[v] = 1;
    if (!options.fixed.empty() && options.fixed[v]) locked_[v] = 1;
    if (borders[v] == 0) continue;
    // On the border only what lies between two neighbours on a side of the box.
    const Vec3& p = points_[v];
    const std::array<bool, 4> on{p.x() == options.box.x0, p.x() == options.box.x1,
                                 p.y() == options.box.y0, p.y() == options.box.y1};
    bool straight = false, fixed = false;
    for (std::size_t s = 0; s < 4; ++s) {
      straight = straight || (on[s] && !options.fixed_side[s]);
      fixed = fixed || (on[s] && options.fixed_side[s]);
    }
    if (borders[v] == 2 && !straight && !fixed && options.may_straighten) {
      on_chain_[v] = 1;
    } else if (borders[v] != 2 || !straight) {
      locked_[v] = 1;
    }
  }
}

// The fan of v into fan_ and ring_.
void Thinner::gather(std::uint32_t v) {
  fan_.clear();
  ring_.clear();
  std::uint32_t start = leaving_[v];
  // Back to where an open fan begins.
  for (std::uint32_t h = start;;) {
    const std::uint32_t twin = sheet_.twin[h];
    if (twin == kNone) {
      start = h;
      break;
    }
    h = ScanSheet::next(twin);
    if (h == start) break;
  }
  closed_ = false;
  for (std::uint32_t h = start;;) {
    fan_.push_back(h);
    ring_.push_back(sheet_.to(h));
    const std::uint32_t back = ScanSheet::previous(h), twin = sheet_.twin[back];
    if (twin == kNone) {
      ring_.push_back(sheet_.from(back));
      break;
    }
    h = twin;
    if (h == start) {
      closed_ = true;
      break;
    }
  }
}

double Thinner::shape(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const Vec3 u = points_[b] - points_[a], v = points_[c] - points_[a];
  const double sum = u.squaredNorm() + v.squaredNorm() + (v - u).squaredNorm();
  return sum > 0 ? 3.4641016151377544 * u.cross(v).norm() / sum : 0;
}

// Largest height between the straight edge a-b and the old sheet under it; infinity where the old
// sheet is not all along under it. Stops looking beyond `most`.
double Thinner::edge_error(std::uint32_t a, std::uint32_t b, double most) const {
  const Vec3 &pa = points_[a], &pb = points_[b];
  const Vec2 d = (pb - pa).head<2>();
  const double square = d.squaredNorm();
  double worst = 0;
  const auto see = [&](const Vec3& p) {
    const double s = d.dot((p - pa).head<2>()) / square;
    worst = std::fmax(worst, std::fabs(pa.z() + s * (pb.z() - pa.z()) - p.z()));
  };
  std::uint32_t at = a;
  for (std::size_t guard = 0; guard < old_.triangles.size(); ++guard) {
    // From a vertex: along an edge, or through the triangle that the way leads into.
    std::uint32_t h = kNone, along = kNone;
    for (std::uint32_t k = begins_[at]; k < begins_[at + 1] && h == kNone && along == kNone; ++k) {
      const std::uint32_t out = around_[k], p = old_.to(out),
                          q = old_.from(ScanSheet::previous(out));
      const int sp = side(at, p, b), sq = side(at, q, b);
      if (sp < 0 || sq > 0) continue;
      for (const std::uint32_t v : {p, q}) {
        const bool on = v == p ? sp == 0 : sq == 0;
        if (on && (points_[v] - points_[at]).head<2>().dot(d) > 0) along = v;
      }
      if (along == kNone && sp > 0 && sq < 0) h = ScanSheet::next(out);
    }
    if (along != kNone) {
      if (along == b) return worst;
      see(points_[along]);
      at = along;
      if (worst > most) return worst;
      continue;
    }
    if (h == kNone) return kInf;
    // Across edge after edge until a vertex lies on the way.
    for (;;) {
      const std::uint32_t p = old_.from(h), q = old_.to(h);
      const double left = std::fabs(area(at, b, q)), right = std::fabs(area(at, b, p));
      if (left + right > 0) see((points_[p] * left + points_[q] * right) / (left + right));
      if (worst > most) return worst;
      const std::uint32_t twin = old_.twin[h];
      if (twin == kNone) return kInf;
      const std::uint32_t r = old_.from(ScanSheet::previous(twin));
      if (r == b) return worst;
      const int s = side(at, b, r);
      if (s == 0) {
        see(points_[r]);
        at = r;
        break;
      }
      // The twin runs q to p: its next p to r, then r to q.
      h = s > 0 ? ScanSheet::next(twin) : ScanSheet::previous(twin);
    }
  }
  return kInf;
}

// Whether the rules of lines and borders let v go to its j-th neighbour.
bool Thinner::may_go_to(std::uint32_t v, std::size_t j) const {
  if (!closed_) {
    if (j != 0 && j + 1 != ring_.size()) return false;
    if (fan_.size() < 2) return false;
    return on_chain_[v] || side(ring_.front(), v, ring_.back()) == 0;
  }
  bool on_line = false, along = false;
  for (std::size_t i = 0; i < fan_.size(); ++i) {
    if (!feature_[fan_[i]]) continue;
    on_line = true;
    along = along || i == j;
  }
  return !on_line || along;
}

// What the sheet would err by where v goes to its j-th neighbour; infinity where it cannot.
double Thinner::try_target(std::uint32_t v, std::size_t j, double most) {
  const std::uint32_t u = ring_[j];
  const std::size_t n = fan_.size();
  const auto end_of = [&](std::size_t i) { return ring_[i + 1 == ring_.size() ? 0 : i + 1]; };
  double was = 1, is = 1;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t a = ring_[i], b = end_of(i);
    was = std::fmin(was, shape(v, a, b));
    if (a == u || b == u) continue;
    if (side(u, a, b) <= 0) return kInf;
    is = std::fmin(is, shape(u, a, b));
  }
  if (is < kLeastShape && is < was) return kInf;
  double worst = 0;
  placed_.clear();
  const auto place = [&](std::uint32_t p) {
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t a = ring_[i], b = end_of(i);
      if (a == u || b == u) continue;
      if (side(a, b, p) < 0 || side(u, a, p) < 0 || side(b, u, p) < 0) continue;
      const double wa = area(b, u, p), wb = area(u, a, p), wu = area(a, b, p);
      const double z =
          (wa * points_[a].z() + wb * points_[b].z() + wu * points_[u].z()) / (wa + wb + wu);
      worst = std::fmax(worst, std::fabs(z - points_[p].z()));
      placed_.emplace_back(p, static_cast<std::uint32_t>(i));
      return true;
    }
    return false;
  };
  // What lay on a border may lie beyond it now: how far is the border's own matter.
  if ((!place(v) && !on_chain_[v]) || worst > most) return kInf;
  for (const std::uint32_t p : inside_) {
    if ((!place(p) && !on_chain_[p]) || worst > most) return kInf;
  }
  // New edges: from u to every other vertex of the ring but its neighbours there.
  for (std::size_t i = 0; i < ring_.size(); ++i) {
    const std::uint32_t w = ring_[i];
    if (w == u) continue;
    const std::size_t before = i == 0 ? ring_.size() - 1 : i - 1,
                      after = i + 1 == ring_.size() ? 0 : i + 1;
    if (closed_ && (ring_[before] == u || ring_[after] == u)) continue;
    if (!closed_ && ((i > 0 && ring_[i - 1] == u) || (i + 1 < ring_.size() && ring_[i + 1] == u)))
      continue;
    worst = std::fmax(worst, edge_error(u, w, most));
    if (worst > most) return kInf;
  }
  return worst;
}

void Thinner::collapse(std::uint32_t v, std::size_t j) {
  const std::uint32_t u = ring_[j];
  const std::size_t n = fan_.size();
  for (const std::uint32_t h : fan_) head_[h / 3] = kNone;
  for (const auto& [p, i] : placed_) {
    const std::uint32_t t = fan_[i] / 3;
    next_[p] = head_[t];
    head_[t] = p;
  }
  const auto glue = [&](std::uint32_t inner, std::uint32_t outer) {
    if (inner != kNone) sheet_.twin[inner] = outer;
    if (outer != kNone) sheet_.twin[outer] = inner;
    const char line = (inner != kNone && feature_[inner]) || (outer != kNone && feature_[outer]);
    if (inner != kNone) feature_[inner] = outer != kNone && line;
    if (outer != kNone) feature_[outer] = inner != kNone && line;
  };
  const auto remove = [&](std::uint32_t t) { sheet_.triangles[t] = {kNone, kNone, kNone}; };
  // The triangle behind v-u on its left, (v, u, x): u-x outside meets x-v inside.
  if (j < n) {
    const std::uint32_t h = fan_[j];
    const std::uint32_t outer = sheet_.twin[ScanSheet::next(h)],
                        inner = sheet_.twin[ScanSheet::previous(h)];
    glue(inner, outer);
    remove(h / 3);
  }
  // And on its right, (v, y, u): y-u outside meets v-y inside.
  if (closed_ || j > 0) {
    const std::uint32_t h = fan_[j == 0 ? n - 1 : j - 1];
    const std::uint32_t outer = sheet_.twin[ScanSheet::next(h)], inner = sheet_.twin[h];
    glue(inner, outer);
    remove(h / 3);
  }
  for (const std::uint32_t h : fan_) {
    if (sheet_.triangles[h / 3][0] == kNone) continue;
    sheet_.triangles[h / 3][h % 3] = u;
    leaving_[u] = h;
    leaving_[sheet_.from(ScanSheet::next(h))] = ScanSheet::next(h);
    leaving_[sheet_.from(ScanSheet::previous(h))] = ScanSheet::previous(h);
  }
  quadric_[u].add(quadric_[v]);
  gone_[v] = 1;
}

bool Thinner::thin(std::uint32_t v, double most) {
  gather(v);
  if (fan_.size() < 2 || (closed_ && fan_.size() < 3)) return false;
  targets_.clear();
  const Vec3& origin = points_[0];
  for (std::size_t j = 0; j < ring_.size(); ++j) {
    if (!may_go_to(v, j)) continue;
    const Vec3 p = points_[ring_[j]] - origin;
    targets_.emplace_back(
        quadric_[v].at(p) + 1e-9 * quadric_[v].w * (points_[ring_[j]] - points_[v]).squaredNorm(),
        j);
  }
  if (targets_.empty()) return false;
  std::sort(targets_.begin(), targets_.end());
  inside_.clear();
  for (const std::uint32_t h : fan_) {
    for (std::uint32_t p = head_[h / 3]; p != kNone; p = next_[p]) inside_.push_back(p);
  }
  constexpr std::size_t kTries = 4;
  for (std::size_t k = 0; k < std::min(kTries, targets_.size()); ++k) {
    const double error = try_target(v, targets_[k].second, most);
    if (!(error <= most)) continue;
    if (on_chain_[v] &&
        !options_.may_straighten(ring_.front(), v, ring_.back(), most / options_.tolerance))
      return false;
    if (!closed_ && options_.straightened) options_.straightened(v);
    largest_ = std::fmax(largest_, error);
    collapse(v, targets_[k].second);
    return true;
  }
  return false;
}

double Thinner::run(std::vector<std::uint32_t>* kept) {
  // A fixed order without direction: neighbours seldom follow one another. Tile by tile, so that
  // what is looked at stays in the cache.
  const std::size_t n = points_.size();
  Vec2 low(kInf, kInf), high(-kInf, -kInf);
  for (std::uint32_t v = 0; v < n; ++v) {
    if (gone_[v]) continue;
    low = low.cwiseMin(points_[v].head<2>());
    high = high.cwiseMax(points_[v].head<2>());
  }
  const auto tiles = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(n / kTile))) + 1;
  const Vec2 extent = high - low;
  const auto line = [&](const Vec3& p, int axis) {
    const double at = extent[axis] > 0 ? (p[axis] - low[axis]) / extent[axis] : 0;
    return std::min(static_cast<std::uint32_t>(at * tiles), tiles - 1);
  };
  const auto mixed = [](std::uint32_t v) {
    std::uint32_t x = v * 0x9E3779B1u;
    x ^= x >> 15;
    x *= 0x85EBCA77u;
    return x ^ (x >> 13);
  };
  std::vector<std::array<std::uint32_t, 3>> keyed;  // tile, mixed, vertex
  for (std::uint32_t v = 0; v < n; ++v) {
    if (gone_[v] || locked_[v]) continue;
    keyed.push_back({line(points_[v], 1) * tiles + line(points_[v], 0), mixed(v), v});
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::uint32_t> order;
  for (const auto& k : keyed) order.push_back(k[2]);
  // Vertices with two fans stay.
  for (const std::uint32_t v : order) {
    gather(v);
    if (fan_.size() != fan_size_[v]) locked_[v] = 1;
  }
  const double tolerance = options_.tolerance;
  for (const double part : kPasses) {
    std::size_t went = 0;
    for (const std::uint32_t v : order) {
      if (!gone_[v] && !locked_[v] && thin(v, part * tolerance)) ++went;
    }
    std::erase_if(order, [&](std::uint32_t v) { return gone_[v] || locked_[v]; });
    if (part == 1 && went * 200 < order.size() + 1) break;
  }
  // What is left, numbered anew.
  std::vector<std::uint32_t> number(n, kNone);
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (const auto& t : sheet_.triangles) {
    if (t[0] == kNone) continue;
    std::array<std::uint32_t, 3> made{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (number[t[k]] == kNone) {
        number[t[k]] = static_cast<std::uint32_t>(points.size());
        points.push_back(points_[t[k]]);
      }
      made[k] = number[t[k]];
    }
    triangles.push_back(made);
  }
  if (kept != nullptr) {
    kept->assign(points.size(), kNone);
    for (std::uint32_t v = 0; v < n; ++v) {
      if (number[v] != kNone) (*kept)[number[v]] = v;
    }
  }
  sheet_.points = std::move(points);
  sheet_.triangles = std::move(triangles);
  sheet_.make_twins();
  return largest_;
}

}  // namespace

double thin_sheet(ScanSheet& sheet, const ThinOptions& options, std::vector<std::uint32_t>* kept) {
  return Thinner(sheet, options).run(kept);
}

}  // namespace diesink
