// Lines that may be seen are cut where they pass over one another, the pieces that are seen are
// triangulated, and each triangle is a piece of what is seen at its middle (layer_cells.h).
// SPDX-License-Identifier: Apache-2.0
#include "core/base/scan_layers.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <unordered_map>

#include "core/base/layer_joiner.h"
#include "core/mesh_tools/weld.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNone = ScanSheet::kNone;
constexpr int kMostAttempts = 64;
// As often whole faces are cut, too, after all; then what lies on their sides gives way.
constexpr int kMostRounds = 6;

// Of the ends of two lines the one that is nearest to the other line.
struct NearestEnd {
  std::uint32_t site = kNone;
  double away = HUGE_VAL;
};

NearestEnd nearest_end(const std::vector<Vec2>& sites, const PlanarTriangulation::Segment& one,
                       const PlanarTriangulation::Segment& two) {
  NearestEnd nearest;
  for (const auto& [ends, line] : {std::pair{one, two}, std::pair{two, one}}) {
    const Vec2& from = sites[line[0]];
    const Vec2 along = sites[line[1]] - from;
    for (const std::uint32_t end : ends) {
      if (end == line[0] || end == line[1]) continue;
      const Vec2 q = sites[end] - from;
      const double part = std::clamp(along.dot(q) / along.squaredNorm(), 0.0, 1.0);
      const double away = (q - part * along).norm();
      if (away < nearest.away) nearest = {end, away};
    }
  }
  return nearest;
}

}  // namespace

void LayerJoiner::take_whole() {
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (part_[f] == Part::kWhole) sheet_.triangles.push_back(faces_[f]);
  }
}

// Faces that have been whole, by their sides.
void LayerJoiner::cut_faces(const std::vector<std::uint64_t>& sides) {
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    for (std::size_t k = 0; k < 3 && part_[f] == Part::kWhole; ++k) {
      if (std::binary_search(sides.begin(), sides.end(), key(faces_[f][k], faces_[f][(k + 1) % 3])))
        part_[f] = Part::kJoined;
    }
  }
}

