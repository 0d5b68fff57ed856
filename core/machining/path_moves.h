// The lowest of a path's moves over a place. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/machining/cutter.h"
#include "core/machining/passed_move.h"

namespace diesink {

// The moves of a path as the places under them see them.
class PathMoves {
 public:
  explicit PathMoves(const CutterShape& cutter) : cutter_(cutter) {}
  void add(const Vec3& from, const Vec3& to) { moves_.emplace_back(from, to); }
  // Has to be called after the last move, before the first question.
  void bin();

  static constexpr std::uint32_t kNone = 0xffffffff;
  // The move that comes lowest over p, as far as it comes under `below`: that becomes its height.
  [[nodiscard]] std::uint32_t lowest(const Vec2& p, double& below) const;
  // The same among those that pass near `tip` only.
  [[nodiscard]] std::uint32_t lowest_near(const Vec2& tip, const Vec2& p, double& below) const;
  [[nodiscard]] double height(std::uint32_t move, const Vec2& p) const;

 private:
  // Bins, or two by two of those of the level below.
  struct Level {
    std::size_t columns = 0, rows = 0;
    std::vector<double> low;  // no tip in a bin is lower
  };
  struct Bins {
    double x0 = 0, y0 = 0, per = 0;  // bins to a unit of length
    std::size_t columns = 0, rows = 0;
    std::vector<std::uint32_t> begin, items;  // of each bin, and the end
    std::vector<Level> levels;                // the last is one
  };
  template <class Do>
  void each_bin(const PassedMove& move, const Do& act) const;
  void lowest_of(std::size_t bin, const Vec2& p, std::uint32_t& best, double& below) const;
  void lowest_of(std::size_t level, std::size_t i, std::size_t j, const Vec2& p,
                 std::uint32_t& best, double& below) const;

  CutterShape cutter_;
  std::vector<PassedMove> moves_;
  Bins bins_;
};

}  // namespace diesink
