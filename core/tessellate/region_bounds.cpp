// How far a region's triangles and chords are from the die, and which chords to split for that.
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/tessellate/region_mesher.h"

namespace diesink {
namespace {

// Share of the tolerance that triangles are refined to whatever their arcs leave of it.
constexpr double kLeastRoom = 0.3;
// Chords of turned triangles that are halved are longer than this part of the tolerance, or than so
// many times what counts as one point. Where shorter ones look down it is by the rounding of
// heights beside a silhouette, and halves do so all the more.
constexpr double kTurnable = 0.02, kTurnablePoints = 2000;
// Of the tolerance: triangles no longer than this are left as they are.
constexpr double kSmall = 0.25;
// Slopes between triangle and face up to which what lies near a chord can be told apart.
constexpr double kGentle = 0.5;

}  // namespace

// Two vertices on arcs that end at one corner, nearer to each other than the least angle would have
// them so far from it.
bool RegionMesher::closing(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t pa = mesh_.arc_point[a], pb = mesh_.arc_point[b];
  if (pa == ArcSamples::kNone || pb == ArcSamples::kNone) return false;
  const std::uint32_t arc_a = samples_.points[pa].arc, arc_b = samples_.points[pb].arc;
  if (arc_a == arc_b || arc_a == ArcPoint::kNoNode || arc_b == ArcPoint::kNoNode) return false;
  const double gap = (mesh_.position[a] - mesh_.position[b]).norm();
  const auto ends = [&](std::uint32_t arc) {
    const PlanArc& of = arrangement_.arcs[arc];
    return std::array<std::uint32_t, 2>{of.nodes.front(), of.nodes.back()};
  };
  for (const std::uint32_t na : ends(arc_a)) {
    const PlanNode& corner = arrangement_.nodes[na];
    for (const std::uint32_t nb : ends(arc_b)) {
      const PlanNode& other = arrangement_.nodes[nb];
      // Corners that are not told apart at the tolerance are one.
      if (na != nb && std::hypot(corner.x - other.x, corner.y - other.y) > options_.shortest)
        continue;
      const Vec3& at = mesh_.position[a];
      if (gap < 0.4 * std::hypot(at.x() - corner.x, at.y() - corner.y)) return true;
    }
  }
  return false;
}

double RegionMesher::longest_edge(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  return std::fmax((mesh_.position[a] - mesh_.position[b]).norm(),
                   std::fmax((mesh_.position[b] - mesh_.position[c]).norm(),
                             (mesh_.position[c] - mesh_.position[a]).norm()));
}

double RegionMesher::border_bound_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  return std::fmax(mesh_.border_bound[a], std::fmax(mesh_.border_bound[b], mesh_.border_bound[c]));
}

double RegionMesher::face_bound_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  // No point of a triangle is farther from its vertices, which lie on the surface or as far off as
  // vertices stand, than its longest edge over the square root of three; that bounds the smallest
  // where no better bound holds (at an apex).
  return std::fmin(deviation_(mesh_.label, mesh_.position[a], mesh_.position[b], mesh_.position[c]),
                   most_off_ + 0.58 * longest_edge(a, b, c));
}

// A point p of the triangle has its foot on the surface within the face's bound f, along the
// triangle's normal. Where that foot lies beyond an arc, p lies between the arc's chord and the arc
// as seen along the normal: with d the way from the chord to the arc beside p, and s <= d·e the
// distance of p from the chord along e, in the triangle and across the chord, p is
// |d - s e|² = d² - s (2 d·e - s) from the arc, so no farther than the chord is. The larger of both
// is the bound, not their sum. The factor of two before d·e is room for neighbouring triangles,
// whose normals differ from that of the one at the chord: `slope` bounds by how much, as a gap that
// is quadratic, at most f and nothing at the vertices falls off by at most 8 f / altitude.
double RegionMesher::bound_of(double face, std::uint32_t a, std::uint32_t b,
                              std::uint32_t c) const {
  const double border = border_bound_of(a, b, c);
  if (border == 0 || face == 0) return face + border;
  const Vec3 &p = mesh_.position[a], &q = mesh_.position[b], &r = mesh_.position[c];
  const double altitude = (q - p).cross(r - p).norm() / longest_edge(a, b, c);
  const double slope = 8 * face / altitude;
  // (The bound of a long ellipsoid need not be along that normal.)
  return slope < kGentle && !chart_.is_long() ? std::fmax(face, border) : face + border;
}

bool RegionMesher::border_keeps(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                                double limit) const {
  const double border = border_bound_of(a, b, c);
  if (border == 0) return true;
  if (border > limit || chart_.is_long()) return false;
  const Vec3 &p = mesh_.position[a], &q = mesh_.position[b], &r = mesh_.position[c];
  const double square =
      std::max({(q - p).squaredNorm(), (r - q).squaredNorm(), (p - r).squaredNorm()});
  // As in bound_of(), with the limit in place of the face's bound.
  const double steepest = 0.999 * kGentle / (8 * limit);
  return square < steepest * steepest * (q - p).cross(r - p).squaredNorm();
}

// A vertex of the border that no vertex inside can make up for, however many there are of them:
// what is left of its triangles is told.
bool RegionMesher::is_off_face(std::uint32_t v) const {
  if (mesh_.arc_point[v] == ArcSamples::kNone) return false;
  if (off_face_.size() <= v) off_face_.resize(mesh_.position.size(), OffFace::kUnknown);
  OffFace& known = off_face_[v];
  if (known == OffFace::kUnknown) {
    const Vec3& p = mesh_.position[v];
    // (Nothing is bounded at an apex.)
    const std::optional<Vec3> apex = chart_.apex();
    const bool on = deviation_(mesh_.label, p, p, p) <= options_.tolerance ||
                    (apex && (*apex - p).norm() <= options_.tolerance);
    known = on ? OffFace::kNo : OffFace::kYes;
  }
  return known == OffFace::kYes;
}

