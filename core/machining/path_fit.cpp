// The longest move from a point on is found by narrowing a window of slopes, one corner after
// another (the cone method of Williams, 1978, and of Sklansky and Gonzalez, 1980), here with one
// window side for overcut and one for undercut.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/path_fit.h"

#include <cmath>
#include <limits>

namespace diesink {
namespace {

constexpr double kCornerTangent = 0.17632698070846498;  // of ten degrees

// Angle between two directions with x >= 0 beyond ten degrees.
bool turns(const Vec2& a, const Vec2& b) {
  const double cross = a.x() * b.y() - a.y() * b.x(), dot = a.dot(b);
  return dot <= 0 || std::fabs(cross) > kCornerTangent * dot;
}

void fit(const std::vector<Vec2>& p, double below, double above, PassRun& out) {
  const std::size_t n = p.size();
  out.push_back(p[0]);
  std::size_t i = 0;
  while (i + 1 < n) {
    // From p[i] on; always at least to the next corner.
    std::size_t best = i + 1;
    if (p[i + 1].x() > p[i].x()) {
      double low = -std::numeric_limits<double>::infinity();
      double high = std::numeric_limits<double>::infinity();
      for (std::size_t j = i + 1; j < n; ++j) {
        const double dx = p[j].x() - p[i].x();
        const double dz = p[j].y() - p[i].y();
        const double slope = dz / dx;
        if (slope >= low && slope <= high) best = j;
        low = std::fmax(low, (dz - below) / dx);
        high = std::fmin(high, (dz + above) / dx);
        if (low > high || j + 1 == n) break;
        // Steps and sharp corners end the move.
        if (p[j + 1].x() <= p[j].x() || turns(p[j] - p[j - 1], p[j + 1] - p[j])) break;
      }
    }
    out.push_back(p[best]);
    i = best;
  }
}

}  // namespace

std::vector<PassRun> fit_runs(std::span<const ProfileSegment> profile, double below, double above,
                              double join) {
  std::vector<PassRun> runs;
  std::vector<Vec2> corners;
  const auto close = [&] {
    if (corners.size() > 1) {
      runs.emplace_back();
      fit(corners, below, above, runs.back());
    }
    corners.clear();
  };
  // Corners closer together than this are one: rounding of the crossings.
  const double tiny = join * 1e-3;
  const auto add = [&](double x, double z) {
    if (!corners.empty()) {
      Vec2& last = corners.back();
      if (x - last.x() <= tiny && std::fabs(z - last.y()) <= tiny) {
        // Keep the higher height; a run begins and ends where the profile does.
        last.y() = std::fmax(last.y(), z);
        return;
      }
    }
    corners.emplace_back(x, z);
  };
  for (const ProfileSegment& s : profile) {
    // Between neighbours that meet to rounding only, what lies below shines through: no slit is
    // cut, nor any that no cutter could tell.
    if (!corners.empty() && s.x1 - s.x0 <= join && s.x0 - corners.back().x() <= join &&
        std::fmax(s.z0, s.z1) < corners.back().y()) {
      continue;
    }
    if (!corners.empty() && s.x0 - corners.back().x() > join) close();
    double x0 = s.x0;
    if (!corners.empty()) x0 = std::fmax(corners.back().x(), x0 - join);
    if (!corners.empty() && s.x0 - corners.back().x() <= join) x0 = corners.back().x();
    add(x0, s.z0);
    add(std::fmax(x0, s.x1), s.z1);
  }
  close();
  return runs;
}

}  // namespace diesink
