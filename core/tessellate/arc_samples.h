// The arcs of the arrangement as chains of exact points, dense enough for the tolerance, and
// splittable. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "core/tessellate/arrangement.h"
#include "core/tessellate/chart.h"
#include "core/tessellate/deviation.h"

namespace diesink {

// A point of one arc or, at a junction, of several.
struct ArcPoint {
  double x = 0, y = 0;
  std::array<LabelHeight, 2> sides;  // interior points: left and right label of their arc
  std::uint32_t arc = kNoNode;       // interior points: theirs
  std::uint32_t node =
      kNoNode;  // junctions and kept nodes: the arrangement's node, which knows all heights
  static constexpr std::uint32_t kNoNode = 0xFFFFFFFFu;
};

// A point in the chain of its arc.
struct ArcSample {
  std::uint32_t point = 0;
  std::uint32_t next = kEnd;  // in the arc's own list
  double t = 0;               // stretch and fraction along the arc
  double deviation =
      0;  // bound of the distance between arc and chord to the next sample, either lifted side
  static constexpr std::uint32_t kEnd = 0xFFFFFFFFu;
};

struct SampledArc {
  std::vector<ArcSample> samples;  // in order of creation; the chain starts at samples[0]
};

struct SamplingOptions {
  double sag = 0;        // largest distance of chords from their arcs beside curved faces
  double flat_sag = 0;   // and between planes, which have no deviation of their own
  double tolerance = 0;  // of the faces beside
  double shortest = 0;   // no chord is made shorter
  double unseen = 0;     // a wall no higher is none
  const std::vector<double>* grid_x =
      nullptr;  // both set: samples where arcs cross these lines, nothing else
  const std::vector<double>* grid_y = nullptr;
};

class ArcSamples {
 public:
  // `charts[k]` is the chart of the k-th region of the arrangement; regions without surface have
  // none.
  ArcSamples(const CompoundSurface::Impl& surface, const Arrangement& arrangement,
             const SamplingOptions& options);

  // The first sampling. Threads work on arcs by blocks; the result does not depend on them.
  void sample_all(int threads);

  // Splits the chord between two points that follow one another on an arc; the new point, or kNone
  // where it is too short or cannot be, and beside a scan.
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  struct Split {
    std::uint32_t point = kNone;
    std::uint32_t arc = 0;
  };
  // In the middle, or where a function of the points of a label's face is zero.
  struct Aim {
    Label label = kNoLabel;
    std::function<double(const Vec3&)> zero;
  };
  Split split(std::uint32_t a, std::uint32_t b, double shortest, const Aim& aim);
  [[nodiscard]] bool can_split(std::uint32_t a, std::uint32_t b, double shortest) const;

  [[nodiscard]] double z(std::uint32_t point, Label label) const;
  [[nodiscard]] Vec3 at(std::uint32_t point, Label label) const {
    const ArcPoint& p = points[point];
    return {p.x, p.y, z(point, label)};
  }
  // Height of a label's own surface.
  bool surface_height(Label label, double x, double y, double& z) const {
    return solver_.height(label, x, y, z);
  }
  // Points of an arc in order; closed arcs repeat the first.
  void chain(std::uint32_t arc, std::vector<std::uint32_t>& out) const;
  [[nodiscard]] bool is_chord(std::uint32_t a, std::uint32_t b) const {
    return chords_.contains(key(a, b));
  }
  // The bound of the straight line between two samples of an arc in place of all chords between.
  [[nodiscard]] double span_bound(std::uint32_t arc, std::uint32_t from, std::uint32_t to) const;
  // Takes points out of the chains of their arcs; ends of arcs stay. By number of the point.
  void drop(const std::vector<char>& gone);

  // The bound kept with the chord between two neighbouring points.
  [[nodiscard]] double chord_bound(std::uint32_t a, std::uint32_t b) const;

  std::vector<ArcPoint> points;
  std::vector<SampledArc> arcs;
  double largest_deviation = 0;
  double unproven_length = 0;            // of chords whose bound could not be shown
  std::uint32_t unproven_point = kNone;  // where the first of them begins

 private:
  struct Ref {
    std::uint32_t arc, sample;
  };
  // The chord between two points, if it can be split, and where it begins and ends on its arc.
  bool find_splittable(std::uint32_t a, std::uint32_t b, double shortest, Ref& ref, double& t0,
                       double& t1) const;
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return a < b ? (std::uint64_t{a} << 32) | b : (std::uint64_t{b} << 32) | a;
  }
  struct Trial {  // a point not yet given a number
    double t = 0;
    ArcPoint p;
  };
  [[nodiscard]] ArcPoint point_at(std::uint32_t arc, double t) const;
  // Halfway between two places on an arc, by length: stretches may be of very different ones.
  [[nodiscard]] double halfway(std::uint32_t arc, double t0, double t1) const;
  [[nodiscard]] double aimed(std::uint32_t arc, double t0, double t1, const Aim& aim) const;
  [[nodiscard]] ArcPoint end_of(std::uint32_t arc, bool last) const;
  void sample(std::uint32_t arc, std::vector<Trial>& out) const;
  struct Piece {  // of an arc, and how many chords it takes
    double t0, t1, weight;
  };
  void lay_points(std::uint32_t arc, const std::vector<Piece>& pieces,
                  std::vector<Trial>& out) const;
  void sample_on_grid(std::uint32_t arc, std::vector<Trial>& out) const;
  // Points where a wall fades to nothing and goes on with its sides exchanged.
  void add_fades(std::uint32_t arc, std::vector<Trial>& out) const;
  [[nodiscard]] double lifted_sag(std::uint32_t arc, const ArcPoint& a, const ArcPoint& m,
                                  const ArcPoint& b) const;
  [[nodiscard]] double z_of(const ArcPoint& p, Label label) const;
  [[nodiscard]] bool is_scan(Label label) const;
  [[nodiscard]] double sag_of(std::uint32_t arc) const;
  // Of the chord between two points of an arc at t0 and t1.
  [[nodiscard]] double bound(std::uint32_t arc, double t0, const ArcPoint& p, double t1,
                             const ArcPoint& q) const;
  [[nodiscard]] double bound(std::uint32_t arc, const ArcSample& a, const ArcSample& b) const;
  // The same for the curve of one stretch, at t on the arc.
  [[nodiscard]] double bound_of(std::uint32_t arc, double t, const ArcPoint& p,
                                const ArcPoint& q) const;
  [[nodiscard]] bool has_scan(std::uint32_t arc) const;
  [[nodiscard]] Vec3 lifted(const ArcPoint& p, Label label) const {
    return {p.x, p.y, z_of(p, label)};
  }
  [[nodiscard]] double beside(double lateral, Label label, const ArcPoint& a, const ArcPoint& b,
                              const PlanCurve& curve) const;
  void certify(std::uint32_t arc, std::uint32_t sample, int depth);
  std::uint32_t insert(std::uint32_t arc, std::uint32_t after, const Trial& trial);

  const CompoundSurface::Impl& surface_;
  const Arrangement& arrangement_;
  SamplingOptions options_;
  CurveSolver solver_;
  std::unordered_map<std::uint64_t, Ref> chords_;
  std::unordered_map<Label, FaceChart> charts_;
};

}  // namespace diesink