bool RegionMesher::too_coarse(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const double tolerance = options_.tolerance;
  const DeviationFilter::Side side = filter_.compare(a, b, c, mesh_.position, tolerance);
  if (side == DeviationFilter::Side::kWithin && border_keeps(a, b, c, tolerance)) return false;
  // Next to nothing across: only its arcs could mend it.
  const double longest = longest_edge(a, b, c);
  if (!(longest > kSmall * tolerance)) return false;
  if (is_off_face(a) || is_off_face(b) || is_off_face(c)) return false;
  if (side == DeviationFilter::Side::kBeyond && most_off_ + 0.57 * longest > tolerance) return true;
  // What arcs leave no room for, vertices inside cannot mend.
  const double face = face_bound_of(a, b, c);
  if (bound_of(face, a, b, c) <= tolerance) return false;
  if (face > kLeastRoom * tolerance) return true;
  tight_ = true;
  return false;
}

// By more than rounding turns an upright triangle.
bool RegionMesher::looks_down(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const Vec3 u = mesh_.position[b] - mesh_.position[a], v = mesh_.position[c] - mesh_.position[a];
  const Vec3 n = u.cross(v);
  return n.z() < 0 && n.z() < -1e-9 * n.norm();
}

bool RegionMesher::is_folded(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  return looks_down(a, b, c) && longest_edge(a, b, c) > kSmall * options_.tolerance;
}

// Nearer to upright than the rounding of vertices that are moved afterwards may turn it.
bool RegionMesher::may_round_down(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  if (options_.largest_coordinate == 0) return false;
  const double ulp = std::ldexp(options_.largest_coordinate, -52);
  const Vec3 u = mesh_.position[b] - mesh_.position[a], v = mesh_.position[c] - mesh_.position[a];
  return u.x() * v.y() - u.y() * v.x() <
         2 * ulp * (u.head<2>().lpNorm<1>() + v.head<2>().lpNorm<1>());
}

bool RegionMesher::has_no_area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const Vec3 &p = mesh_.position[a], &q = mesh_.position[b], &r = mesh_.position[c];
  return !((q - p).cross(r - p).norm() > flat_ * longest_edge(a, b, c));
}

// The bounds of chords as they are now: splits have left those of their ends as they were.
void RegionMesher::renew_border_bounds() {
  worst_chord_.clear();
  std::fill(mesh_.border_bound.begin(), mesh_.border_bound.end(), 0);
  std::vector<std::uint32_t> chain;
  for (const std::vector<ArcUse>& loop : arrangement_.regions[mesh_.region].loops) {
    for (const ArcUse& use : loop) {
      samples_.chain(use.arc, chain);
      for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
        const double d = samples_.chord_bound(chain[k], chain[k + 1]);
        for (const std::uint32_t p : {chain[k], chain[k + 1]}) {
          const auto own = local_of_.find(p);
          if (own == local_of_.end()) continue;
          double& most = mesh_.border_bound[own->second];
          if (d > most) worst_chord_[own->second] = {chain[k], chain[k + 1]};
          most = std::fmax(most, d);
        }
      }
    }
  }
}

// In the narrow end between two arcs a triangle's own bound and that of its chords add up: chords
// that leave it too little room are split.
std::vector<RegionMesher::Chord> RegionMesher::chords_of_tight() {
  renew_border_bounds();
  std::vector<Chord> chords;
  for (const auto& t : triangulation_.triangles()) {
    if (border_bound_of(t[0], t[1], t[2]) == 0 ||
        bound_of(face_bound_of(t[0], t[1], t[2]), t[0], t[1], t[2]) <= options_.tolerance)
      continue;
    std::uint32_t worst = t[0];
    for (const std::uint32_t v : t) {
      if (mesh_.border_bound[v] > mesh_.border_bound[worst]) worst = v;
    }
    const auto chord = worst_chord_.find(worst);
    if (chord != worst_chord_.end()) chords.push_back(chord->second);
  }
  std::sort(chords.begin(), chords.end());
  chords.erase(std::unique(chords.begin(), chords.end()), chords.end());
  return chords;
}

// The border alone, before a vertex inside or a split could help.
bool RegionMesher::folds() const {
  const auto triangles = triangulation_.triangles();
  return std::any_of(triangles.begin(), triangles.end(),
                     [&](const auto& t) { return is_folded(t[0], t[1], t[2]); });
}

// Beside a silhouette chords of two arcs that never meet may cross in plan, one above the other:
// the triangles between them look down. Shorter chords do not.
std::vector<RegionMesher::Chord> RegionMesher::chords_of_turned() {
  std::vector<Chord> chords;
  for (const auto& t : triangulation_.triangles()) {
    if (!looks_down(t[0], t[1], t[2])) continue;
    // The longest alone: where two arcs leave a corner in one direction short chords of the one
    // cross long ones of the other for ever, however short.
    Chord longest{};
    double length = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t u = t[k], v = t[(k + 1) % 3];
      const std::uint32_t p = mesh_.arc_point[u], q = mesh_.arc_point[v];
      if (p == ArcSamples::kNone || q == ArcSamples::kNone || !samples_.is_chord(p, q)) continue;
      const double own = (mesh_.position[u] - mesh_.position[v]).norm();
      if (!(own > length)) continue;
      length = own;
      longest = {p, q};
    }
    if (length > std::fmin(kTurnable * options_.tolerance, kTurnablePoints * near_))
      chords.push_back(longest);
  }
  return chords;
}

}  // namespace diesink
