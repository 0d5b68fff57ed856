// The paper's method, CC-Cartesian or along isoparametric curves: CC-data along each pass, CL-data
// by equation (6), interferences removed, and the next pass by the cusp height at all contacts of
// this one.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/machining/closing_runs.h"
#include "core/machining/interference.h"
#include "core/machining/pass_family.h"
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

// INTOL pays for the mesh, the controller's blending and the moves; where it is too small for that,
// a cutter larger all round by `grow` is used in place of the real one.
struct Allowance {
  double blend = 0, grow = 0;
  double tolerance = 0;  // of the moves
};

Allowance allowance_of(const PathOptions& options, double deviation) {
  Allowance all;
  all.blend = kBlendPart * std::fmin(options.intol, options.outtol);
  const double sum = options.intol + options.outtol;
  all.grow = std::fmax(0, deviation + all.blend + sum / 32 - options.intol);
  all.tolerance = options.intol + all.grow - deviation - all.blend;
  return all;
}

using Stretches = std::vector<std::vector<CcSample>>;

class CcPlanner {
 public:
  // Needs: all but `head` outlive it.
  CcPlanner(const CompoundSurface& surface, const TriangleMesh& mesh, double deviation,
            const PathOptions& options, const CutterShape& real, const Allowance& allowance,
            const PassFamily& family, ToolPath head, PathReceiver& receiver)
      : surface_(surface),
        mesh_(mesh),
        deviation_(deviation),
        options_(options),
        real_(real),
        cutter_(*CutterShape::make(
            {2 * (real.radius() + allowance.grow), real.corner() + allowance.grow})),
        family_(family),
        grow_(allowance.grow),
        tolerance_(allowance.tolerance),
        blend_(allowance.blend),
        level_(options.interval
                   ? *options.interval
                   : cusp_interval(std::fmax(cutter_.corner(), *options.cusp), 0, *options.cusp)),
        inside_(std::fmax(options.intol, 1e-3 * options.outtol)),
        outside_(std::fmax(options.outtol, 1e-3 * options.intol)),
        head_(std::move(head)),
        offset_(mesh, cutter_, 0),
        drop_(offset_),
        tops_(offset_, cutter_.radius() / 4),
        stream_(offset_, head_, receiver, report_),
        joiner_(tops_, grow_, head_.clearance, 2 * level_ + cutter_.radius(), stream_),
        profile_(offset_, drop_, tolerance_ / 16) {}
  CcPlanner(const CcPlanner&) = delete;
  CcPlanner& operator=(const CcPlanner&) = delete;

  Result<PathReport> run() {
    if (!options_.interval && !options_.keep_interference) {
      joiner_.follow(profile_, tolerance_);
      watch_what_is_left();
    }
    if (const Status done = cut_passes(); !done) return done.error();
    if (left_ && !stream_.failed()) {
      cut_along_walls();
      close_what_is_left();
    }
    joiner_.finish();
    if (const Status done = stream_.finish(); !done) return done.error();
    report_.mesh_deviation = deviation_;
    report_.overcut_bound = options_.keep_interference
                                ? 0
                                : std::fmax(worst_, tolerance_) - grow_ + deviation_ + blend_;
    report_.loops_removed = counts_.loops;
    report_.crossings_inserted = counts_.crossings;
    return report_;
  }

 private:
  void watch_what_is_left();
  [[nodiscard]] std::optional<double> interval_at(const PlanCurve& curve,
                                                  const std::vector<CcSample>& stretch,
                                                  std::size_t k) const;
  [[nodiscard]] double step_after(double position, const PlanCurve& curve,
                                  const Stretches& stretches) const;
  void tell_contacts(const std::vector<CcSample>& stretch) const;
  bool cut_pass(const Stretches& stretches, bool forward);
  Status cut_passes();
  void cut_along_walls();
  void close_what_is_left();

