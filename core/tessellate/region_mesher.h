// One region of the die, triangulated in the chart of its face and refined.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <unordered_map>
#include <vector>

#include "core/tessellate/deviation_filter.h"
#include "core/tessellate/region_mesh.h"

namespace diesink {

// Used by one thread at a time; different regions may be refined side by side.
// Needs: everything given by reference outlives this; arcs change between calls alone, as
//        take_split() and keep() say.
class RegionMesher {
 public:
  RegionMesher(const CompoundSurface::Impl& surface, const Arrangement& arrangement,
               const ArcSamples& samples, const TriangleDeviation& deviation,
               const RegionOptions& options, std::uint32_t index)
      : arrangement_(arrangement),
        samples_(samples),
        deviation_(deviation),
        options_(options),
        chart_(surface, arrangement.regions[index].label, deviation.base()),
        filter_(deviation, arrangement.regions[index].label),
        flat_(2 * options.least_altitude),
        near_(1e-9 * surface.size),
        may_be_strip_(chart_.has_rulings() && options.grid_x == nullptr) {
    mesh_.label = arrangement.regions[index].label;
    mesh_.region = index;
    chart_.draw_for(options.tolerance);
  }

  using Chord = std::array<std::uint32_t, 2>;  // arc points

  // Builds anew from the arcs as they are; the chords to split where that does not go.
  std::vector<Chord> build();
  // One round; the chords to split before it can go on.
  std::vector<Chord> refine();
  // Zero where a chord that refine() asked for last is to be split; empty: in its middle.
  [[nodiscard]] std::function<double(const Vec3&)> aim_of(const Chord& chord) const;
  // A chord of this region's border has got a point in its middle.
  void take_split(const Chord& chord, std::uint32_t point);
  void keep(const Chord& chord);
  [[nodiscard]] Label label() const { return mesh_.label; }
  [[nodiscard]] bool broken() const { return broken_; }
  // What refine() asked for last must be split however short it is.
  [[nodiscard]] bool urgent() const { return urgent_; }
  RegionMesh finish();
  // Triangulates in plan from the next build() on, where chords of arcs that do not cross in plan
  // cannot cross; false where it does so already.
  bool lay_in_plan() {
    if (options_.grid_x != nullptr || in_plan_) return false;
    return in_plan_ = true;
  }
  // Triangles to be expected, roughly: curved faces are filled at the spacing of their borders.
  [[nodiscard]] double weight() const;

 private:
  [[nodiscard]] Vec2 to_plane(const Vec3& p) const {
    return options_.grid_x != nullptr || in_plan_ ? Vec2(p.head<2>()) : chart_.to_chart(p);
  }
  std::uint32_t local(std::uint32_t arc_point);
  std::vector<Chord> chords_of_turned();
  std::vector<Chord> chords_of_tight();
  void renew_border_bounds();
  struct FanPiece {
    std::array<std::uint32_t, 3> triangle;
    std::array<std::uint32_t, 2> across;  // the chord of the border that makes it finer
  };
  struct Chain;
  struct Strip;
  struct Span {  // of rulings
    double from, to;
  };
  bool find_strip(const std::vector<PlanarTriangulation::Segment>& border, Strip& strip) const;
  bool make_strip(const std::vector<PlanarTriangulation::Segment>& border);
  [[nodiscard]] bool deviates(const FanPiece& piece) const;
  [[nodiscard]] Span span_of(const FanPiece& piece) const;
  [[nodiscard]] std::vector<Span> spans_of_wrong() const;
  void aim_at_rulings(const Chain& chain, const Chain& other, const std::vector<Span>& wrong);
  [[nodiscard]] bool fan_follows_rulings() const;
  [[nodiscard]] bool strip_fails() const;
  [[nodiscard]] bool is_steep_side() const;
  [[nodiscard]] double turn_at(std::uint32_t v) const {
    return chart_.turn(mesh_.position[v]).value_or(0);
  }
  [[nodiscard]] bool folds() const;
  bool make_fan(const std::vector<PlanarTriangulation::Segment>& border);
  bool make_fan_around(const std::vector<PlanarTriangulation::Segment>& border, const Vec3& apex);
  bool make_fan_between(const std::vector<PlanarTriangulation::Segment>& border, const Vec3& apex);
  [[nodiscard]] std::vector<Chord> chords_of_fan() const;
  void finish_fan();
  [[nodiscard]] std::optional<std::uint32_t> border_vertex_at(const Vec3& apex) const;
  void draw_to_apex();
  void insert_apex();
  bool finish_in_plan();
  void insert_grid();
  [[nodiscard]] bool closing(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] bool looks_down(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  // Looks down, and is long enough to be mended.
  [[nodiscard]] bool is_folded(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] bool may_round_down(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] bool has_no_area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] double longest_edge(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  // Distance between the triangle and its face, that of its vertices' chords from their arcs, and
  // both.
  [[nodiscard]] double face_bound_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] double border_bound_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] double bound_of(double face, std::uint32_t a, std::uint32_t b,
                                std::uint32_t c) const;
  // True where bound_of() is at most the limit if the face's bound is.
  [[nodiscard]] bool border_keeps(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                                  double limit) const;
  [[nodiscard]] bool is_off_face(std::uint32_t v) const;
  [[nodiscard]] bool too_coarse(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;

  const Arrangement& arrangement_;
  const ArcSamples& samples_;
  const TriangleDeviation& deviation_;
  const RegionOptions& options_;
  FaceChart chart_;
  DeviationFilter filter_;
  double most_off_ = 0;  // of vertices inside, off the face
  double flat_;          // altitude of a triangle without area
  double near_;          // what vertices of curves are held to
  PlanarTriangulation triangulation_;
  RegionMesh mesh_;
  std::unordered_map<std::uint32_t, std::uint32_t> local_of_;
  std::vector<Vec2> points_;
  std::vector<double> spacing_;                           // of each vertex, chart length
  std::unordered_map<std::uint32_t, Chord> worst_chord_;  // of those that end at a vertex
  std::vector<FanPiece> fan_;                             // between rulings, in place of all else
  std::map<Chord, double> aims_;  // chords to be split at a ruling, and its turn
  bool is_strip_ = false, may_be_strip_;
  bool built_ = false, broken_ = false, urgent_ = false, in_plan_ = false;
  enum class OffFace : std::uint8_t { kUnknown, kNo, kYes };
  mutable std::vector<OffFace> off_face_;  // of vertices on arcs, looked at when first asked
  mutable bool tight_ = false;             // arcs leave some triangle no room
  int turned_rounds_ = 0, tight_rounds_ = 0;
};

}  // namespace diesink
