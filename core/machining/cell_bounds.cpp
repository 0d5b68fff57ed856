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

// From a point to all that is on a triangle and straight below it: where the triangle ends at a
// wall, sideways.
class Column {
 public:
  explicit Column(const Corners& t) : t_(t), n_((t[1] - t[0]).cross(t[2] - t[0])) {}

  [[nodiscard]] double distance(const Vec3& p) const {
    double best2 = kInfinity;
    bool inside = n_.z() > 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = t_[k], &b = t_[(k + 1) % 3];
      const Vec3 e = b - a, o = p - a;
      inside = inside && e.x() * o.y() - e.y() * o.x() >= 0;
      const double s = along(o, e, e.squaredNorm());
      best2 = std::min(best2, (o - s * e).squaredNorm());
      const double flat = along({o.x(), o.y(), 0}, {e.x(), e.y(), 0}, e.head<2>().squaredNorm());
      const Vec3 beside = o - flat * e;
      if (beside.z() <= 0) best2 = std::min(best2, beside.head<2>().squaredNorm());
    }
    const double size2 = n_.squaredNorm();
    if (inside) {
      const double above = n_.dot(p - t_[0]);
      if (above <= 0) return 0;
      best2 = std::min(best2, (p.z() - height(p)) * (p.z() - height(p)));
    }
    if (size2 > 0 && foot_inside(p)) {
      const double off = n_.dot(p - t_[0]);
      best2 = std::min(best2, off * off / size2);
    }
    return std::sqrt(best2);
  }

 private:
  static double along(const Vec3& o, const Vec3& e, double length2) {
    return length2 > 0 ? std::clamp(o.dot(e) / length2, 0.0, 1.0) : 0;
  }
  [[nodiscard]] double height(const Vec3& p) const {
    return t_[0].z() - (n_.head<2>().dot((p - t_[0]).head<2>())) / n_.z();
  }
  // Whether the point of the triangle's plane that is nearest is one of the triangle's.
  [[nodiscard]] bool foot_inside(const Vec3& p) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 e = t_[(k + 1) % 3] - t_[k];
      if (n_.cross(e).dot(p - t_[k]) < 0) return false;
    }
    return true;
  }

  Corners t_;
  Vec3 n_;
};

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
  using Tops = std::array<Vec3, 4>;  // what a move leaves at a box's corners

  // The least over the moves of what `distance` tells of the worst of their corners.
  template <class Distance>
  double least_over_moves(double best, const Distance& distance) const {
    for (const Tops& tops : tops_) {
      double most = deviation_;
      for (std::size_t c = 0; c < 4 && most < best; ++c) {
        most = std::max(most, distance(tops[c]) + deviation_);
      }
      best = std::min(best, most);
      if (best <= enough_) break;
    }
    return best;
  }

  double of_box(const PlanBox& box) {
    tops_.clear();
    for (const SweepMove& move : moves_) {
      Tops tops;
      bool over = true;
      for (std::size_t c = 0; c < 4 && over; ++c) {
        const Vec2 at = corner(box, c);
        tops[c] = {at.x(), at.y(), swept_height(cutter_, move, at.x(), at.y())};
        over = tops[c].z() < kInfinity;
      }
      if (over) tops_.push_back(tops);
    }
    double best = kInfinity;
    if (tops_.empty()) return best;
    best = by_planes(box, best);
    // What ends at a wall beside the box, or in it.
    for (const Corners& t : triangles_) {
      if (best <= enough_) break;
      if (!meet(box_over(t), wider(box, best))) continue;
      const Column column(t);
      best = least_over_moves(best, [&](const Vec3& top) { return column.distance(top); });
    }
    return best;
  }

  // Planes of the triangles met, each let down until all of the part around is above it.
  double by_planes(const PlanBox& box, double best) {
    constexpr std::size_t kPlanes = 8;
    const double size = std::min(box.x1 - box.x0, box.y1 - box.y0);
    for (const double reach : {size, 0.0}) {
      if (!part_over(triangles_, wider(box, reach), corners_, met_)) continue;
      const std::size_t step = std::max<std::size_t>(1, met_.size() / kPlanes);
      for (std::size_t k = 0; k < met_.size(); k += step) {
        const Corners& t = triangles_[met_[k]];
        const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
        if (!(n.z() > 1e-7 * n.norm())) continue;
        const Vec2 slope(-n.x() / n.z(), -n.y() / n.z());
        const double steep = slope.norm();
        double base = kInfinity;  // the plane's height at the origin of the plan
        for (const Vec3& c : corners_) base = std::min(base, c.z() - slope.dot(c.head<2>()));
        best = least_over_moves(best, [&](const Vec3& top) {
          return distance_to_plane(top.z() - base - slope.dot(top.head<2>()), steep, reach);
        });
        if (best <= enough_) return best;
      }
    }
    return best;
  }

  const CutterShape& cutter_;
  std::span<const SweepMove> moves_;
  const std::vector<Corners>& triangles_;
  double deviation_, enough_;
  std::vector<Tops> tops_;
  std::vector<Vec3> corners_;
  std::vector<std::size_t> met_;
};

}  // namespace

