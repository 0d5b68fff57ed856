// What join_layers() works with: the rims of layers and the lines that may be seen
// (layer_lines.cpp), and the pieces between them (scan_layers.cpp).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

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
  enum class Part : std::uint8_t { kHidden, kWhole, kJoined };  // of a face
  struct Rim {
    std::uint32_t a, b;  // the upper layer on the left
    std::uint32_t foot_a = ScanSheet::kNone,
                  foot_b = ScanSheet::kNone;  // a and b themselves where there is no step
  };
  struct Line {
    std::uint32_t a, b;
    bool fixed = false;                    // side of a face that stays whole
    bool foot = false;                     // its height is that of what it runs over
    std::uint32_t rim = ScanSheet::kNone;  // of a foot line: its rim
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
    at_wall_.push_back(0);
    return static_cast<std::uint32_t>(sheet_.points.size() - 1);
  }

  void find_rims();
  void place_feet();
  void choose_faces(const std::vector<char>& marks);
  void add_lines(const std::vector<std::array<Vec3, 2>>& meets);
  void cut_lines();
  void cut_pair(std::uint32_t i, std::uint32_t j);
  [[nodiscard]] bool in_strip(const Rim& rim, const Vec2& p, bool strictly) const;
  [[nodiscard]] double height_on(const Rim& rim, const Vec2& p) const;  // over its line
  [[nodiscard]] bool behind_strip(const Vec2& p, double z, std::uint32_t but) const;
  [[nodiscard]] bool is_seen(const Line& line, const Vec2& from, const Vec2& to) const;
  void collect_pieces();
  void triangulate();
  void take_cell(const std::array<std::uint32_t, 3>& v, bool all_lines);

  const ScannedSurface& scan_;
  const std::vector<std::array<std::uint32_t, 3>>& faces_;
  double lean_, snap_;
  ScanSheet& sheet_;
  std::vector<Part> part_;
  std::vector<Rim> rims_;
  std::vector<PlanBox> strip_boxes_;
  std::optional<PlanBins> strips_;
  std::vector<Line> lines_;
  std::vector<char> at_wall_;                         // points on rims and their feet
  std::vector<PlanarTriangulation::Segment> pieces_;  // each both ways
  std::size_t fixed_pieces_ = 0;                      // those first
};

}  // namespace diesink
