// SPDX-License-Identifier: Apache-2.0
#include "core/machining/cell_bounds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/machining/plan_clip.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kDeepest = 4;  // halvings of a cell

PlanBox wider(const PlanBox& b, double by) { return {b.x0 - by, b.x1 + by, b.y0 - by, b.y1 + by}; }

Vec2 corner(const PlanBox& b, std::size_t k) {
  return {(k & 1) != 0 ? b.x1 : b.x0, (k & 2) != 0 ? b.y1 : b.y0};
}

bool meet(const PlanBox& a, const PlanBox& b) {
  return a.x0 <= b.x1 && a.x1 >= b.x0 && a.y0 <= b.y1 && a.y1 >= b.y0;
}

using Corners = std::array<Vec3, 3>;

PlanBox box_over(const Corners& t) {
  const auto [x0, x1] = std::minmax({t[0].x(), t[1].x(), t[2].x()});
  const auto [y0, y1] = std::minmax({t[0].y(), t[1].y(), t[2].y()});
  return {x0, x1, y0, y1};
}

// The corners of the mesh's part over the box; false where it does not cover all of it.
bool part_over(const std::vector<Corners>& triangles, const PlanBox& box,
               std::vector<Vec3>& corners, std::vector<std::size_t>& met) {
  corners.clear();
  met.clear();
  double twice = 0;  // the plan area covered
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    PlanPolygon polygon;
    for (const Vec3& p : triangles[t]) polygon.add(p);
    polygon = cut(cut(polygon, 0, box.x0, 1), 0, box.x1, -1);
    polygon = cut(cut(polygon, 1, box.y0, 1), 1, box.y1, -1);
    if (polygon.size == 0) continue;
    corners.insert(corners.end(), polygon.p.begin(),
                   polygon.p.begin() + static_cast<std::ptrdiff_t>(polygon.size));
    met.push_back(t);
    for (std::size_t k = 2; k < polygon.size; ++k) {
      const Vec3 a = polygon.p[k - 1] - polygon.p[0], b = polygon.p[k] - polygon.p[0];
      twice += a.x() * b.y() - a.y() * b.x();
    }
  }
  constexpr double kRounding = 1e-6;  // of the area
  return twice >= 2 * (1 - kRounding) * (box.x1 - box.x0) * (box.y1 - box.y0);
}

// From a point `above` a plane of the slope `steep` to that part of it which lies at most `reach`
// away in plan.
double distance_to_plane(double above, double steep, double reach) {
  if (!(above > 0)) return 0;
  const double foot = std::min(reach, above * steep / (1 + steep * steep));
  return std::hypot(foot, above - steep * foot);
}

class Divider {
 public:
  Divider(const CutterShape& cutter, std::span<const SweepMove> moves,
          const std::vector<Corners>& triangles, double deviation, double enough)
      : cutter_(cutter),
        moves_(moves),
        triangles_(triangles),
        deviation_(deviation),
        enough_(enough) {}

  double bound(const PlanBox& box, int depth) {
    double best = of_box(box);
    if (best <= enough_ || depth == kDeepest) return best;
    const double x = box.x0 + (box.x1 - box.x0) / 2, y = box.y0 + (box.y1 - box.y0) / 2;
    double parts = 0;
    for (const PlanBox& part : {PlanBox{box.x0, x, box.y0, y}, PlanBox{x, box.x1, box.y0, y},
                                PlanBox{box.x0, x, y, box.y1}, PlanBox{x, box.x1, y, box.y1}}) {
      parts = std::max(parts, bound(part, depth + 1));
      if (!(parts < best)) return best;
    }
    return parts;
  }

