// Vertices are split as in meshes, a run of triangles at a time, so that the plan stays a
// triangulation by construction.
// SPDX-License-Identifier: Apache-2.0
#include "core/base/layer_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/exact_plan.h"
#include "core/base/scanned_triangle.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;
// Of the strips' width: heights that differ by less at a vertex need none.
constexpr double kLeastStep = 0.5;
// Of the way to the opposite side of a triangle: how far a vertex moves at most.
constexpr double kMostOfTheWay = 0.5;
// Of the strips' width: where there is no room for more, a run is told and not moved.
constexpr double kLeastWidth = 1e-6;
// What opens out from a wall more steeply than that has narrower strips, too, lest they run far
// down it.
constexpr double kSteep = 8;
// Of the ways that go to the left of its first side and to the right of its last: which are tried,
// the middle first.
constexpr double kWays[] = {0.5, 0.25, 0.75, 0.1, 0.9};
// Of the strips' width: what lies no farther from a side of a cell is on it, as lines are laid
// through points that near.
constexpr double kBesideSide = 2e-3;

// Radians: from there on what lies beside an opening counts as half a round.
constexpr double kHalf = std::numbers::pi - 1e-3;
// Where cells round a vertex begin: after an opening, or anywhere of a full round.
constexpr char kOpen = 1, kClosed = 2;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

bool turns_left(const Vec2& a, const Vec2& b, const Vec2& c) {
  return turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y()) > 0;
}

}  // namespace

double LayerCells::plan_area(const std::array<std::uint32_t, 3>& v) const {
  const Vec3& p = sheet_.points[v[0]];
  return 0.5 * cross((sheet_.points[v[1]] - p).head<2>(), (sheet_.points[v[2]] - p).head<2>());
}

// Across the longest side.
double LayerCells::width_of(const std::array<std::uint32_t, 3>& v) const {
  const Vec3 &p = sheet_.points[v[0]], &q = sheet_.points[v[1]], &r = sheet_.points[v[2]];
  return 2 * plan_area(v) /
         std::max({(q - p).head<2>().norm(), (r - q).head<2>().norm(), (p - r).head<2>().norm()});
}

// A vertex of the face itself has its height to the bit.
double LayerCells::height(std::uint32_t cell, std::uint32_t v) const {
  const Vec3& p = sheet_.points[v];
  for (const std::uint32_t w : faces_[cells_[cell].face]) {
    const Vec3& q = given_[w];
    if (q.x() == p.x() && q.y() == p.y()) return q.z();
  }
  return planes_[cell].at(p);
}

// The cells round v, anticlockwise, those after an opening first.
void LayerCells::order_round(std::uint32_t v) {
  std::vector<Spoke> spokes;
  for (const std::uint32_t c : around_[v]) {
    const auto& t = cells_[c].v;
    const std::size_t k = t[0] == v ? 0 : t[1] == v ? 1 : 2;
    spokes.push_back({c, t[(k + 1) % 3], t[(k + 2) % 3], 0});
  }
  std::sort(spokes.begin(), spokes.end(),
            [](const Spoke& a, const Spoke& b) { return a.from < b.from; });
  const auto starting = [&](std::uint32_t w) {
    const auto it = std::lower_bound(spokes.begin(), spokes.end(), w,
                                     [](const Spoke& s, std::uint32_t u) { return s.from < u; });
    return it != spokes.end() && it->from == w ? static_cast<std::size_t>(it - spokes.begin())
                                               : spokes.size();
  };
  std::vector<char> has_before(spokes.size(), 0), taken(spokes.size(), 0);
  for (const Spoke& s : spokes) {
    if (const std::size_t k = starting(s.to); k < spokes.size()) has_before[k] = 1;
  }
  round_.clear();
  begins_.clear();
  for (const bool closed : {false, true}) {
    for (std::size_t k = 0; k < spokes.size(); ++k) {
      if (taken[k] || (!closed && has_before[k])) continue;
      begins_.push_back(closed ? kClosed : kOpen);
      for (std::size_t s = k; s < spokes.size() && !taken[s]; s = starting(spokes[s].to)) {
        taken[s] = 1;
        round_.push_back(spokes[s]);
        begins_.resize(round_.size(), 0);
      }
    }
  }
  for (Spoke& s : round_) {
    if (cells_[s.cell].face != kNone) s.height = height(s.cell, v);
  }
}