  const CompoundSurface& surface_;
  const TriangleMesh& mesh_;
  double deviation_;
  const PathOptions& options_;
  const CutterShape& real_;
  CutterShape cutter_;
  const PassFamily& family_;
  double grow_, tolerance_, blend_;
  double level_;             // the interval on level ground
  double inside_, outside_;  // of the CC-data: chords under and over the surface
  ToolPath head_;
  OffsetSurface offset_;
  PointDrop drop_;
  TopGrid tops_;
  PathReport report_;
  PathStream stream_;
  PathJoiner joiner_;
  SegmentProfile profile_;
  std::optional<FrameDomain> frame_;
  std::optional<LeftOver> left_;
  std::optional<ReachProof> reach_;
  std::optional<UncutProof> proof_;
  InterferenceCounts counts_;
  double worst_ = 0;  // how deep a move goes under the offset surface
};

// What stays beside concave edges and on the far sides of contacts is seen where it is left.
void CcPlanner::watch_what_is_left() {
  const Machining& machining = surface_.program().machining;
  const std::array<double, 4> domain{machining.x_range[0], machining.x_range[1],
                                     machining.y_range[0], machining.y_range[1]};
  const double limit = options_.outtol + *options_.cusp;
  frame_.emplace(offset_, domain);
  left_.emplace(surface_, offset_, drop_, real_, *frame_, left_over_limits(limit),
                real_.radius() / kLatticePart, options_.threads);
  if (deviation_ < limit) {
    proof_.emplace(mesh_, offset_, real_, *frame_, limit - deviation_, options_.threads);
    reach_.emplace(surface_, offset_, drop_, real_, *frame_, deviation_);
    proof_->tell_reach(*reach_, out_of_reach(options_.outtol, limit) + deviation_);
  }
  stream_.watch([this](const Vec3& from, const Vec3& to) {
    left_->cut(from, to);
    if (proof_) proof_->cut(from, to);
  });
}

// In plan, square to the pass, to where the next may run for the cusp height at one contact;
// nothing where the pass has no direction.
std::optional<double> CcPlanner::interval_at(const PlanCurve& curve,
                                             const std::vector<CcSample>& stretch,
                                             std::size_t k) const {
  const CcSample& sample = stretch[k];
  const CcSample& other = stretch[k + 1 < stretch.size() ? k + 1 : k > 0 ? k - 1 : k];
  Vec2 along = curve(std::fmin(1, sample.s + 1e-6)) - curve(std::fmax(0, sample.s - 1e-6));
  if (!(along.norm() > 0)) along = (other.contact.p - sample.contact.p).head<2>();
  if (!(along.norm() > 0)) return std::nullopt;
  along.normalize();
  const double R = cutter_.radius(), cusp = *options_.cusp;
  const Vec3 n = sample.contact.n.z() > 1e-9 ? sample.contact.n : Vec3(Vec3::UnitZ());
  const double curvature = curvature_at(surface_, sample, across_of(n, along), R / 64);
  // On ground that is level across the pass the disk's own width leaves nothing. On slopes its
  // sharp corner leaves triangles, for which a corner of a cusp height counts.
  const double on_surface = cusp_interval(std::fmax(cutter_.corner(), cusp), curvature, cusp);
  const bool flat =
      cutter_.corner() < cusp && std::fabs(across_of(n, along).z()) < 1e-9 && curvature == 0;
  const double wide =
      flat ? 2 * cutter_.flat() : plan_interval(std::fmin(on_surface, 2 * R), n, along);
  return std::clamp(wide, kSteepest * level_, 2 * R);
}

// How far the position of the next pass may lie from this one's.
double CcPlanner::step_after(double position, const PlanCurve& curve,
                             const Stretches& stretches) const {
  // A pass over nothing, at a corner of the domain or in a hole, says nothing of the next.
  double step = stretches.empty() ? level_ : family_.last() - family_.first();
  for (const std::vector<CcSample>& stretch : stretches) {
    if (stretch.size() < 2) step = std::fmin(step, level_);
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      const std::optional<double> distance =
          options_.interval ? level_ : interval_at(curve, stretch, k);
      if (distance) step = std::fmin(step, family_.step(position, stretch[k].s, *distance));
    }
  }
  return step;
}

void CcPlanner::tell_contacts(const std::vector<CcSample>& stretch) const {
  if (!options_.cc_pass) return;
  std::vector<CcContact> contacts;
  contacts.reserve(stretch.size());
  for (const CcSample& sample : stretch) contacts.push_back(sample.contact);
  options_.cc_pass(contacts);
}

