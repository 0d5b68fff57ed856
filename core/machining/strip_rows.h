// Rows of the offset surface anywhere in a strip between two passes, and what stays between rows.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/machining/pass_profile.h"
#include "core/vec.h"

namespace diesink {

// A run of x to look at.
struct Stretch {
  double x0 = 0, x1 = 0;
};

// The pieces that reach each of the strips of a family of rows, `block` strips together.
class StripPieces {
 public:
  struct Item {
    std::uint32_t piece = 0;
    float x0 = 0, x1 = 0, y0 = 0, y1 = 0;  // its plan box, rounded outward
  };
  // Needs: ys ascending.
  StripPieces(const OffsetSurface& offset, std::span<const double> ys, std::size_t block);

  // Those that reach [ys[block * b], ys[block * (b + 1)]].
  [[nodiscard]] std::span<const Item> of(std::size_t b) const {
    return std::span<const Item>(items_).subspan(start_[b], start_[b + 1] - start_[b]);
  }

 private:
  std::vector<std::size_t> start_;
  std::vector<Item> items_;
};

// Appends the row y over [x0, x1] of the pieces given, not yet their envelope.
void slice_row(const OffsetSurface& offset, std::span<const StripPieces::Item> items, double y,
               const Stretch& over, double chord, std::vector<ProfileSegment>& out);

// A position of the cutter on a row: where it touches, and how the row goes on.
struct RowPosition {
  double x = 0, z = 0;
  Vec2 away = Vec2::Zero();   // from the contact to the centre, in plan
  Vec2 slope = Vec2::Zero();  // of the tip's height; may be infinite
  bool border = false;        // it touches the rim of a wall, or of the surface
};

// A row's envelope with its contacts.
class RowContacts {
 public:
  RowContacts(const OffsetSurface& offset, double y, std::vector<ProfileSegment> profile)
      : offset_(&offset), y_(y), profile_(std::move(profile)) {}

  [[nodiscard]] double y() const { return y_; }
  [[nodiscard]] const std::vector<ProfileSegment>& profile() const { return profile_; }
  // The position at x; nothing in gaps.
  [[nodiscard]] std::optional<RowPosition> at(double x) const;
  [[nodiscard]] RowPosition on(const ProfileSegment& segment, double x) const;

 private:
  const OffsetSurface* offset_;
  double y_;
  std::vector<ProfileSegment> profile_;
};

// An upper bound of what stays, in depth, of any cutter that stands free on the straight plan line
// between two positions once both have been cut; d leads from a to b in plan.
// Two parts: the ridge between two cutters at the ends of a chord, and how far the surface between
// may let the cutter sink below the chord. A cutter never sinks below rolling about a contact, so
// the contacts of both ends bound that, without a look between them. (For a flat end the contact
// does not bound it; there the slopes at both ends are carried on.)
struct Between {
  double ridge = 0, sink = 0;
  [[nodiscard]] double sum() const { return ridge + sink; }
};
Between left_between(const CutterShape& cutter, const RowPosition& a, const RowPosition& b,
                     const Vec2& d);

}  // namespace diesink
