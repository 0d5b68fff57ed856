// SPDX-License-Identifier: Apache-2.0
#include "core/base/scanned_border.h"

#include <algorithm>
#include <cmath>

#include "core/interval.h"
#include "core/mesh_tools/topology.h"
#include "core/parallel.h"

namespace diesink {
namespace {

// Edges that lie on one another in plan, one with its triangles on either side, are border of
// neither: the top and foot of an upright wall, or of sheets that touch without sharing vertices.
void drop_pairs(const std::vector<Vec3>& positions,
                std::vector<ScannedSurface::BorderEdge>& edges) {
  struct Key {
    double ax, ay, bx, by;  // the lesser end first
    bool turned;
    std::uint32_t edge;
  };
  std::vector<Key> keys;
  keys.reserve(edges.size());
  for (std::uint32_t k = 0; k < edges.size(); ++k) {
    const Vec3 &a = positions[edges[k][0]], &b = positions[edges[k][1]];
    const bool turned = b.x() < a.x() || (b.x() == a.x() && b.y() < a.y());
    const Vec3 &low = turned ? b : a, &high = turned ? a : b;
    keys.push_back({low.x(), low.y(), high.x(), high.y(), turned, k});
  }
  const auto place = [](const Key& k) { return std::array{k.ax, k.ay, k.bx, k.by}; };
  std::sort(keys.begin(), keys.end(), [&](const Key& p, const Key& q) {
    const std::array a = place(p), b = place(q);
    return a != b ? a < b : p.edge < q.edge;
  });
  std::vector<ScannedSurface::BorderEdge> kept;
  for (std::size_t first = 0; first < keys.size();) {
    std::size_t last = first;
    bool sides[2] = {false, false};
    for (; last < keys.size() && place(keys[last]) == place(keys[first]); ++last) {
      sides[keys[last].turned ? 1 : 0] = true;
    }
    if (!(sides[0] && sides[1])) kept.push_back(edges[keys[first].edge]);
    first = last;
  }
  edges = std::move(kept);
}

}  // namespace

std::vector<ScannedSurface::BorderEdge> plan_border(
    const std::vector<Vec3>& positions,
    const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<ScannedSurface::BorderEdge> edges;
  const std::vector<EdgeUse> uses = edge_uses(triangles, positions.size());
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    bool left = false, right = false;
    for (const EdgeUse& use : edge) {
      const std::array<std::uint32_t, 3>& t = triangles[use.corner / 3];
      const Vec3 &a = positions[t[0]], &b = positions[t[1]], &c = positions[t[2]];
      const int sign = turn(a.x(), a.y(), b.x(), b.y(), c.x(), c.y());
      if (sign == 0) continue;
      ((sign > 0) == use.forward ? left : right) = true;
    }
    if (left == right) return;
    edges.push_back(left ? ScannedSurface::BorderEdge{edge[0].low, edge[0].high}
                         : ScannedSurface::BorderEdge{edge[0].high, edge[0].low});
  });
  drop_pairs(positions, edges);
  return edges;
}

const ScannedSurface::Border& ScannedSurface::border() const {
  Border& border = *border_;
  std::call_once(border.once, [&] {
    border.edges = plan_border(positions_, triangles_);
    const Cells& cells = plan().cells;
    // The cells of each edge's box, by counting.
    const auto each_cell = [&](const auto& see) {
      for (std::uint32_t k = 0; k < border.edges.size(); ++k) {
        const Vec3 &a = positions_[border.edges[k][0]], &b = positions_[border.edges[k][1]];
        const int last_line = cells.line(std::max(a.y(), b.y()));
        const int last_column = cells.column(std::max(a.x(), b.x()));
        for (int j = cells.line(std::min(a.y(), b.y())); j <= last_line; ++j) {
          for (int i = cells.column(std::min(a.x(), b.x())); i <= last_column; ++i) {
            see(static_cast<std::size_t>(j) * static_cast<std::size_t>(cells.nx) +
                    static_cast<std::size_t>(i),
                k);
          }
        }
      }
    };
    border.start.assign(plan().start.size() + 1, 0);
    each_cell([&](std::size_t cell, std::uint32_t) { ++border.start[cell + 2]; });
    for (std::size_t c = 2; c < border.start.size(); ++c) border.start[c] += border.start[c - 1];
    border.items.resize(border.start.back());
    each_cell([&](std::size_t cell, std::uint32_t edge) {
      border.items[border.start[cell + 1]++] = edge;
    });
  });
  return border;
}