 private:
  // Planes of the triangles met, each let down until all of the part around is above it.
  double of_box(const PlanBox& box) {
    constexpr std::size_t kPlanes = 8;
    double best = kInfinity;
    const double size = std::min(box.x1 - box.x0, box.y1 - box.y0);
    for (const double reach : {size, 0.0}) {
      if (!part_over(triangles_, wider(box, reach), corners_, met_)) continue;
      const std::size_t step = std::max<std::size_t>(1, met_.size() / kPlanes);
      for (std::size_t k = 0; k < met_.size(); k += step) {
        const Corners& t = triangles_[met_[k]];
        const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
        if (!(n.z() > 1e-7 * n.norm())) continue;
        const Vec2 slope(-n.x() / n.z(), -n.y() / n.z());
        double base = kInfinity;  // the plane's height at the origin of the plan
        for (const Vec3& c : corners_) base = std::min(base, c.z() - slope.dot(c.head<2>()));
        for (const SweepMove& move : moves_) {
          double most = 0;
          for (std::size_t c = 0; c < 4 && most < best; ++c) {
            const Vec2 at = corner(box, c);
            const double left = swept_height(cutter_, move, at.x(), at.y());
            most =
                std::max(most, distance_to_plane(left - base - slope.dot(at), slope.norm(), reach) +
                                   deviation_);
          }
          best = std::min(best, most);
          if (best <= enough_) return best;
        }
      }
    }
    return best;
  }

  const CutterShape& cutter_;
  std::span<const SweepMove> moves_;
  const std::vector<Corners>& triangles_;
  double deviation_, enough_;
  std::vector<Vec3> corners_;
  std::vector<std::size_t> met_;
};

}  // namespace

CellBounds::CellBounds(const CutterShape& cutter, const PlanLattice& lattice,
                       const std::vector<double>& part, std::vector<std::size_t> cells)
    : cutter_(cutter), lattice_(lattice), cells_(std::move(cells)), kept_(cells_.size()) {
  const double side = cutter.radius() / 2;
  std::map<std::array<long, 2>, std::size_t> tile_at;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    kept_[c].height.fill(kInfinity);
    const std::size_t i = cells_[c] % lattice.columns, j = cells_[c] / lattice.columns;
    const std::array<double, 4> z{part[cells_[c]], part[cells_[c] + 1],
                                  part[cells_[c] + lattice.columns],
                                  part[cells_[c] + lattice.columns + 1]};
    const auto [low, high] = std::minmax_element(z.begin(), z.end());
    spread_.push_back(*high - *low + lattice.dx + lattice.dy);
    const PlanBox box{lattice.x(i), lattice.x(i + 1), lattice.y(j), lattice.y(j + 1)};
    const auto [at, fresh] = tile_at.try_emplace(
        {std::lround((box.x0 - lattice.x0) / side), std::lround((box.y0 - lattice.y0) / side)},
        tiles_.size());
    if (fresh) {
      tiles_.push_back(box);
      cells_of_.emplace_back();
    }
    PlanBox& tile = tiles_[at->second];
    tile = {std::min(tile.x0, box.x0), std::max(tile.x1, box.x1), std::min(tile.y0, box.y0),
            std::max(tile.y1, box.y1)};
    cells_of_[at->second].push_back(static_cast<std::uint32_t>(c));
  }
  bins_.emplace(tiles_);
}

template <class BoxOf>
std::vector<std::vector<std::uint32_t>> CellBounds::over_tiles(std::size_t count,
                                                               const BoxOf& box_of) const {
  std::vector<std::vector<std::uint32_t>> over(tiles_.size());
  for (std::uint32_t k = 0; k < count; ++k) {
    bins_->over(box_of(k), [&](std::uint32_t tile) {
      if (over[tile].empty() || over[tile].back() != k) over[tile].push_back(k);
    });
  }
  return over;
}

Vec2 CellBounds::sample(std::size_t cell, std::size_t k) const {
  const std::size_t i = cells_[cell] % lattice_.columns, j = cells_[cell] / lattice_.columns;
  return {lattice_.x(i) + static_cast<double>(k % 3) * (lattice_.x(i + 1) - lattice_.x(i)) / 2,
          lattice_.y(j) + static_cast<double>(k / 3) * (lattice_.y(j + 1) - lattice_.y(j)) / 2};
}

