// The paper's method, CC-Cartesian or along isoparametric curves: CC-data along each pass, CL-data
// by equation (6), interferences removed, and the next pass by the cusp height at all contacts of
// this one.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/base/ferguson.h"
#include "core/machining/closing_runs.h"
#include "core/machining/interference.h"
#include "core/machining/path_interval.h"
#include "core/machining/path_links.h"
#include "core/machining/run_order.h"
#include "core/machining/tool_path_plan.h"
#include "core/machining/uncut_proof.h"
#include "core/machining/wall_runs.h"
#include "core/number.h"

namespace diesink {
namespace {

constexpr double kSteepest = 0.17364817766693033;  // as plan_drop.cpp: slopes of 80 degrees
constexpr std::size_t kMostPasses = 200'000;

Error input_error(std::string message) { return {ErrorCode::kInput, std::move(message), {}}; }

// The passes of one path: numbered by a position that grows from `first` to `last`.
class PassFamily {
 public:
  virtual ~PassFamily() = default;
  [[nodiscard]] virtual double first() const = 0;
  [[nodiscard]] virtual double last() const = 0;
  [[nodiscard]] virtual PlanCurve curve(double position) const = 0;
  // Step of the position whose pass lies `distance` away, square to the pass, at a point of it.
  [[nodiscard]] virtual double step(double position, double s, double distance) const = 0;
};

class StraightPasses final : public PassFamily {
 public:
  StraightPasses(const Machining& m, double angle)
      : along_(std::cos(angle), std::sin(angle)), square_(-along_.y(), along_.x()) {
    if (std::fabs(along_.x()) < 1e-15) along_.x() = square_.y() = 0;
    if (std::fabs(along_.y()) < 1e-15) along_.y() = square_.x() = 0;
    for (const double x : m.x_range) {
      for (const double y : m.y_range) {
        const Vec2 p(x, y);
        first_ = std::fmin(first_, p.dot(square_));
        last_ = std::fmax(last_, p.dot(square_));
        low_ = std::fmin(low_, p.dot(along_));
        high_ = std::fmax(high_, p.dot(along_));
      }
    }
  }
  [[nodiscard]] double first() const override { return first_; }
  [[nodiscard]] double last() const override { return last_; }
  [[nodiscard]] PlanCurve curve(double position) const override {
    return [this, position](double s) -> Vec2 {
      return (low_ + s * (high_ - low_)) * along_ + position * square_;
    };
  }
  [[nodiscard]] double step(double, double, double distance) const override { return distance; }

 private:
  Vec2 along_, square_;
  double first_ = 1e300, last_ = -1e300, low_ = 1e300, high_ = -1e300;
};

class IsoparametricPasses final : public PassFamily {
 public:
  IsoparametricPasses(const FergusonSurface& base, bool along_u)
      : base_(&base), along_u_(along_u) {}
  [[nodiscard]] double first() const override { return 0; }
  [[nodiscard]] double last() const override {
    return (along_u_ ? base_->rows() : base_->columns()) - 1;
  }
  [[nodiscard]] PlanCurve curve(double position) const override {
    return [this, position](double s) -> Vec2 { return at(position, s).r.head<2>(); };
  }
  [[nodiscard]] double step(double position, double s, double distance) const override {
    const FergusonSurface::Point p = at(position, s);
    const Vec2 along = (along_u_ ? p.ru : p.rv).head<2>(),
               across = (along_u_ ? p.rv : p.ru).head<2>();
    const double square = std::fabs(along.x() * across.y() - along.y() * across.x()) / along.norm();
    return distance / square;
  }