const std::vector<ScannedSurface::BorderEdge>& ScannedSurface::border_edges() const {
  return border().edges;
}

void ScannedSurface::border_over(const PlanBox& box, std::size_t most,
                                 std::vector<std::uint32_t>& edges) const {
  edges.clear();
  const Border& border = this->border();
  if (border.edges.empty()) return;
  const Cells& cells = plan().cells;
  const int first_line = cells.line(box.y0), last_line = cells.line(box.y1);
  const int first_column = cells.column(box.x0), last_column = cells.column(box.x1);
  for (int j = first_line; j <= last_line; ++j) {
    for (int i = first_column; i <= last_column; ++i) {
      const std::size_t cell = static_cast<std::size_t>(j) * static_cast<std::size_t>(cells.nx) +
                               static_cast<std::size_t>(i);
      for (std::uint32_t k = border.start[cell]; k < border.start[cell + 1]; ++k) {
        const BorderEdge& edge = border.edges[border.items[k]];
        const Vec3 &a = positions_[edge[0]], &b = positions_[edge[1]];
        const double low_x = std::min(a.x(), b.x()), low_y = std::min(a.y(), b.y());
        if (std::max(a.x(), b.x()) < box.x0 || low_x > box.x1 || std::max(a.y(), b.y()) < box.y0 ||
            low_y > box.y1) {
          continue;
        }
        // Once is enough: in the first cell of those asked for that holds it.
        if (std::max(cells.column(low_x), first_column) != i ||
            std::max(cells.line(low_y), first_line) != j) {
          continue;
        }
        // Apart where all four corners are on one side of the edge's line.
        const int s00 = turn(a.x(), a.y(), b.x(), b.y(), box.x0, box.y0);
        if (s00 != 0 && turn(a.x(), a.y(), b.x(), b.y(), box.x1, box.y0) == s00 &&
            turn(a.x(), a.y(), b.x(), b.y(), box.x0, box.y1) == s00 &&
            turn(a.x(), a.y(), b.x(), b.y(), box.x1, box.y1) == s00) {
          continue;
        }
        edges.push_back(border.items[k]);
        if (edges.size() >= most) return;
      }
    }
  }
}

// Calls see(triangle, its box) for every triangle that reaches into the box.
template <class See>
void ScannedSurface::each_triangle_over(const PlanBox& box, const See& see) const {
  const PlanGrid& plan = this->plan();
  const Cells& cells = plan.cells;
  const int first_line = cells.line(box.y0), last_line = cells.line(box.y1);
  const int first_column = cells.column(box.x0), last_column = cells.column(box.x1);
  ScannedTriangle t;
  for (int j = first_line; j <= last_line; ++j) {
    for (int i = first_column; i <= last_column; ++i) {
      for (const std::uint32_t face : plan.in_cell(i, j)) {
        const PlanBox b = box_of(face);
        if (b.x1 < box.x0 || b.x0 > box.x1 || b.y1 < box.y0 || b.y0 > box.y1) continue;
        // Once is enough: in the first cell of those asked for that holds it.
        if (std::max(cells.column(b.x0), first_column) != i ||
            std::max(cells.line(b.y0), first_line) != j) {
          continue;
        }
        if (!triangle(face, t)) continue;
        // Apart along one of the triangle's edges.
        bool apart = false;
        for (std::size_t k = 0; k < 3 && !apart; ++k) {
          const std::size_t next = k == 2 ? 0 : k + 1;
          const double ex = t.x[next] - t.x[k], ey = t.y[next] - t.y[k];
          // The corner furthest to the left of the edge.
          apart = turn(t.x[k], t.y[k], t.x[next], t.y[next], ey > 0 ? box.x0 : box.x1,
                       ex > 0 ? box.y1 : box.y0) < 0;
        }
        if (!apart) see(t, b);
      }
    }
  }
}

