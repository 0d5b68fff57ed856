// The parts of untangle(): chords laid without crossings, the faces between them labelled, and arcs
// and regions made of those. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/pair_key.h"
#include "core/tessellate/arc_samples.h"
#include "core/tessellate/plan_curve.h"
#include "core/tessellate/planar_triangulation.h"

namespace diesink {

// Lays one plan; for untangle() alone.
class Untangler {
 public:
  Untangler(const CompoundSurface::Impl& surface, const Arrangement& from,
            const ArcSamples& samples, double grain, std::size_t most_crossings)
      : surface_(surface),
        from_(from),
        samples_(samples),
        solver_(surface),
        box_(from.box),
        grain_(grain),
        crossings_left_(most_crossings) {}

  [[nodiscard]] bool is_too_coarse() const {
    return !(grain_ <= kWidest * std::fmin(box_.x1 - box_.x0, box_.y1 - box_.y0));
  }
  // The chords, and their crossings done away with; false where that does not end.
  bool lay();
  Arrangement make();

 private:
  using Impl = CompoundSurface::Impl;
  using Ends = std::pair<std::uint32_t, std::uint32_t>;
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  static constexpr double kWidest = 0.1;  // grain, of the domain's shorter side

  // What an arc says of a chord: labels on either side, from its lower vertex to its higher one.
  struct Claim {
    Label left = kNoLabel, right = kNoLabel;
  };
  struct Chord {
    std::vector<Claim> claims;
    double bound = 0;
    std::uint8_t side = 4;  // on the border of the domain: 0 bottom, 1 right, 2 top, 3 left
    bool seam = false;
  };
  struct Face {  // of the triangulation: what no chord parts
    std::vector<std::uint32_t> triangles;
  };

  [[nodiscard]] double snapped(double v) const { return grain_ * std::nearbyint(v / grain_); }
  [[nodiscard]] Vec2 inside(const Vec2& p) const;
  std::uint32_t vertex(const Vec2& p);
  void take_points(bool border);
  void take_chords();
  void join(std::uint32_t u, std::uint32_t v, const Chord& chord);
  bool build();
  void fill_buckets();
  [[nodiscard]] std::size_t bucket_of(double at, double low, double high) const;
  void take_near(const Ends& ends, std::vector<std::uint32_t>& near) const;
  void split(const std::map<Ends, std::vector<std::uint32_t>>& at);

  [[nodiscard]] std::uint32_t across(std::uint32_t u, std::uint32_t v) const {
    const auto found = left_of_.find(pair_key(v, u));
    return found == left_of_.end() ? kNone : found->second;
  }
  [[nodiscard]] const Chord* chord_between(std::uint32_t u, std::uint32_t v) const {
    const auto found = chords_.find(std::minmax(u, v));
    return found == chords_.end() ? nullptr : &found->second;
  }
  [[nodiscard]] Vec2 middle(std::uint32_t t) const;
  [[nodiscard]] double area(std::uint32_t t) const;
  [[nodiscard]] Label label_at(std::uint32_t t) const;
  void label_faces();
  void label_face(const Face& face);
  void tell(const Vec2& place, double doubtful);

  [[nodiscard]] bool parts(std::uint32_t u, std::uint32_t v) const;
  void make_nodes();
  double height(std::uint32_t v, Label label) const;
  void make_arcs();
  void walk(std::uint32_t from, std::uint32_t to);
  void make_regions();

  const Impl& surface_;
  const Arrangement& from_;
  const ArcSamples& samples_;
  CurveSolver solver_;
  PlanBox box_;
  double grain_;
  std::size_t crossings_left_;
  bool no_holes_ = false;
  std::vector<Vec2> points_;
  std::vector<std::vector<LabelHeight>> heights_;  // that arcs know, of each vertex
  std::vector<char> on_border_, on_seam_;
  std::map<std::pair<double, double>, std::uint32_t> vertex_at_;
  std::vector<std::uint32_t> vertex_of_;  // of each arc point
  std::map<Ends, Chord> chords_;          // by their vertices, the lower number first
  int buckets_ = 1;                       // of vertices, so many along either axis
  std::vector<std::vector<std::uint32_t>> bucket_;
  PlanarTriangulation triangulation_;
  std::vector<PlanarTriangulation::Corners> triangles_;
  std::unordered_map<std::uint64_t, std::uint32_t> left_of_;  // the triangle to the left of a side
  std::vector<Label> label_;                                  // of each triangle
  std::vector<std::vector<std::uint32_t>> neighbours_;  // of each vertex, over sides that part
  std::unordered_map<std::uint64_t, ArcUse> use_of_;    // of each such side, directed
  Arrangement out_;
};

}  // namespace diesink