// All the way round, from one that stays where there is one.
void LayerCells::find_runs(double kept) {
  const auto joins = [&](const Spoke& a, const Spoke& b) {
    return cells_[a.cell].face != kNone && cells_[b.cell].face != kNone &&
           std::fabs(a.height - b.height) <= kLeastStep * lean_;
  };
  const std::size_t n = round_.size();
  const bool closed = n > 0 && begins_[0] == kClosed;
  if (closed) {
    std::size_t start = n;
    for (std::size_t k = 0; k < n; ++k) {
      if (joins(round_[(k + n - 1) % n], round_[k])) continue;
      const bool stays = cells_[round_[k].cell].face != kNone &&
                         std::fabs(round_[k].height - kept) <= kLeastStep * lean_;
      if (start == n || stays) start = k;
      if (stays) break;
    }
    std::rotate(round_.begin(), round_.begin() + static_cast<std::ptrdiff_t>(start % n),
                round_.end());
  }
  runs_.clear();
  for (std::size_t k = 0; k < n; ++k) {
    const Spoke& s = round_[k];
    if (cells_[s.cell].face == kNone) continue;
    const bool opens = begins_[k] == kOpen;
    if (k == 0 || opens || !joins(round_[k - 1], s))
      runs_.push_back({k, 0, s.height, s.height, opens, false});
    Run& run = runs_.back();
    ++run.count;
    run.low = std::fmin(run.low, s.height);
    run.high = std::fmax(run.high, s.height);
    run.open_after = !closed && (k + 1 == n || begins_[k + 1] == kOpen);
  }
}

// What lies off that height on one side, without anything at it between.
std::vector<LayerCells::Group> LayerCells::groups_off(double kept) {
  std::vector<Group> groups;
  const auto is_strip = [&](const Spoke& s) { return cells_[s.cell].face == kNone; };
  for (std::size_t r = 0; r < runs_.size();) {
    const double off = runs_[r].off(kept);
    std::size_t end = r + 1;
    if (std::fabs(off) <= kLeastStep * lean_) {
      r = end;
      continue;
    }
    double nearest = off;
    for (; end < runs_.size() && !runs_[end - 1].open_after; ++end) {
      const double next = runs_[end].off(kept);
      if (std::fabs(next) <= kLeastStep * lean_ || (next > 0) != (off > 0)) break;
      if (std::fabs(next) < std::fabs(nearest)) nearest = next;
    }
    const Run &first = runs_[r], &last = runs_[end - 1];
    // What is nothing of its own goes along where nothing lies beyond.
    std::size_t from = first.first, to = last.first + last.count;
    while (from > 0 && begins_[from] == 0 && is_strip(round_[from - 1])) --from;
    const bool open_before = begins_[from] == kOpen;
    while (to < round_.size() && begins_[to] == 0 && is_strip(round_[to])) ++to;
    const bool open_after = begins_[0] == kOpen && (to == round_.size() || begins_[to] == kOpen);
    if (!open_before) from = first.first;
    if (!open_after) to = last.first + last.count;
    groups.push_back({{round_.begin() + static_cast<std::ptrdiff_t>(from),
                       round_.begin() + static_cast<std::ptrdiff_t>(to)},
                      open_before,
                      open_after,
                      off < 0,
                      kept + nearest});
    r = end;
  }
  return groups;
}

bool LayerCells::all_turn_left(const Group& group, std::uint32_t v, const Vec2& p) const {
  const auto plan = [&](std::uint32_t w) -> Vec2 { return sheet_.points[w].head<2>(); };
  for (const Spoke& s : group.spokes) {
    if (!turns_left(p, plan(s.from), plan(s.to))) return false;
  }
  return (group.open_before || turns_left(plan(v), plan(group.spokes.front().from), p)) &&
         (group.open_after || turns_left(plan(v), p, plan(group.spokes.back().to)));
}