void ScannedSurface::faces_over(const PlanBox& box, std::vector<std::uint32_t>& faces) const {
  faces.clear();
  const PlanGrid& plan = this->plan();
  const Cells& cells = plan.cells;
  const int last_line = cells.line(box.y1), last_column = cells.column(box.x1);
  ScannedTriangle t;
  for (int j = cells.line(box.y0); j <= last_line; ++j) {
    for (int i = cells.column(box.x0); i <= last_column; ++i) {
      for (const std::uint32_t face : plan.in_cell(i, j)) {
        const PlanBox b = box_of(face);
        if (b.x1 < box.x0 || b.x0 > box.x1 || b.y1 < box.y0 || b.y0 > box.y1) continue;
        if (triangle(face, t)) faces.push_back(face);
      }
    }
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
}

ScannedSurface::Layers ScannedSurface::layers(int threads) const {
  // True where some side of s has all of t on its right or on its line.
  const auto parted = [](const ScannedTriangle& s, const ScannedTriangle& t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = k == 2 ? 0 : k + 1;
      bool apart = true;
      for (std::size_t i = 0; i < 3 && apart; ++i)
        apart = turn(s.x[k], s.y[k], s.x[next], s.y[next], t.x[i], t.y[i]) <= 0;
      if (apart) return true;
    }
    return false;
  };
  // Heights that differ by less are one.
  const double same = 1e-10 * std::max({plan_box_.x1 - plan_box_.x0, plan_box_.y1 - plan_box_.y0,
                                        z_high_ - z_low_});
  struct Here {
    ScannedTriangle t;
    std::uint32_t face;
    char marks;
  };
  const PlanGrid& plan = this->plan();
  const Cells& cells = plan.cells;
  // Lines of cells mark triangles of their own in lists: a triangle may stand in several.
  const auto lines = static_cast<std::size_t>(cells.ny);
  std::vector<std::vector<std::pair<std::uint32_t, char>>> found(lines);
  std::vector<std::vector<std::array<Vec3, 2>>> meets(lines);
  // Which of two that overlap is the upper one: the corners of what they have in common tell.
  const auto compare = [&](Here& s, Here& t, std::vector<std::array<Vec3, 2>>* through) {
    std::vector<Vec2> polygon, cut;
    for (std::size_t k = 0; k < 3; ++k) polygon.emplace_back(s.t.x[k], s.t.y[k]);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 a(t.t.x[k], t.t.y[k]), d = Vec2(t.t.x[(k + 1) % 3], t.t.y[(k + 1) % 3]) - a;
      const auto left = [&](const Vec2& p) {
        return d.x() * (p.y() - a.y()) - d.y() * (p.x() - a.x());
      };
      cut.clear();
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const double lp = left(p), lq = left(q);
        if (lp >= 0) cut.push_back(p);
        if ((lp > 0 && lq < 0) || (lp < 0 && lq > 0)) cut.push_back(p + lp / (lp - lq) * (q - p));
      }
      polygon.swap(cut);
    }
    std::vector<double> above;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Vec2& p : polygon) {
      above.push_back(s.t.height(s.t.along_row(p.y()), p.x()) -
                      t.t.height(t.t.along_row(p.y()), p.x()));
      low = std::min(low, above.back());
      high = std::max(high, above.back());
    }
    if (!(high >= low)) return;
    const bool crosses = high > same && low < -same;
    if (high > same || (high >= -same && low >= -same && s.face < t.face)) {
      s.marks |= Layers::kOver;
      t.marks |= Layers::kUnder;
    } else {
      s.marks |= Layers::kUnder;
      t.marks |= Layers::kOver;
    }
    if (!crosses) return;
    for (Here* h : {&s, &t}) h->marks |= Layers::kOver | Layers::kUnder | Layers::kCrosses;
    if (through == nullptr) return;
    std::vector<Vec3> ends;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const std::size_t j = (i + 1) % polygon.size();
      if ((above[i] > 0) == (above[j] > 0)) continue;
      const Vec2 p = polygon[i] + above[i] / (above[i] - above[j]) * (polygon[j] - polygon[i]);
      ends.emplace_back(p.x(), p.y(), s.t.height(s.t.along_row(p.y()), p.x()));
    }
    if (ends.size() == 2) through->push_back({ends[0], ends[1]});
  };
  parallel_blocks(lines, 1, threads, [&](std::size_t begin, std::size_t end, int) {
    std::vector<Here> here;
    for (std::size_t j = begin; j < end; ++j) {
      for (int i = 0; i < cells.nx; ++i) {
        here.clear();
        for (const std::uint32_t f : plan.in_cell(i, static_cast<int>(j))) {
          Here h;
          if (!triangle(f, h.t)) continue;
          h.face = f;
          h.marks = 0;
          here.push_back(h);
        }
        // From left to right: those that begin beyond a triangle's end are apart from it.
        std::sort(here.begin(), here.end(), [](const Here& s, const Here& t) {
          return s.t.x_low() != t.t.x_low() ? s.t.x_low() < t.t.x_low() : s.face < t.face;
        });
        for (std::size_t a = 0; a < here.size(); ++a) {
          const double right = here[a].t.x_high();
          for (std::size_t b = a + 1; b < here.size() && here[b].t.x_low() < right; ++b) {
            const ScannedTriangle &s = here[a].t, &t = here[b].t;
            if (s.y_high() <= t.y_low() || t.y_high() <= s.y_low() || parted(s, t) || parted(t, s))
              continue;
            // Once is enough: in the first cell that holds both.
            if (cells.column(std::max(s.x_low(), t.x_low())) != i ||
                cells.line(std::max(s.y_low(), t.y_low())) != static_cast<int>(j))
              continue;
            compare(here[a], here[b], &meets[j]);
          }
        }
        for (const Here& h : here) {
          if (h.marks != 0) found[j].emplace_back(h.face, h.marks);
        }
      }
    }
  });
  Layers layers;
  layers.marks.assign(triangles_.size(), 0);
  for (const auto& line : found) {
    for (const auto& [f, marks] : line) layers.marks[f] |= marks;
  }
  for (const auto& line : meets) layers.meets.insert(layers.meets.end(), line.begin(), line.end());
  return layers;
}

