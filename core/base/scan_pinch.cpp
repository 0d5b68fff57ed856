// SPDX-License-Identifier: Apache-2.0
#include "core/base/scan_pinch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "core/base/exact_plan.h"
#include "core/mesh_tools/weld.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;
// Of the way to the opposite side of a triangle: how far a corner moves at most.
constexpr double kMostOfTheWay = 0.5;
// How often a way is halved before rounding is held to leave no room.
constexpr int kMostHalvings = 20;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

// A triangle at a corner: the sides there go to `from` and, anticlockwise, to `to`.
struct Spoke {
  std::uint32_t triangle, from, to;
};

// Moves the corner of triangles that follow one another round it, the first and the last with open
// sides, to a point of their own.
void move_in(ScanSheet& sheet, std::uint32_t v, const std::vector<Spoke>& wedge, double lean) {
  const Vec3 at = sheet.points[v];
  const auto way_to = [&](std::uint32_t w) -> Vec2 { return (sheet.points[w] - at).head<2>(); };
  double angle = 0, steepest = 0;
  std::vector<Vec2> slopes;
  for (const Spoke& s : wedge) {
    const Vec2 p = way_to(s.from), q = way_to(s.to);
    angle += std::atan2(cross(p, q), p.dot(q));
    const double zp = sheet.points[s.from].z() - at.z(), zq = sheet.points[s.to].z() - at.z();
    const double area = cross(p, q);
    slopes.emplace_back((zp * q.y() - zq * p.y()) / area, (zq * p.x() - zp * q.x()) / area);
    steepest = std::fmax(steepest, slopes.back().norm());
  }
  const Vec2 u = way_to(wedge.front().from).normalized();
  const Vec2 d(std::cos(0.5 * angle) * u.x() - std::sin(0.5 * angle) * u.y(),
               std::sin(0.5 * angle) * u.x() + std::cos(0.5 * angle) * u.y());
  double width = lean / std::sqrt(1 + steepest * steepest);
  for (const Spoke& s : wedge) {
    const Vec2 p = way_to(s.from), side = way_to(s.to) - p;
    const double nearing = cross(d, side);
    if (nearing > 0) width = std::fmin(width, kMostOfTheWay * cross(p, side) / nearing);
  }
  const auto turns_left = [&](const Vec2& p) {
    return std::ranges::all_of(wedge, [&](const Spoke& s) {
      const Vec3 &a = sheet.points[s.from], &b = sheet.points[s.to];
      return turn(p.x(), p.y(), a.x(), a.y(), b.x(), b.y()) > 0;
    });
  };
  for (int k = 0; k < kMostHalvings; ++k, width *= 0.5) {
    const Vec2 p = at.head<2>() + width * d;
    if (!turns_left(p)) continue;
    double low = HUGE_VAL, high = -HUGE_VAL;  // of what its faces are there
    for (const Vec2& slope : slopes) {
      low = std::fmin(low, width * slope.dot(d));
      high = std::fmax(high, width * slope.dot(d));
    }
    const auto made = static_cast<std::uint32_t>(sheet.points.size());
    sheet.points.emplace_back(p.x(), p.y(), at.z() + 0.5 * (low + high));
    sheet.moved =
        std::fmax(sheet.moved, width * std::sqrt(1 + steepest * steepest) + 0.5 * (high - low));
    for (const Spoke& s : wedge) std::ranges::replace(sheet.triangles[s.triangle], v, made);
    return;
  }
}

}  // namespace

void part_pinches(ScanSheet& sheet, double lean) {
  std::vector<Vec3> flat;
  flat.reserve(sheet.points.size());
  for (const Vec3& p : sheet.points) flat.emplace_back(p.x(), p.y(), 0);
  const WeldMap places = weld_map(flat);
  if (places.kept.size() == sheet.points.size()) return;
  std::vector<char> used(sheet.points.size(), 0);
  for (const auto& t : sheet.triangles) {
    for (const std::uint32_t v : t) used[v] = 1;
  }
  std::vector<std::uint32_t> highest(places.kept.size(), kNone), count(places.kept.size(), 0);
  for (std::uint32_t v = 0; v < sheet.points.size(); ++v) {
    if (!used[v]) continue;
    const std::uint32_t place = places.of_vertex[v];
    ++count[place];
    if (highest[place] == kNone || sheet.points[v].z() > sheet.points[highest[place]].z())
      highest[place] = v;
  }
  const auto moves = [&](std::uint32_t v) {
    const std::uint32_t place = places.of_vertex[v];
    return count[place] > 1 && highest[place] != v;
  };
  std::unordered_map<std::uint32_t, std::vector<Spoke>> around;
  std::vector<std::uint32_t> order;
  for (std::uint32_t t = 0; t < sheet.triangles.size(); ++t) {
    const auto& c = sheet.triangles[t];
    for (std::size_t k = 0; k < 3; ++k) {
      if (!moves(c[k])) continue;
      std::vector<Spoke>& spokes = around[c[k]];
      if (spokes.empty()) order.push_back(c[k]);
      spokes.push_back({t, c[(k + 1) % 3], c[(k + 2) % 3]});
    }
  }
  for (const std::uint32_t v : order) {
    const std::vector<Spoke>& spokes = around[v];
    for (const Spoke& first : spokes) {
      if (std::ranges::any_of(spokes, [&](const Spoke& s) { return s.to == first.from; })) continue;
      std::vector<Spoke> wedge{first};
      for (bool more = true; more && wedge.size() <= spokes.size();) {
        const auto next = std::ranges::find(spokes, wedge.back().to, &Spoke::from);
        more = next != spokes.end();
        if (more) wedge.push_back(*next);
      }
      if (wedge.size() <= spokes.size()) move_in(sheet, v, wedge, lean);
    }
  }
}

}  // namespace diesink