void CellBounds::add(std::span<const SweepMove> moves, int threads) {
  constexpr std::size_t kRun = 32;  // moves one after another lie close together
  const double R = cutter_.radius();
  const auto box_of = [R](std::span<const SweepMove> some) {
    PlanBox box{kInfinity, -kInfinity, kInfinity, -kInfinity};
    for (const SweepMove& m : some) {
      box.x0 = std::min({box.x0, m.from.x(), m.to.x()});
      box.x1 = std::max({box.x1, m.from.x(), m.to.x()});
      box.y0 = std::min({box.y0, m.from.y(), m.to.y()});
      box.y1 = std::max({box.y1, m.from.y(), m.to.y()});
    }
    return wider(box, R);
  };
  const auto run = [&](std::size_t r) {
    return moves.subspan(r * kRun, std::min(kRun, moves.size() - r * kRun));
  };
  const std::vector<std::vector<std::uint32_t>> runs_over =
      over_tiles((moves.size() + kRun - 1) / kRun, [&](std::uint32_t r) { return box_of(run(r)); });
  parallel_blocks(tiles_.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t t = begin; t < end; ++t) {
      for (const std::uint32_t r : runs_over[t]) {
        for (const SweepMove& m : run(r)) {
          if (!meet(box_of({&m, 1}), tiles_[t])) continue;
          const double low = std::min(m.from.z(), m.to.z());
          for (const std::uint32_t c : cells_of_[t]) {
            Kept& kept = kept_[c];
            constexpr std::size_t kMiddle = 4;
            if (low > kept.height[kMiddle] + spread_[c]) continue;
            const Vec2 middle = sample(c, kMiddle);
            const double there = swept_height(cutter_, m, middle.x(), middle.y());
            if (!(there <= kept.height[kMiddle] + spread_[c]) || there == kInfinity) continue;
            for (std::size_t s = 0; s < kSamples; ++s) {
              const Vec2 p = sample(c, s);
              const double z = s == kMiddle ? there : swept_height(cutter_, m, p.x(), p.y());
              if (!(z < kept.height[s])) continue;
              kept.height[s] = z;
              kept.move[s] = m;
            }
          }
        }
      }
    }
  });
}

std::vector<double> CellBounds::bounds(const TriangleMesh& mesh, double deviation, double enough,
                                       int threads) const {
  std::vector<double> out(cells_.size(), kInfinity);
  const double wide = std::max(lattice_.dx, lattice_.dy);
  const auto corners_of = [&](std::uint32_t triangle) {
    const auto& ids = mesh.triangles[triangle];
    return Corners{mesh.positions[ids[0]], mesh.positions[ids[1]], mesh.positions[ids[2]]};
  };
  const std::vector<std::vector<std::uint32_t>> triangles_over = over_tiles(
      mesh.triangles.size(),
      [&](std::uint32_t triangle) { return wider(box_over(corners_of(triangle)), wide); });
  parallel_blocks(tiles_.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
    std::vector<Corners> near, mine;
    for (std::size_t t = begin; t < end; ++t) {
      near.clear();
      for (const std::uint32_t triangle : triangles_over[t]) near.push_back(corners_of(triangle));
      for (const std::uint32_t c : cells_of_[t]) {
        const Vec2 low = sample(c, 0), high = sample(c, kSamples - 1);
        const PlanBox box{low.x(), high.x(), low.y(), high.y()};
        const PlanBox around = wider(box, wide);
        mine.clear();
        for (const Corners& corners : near) {
          if (meet(box_over(corners), around)) mine.push_back(corners);
        }
        std::vector<SweepMove> moves;
        for (std::size_t s = 0; s < kSamples; ++s) {
          if (kept_[c].height[s] == kInfinity) continue;
          const SweepMove& m = kept_[c].move[s];
          const bool known = std::any_of(moves.begin(), moves.end(), [&](const SweepMove& o) {
            return o.from == m.from && o.to == m.to;
          });
          if (!known) moves.push_back(m);
        }
        out[c] = Divider(cutter_, moves, mine, deviation, enough).bound(box, 0);
      }
    }
  });
  return out;
}

}  // namespace diesink