CellBounds::CellBounds(const CutterShape& cutter, const PlanLattice& lattice,
                       std::vector<std::size_t> cells, int halvings)
    : cutter_(cutter),
      lattice_(lattice),
      cells_(std::move(cells)),
      side_(std::size_t{1} << halvings),
      each_((side_ + 1) * (side_ + 1) + side_ * side_),
      kept_(cells_.size() * each_),
      highest_(cells_.size(), kInfinity) {
  const double side = cutter.radius() / 2;
  std::map<std::array<long, 2>, std::size_t> tile_at;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const std::size_t i = cells_[c] % lattice.columns, j = cells_[c] / lattice.columns;
    const PlanBox box{lattice.x(i), lattice.x(i + 1), lattice.y(j), lattice.y(j + 1)};
    boxes_.push_back(box);
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

Vec2 CellBounds::point(std::size_t cell, std::size_t i, std::size_t j) const {
  const std::size_t ci = cells_[cell] % lattice_.columns, cj = cells_[cell] / lattice_.columns;
  const auto between = [&](std::size_t k, double low, double high) {
    return k == side_ ? high
                      : low + static_cast<double>(k) * (high - low) / static_cast<double>(side_);
  };
  return {between(i, lattice_.x(ci), lattice_.x(ci + 1)),
          between(j, lattice_.y(cj), lattice_.y(cj + 1))};
}

void CellBounds::keep(std::size_t cell, const SweepMove& move, std::vector<double>& z) {
  const std::size_t points = side_ + 1;
  Kept* const kept = kept_.data() + cell * each_;
  bool better = false;
  const auto offer = [&](Kept& best, double height) {
    if (!(height < best.height)) return;
    best = {move, height};
    better = true;
  };
  z.resize(points * points);
  for (std::size_t j = 0; j < points; ++j) {
    for (std::size_t i = 0; i < points; ++i) {
      const Vec2 p = point(cell, i, j);
      z[j * points + i] = swept_height(cutter_, move, p.x(), p.y());
      offer(kept[j * points + i], z[j * points + i]);
    }
  }
  for (std::size_t j = 0; j < side_; ++j) {
    for (std::size_t i = 0; i < side_; ++i) {
      const double* const at = z.data() + j * points + i;
      offer(kept[points * points + j * side_ + i],
            std::max({at[0], at[1], at[points], at[points + 1]}));
    }
  }
  if (!better) return;
  highest_[cell] = std::max_element(kept, kept + each_, [](const Kept& p, const Kept& q) {
                     return p.height < q.height;
                   })->height;
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
    std::vector<double> z;
    for (std::size_t t = begin; t < end; ++t) {
      for (const std::uint32_t r : runs_over[t]) {
        for (const SweepMove& m : run(r)) {
          const PlanBox reach = box_of({&m, 1});  // wider than the move by the radius
          if (!meet(reach, tiles_[t])) continue;
          const double low = std::min(m.from.z(), m.to.z());
          for (const std::uint32_t c : cells_of_[t]) {
            const PlanBox& cell = boxes_[c];
            const double x = std::max(reach.x0 - cell.x1, cell.x0 - reach.x1) + R;
            const double y = std::max(reach.y0 - cell.y1, cell.y0 - reach.y1) + R;
            const double gap = std::hypot(std::max(0.0, x), std::max(0.0, y));
            if (gap <= R && low + cutter_.height(gap) < highest_[c]) keep(c, m, z);
          }
        }
      }
    }
  });
}

std::vector<double> CellBounds::bounds(const TriangleMesh& mesh, double deviation,
                                       std::span<const double> enough, int threads) const {
  std::vector<double> out(cells_.size(), kInfinity);
  // The part so near counts: for a plane that is let down, and for what is nearer sideways.
  const double most = cells_.empty() ? 0 : *std::max_element(enough.begin(), enough.end());
  const double wide = std::max({lattice_.dx, lattice_.dy, std::min(most, cutter_.radius() / 4)});
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
        const Vec2 low = point(c, 0, 0), high = point(c, side_, side_);
        const PlanBox box{low.x(), high.x(), low.y(), high.y()};
        const PlanBox around = wider(box, wide);
        mine.clear();
        for (const Corners& corners : near) {
          if (meet(box_over(corners), around)) mine.push_back(corners);
        }
        std::vector<SweepMove> moves;
        for (const Kept& kept : std::span(kept_).subspan(c * each_, each_)) {
          if (kept.height == kInfinity) continue;
          const SweepMove& m = kept.move;
          const bool known = std::any_of(moves.begin(), moves.end(), [&](const SweepMove& o) {
            return o.from == m.from && o.to == m.to;
          });
          if (!known) moves.push_back(m);
        }
        out[c] = Divider(cutter_, moves, mine, deviation, enough[c]).bound(box, 0);
      }
    }
  });
  return out;
}

}  // namespace diesink