// Gives the group a vertex of its own and returns it, or none where there is no room.
std::uint32_t LayerCells::move(std::uint32_t v, const Group& group) {
  const Vec2 from = sheet_.points[v].head<2>();
  const auto way_to = [&](std::uint32_t w) -> Vec2 { return sheet_.points[w].head<2>() - from; };
  const std::uint32_t first = group.spokes.front().from, last = group.spokes.back().to;
  const double angle = angle_of(v, group.spokes);
  // How steeply the faces of the group close in on the wall, that way into it. What lies in that
  // corner moves along the steepest of them; what opens out, no farther than sideways.
  const auto closing = [&](const Vec2& d) {
    double steepest = 0;
    for (const Spoke& s : group.spokes) {
      const Plane& plane = planes_[s.cell];  // (a strip's is none)
      const double rise = plane.zx * d.x() + plane.zy * d.y();
      const double closes = group.lower ? rise : -rise;
      steepest = std::fmax(steepest, closes > 0 ? closes : -closes / kSteep);
    }
    return std::sqrt(1 + steepest * steepest);
  };
  // Not farther than `lean`; half of that where it has moved before, and in all, however many
  // heights there are, not beyond twice that.
  const double lean = shift_[v] > 0 ? 0.5 * std::fmin(lean_, 2 * lean_ - shift_[v]) : lean_;
  Vec2 best = Vec2::Zero();
  double width = 0;
  const auto look = [&](const Vec2& d, double longest) {
    const double most = lean / closing(d);
    double room = std::fmin(most, longest);
    for (const Spoke& s : group.spokes) {
      const Vec2 p = way_to(s.from), side = way_to(s.to) - p;
      const double nearing = cross(d, side);  // towards the opposite side
      if (nearing > 0) room = std::fmin(room, kMostOfTheWay * cross(p, side) / nearing);
    }
    if (room > width) {
      width = room;
      best = d;
    }
    return room >= kMostOfTheWay * lean;
  };
  Vec2 p = from;
  // Less of the way where rounding does not let all of it look up.
  const auto has_room = [&] {
    while (width >= kLeastWidth * lean_) {
      p = from + width * best;
      if (all_turn_left(group, v, p)) return true;
      width *= 0.5;
    }
    return false;
  };
  bool found = false;
  if (group.open_before || group.open_after) {
    // Along its open side, so that nothing opens there.
    const Vec2 side = way_to(group.open_before ? first : last);
    look(side.normalized(), kMostOfTheWay * side.norm());
    found = has_room();
  }
  if (!found) {
    // (Beside an opening that leaves off a border no wider than `lean`.)
    const Vec2 u = way_to(first).normalized();
    const double least = std::fmax(0, angle - std::numbers::pi);
    const double span = std::fmin(angle, std::numbers::pi) - least;
    width = 0;
    for (const double part : kWays) {
      const double a = least + part * span;
      const Vec2 d(std::cos(a) * u.x() - std::sin(a) * u.y(),
                   std::sin(a) * u.x() + std::cos(a) * u.y());
      if (look(d, HUGE_VAL)) break;
    }
    found = has_room();
  }
  if (!found) return kNone;
  // In the middle of what its faces are there, of those at the height that it gets.
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const Spoke& s : group.spokes) {
    if (cells_[s.cell].face == kNone || std::fabs(s.height - group.nearest) > kLeastStep * lean_)
      continue;
    const double h = planes_[s.cell].at({p.x(), p.y(), 0});
    low = std::fmin(low, h);
    high = std::fmax(high, h);
  }
  const auto made = static_cast<std::uint32_t>(sheet_.points.size());
  sheet_.points.emplace_back(p.x(), p.y(), 0.5 * (low + high));
  shift_.push_back(shift_[v] + width * closing(best));
  sheet_.moved = std::fmax(sheet_.moved, shift_.back());
  around_.emplace_back();
  std::vector<std::uint32_t>& old = around_[v];
  for (const Spoke& s : group.spokes) {
    std::replace(cells_[s.cell].v.begin(), cells_[s.cell].v.end(), v, made);
    old.erase(std::find(old.begin(), old.end(), s.cell));
    around_[made].push_back(s.cell);
  }
  const auto add_strip = [&](std::uint32_t b, std::uint32_t c) {
    const auto number = static_cast<std::uint32_t>(cells_.size());
    cells_.push_back({{v, b, c}, kNone});
    planes_.push_back({});
    for (const std::uint32_t w : {v, b, c}) around_[w].push_back(number);
  };
  if (!group.open_before) add_strip(first, made);
  if (!group.open_after) add_strip(made, last);
  return made;
}

void LayerCells::split(std::uint32_t v, double kept) {
  order_round(v);
  find_runs(kept);
  for (const Group& group : groups_off(kept)) {
    if (const std::uint32_t made = move(v, group); made != kNone)
      split(made, sheet_.points[made].z());
  }
}