// False where no stretch has anything to cut.
bool CcPlanner::cut_pass(const Stretches& stretches, bool forward) {
  bool cut = false;
  for (std::size_t k = 0; k < stretches.size(); ++k) {
    const std::vector<CcSample>& stretch = stretches[forward ? k : stretches.size() - 1 - k];
    tell_contacts(stretch);
    std::vector<Vec3> tips = tips_of(cutter_, stretch, inside_);
    if (!options_.keep_interference) {
      worst_ = std::fmax(worst_, without_interference(tips, drop_, profile_, tolerance_, counts_));
    }
    if (tips.empty()) continue;
    for (Vec3& tip : tips) tip.z() += grow_;
    if (!forward) std::reverse(tips.begin(), tips.end());
    joiner_.cut(tips, cut || options_.pattern == PathPattern::kOneway);
    cut = true;
  }
  return cut;
}

Status CcPlanner::cut_passes() {
  const double spacing = std::fmin(surface_.program().machining.x_interval, cutter_.radius() / 2);
  double position = family_.first();
  double least = 0, widest = 0;
  bool forward = true;
  for (std::size_t pass = 0; !stream_.failed(); ++pass) {
    if (pass == kMostPasses) return input_error("more than 200000 passes");
    const PlanCurve curve = family_.curve(position);
    const Stretches stretches =
        cc_pass(surface_, curve, cutter_.radius(), spacing, inside_, outside_);
    if (cut_pass(stretches, forward)) {
      ++report_.passes;
      if (options_.pattern == PathPattern::kZigzag) forward = !forward;
    }
    if (position >= family_.last()) break;
    const double next =
        std::fmin(position + step_after(position, curve, stretches), family_.last());
    const double distance = next - position;
    least = least > 0 ? std::fmin(least, distance) : distance;
    widest = std::fmax(widest, distance);
    position = next;
  }
  report_.least_interval = least;
  report_.greatest_interval = widest;
  return ok();
}

// Upright walls have no contacts over a point of the plane.
void CcPlanner::cut_along_walls() {
  WallRunOptions walls;
  walls.below = tolerance_ / 2;
  walls.above = options_.outtol / 4;
  walls.chord = tolerance_ / 16;
  walls.least_depth = options_.outtol;
  walls.domain = frame_->corners();
  std::vector<AddedRun> along_walls;
  for (std::vector<Vec3>& run : wall_runs(mesh_, offset_, drop_, walls)) {
    ++report_.wall_runs;
    for (Vec3& tip : run) tip.z() += grow_;
    along_walls.push_back({run.front().y(), std::move(run)});
  }
  cut_nearest_first(std::move(along_walls), options_.pattern == PathPattern::kOneway, stream_,
                    joiner_);
}

void CcPlanner::close_what_is_left() {
  const ClosingOptions closing{tolerance_, options_.outtol / 4, grow_,
                               options_.pattern == PathPattern::kOneway, options_.threads};
  worst_ = std::fmax(worst_, close_left_over(*left_, profile_, closing, stream_, joiner_, report_));
  tell_left_over(*left_, report_);
  if (proof_) {
    worst_ = std::fmax(
        worst_, close_unproven(*proof_, *left_, profile_, closing, stream_, joiner_, report_));
  }
}

}  // namespace

Result<PathReport> plan_cc_path(const CompoundSurface& surface, const TriangleMesh& mesh,
                                double deviation, const PathOptions& options, ToolPath head,
                                PathReceiver& receiver) {
  const Result<CutterShape> real = CutterShape::make(options.cutter);
  if (!real) return real.error();
  const Result<std::unique_ptr<PassFamily>> family = make_pass_family(surface.program(), options);
  if (!family) return family.error();
  const Allowance allowance = allowance_of(options, deviation);
  const Result<double> clearance = clearance_over(mesh, options, allowance.grow);
  if (!clearance) return clearance.error();
  head.cutter = options.cutter;
  head.intol = options.intol;
  head.outtol = options.outtol;
  head.clearance = *clearance;
  return CcPlanner(surface, mesh, deviation, options, *real, allowance, **family, std::move(head),
                   receiver)
      .run();
}

}  // namespace diesink
