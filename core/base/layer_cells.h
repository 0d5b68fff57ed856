// The triangles between the lines of layers that are seen, each a piece of one face of the scan,
// and the strips that stand for the walls between them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/scan_sheet.h"
#include "core/base/scanned.h"

namespace diesink {

// Each cell is a piece of the face that is topmost at its middle. Where the cells round a vertex
// have other heights there, the vertex is split: it stays with the highest of them, and what lies
// lower between two of those gets a vertex of its own, moved in by not more than `lean`, at the
// height that is next; and so on with that one, by less and less: none ends up farther than twice
// `lean` from where it was. What opens between the two is a strip, the wall.
// Vertices are split one after another, by less than half of the way to the opposite side of each
// triangle that goes along: none ever turns over, however narrow.
class LayerCells {
 public:
  enum class Part : std::uint8_t { kHidden, kWhole, kJoined };  // of a face

  // `faces` as for join_layers(). Whole ones are not cut, and in the sheet already.
  LayerCells(const ScannedSurface& scan, const std::vector<std::array<std::uint32_t, 3>>& faces,
             const std::vector<Part>& parts, double lean, ScanSheet& sheet)
      : scan_(scan), faces_(faces), parts_(parts), lean_(lean), sheet_(sheet) {}

  // Puts the triangles and strips into the sheet and sets moved; what is off by more than `lean`
  // from its face goes into unproven_area.
  // Needs:  cells anticlockwise in plan, a triangulation, of points of the sheet no two of which
  //         lie at one place; `fixed` tells the points that belong to faces which are not cut.
  //         `lost` are lines that are not sides of cells as they should be: what they pass through
  //         is told.
  void take(const std::vector<std::array<std::uint32_t, 3>>& cells, const std::vector<char>& fixed,
            const std::vector<std::array<Vec2, 2>>& lost);

 private:
  struct Cell {
    std::array<std::uint32_t, 3> v;         // none: gone
    std::uint32_t face = ScanSheet::kNone;  // none: a strip, or as wide as nothing
  };
  // A plane over the plan.
  struct Plane {
    double x, y, z, zx, zy;
    [[nodiscard]] double at(const Vec3& p) const { return z + zx * (p.x() - x) + zy * (p.y() - y); }
  };
  // One of the cells round a vertex, anticlockwise from `from` to `to`.
  struct Spoke {
    std::uint32_t cell, from, to;
    double height;  // of the cell's face at the vertex
  };
  // Cells round a vertex that meet there at one height, in order.
  struct Run {
    std::size_t first, count;  // in round_
    double low, high;
    bool open_before;  // there is no cell beside it
    bool open_after;
    // How far from z it all lies, the nearest of it; 0 at it.
    [[nodiscard]] double off(double z) const { return z < low ? low - z : z > high ? high - z : 0; }
  };
  // What goes along when a vertex is split: cells and the strips between them, in order.
  struct Group {
    std::vector<Spoke> spokes;
    bool open_before, open_after;
    bool lower;      // than what stays
    double nearest;  // of the heights of its runs: to the one that stays
  };

  [[nodiscard]] double plan_area(const std::array<std::uint32_t, 3>& v) const;
  [[nodiscard]] double width_of(const std::array<std::uint32_t, 3>& v) const;
  [[nodiscard]] double height(std::uint32_t cell, std::uint32_t v) const;
  bool take_shown(const Vec2& p, BaseHit& hit) const;
  void flip_slivers(const std::vector<char>& fixed);
  void order_round(std::uint32_t v);
  void find_runs(double kept);
  std::vector<Group> groups_off(double kept);
  void split(std::uint32_t v, double kept);
  void split_free(std::uint32_t v);
  [[nodiscard]] double angle_of(std::uint32_t v, std::span<const Spoke> spokes) const;
  std::uint32_t move(std::uint32_t v, const Group& group);
  [[nodiscard]] bool all_turn_left(const Group& group, std::uint32_t v, const Vec2& p) const;
  [[nodiscard]] double passes_through(const std::array<Vec2, 2>& line, const Cell& cell) const;
  void finish(const std::vector<std::array<Vec2, 2>>& lost);

  const ScannedSurface& scan_;
  const std::vector<std::array<std::uint32_t, 3>>& faces_;
  const std::vector<Part>& parts_;
  double lean_;
  ScanSheet& sheet_;
  std::vector<Vec3> given_;  // the points before any is split or moved
  std::vector<Cell> cells_;
  std::vector<Plane> planes_;                       // of each cell
  std::vector<std::vector<std::uint32_t>> around_;  // the cells of each point
  std::vector<Spoke> round_;                        // of the vertex at hand
  std::vector<char> begins_;                        // of round_: nothing lies before it
  std::vector<double> shift_;                       // of each point: from where it was split off
  std::vector<Run> runs_;
};

}  // namespace diesink
