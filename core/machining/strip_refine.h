// Passes put in between two passes wherever more would stay between them than is allowed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/machining/frame_domain.h"
#include "core/machining/strip_rows.h"

namespace diesink {

// A row that is cut in parts only: gaps in the profile are not cut.
struct AddedRow {
  double y = 0;
  std::vector<ProfileSegment> profile;
};

class StripRefiner {
 public:
  // `domain`: where rows run; `limit`: the most that may stay between two rows, as left_between()
  // bounds it; `least`: rows come no closer; `margin`: how far an added row reaches beyond what
  // called for it; `wall`: walls are followed at their feet where they reach that much higher than
  // the cutter's corner. Needs: `offset` and `domain` outlive it. One a thread.
  StripRefiner(const OffsetSurface& offset, const FrameDomain& domain, double chord, double limit,
               double least, double margin, double wall)
      : offset_(&offset),
        domain_(&domain),
        chord_(chord),
        limit_(limit),
        least_(least),
        margin_(margin),
        wall_(wall) {}

  // Appends the rows that the strip between a and b needs, in order of y. Each is looked at before
  // it is taken: where the row in the middle shows that nothing sank between, none is added.
  // Beside the rim of a wall, or of the surface, the cutter only rolls about an edge, and the foot
  // of the wall is cut along the wall: there it is the ground beside the foot that must not be left
  // too high; and rows between are looked at, as where rows lie far apart, and taken where the
  // cutter sinks in deeper than on both sides. Needs: `items` hold every piece that reaches the
  // strip.
  void refine(const RowContacts& a, const RowContacts& b, std::span<const StripPieces::Item> items,
              std::vector<AddedRow>& out);

  // Where the cutter's tip stands between rows less than twice `least` apart that the bound could
  // not settle, in the order they were met.
  [[nodiscard]] const std::vector<PlanBox>& unsettled() const { return unsettled_; }

 private:
  struct Worst {
    double left = 0, y = 0;  // of the place that leaves most, and where a row would help
  };
  // The parts of `among` where too much stays between a and b, given what a row between is known
  // to be; those closer than `margin` are one, and short pieces are looked at a quarter of it
  // apart. Where `unsure` is given, those where it cannot tell go there.
  std::vector<Stretch> too_much(const RowContacts& a, const RowContacts& b,
                                const RowContacts* middle, std::span<const Stretch> among,
                                double margin, Worst& worst, std::vector<Stretch>* unsure) const;
  [[nodiscard]] double left_at(const RowPosition& from, const RowContacts& to, double dy,
                               const RowContacts* middle, Worst& worst) const;
  // What stays between the foot of a wall and the ground beside it; empty where from and across are
  // not a rim of such a wall and its ground.
  [[nodiscard]] std::optional<double> beside_wall(const RowPosition& from,
                                                  const RowPosition& across, double from_y,
                                                  double dy, const RowContacts* middle) const;
  void refine(const RowContacts& a, const RowContacts& b, std::span<const StripPieces::Item> items,
              std::span<const Stretch> among, int depth, std::vector<AddedRow>& out);

  const OffsetSurface* offset_;
  const FrameDomain* domain_;
  double chord_, limit_, least_, margin_, wall_;
  std::vector<PlanBox> unsettled_;
  std::vector<StripPieces::Item> near_;
};

}  // namespace diesink