// False, and those faces no longer whole, where lines lie on the sides of faces that are and such
// faces may be cut.
bool LayerJoiner::triangulate(bool may_cut_faces) {
  // Points at one place are one: a whole face's, else the topmost. A frame round all keeps what is
  // open out.
  std::vector<std::uint32_t> used;
  for (const auto& s : pieces_) used.insert(used.end(), s.begin(), s.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::vector<char> fixed(sheet_.points.size(), 0);
  for (const Line& line : lines_) {
    if (line.fixed) fixed[line.a] = fixed[line.b] = 1;
  }
  std::sort(used.begin(), used.end(), [&](std::uint32_t i, std::uint32_t j) {
    if (fixed[i] != fixed[j]) return fixed[i] > fixed[j];
    const double zi = sheet_.points[i].z(), zj = sheet_.points[j].z();
    return zi != zj ? zi > zj : i < j;
  });
  std::vector<Vec3> flat;
  flat.reserve(used.size());
  for (const std::uint32_t v : used) flat.emplace_back(plan(v).x(), plan(v).y(), 0);
  const WeldMap weld = weld_map(flat, snap_);
  std::vector<Vec2> sites;
  std::vector<std::uint32_t> vertex;
  for (const std::uint32_t k : weld.kept) {
    sites.push_back(plan(used[k]));
    vertex.push_back(used[k]);
  }
  std::unordered_map<std::uint32_t, std::uint32_t> site;
  for (std::size_t k = 0; k < used.size(); ++k) site[used[k]] = weld.of_vertex[k];
  PlanBox box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
  for (const Vec2& p : sites) {
    box = {std::fmin(box.x0, p.x()), std::fmax(box.x1, p.x()), std::fmin(box.y0, p.y()),
           std::fmax(box.y1, p.y())};
  }
  const double margin = 0.1 * (box.x1 - box.x0 + box.y1 - box.y0) + 64 * lean_;
  const auto frame = static_cast<std::uint32_t>(sites.size());
  for (const auto& [x, y] : {std::pair{box.x0 - margin, box.y0 - margin},
                             {box.x1 + margin, box.y0 - margin},
                             {box.x1 + margin, box.y1 + margin},
                             {box.x0 - margin, box.y1 + margin}}) {
    sites.emplace_back(x, y);
    vertex.push_back(kNone);
  }
  std::vector<PlanarTriangulation::Segment> segments;
  for (std::uint32_t k = 0; k < 4; ++k) segments.push_back({frame + k, frame + (k + 1) % 4});
  std::unordered_map<std::uint64_t, char> known;      // directed
  std::vector<std::uint64_t> sides(segments.size());  // of whole faces
  std::size_t fixed_segments = segments.size();
  for (std::size_t s = 0; s < pieces_.size(); ++s) {
    const std::uint32_t a = site[pieces_[s][0]], b = site[pieces_[s][1]];
    if (a == b || !known.try_emplace(pair_key(a, b), 0).second) continue;
    segments.push_back({a, b});
    if (s >= fixed_pieces_) continue;
    sides.push_back(key(pieces_[s][0], pieces_[s][1]));
    fixed_segments = segments.size();
  }
  std::vector<std::array<Vec2, 2>> lost;  // lines that gave way
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    // Only what lines still use.
    std::vector<std::uint32_t> number(sites.size(), kNone), of;
    std::vector<Vec2> points;
    std::vector<PlanarTriangulation::Segment> numbered;
    for (const auto& s : segments) {
      for (const std::uint32_t v : s) {
        if (number[v] != kNone) continue;
        number[v] = static_cast<std::uint32_t>(points.size());
        points.push_back(sites[v]);
        of.push_back(v);
      }
      numbered.push_back({number[s[0]], number[s[1]]});
    }
    PlanarTriangulation triangulation;
    std::vector<SegmentCrossing> wrong = triangulation.build(points, numbered);
    for (SegmentCrossing& w : wrong) {
      for (std::uint32_t* q : {&w.point, &w.other_point}) *q = *q < of.size() ? of[*q] : kNone;
    }
    if (wrong.empty()) {
      std::vector<std::array<std::uint32_t, 3>> cells;
      for (const auto& t : triangulation.triangles()) {
        const std::array<std::uint32_t, 3> v{vertex[of[t[0]]], vertex[of[t[1]]], vertex[of[t[2]]]};
        if (v[0] != kNone && v[1] != kNone && v[2] != kNone) cells.push_back(v);
      }
      take_whole();
      LayerCells(scan_, faces_, part_, lean_, sheet_).take(cells, fixed, lost);
      return true;
    }
    if (may_cut_faces) {
      std::vector<std::uint64_t> touched;
      for (const SegmentCrossing& w : wrong) {
        for (const std::uint32_t s : {w.segment_a, w.segment_b}) {
          if (s >= 4 && s < fixed_segments) touched.push_back(sides[s]);
        }
      }
      std::sort(touched.begin(), touched.end());
      if (!touched.empty()) {
        cut_faces(touched);
        return false;
      }
    }
    // Lines that still pass over one another, or over a point, by rounding: cut there, or else the
    // later one gives way. Sides of whole faces come first and stay.
    // All of a line's at once: one line may pass over hundreds.
    struct Cut {
      std::vector<std::uint32_t> at;  // sites
      bool lost = false;              // gives way, as it does where it is cut nowhere
    };
    std::unordered_map<std::uint64_t, Cut> cut;               // by the ends
    std::set<std::pair<std::uint64_t, std::uint64_t>> pairs;  // whose crossing is known
    for (const SegmentCrossing& w : wrong) {
      std::uint32_t s = w.segment_a, other = w.segment_b;
      if (other < segments.size() && (s >= segments.size() || other > s)) std::swap(s, other);
      if (s >= segments.size()) continue;
      if (s < fixed_segments) {  // nothing may lie on it
        for (const auto& q : std::span(segments).subspan(fixed_segments)) {
          const bool there =
              q[0] == w.point || q[1] == w.point || q[0] == w.other_point || q[1] == w.other_point;
          if (there) cut[key(q[0], q[1])].lost = true;
        }
        continue;
      }
      const auto [a, b] = segments[s];
      std::uint32_t at = w.point != a && w.point != b ? w.point : kNone;
      if (at == kNone && other < segments.size() && other >= fixed_segments) {
        const auto [c, d] = segments[other];
        if (!pairs.insert(std::minmax(key(a, b), key(c, d))).second) continue;
        const Vec2 u = sites[b] - sites[a], v = sites[d] - sites[c];
        const Vec2 p = sites[a] + cross(sites[c] - sites[a], v) / cross(u, v) * u;
        double z = 0;
        // At an end that is as near to the other as nothing, or else at a point of its own.
        if (const NearestEnd end = nearest_end(sites, {a, b}, {c, d}); end.away <= snap_) {
          if (end.site == a || end.site == b) {
            cut[key(c, d)].at.push_back(end.site);
            continue;
          }
          at = end.site;
        } else {
          if (!top(p, z)) z = sheet_.points[vertex[a]].z();  // at the border, by rounding
          at = static_cast<std::uint32_t>(sites.size());
          sites.push_back(p);
          vertex.push_back(add_point({p.x(), p.y(), z}));
          cut[key(c, d)].at.push_back(at);
        }
      }
      Cut& of_first = cut[key(a, b)];
      if (at != kNone) of_first.at.push_back(at);
    }
    if (cut.empty()) break;
    std::vector<PlanarTriangulation::Segment> rest;
    for (const auto& s : segments) {
      const auto it = cut.find(key(s[0], s[1]));
      if (it == cut.end()) {
        rest.push_back(s);
      } else if (it->second.lost || it->second.at.empty()) {
        lost.push_back({sites[s[0]], sites[s[1]]});
      } else {
        // (In the same order for both directions.)
        const Vec2 way = sites[std::max(s[0], s[1])] - sites[std::min(s[0], s[1])];
        std::vector<std::uint32_t> on = it->second.at;
        std::sort(on.begin(), on.end(), [&](std::uint32_t i, std::uint32_t j) {
          const double at_i = way.dot(sites[i]), at_j = way.dot(sites[j]);
          return at_i != at_j ? at_i < at_j : i < j;
        });
        on.erase(std::unique(on.begin(), on.end()), on.end());
        if (s[0] > s[1]) std::reverse(on.begin(), on.end());
        on.push_back(s[1]);
        std::uint32_t from = s[0];
        for (const std::uint32_t to : on) {
          if (known.try_emplace(pair_key(from, to), 0).second) rest.push_back({from, to});
          from = to;
        }
      }
    }
    segments = std::move(rest);
  }
  take_whole();
  // Left open: a hole, counted.
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (part_[f] != Part::kJoined) continue;
    const Vec3 &a = sheet_.points[faces_[f][0]], &b = sheet_.points[faces_[f][1]],
               &c = sheet_.points[faces_[f][2]];
    sheet_.unproven_area += 0.5 * cross((b - a).head<2>(), (c - a).head<2>());
  }
  return true;
}

void LayerJoiner::run(int threads) {
  const ScannedSurface::Layers layers = scan_.layers(threads);
  find_rims();
  choose_faces(layers.marks);
  if (std::find(part_.begin(), part_.end(), Part::kJoined) == part_.end()) {
    take_whole();
    return;
  }
  for (int round = 1;; ++round) {
    lines_.clear();
    pieces_.clear();
    add_lines(layers.meets);
    cut_lines();
    collect_pieces();
    if (triangulate(round < kMostRounds)) break;
  }
}

void join_layers(const ScannedSurface& scan, const std::vector<std::array<std::uint32_t, 3>>& faces,
                 double lean, int threads, ScanSheet& sheet) {
  LayerJoiner(scan, faces, lean, sheet).run(threads);
}

}  // namespace diesink