 private:
  [[nodiscard]] FergusonSurface::Point at(double position, double s) const {
    const double along = s * ((along_u_ ? base_->columns() : base_->rows()) - 1);
    return along_u_ ? base_->point(along, position) : base_->point(position, along);
  }
  const FergusonSurface* base_;
  bool along_u_;
};

// Curvature of the surface along its tangent e at a contact, from the normals a little to both
// sides; 0 where they lie on other faces.
double curvature_at(const CompoundSurface& surface, const CcSample& at, const Vec3& e,
                    double reach) {
  const Vec2 d = e.head<2>() * reach;
  const Vec2 p = at.contact.p.head<2>();
  const std::optional<CcDatum> a = surface.at(p.x() - d.x(), p.y() - d.y());
  const std::optional<CcDatum> b = surface.at(p.x() + d.x(), p.y() + d.y());
  if (!a || !b || a->row != at.row || b->row != at.row || a->face != at.face ||
      b->face != at.face) {
    return 0;
  }
  const Vec3 chord(2 * d.x(), 2 * d.y(), b->z - a->z);
  const double length = chord.norm();
  return length > 0 ? (b->n - a->n).dot(chord) / (length * length) : 0;
}

}  // namespace

Result<PathReport> plan_cc_path(const CompoundSurface& surface, const TriangleMesh& mesh,
                                double deviation, const PathOptions& options, ToolPath head,
                                PathReceiver& receiver) {
  const Result<CutterShape> real = CutterShape::make(options.cutter);
  if (!real) return real.error();
  // INTOL pays for the mesh, the controller's blending and the moves; where it is too small for
  // that, a cutter larger all round is used in place of the real one.
  const double blend = kBlendPart * std::fmin(options.intol, options.outtol);
  const double sum = options.intol + options.outtol;
  const double grow = std::fmax(0, deviation + blend + sum / 32 - options.intol);
  const double tolerance = options.intol + grow - deviation - blend;
  const CutterShape cutter =
      *CutterShape::make({2 * (real->radius() + grow), real->corner() + grow});
  const PartProgram& program = surface.program();
  const Machining& machining = program.machining;

  std::unique_ptr<PassFamily> family;
  std::optional<Result<FergusonSurface>> base;
  if (options.along == PathAlong::kAngle) {
    family = std::make_unique<StraightPasses>(machining, options.angle);
  } else {
    const FergusonBase* grid = std::get_if<FergusonBase>(&program.base);
    if (grid == nullptr) {
      return Error{ErrorCode::kInput, "paths along u or v need a Ferguson base surface", {}};
    }
    base.emplace(FergusonSurface::make(*grid));
    if (!*base) return base->error();
    family = std::make_unique<IsoparametricPasses>(**base, options.along == PathAlong::kU);
  }

  const OffsetSurface offset(mesh, cutter, 0);
  const PointDrop drop(offset);
  double top = kNoContact;
  for (const Vec3& p : mesh.positions) top = std::fmax(top, p.z());
  const double clearance = options.clearance.value_or(top + options.cutter.diameter);
  if (!(clearance > top + grow)) {
    return input_error("the clearance plane " + number_text(clearance) +
                       " must lie above the surface, whose highest point is " + number_text(top));
  }

  const double R = cutter.radius();
  const double spacing = std::fmin(machining.x_interval, R / 2);
  const double level =
      options.interval ? *options.interval
                       : cusp_interval(std::fmax(cutter.corner(), *options.cusp), 0, *options.cusp);
  const TopGrid tops(offset, R / 4);
  head.cutter = options.cutter;
  head.intol = options.intol;
  head.outtol = options.outtol;
  head.clearance = clearance;
  PathReport report;
  PathStream stream(offset, head, receiver, report);
  PathJoiner joiner(tops, grow, clearance, 2 * level + R, stream);
  SegmentProfile profile(offset, drop, tolerance / 16);
  if (!options.interval && !options.keep_interference) joiner.follow(profile, tolerance);
  // What stays beside concave edges and on the far sides of contacts is seen where it is left.
  std::optional<LeftOver> left;
  std::optional<FrameDomain> frame;
  std::optional<ReachProof> reach;
  std::optional<UncutProof> proof;
  if (!options.interval && !options.keep_interference) {
    const std::array<double, 4> domain{machining.x_range[0], machining.x_range[1],
                                       machining.y_range[0], machining.y_range[1]};
    const double limit = options.outtol + *options.cusp;
    frame.emplace(offset, domain);
    left.emplace(surface, offset, drop, *real, *frame, left_over_limits(limit),
                 real->radius() / kLatticePart, options.threads);
    if (deviation < limit) {
      proof.emplace(mesh, offset, *real, *frame, limit - deviation, options.threads);
      reach.emplace(surface, offset, drop, *real, *frame, deviation);
      proof->tell_reach(*reach, out_of_reach(options.outtol, limit) + deviation);
    }
    stream.watch([&](const Vec3& from, const Vec3& to) {
      left->cut(from, to);
      if (proof) proof->cut(from, to);
    });
  }
  InterferenceCounts counts;
  const double inside = std::fmax(options.intol, 1e-3 * options.outtol);
  double worst = 0;
  double position = family->first();
  double least = 0, widest = 0;
  bool forward = true;
  std::vector<CcContact> contacts;
  for (std::size_t pass = 0;; ++pass) {
    if (pass == kMostPasses) return input_error("more than 200000 passes");
    const PlanCurve curve = family->curve(position);
    const std::vector<std::vector<CcSample>> stretches = cc_pass(
        surface, curve, R, spacing, inside, std::fmax(options.outtol, 1e-3 * options.intol));
    // A pass over nothing, at a corner of the domain or in a hole, says nothing of the next.
    double step = stretches.empty() ? level : family->last() - family->first();
    for (const std::vector<CcSample>& stretch : stretches) {
      if (stretch.size() < 2) step = std::fmin(step, level);
      for (std::size_t k = 0; k < stretch.size(); ++k) {
        const CcSample& sample = stretch[k];
        double distance = level;
        if (!options.interval) {
          const CcSample& other = stretch[k + 1 < stretch.size() ? k + 1 : k > 0 ? k - 1 : k];
          Vec2 along = curve(std::fmin(1, sample.s + 1e-6)) - curve(std::fmax(0, sample.s - 1e-6));
          if (!(along.norm() > 0)) along = (other.contact.p - sample.contact.p).head<2>();
          if (!(along.norm() > 0)) continue;
          along.normalize();
          const Vec3 n = sample.contact.n.z() > 1e-9 ? sample.contact.n : Vec3(Vec3::UnitZ());
          const double curvature = curvature_at(surface, sample, across_of(n, along), R / 64);
          // On ground that is level across the pass the disk's own width leaves nothing. On slopes
          // its sharp corner leaves triangles, for which a corner of a cusp height counts.
          const double corner = std::fmax(cutter.corner(), *options.cusp);
          const double on_surface = cusp_interval(corner, curvature, *options.cusp);
          const bool flat = cutter.corner() < *options.cusp &&
                            std::fabs(across_of(n, along).z()) < 1e-9 && curvature == 0;
          const double wide =
              flat ? 2 * cutter.flat() : plan_interval(std::fmin(on_surface, 2 * R), n, along);
          distance = std::clamp(wide, kSteepest * level, 2 * R);
        }
        step = std::fmin(step, family->step(position, sample.s, distance));
      }
    }

    if (stream.failed()) break;
    bool cut = false;
    const auto count = static_cast<std::ptrdiff_t>(stretches.size());
    for (std::ptrdiff_t k = 0; k < count; ++k) {
      const std::vector<CcSample>& stretch =
          stretches[static_cast<std::size_t>(forward ? k : count - 1 - k)];
      if (options.cc_pass) {
        contacts.clear();
        for (const CcSample& sample : stretch) contacts.push_back(sample.contact);
        options.cc_pass(contacts);
      }
      std::vector<Vec3> tips = tips_of(cutter, stretch, inside);
      if (!options.keep_interference) {
        worst = std::fmax(worst, without_interference(tips, drop, profile, tolerance, counts));
      }
      if (tips.empty()) continue;
      for (Vec3& tip : tips) tip.z() += grow;
      if (!forward) std::reverse(tips.begin(), tips.end());
      joiner.cut(tips, cut || options.pattern == PathPattern::kOneway);
      cut = true;
    }
    if (cut) {
      ++report.passes;
      if (options.pattern == PathPattern::kZigzag) forward = !forward;
    }
    if (position >= family->last()) break;
    const double next = std::fmin(position + step, family->last());
    const double distance = next - position;
    least = least > 0 ? std::fmin(least, distance) : distance;
    widest = std::fmax(widest, distance);
    position = next;
  }
  if (left && !stream.failed()) {
    // Upright walls have no contacts over a point of the plane.
    WallRunOptions walls;
    walls.below = tolerance / 2;
    walls.above = options.outtol / 4;
    walls.chord = tolerance / 16;
    walls.least_depth = options.outtol;
    walls.domain = frame->corners();
    std::vector<AddedRun> along_walls;
    for (std::vector<Vec3>& run : wall_runs(mesh, offset, drop, walls)) {
      ++report.wall_runs;
      for (Vec3& tip : run) tip.z() += grow;
      along_walls.push_back({run.front().y(), std::move(run)});
    }
    cut_nearest_first(std::move(along_walls), options.pattern == PathPattern::kOneway, stream,
                      joiner);
    const ClosingOptions closing{tolerance, options.outtol / 4, grow,
                                 options.pattern == PathPattern::kOneway, options.threads};
    worst = std::fmax(worst, close_left_over(*left, profile, closing, stream, joiner, report));
    tell_left_over(*left, report);
    if (proof) {
      worst =
          std::fmax(worst, close_unproven(*proof, *left, profile, closing, stream, joiner, report));
    }
  }
  joiner.finish();
  if (const Status done = stream.finish(); !done) return done.error();
  report.least_interval = least;
  report.greatest_interval = widest;
  report.mesh_deviation = deviation;
  report.overcut_bound =
      options.keep_interference ? 0 : std::fmax(worst, tolerance) - grow + deviation + blend;
  report.loops_removed = counts.loops;
  report.crossings_inserted = counts.crossings;
  return report;
}

}  // namespace diesink