double LayerCells::angle_of(std::uint32_t v, std::span<const Spoke> spokes) const {
  double angle = 0;
  for (const Spoke& s : spokes) {
    const Vec2 p = (sheet_.points[s.from] - sheet_.points[v]).head<2>();
    const Vec2 q = (sheet_.points[s.to] - sheet_.points[v]).head<2>();
    angle += std::atan2(cross(p, q), p.dot(q));
  }
  return angle;
}

// It stays with the highest of what is round it, in the middle of that; or with what takes half a
// round beside an opening, which cannot move along its open side without passing over the wall.
void LayerCells::split_free(std::uint32_t v) {
  order_round(v);
  double& z = sheet_.points[v].z();
  find_runs(z);
  const Run* stays = nullptr;
  bool wide = false;
  for (const Run& run : runs_) {
    const bool half_round = (run.open_before || run.open_after) &&
                            angle_of(v, std::span(round_).subspan(run.first, run.count)) >= kHalf;
    if (stays == nullptr || (wide == half_round ? run.high > stays->high : half_round)) {
      stays = &run;
      wide = half_round;
    }
  }
  if (stays == nullptr) return;
  if (stays->off(z) != 0) z = 0.5 * (stays->low + stays->high);
  split(v, z);
}

// In place of a hidden face that is topmost over p what hides it: of two that are one but for the
// order of their corners, rounding makes now this one the higher, now that one. False where nothing
// that may be seen is as high.
bool LayerCells::take_shown(const Vec2& p, BaseHit& hit) const {
  std::vector<std::uint32_t> over;
  scan_.faces_over({p.x(), p.x(), p.y(), p.y()}, over);
  double highest = hit.z - kLeastWidth * lean_;
  bool found = false;
  ScannedTriangle t;
  for (const std::uint32_t f : over) {
    const auto& v = scan_.triangles()[f];
    if (parts_[f] == Part::kHidden ||
        !t.set(scan_.positions()[v[0]], scan_.positions()[v[1]], scan_.positions()[v[2]]) ||
        !t.covers(p.x(), p.y()))
      continue;
    const double z = t.height(t.along_row(p.y()), p.x());
    if (!(z > highest)) continue;
    highest = z;
    hit = {z, t.zx, t.zy, f};
    found = true;
  }
  return found;
}

// A point on the side of a cell, but for rounding, with a cell of no width between: the side's
// other cell is split there. Beyond the border there is nothing to be split.
void LayerCells::flip_slivers(const std::vector<char>& fixed) {
  std::vector<std::uint32_t> slivers;
  for (std::uint32_t c = 0; c < cells_.size(); ++c) {
    if (cells_[c].face == kNone) slivers.push_back(c);
  }
  const std::size_t most = 4 * slivers.size();  // one may make another
  for (std::size_t k = 0; k < slivers.size() && k < most; ++k) {
    const std::uint32_t c = slivers[k];
    if (cells_[c].face != kNone || cells_[c].v[0] == kNone) continue;
    std::array<std::uint32_t, 3> t = cells_[c].v;
    const auto side = [&](std::size_t i) {
      return (sheet_.points[t[(i + 1) % 3]] - sheet_.points[t[i]]).head<2>().norm();
    };
    const std::size_t longest =
        side(0) >= side(1) ? (side(0) >= side(2) ? 0 : 2) : (side(1) >= side(2) ? 1 : 2);
    std::rotate(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(longest), t.end());
    const auto [p, q, v] = t;
    std::uint32_t other = kNone, r = kNone;
    for (const std::uint32_t d : around_[q]) {
      const auto& u = cells_[d].v;
      for (std::size_t i = 0; i < 3; ++i) {
        if (u[i] != q || u[(i + 1) % 3] != p) continue;
        other = d;
        r = u[(i + 2) % 3];
      }
    }
    if (other == kNone) {
      if (p < fixed.size() && q < fixed.size() && fixed[p] != 0 && fixed[q] != 0) continue;
      for (const std::uint32_t w : t) std::erase(around_[w], c);
      cells_[c].v = {kNone, kNone, kNone};
      continue;
    }
    const auto plan = [&](std::uint32_t w) -> Vec2 { return sheet_.points[w].head<2>(); };
    if (!turns_left(plan(q), plan(v), plan(r)) || !turns_left(plan(v), plan(p), plan(r))) continue;
    cells_[c] = {{q, v, r}, cells_[other].face};
    planes_[c] = planes_[other];
    cells_[other].v = {v, p, r};
    std::erase(around_[p], c);
    std::erase(around_[q], other);
    around_[r].push_back(c);
    around_[v].push_back(other);
    for (const std::uint32_t d : {c, other}) {
      if (width_of(cells_[d].v) <= kLeastWidth * lean_) cells_[d].face = kNone;
      if (cells_[d].face == kNone) slivers.push_back(d);
    }
  }
}