BaseBounds ScannedSurface::bounds(const PlanBox& box, Band& band) const {
  BaseBounds out;
  out.coverage = Coverage::kOutside;
  if (box.x1 < plan_box_.x0 || box.x0 > plan_box_.x1 || box.y1 < plan_box_.y0 ||
      box.y0 > plan_box_.y1) {
    return out;
  }
  Range z{HUGE_VAL, -HUGE_VAL}, zx = z, zy = z, rest = z;
  const auto take = [](Range& range, const Range& more) {
    range = {std::min(range.lo, more.lo), std::max(range.hi, more.hi)};
  };
  each_triangle_over(box, [&](const ScannedTriangle& t, const PlanBox& b) {
    // The plane over the box's part inside the triangle's own, cut to the triangle's heights.
    const Range dx = widened(std::max(box.x0, b.x0) - t.x[0], std::min(box.x1, b.x1) - t.x[0]);
    const Range dy = widened(std::max(box.y0, b.y0) - t.y[0], std::min(box.y1, b.y1) - t.y[0]);
    const Range plane = point_range(t.z0) + t.zx * dx + t.zy * dy;
    take(z, {std::max(plane.lo, t.z_low), std::min(plane.hi, t.z_high)});
    take(zx, point_range(t.zx));
    take(zy, point_range(t.zy));
  });
  if (is_empty(z)) return out;
  out.z = z;
  out.zx = zx;
  out.zy = zy;
  band.gx = 0.5 * (zx.lo + zx.hi);
  band.gy = 0.5 * (zy.lo + zy.hi);
  band.c = 0.5 * (z.lo + z.hi);
  const double cx = 0.5 * (box.x0 + box.x1), cy = 0.5 * (box.y0 + box.y1);
  each_triangle_over(box, [&](const ScannedTriangle& t, const PlanBox& b) {
    // Its plane less the band's, over the same part.
    const Range dx = widened(std::max(box.x0, b.x0) - t.x[0], std::min(box.x1, b.x1) - t.x[0]);
    const Range dy = widened(std::max(box.y0, b.y0) - t.y[0], std::min(box.y1, b.y1) - t.y[0]);
    const Range own = point_range(t.z0) - point_range(band.c);
    const Range there = band.gx * (point_range(t.x[0]) - point_range(cx)) +
                        band.gy * (point_range(t.y[0]) - point_range(cy));
    take(rest, own - there + (point_range(t.zx) - point_range(band.gx)) * dx +
                   (point_range(t.zy) - point_range(band.gy)) * dy);
  });
  band.rest = rest;
  std::vector<std::uint32_t> met;
  border_over(box, 1, met);
  // Without an end of the plan in the box all of it is inside, for a triangle reaches into it.
  out.coverage = met.empty() ? Coverage::kInside : Coverage::kPartly;
  return out;
}

}  // namespace diesink
