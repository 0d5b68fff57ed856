// Where no place of the cutter comes low enough, proven over whole parts of facets and not only at
// points: the surface closed by the cutter, bounded from below.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/machining/drop.h"
#include "core/machining/facet_part.h"
#include "core/machining/frame_domain.h"

namespace diesink {

// A cutter whose axis is at c in plan stands at least as high as any point q of the part within its
// radius holds it. What it then leaves over a place p grows with q's height and falls with its
// profile at q: over a box of axes the profile at q is largest at a corner, and the profile at p,
// which is convex, lies over its tangent plane; so the corners of the box and of the part of a
// facet that is asked about bound what stays there. Boxes of axes are divided until one such point
// q, of a contact of the cutter dropped at the box's middle, tells for each of them that too much
// stays.
class ReachProof {
 public:
  // `cutter` is the one that cuts, `offset` and `drop` may be of one that is larger or smaller. The
  // mesh under them lies at most `deviation` from the surface. Everything is in the frame of
  // `offset`.
  // Needs: all outlive it.
  ReachProof(const CompoundSurface& surface, const OffsetSurface& offset, const PointDrop& drop,
             const CutterShape& cutter, const FrameDomain& domain, double deviation)
      : surface_(&surface),
        offset_(&offset),
        drop_(&drop),
        cutter_(cutter),
        domain_(domain),
        deviation_(deviation) {}

  enum class Reach : std::uint8_t {
    kOut,   // no cutter in the domain leaves less, anywhere over the part
    kIn,    // one does over one of its points
    kOpen,  // neither is known
  };
  struct Answer {
    Reach reach = Reach::kOpen;
    Vec3 tip = Vec3::Zero();  // kIn: of the offset's cutter
  };

  // What is asked about a part of a facet.
  struct Question {
    double lift = 0;  // how much has to stay over it, straight up, for it to be out of reach
    double low = 0;   // how little may stay over one of its points for that to be in reach
    std::size_t most_boxes = 64;  // that are looked at
  };

  // What the offset's cutter at this tip makes the real one leave over a place; infinity where it
  // does not come over it.
  [[nodiscard]] double height(const Vec3& tip, const Vec2& over) const {
    const double rho = (tip.head<2>() - over).norm();
    if (rho > cutter_.radius()) return std::numeric_limits<double>::infinity();
    return tip.z() + offset_->cutter().radius() - cutter_.radius() + cutter_.height(rho);
  }

  // One thread's: what was found for one part serves its neighbours.
  class Search {
   public:
    explicit Search(const ReachProof& proof);
    // A point that holds cutters up: exact on the surface, or of the mesh.
    struct Holder {
      Vec2 q = Vec2::Zero();
      double z = -std::numeric_limits<double>::infinity();
      bool exact = false;
    };
    struct Box {
      int level = 0;
      std::int64_t i = 0, j = 0;
      Vec2 middle = Vec2::Zero();
      double half = 0;
      // A plane under the cutter's profile over the part, at the box's middle: its slope, and by
      // how much it lies over the part at least, for a tip at height 0.
      Vec2 slope = Vec2::Zero();
      double over = 0;
      std::uint64_t asked = 0;  // of which question that is
      Holder holder;            // the best so far, and what it proves to stay
      double bound = -std::numeric_limits<double>::infinity();
    };
    // Boxes of axes that are still to be settled.
    using Rest = std::vector<Box>;
    // All that may reach a part.
    [[nodiscard]] Rest all(const FacetPart& part) const;
    // `rest`: what was left when a part was asked for that holds this one, with no less a lift; is
    // what is left then. Bound: kOut is certain for the surface itself.
    Answer ask(const FacetPart& part, const Question& question, Rest& rest);

   private:
    // Boxes to begin with are as wide as the radius; so often they are halved.
    static constexpr std::size_t kMostHalvings = 14;
    // Axes of a square, and what a cutter dropped at its middle meets.
    struct Axes {
      // Tips of the offset's cutter: in the middle, and where its rim only touches what holds it.
      Vec3 tip = Vec3(0, 0, kNoContact), aside = tip;
      // What it meets; where that is at its rim, what it would meet less far out, and a point as
      // far within as all of them reach. Of the mesh and of the surface itself.
      std::array<Holder, 6> holders;
    };
    struct Asked;
    [[nodiscard]] Box make_box(int level, std::int64_t i, std::int64_t j) const;
    void put_under(const Asked& asked, Box& box) const;
    [[nodiscard]] double held_at(const Holder& holder, const Vec2& axis) const;
    const Axes& axes(const Box& box);
    [[nodiscard]] bool meets_domain(const Vec2& middle, double half) const;
    // Whether the holder keeps all cutters of the box high enough; raises the box's bound.
    bool settled(const Asked& asked, Box& box, const Holder& holder) const;

    const ReachProof& proof_;
    Vec2 from_;                                    // a corner of all boxes
    std::array<double, kMostHalvings + 1> sides_;  // of the boxes of each level
    std::unordered_map<std::uint64_t, Axes> known_;
    std::uint64_t asked_ = 0;
  };

 private:
  // The least height of the part over the tip of a cutter that does not gouge, where the mesh is so
  // far from its axis; infinity where it tells nothing.
  [[nodiscard]] double holding_height(double rho) const;

  const CompoundSurface* surface_;
  const OffsetSurface* offset_;
  const PointDrop* drop_;
  CutterShape cutter_;
  FrameDomain domain_;
  double deviation_;
};

}  // namespace diesink