void LayerCells::take(const std::vector<std::array<std::uint32_t, 3>>& cells,
                      const std::vector<char>& fixed,
                      const std::vector<std::array<Vec2, 2>>& lost) {
  given_ = sheet_.points;
  around_.resize(sheet_.points.size());
  shift_.assign(sheet_.points.size(), 0);
  for (const auto& v : cells) {
    const Vec2 p = sheet_.points[v[0]].head<2>(), q = sheet_.points[v[1]].head<2>(),
               r = sheet_.points[v[2]].head<2>(), m = (p + q + r) / 3;
    BaseHit hit;
    if (!scan_.at(m.x(), m.y(), hit)) continue;
    // What is left between lines by rounding is nothing of its own, and may be in a wall.
    const double width = width_of(v);
    if (width <= kLeastWidth * lean_) {
      hit.face = kNone;
    } else if (faces_[hit.face][0] == kNone) {  // upright but for rounding
      hit.face = kNone;
      if (width > 2 * kBesideSide * lean_) sheet_.unproven_area += plan_area(v);
    }
    if (hit.face != kNone && parts_[hit.face] == Part::kHidden && !take_shown(m, hit)) {
      sheet_.unproven_area += plan_area(v);
      continue;
    }
    if (hit.face != kNone && parts_[hit.face] == Part::kWhole) continue;
    for (const std::uint32_t w : v) around_[w].push_back(static_cast<std::uint32_t>(cells_.size()));
    cells_.push_back({v, hit.face});
    planes_.push_back({m.x(), m.y(), hit.z, hit.zx, hit.zy});
  }
  flip_slivers(fixed);
  const std::size_t given = around_.size();
  for (std::uint32_t v = 0; v < given; ++v) {
    if (around_[v].empty()) continue;
    if (v < fixed.size() && fixed[v] != 0) {
      split(v, sheet_.points[v].z());
    } else {
      split_free(v);
    }
  }
  finish(lost);
}

// The length of the line inside the cell, but for what is near its sides.
double LayerCells::passes_through(const std::array<Vec2, 2>& line, const Cell& cell) const {
  double from = 0, to = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 p = sheet_.points[cell.v[k]].head<2>();
    const Vec2 side = (sheet_.points[cell.v[(k + 1) % 3]].head<2>() - p).normalized();
    const double a = cross(side, line[0] - p) - kBesideSide * lean_;
    const double b = cross(side, line[1] - p) - kBesideSide * lean_;
    if (a <= 0 && b <= 0) return 0;
    if (a < 0) from = std::fmax(from, a / (a - b));
    if (b < 0) to = std::fmin(to, a / (a - b));
  }
  return to > from ? (to - from) * (line[1] - line[0]).norm() : 0;
}

void LayerCells::finish(const std::vector<std::array<Vec2, 2>>& lost) {
  for (std::uint32_t c = 0; c < cells_.size(); ++c) {
    const Cell& cell = cells_[c];
    if (cell.v[0] == kNone) continue;
    sheet_.triangles.push_back(cell.v);
    if (cell.face == kNone) continue;
    // Along the normal of its face.
    const Plane& plane = planes_[c];
    const double along = 1 / std::sqrt(1 + plane.zx * plane.zx + plane.zy * plane.zy);
    double off = 0;
    for (const std::uint32_t v : cell.v) {
      const Vec3& x = sheet_.points[v];
      off = std::fmax(off, std::fabs(plane.at(x) - x.z()) * along);
    }
    const bool is_one = std::none_of(
        lost.begin(), lost.end(), [&](const auto& line) { return passes_through(line, cell) > 0; });
    if (is_one && off <= lean_) {
      sheet_.moved = std::fmax(sheet_.moved, off);
    } else {
      sheet_.unproven_area += plan_area(cell.v);
    }
  }
}

}  // namespace diesink
