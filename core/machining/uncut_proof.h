// What a path leaves over the surface, bounded everywhere and not only at points: facets are
// whittled down, move by move, to the pieces over which more than a limit may stay.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/machining/facet_part.h"
#include "core/machining/frame_domain.h"
#include "core/machining/offset_surface.h"
#include "core/machining/path_moves.h"
#include "core/machining/reach_proof.h"
#include "core/mesh.h"
#include "core/plan_bins.h"

namespace diesink {

// What one move leaves is a convex function of the place in plan, and so is the distance from there
// to all that is on and below one facet: where a convex part of a facet keeps a limit at its
// corners it does so everywhere. The corners that keep it, and the places on the sides up to which
// they do, so cut a part off that needs no more look; the rest is tried with the next move.
class UncutProof {
 public:
  // Of `mesh` over the domain. `offset` gives the frame, in which everything is. `cutter` is the
  // one that cuts.
  // Needs: limit > 0; `mesh` and `offset` outlive it.
  UncutProof(const TriangleMesh& mesh, const OffsetSurface& offset, const CutterShape& cutter,
             const FrameDomain& domain, double limit, int threads);

  // A move of the cutter's tip.
  void cut(const Vec3& from, const Vec3& to) {
    moves_.add(from, to);
    binned_ = false;
  }

  // The mesh over the domain.
  [[nodiscard]] const std::vector<FacetPart>& all() const { return all_; }

  // With it the parts that are out of reach are proven to be: nowhere in the domain does the cutter
  // come within `distance` of the mesh there. Needs: `reach` outlives this.
  void tell_reach(const ReachProof& reach, double distance) {
    reach_ = &reach;
    distance_ = distance;
  }

  struct Unproven {
    std::vector<FacetPart> open;
    std::vector<FacetPart> out;  // of reach, proven
  };
  // What of the parts is not proven to keep the limit, by the distance to the mesh, once all moves
  // so far are made; no wider than a sixteenth of the radius.
  // `stands` tells what is known to stand over a place, along the normal: where that is more than
  // the limit the moves are not asked. It may be empty.
  // Bound: what is not told keeps the limit, certain for the mesh. Same result for any thread
  // count.
  using Stands = std::function<double(const Vec2&)>;
  [[nodiscard]] Unproven unproven(const std::vector<FacetPart>& parts, const Stands& stands);

  [[nodiscard]] const Vec3& normal(const FacetPart& part) const { return facets_[part.facet].n; }
  [[nodiscard]] double limit() const { return limit_; }
  // Whether the mesh comes within the limit of what stands over a point of the part.
  [[nodiscard]] bool keeps(const FacetPart& part, const Vec3& p, double top) const {
    return nearby(part.facet, p, top).has_value();
  }
  // How much has to stand over a part, straight up, for the mesh to be no nearer than `distance`
  // to what does.
  [[nodiscard]] double lift(const FacetPart& part, double distance) const;
  // Whether a cutter of the offset's at this tip keeps the limit all over the part.
  // Needs: tell_reach().
  [[nodiscard]] bool kept_from(const FacetPart& part, const Vec3& tip) const;
  // What stands over a place; infinity where nothing was cut.
  [[nodiscard]] double top(const Vec2& p) const;

 private:
  struct Facet {
    std::array<Vec3, 3> v;
    Vec3 n;
  };
  class Whittler;
  // A facet that comes within the limit of what stands over a point of the facet `own`.
  [[nodiscard]] std::optional<std::uint32_t> nearby(std::uint32_t own, const Vec3& p,
                                                    double top) const;
  [[nodiscard]] bool keeps(std::uint32_t facet, std::uint32_t own, const Vec3& p, double top) const;

  CutterShape cutter_;
  double limit_;
  int threads_;
  std::vector<Facet> facets_;
  std::vector<PlanBox> boxes_;      // of the facets
  std::optional<PlanBins> around_;  // of the boxes
  PathMoves moves_;
  std::vector<FacetPart> all_;
  bool binned_ = false;
  const ReachProof* reach_ = nullptr;
  double distance_ = 0;
};

}  // namespace diesink
