// What join_layers() works with: the rims of layers and the lines that may be seen
// (layer_lines.cpp), and the triangulation between them (scan_layers.cpp).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <utility>
#include <vector>

#include "core/base/layer_cells.h"
#include "core/base/scan_layers.h"
#include "core/pair_key.h"
#include "core/plan_bins.h"
#include "core/tessellate/planar_triangulation.h"

namespace diesink {

class LayerJoiner {
 public:
  LayerJoiner(const ScannedSurface& scan, const std::vector<std::array<std::uint32_t, 3>>& faces,
              double lean, ScanSheet& sheet)
      : scan_(scan), faces_(faces), lean_(lean), snap_(kSnap * lean), sheet_(sheet) {}

  void run(int threads);

 private:
  // Of the strips' width: points that close are one.
  static constexpr double kSnap = 1e-3;
  using Part = LayerCells::Part;
  struct Rim {
    std::uint32_t a, b;  // the upper layer on the left
  };
  struct Line {
    std::uint32_t a, b;
    bool fixed = false;  // side of a face that stays whole
    std::vector<std::pair<double, std::uint32_t>> stops;
  };

  [[nodiscard]] Vec2 plan(std::uint32_t v) const { return sheet_.points[v].head<2>(); }
  [[nodiscard]] PlanBox box_of(std::initializer_list<std::uint32_t> vertices, double more) const;
  static double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return pair_key(std::min(a, b), std::max(a, b));
  }
  [[nodiscard]] bool top(const Vec2& p, double& z) const {
    BaseHit hit;
    if (!scan_.at(p.x(), p.y(), hit)) return false;
    z = hit.z;
    return true;
  }
  std::uint32_t add_point(const Vec3& p) {
    sheet_.points.push_back(p);
    return static_cast<std::uint32_t>(sheet_.points.size() - 1);
  }

  void find_rims();
  void choose_faces(const std::vector<char>& marks);
  void add_lines(const std::vector<std::array<Vec3, 2>>& meets);
  void cut_lines();
  void cut_pair(std::uint32_t i, std::uint32_t j);
  [[nodiscard]] double height_on(const Rim& rim, const Vec2& p) const;  // over its line
  [[nodiscard]] bool is_seen(const Line& line, const Vec2& from, const Vec2& to) const;
  void collect_pieces();
  bool triangulate(bool may_cut_faces);
  void take_whole();
  void cut_faces(const std::vector<std::uint64_t>& sides);

  const ScannedSurface& scan_;
  const std::vector<std::array<std::uint32_t, 3>>& faces_;
  double lean_, snap_;
  ScanSheet& sheet_;
  std::vector<Part> part_;
  std::vector<Rim> rims_;
  std::vector<Line> lines_;
  std::vector<PlanarTriangulation::Segment> pieces_;  // each both ways
  std::size_t fixed_pieces_ = 0;                      // those first
};

}  // namespace diesink
