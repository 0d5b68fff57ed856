// The plain exchange struct of CL-data: what planners make and APT, G-code and CSV writers and
// readers carry. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/part_program/part_program.h"
#include "core/result.h"
#include "core/units.h"
#include "core/vec.h"

namespace diesink {

enum class Motion : std::uint8_t { kRapid, kFeed };

// The cutter's tip (bottom centre) at the end of a straight move; the axis is (0, 0, 1).
struct ClPoint {
  Vec3 tip = Vec3::Zero();
  Motion motion = Motion::kFeed;
};

// The part of the smaller of two tolerances that a planned path leaves to the controller, which may
// round corners off by that much (G64 P).
inline constexpr double kBlendPart = 0.1;

// Units: lengths in `unit`, feed in `unit` a minute, spindle in turns a minute.
struct ToolPath {
  std::string name;
  LengthUnit unit = LengthUnit::kMillimetre;
  std::optional<Cutter> cutter;
  double intol = 0, outtol = 0;
  double feed = 0, spindle = 0;
  double clearance = 0;
  int tool_number = 1;
  double arc_height = 0;  // no point of an arc lies farther than this from its chords, as read
  std::vector<ClPoint> points;
};

// Is called with the points of a path in order, some at a time.
using PathTaker = std::function<void(std::span<const ClPoint>)>;

// Takes a path in pieces, so that it need not be held whole.
class PathReceiver {
 public:
  virtual ~PathReceiver() = default;
  // Once, before any point: everything but the points.
  virtual Status begin(const ToolPath& head) = 0;
  // The next points. After an error none come.
  virtual Status take(std::span<const ClPoint> points) = 0;
};

}  // namespace diesink
