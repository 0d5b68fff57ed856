// The drop method: profiles of the offset surface, pass by pass, and their fit.
// Budget of the tolerances: the mesh lies at most `deviation` from the surface, the chords of the
// profile at most `chord` under the tip's true height, the moves at most `below` under and `above`
// over the profile. Where one of INTOL and OUTTOL leaves too little for that, a cutter grown (or
// shrunk) by `grow` all round is dropped in place of the real one, which then keeps that distance
// from the mesh. Where the cusp height is given, half of what OUTTOL leaves is kept for what stays
// between passes.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/machining/closing_runs.h"
#include "core/machining/doubtful_places.h"
#include "core/machining/pass_positions.h"
#include "core/machining/path_fit.h"
#include "core/machining/path_interval.h"
#include "core/machining/path_links.h"
#include "core/machining/run_order.h"
#include "core/machining/segment_profile.h"
#include "core/machining/steep_regions.h"
#include "core/machining/strip_refine.h"
#include "core/machining/tool_path_plan.h"
#include "core/machining/uncut_proof.h"
#include "core/machining/wall_runs.h"
#include "core/number.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr std::size_t kPassesABlock = 8;
// Blocks planned before their passes are handed on: bounds what is held, for any thread count.
constexpr std::size_t kBlocksATime = 16;

Error input_error(std::string message) { return {ErrorCode::kInput, std::move(message), {}}; }

struct Budget {
  double chord = 0, blend = 0, grow = 0, below = 0, above = 0, between = 0;
};

Result<Budget> budget_of(const PathOptions& options, const CutterShape& real, double deviation) {
  Budget b;
  b.chord = (options.intol + options.outtol) / 64;
  // What the two tolerances leave once mesh, chords and controller have had theirs.
  b.blend = kBlendPart * std::fmin(options.intol, options.outtol);
  const double inside = options.intol - deviation - b.chord - b.blend;
  const double outside = options.outtol - deviation - b.blend;
  if (!(inside + outside > 0)) {
    return input_error(
        "the tolerances are too small for the mesh under the path, which deviates by " +
        number_text(deviation));
  }
  b.below = inside;
  b.above = outside;
  if (std::fmin(inside, outside) < 0.1 * std::fmax(inside, outside)) {
    b.grow = std::fmax((outside - inside) / 2, -real.radius() / 2);
    b.below = b.above = (inside + outside) / 2;
  }
  if (!options.interval) {
    b.between = b.above / 2;
    b.above -= b.between;
  }
  return b;
}

// Rows put in come no closer than this part of the level interval, or of the corner's own.
constexpr double kLeastPart = 32;

// What a block of passes and the strips behind them gives.
struct Block {
  std::vector<std::vector<PassRun>> passes;
  std::vector<AddedRun> added;
  std::vector<PlanBox> unsettled;
};

class DropPlanner {
 public:
  DropPlanner(const TriangleMesh& mesh, const OffsetSurface& offset, const FrameDomain& frame,
              const Budget& budget, const PathOptions& options, double join)
      : mesh_(mesh),
        offset_(offset),
        frame_(frame),
        budget_(budget),
        options_(options),
        join_(join) {}

  // Positions of the passes, and how close passes put in between may come.
  void place_passes(const CutterShape& real) {
    if (options_.interval) {
      ys_ = even_passes(frame_, *options_.interval);
      return;
    }
    const Vec2 along = offset_.from_frame(Vec3::UnitX()).head<2>();
    const double level = drop_interval(real, Vec3::UnitZ(), along, 0, *options_.cusp);
    // A contact on its own allows the cutter to sink by another cusp height between two passes; the
    // row in the middle, by a quarter of that. What OUTTOL cannot take of it makes them closer.
    const double limit = *options_.cusp + budget_.between;
    const double closer = std::sqrt(std::fmin(1, limit / (1.25 * *options_.cusp)));
    ys_ = cusp_passes(offset_, mesh_, frame_, real, *options_.cusp * closer * closer, budget_.chord,
                      options_.threads);
    limit_ = limit;
    // On slopes it is the corner that leaves a ridge.
    const double r = real.corner(), h = std::fmin(*options_.cusp, r);
    least_ = (r > 0 ? std::fmin(level, 2 * std::sqrt(h * (2 * r - h))) : level) / kLeastPart;
    margin_ = level / 4;
  }

  // Tells `doubts` of the places that are not bounded before the moves over them are made.
  Status plan(PathJoiner& joiner, PathStream& stream, DoubtfulPlaces* doubts, PathReport& report) {
    const StripPieces pieces(offset_, ys_, kPassesABlock);
    const std::size_t blocks = (ys_.size() + kPassesABlock - 1) / kPassesABlock;
    double widest = 0, least = ys_.size() > 1 ? ys_.back() - ys_.front() : 0;
    for (std::size_t k = 1; k < ys_.size(); ++k) {
      widest = std::fmax(widest, ys_[k] - ys_[k - 1]);
      least = std::fmin(least, ys_[k] - ys_[k - 1]);
    }
    report.least_interval = least;
    report.greatest_interval = widest;
    SteepRegions regions(1.01 * widest);
    bool forward = true;
    const bool down = frame_.from_high();
    std::vector<Block> done(kBlocksATime);
    for (std::size_t first = 0; first < blocks && !stream.failed(); first += kBlocksATime) {
      const std::size_t count = std::min(kBlocksATime, blocks - first);
      const auto part = [&](std::size_t done_blocks) {
        return 0.3 + 0.5 * static_cast<double>(done_blocks) / static_cast<double>(blocks);
      };
      const ProgressSpan span(options_.progress, part(first), part(first + count));
      parallel_blocks(count, 1, options_.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t k = begin; k < end; ++k) {
          const std::size_t b = down ? blocks - 1 - (first + k) : first + k;
          done[k] = plan_block(pieces, b);
        }
      });
      std::vector<PlanBox> open;
      for (std::size_t k = 0; k < count; ++k) {
        open.insert(open.end(), done[k].unsettled.begin(), done[k].unsettled.end());
      }
      if (doubts != nullptr) doubts->add(open);
      for (const PlanBox& box : open) {
        if (doubts == nullptr) report.unsettled_area += (box.x1 - box.x0) * (box.y1 - box.y0);
      }
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t b = down ? blocks - 1 - (first + k) : first + k;
        Block& block = done[k];
        for (AddedRun& run : block.added) regions.add(std::move(run));
        for (std::size_t i = 0; i < block.passes.size(); ++i) {
          const std::size_t at = down ? block.passes.size() - 1 - i : i;
          const double y = ys_[b * kPassesABlock + at];
          if (cut_pass(block.passes[at], y, forward, joiner)) {
            ++report.passes;
            if (options_.pattern == PathPattern::kZigzag) forward = !forward;
          }
        }
        const double reached =
            ys_[down ? b * kPassesABlock
                     : std::min(b * kPassesABlock + kPassesABlock, ys_.size()) - 1];
        cut_regions(regions.finished(reached, down), stream, joiner, report);
        if (doubts != nullptr) doubts->forget(reached, down);
        block = {};
      }
    }
    cut_regions(regions.all(), stream, joiner, report);
    return ok();
  }

  [[nodiscard]] const std::vector<double>& ys() const { return ys_; }

 private:
  std::vector<ProfileSegment> row(std::span<const StripPieces::Item> items, double y,
                                  UpperEnvelope& envelope) const {
    std::vector<ProfileSegment> profile;
    const Span span = frame_.pass(y);
    slice_row(offset_, items, y, {span.x0, span.x1}, budget_.chord, profile);
    envelope.take(profile);
    return profile;
  }

  // The passes of block b, and the strips between them and up to the next block.
  Block plan_block(const StripPieces& pieces, std::size_t b) const {
    Block out;
    UpperEnvelope envelope;
    const std::size_t begin = b * kPassesABlock, end = std::min(begin + kPassesABlock, ys_.size());
    // The last row may begin a block of its own, without a strip.
    const auto items = pieces.of(std::min(begin, ys_.size() - 2) / kPassesABlock);
    StripRefiner refiner(offset_, frame_, budget_.chord, limit_, least_, margin_, options_.outtol);
    std::optional<RowContacts> last;
    for (std::size_t j = begin; j < end || (j == end && end < ys_.size() && !options_.interval);
         ++j) {
      RowContacts contacts(offset_, ys_[j], row(items, ys_[j], envelope));
      if (j < end) {
        out.passes.push_back(fit_runs(contacts.profile(), budget_.below, budget_.above, join_));
      }
      if (last && !options_.interval) {
        std::vector<AddedRow> rows;
        refiner.refine(*last, contacts, items, rows);
        for (const AddedRow& added : rows) {
          for (PassRun& run : fit_runs(added.profile, budget_.below, budget_.above, join_)) {
            AddedRun tips{added.y, {}};
            for (const Vec2& p : run) tips.tips.emplace_back(p.x(), added.y, p.y() + budget_.grow);
            out.added.push_back(std::move(tips));
          }
        }
      }
      last.emplace(std::move(contacts));
    }
    out.unsettled = refiner.unsettled();
    return out;
  }

  // False where the pass cuts nothing.
  bool cut_pass(const std::vector<PassRun>& runs, double y, bool forward,
                PathJoiner& joiner) const {
    std::vector<Vec3> tips;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const PassRun& run = runs[forward ? r : runs.size() - 1 - r];
      tips.clear();
      for (const Vec2& p : run) tips.emplace_back(p.x(), y, p.y() + budget_.grow);
      if (!forward) std::reverse(tips.begin(), tips.end());
      joiner.cut(tips, r > 0 || options_.pattern == PathPattern::kOneway);
    }
    return !runs.empty();
  }

  void cut_regions(std::vector<std::vector<AddedRun>> regions, const PathStream& stream,
                   PathJoiner& joiner, PathReport& report) const {
    std::vector<AddedRun> runs;
    for (std::vector<AddedRun>& region : regions) {
      report.added_runs += region.size();
      std::move(region.begin(), region.end(), std::back_inserter(runs));
    }
    cut_nearest_first(std::move(runs), options_.pattern == PathPattern::kOneway, stream, joiner);
  }

  const TriangleMesh& mesh_;
  const OffsetSurface& offset_;
  const FrameDomain& frame_;
  const Budget& budget_;
  const PathOptions& options_;
  double join_, limit_ = 0, least_ = 0, margin_ = 0;
  std::vector<double> ys_;
};

}  // namespace

Result<PathReport> plan_drop_path(const TriangleMesh& mesh, double deviation,
                                  const std::array<double, 4>& domain, const PathOptions& options,
                                  ToolPath head, PathReceiver& receiver,
                                  const CompoundSurface* surface) {
  const Result<CutterShape> real = CutterShape::make(options.cutter);
  if (!real) return real.error();
  const Result<Budget> budget = budget_of(options, *real, deviation);
  if (!budget) return budget.error();
  const double grow = budget->grow;
  const CutterShape cutter =
      *CutterShape::make({2 * (real->radius() + grow), std::fmax(0, real->corner() + grow)});
  const OffsetSurface offset(mesh, cutter, options.angle);
  const FrameDomain frame(offset, domain);

  const Result<double> clearance = clearance_over(mesh, options, grow);
  if (!clearance) return clearance.error();
  head.cutter = options.cutter;
  head.intol = options.intol;
  head.outtol = options.outtol;
  head.clearance = *clearance;

  PathReport report;
  double size = 0;
  for (const Vec3& p : mesh.positions) size = std::fmax(size, p.cwiseAbs().maxCoeff());
  const double join = 1e-7 * (real->radius() + 1e-3 * size);
  DropPlanner planner(mesh, offset, frame, *budget, options, join);
  planner.place_passes(*real);
  double widest = 0;
  for (std::size_t k = 1; k < planner.ys().size(); ++k) {
    widest = std::fmax(widest, planner.ys()[k] - planner.ys()[k - 1]);
  }
  const TopGrid tops(offset, std::fmax(widest, real->radius() / 4));
  PathStream stream(offset, head, receiver, report);
  PathJoiner joiner(tops, grow, *clearance, 2 * widest + real->radius(), stream);
  const double limit = options.outtol + options.cusp.value_or(0);
  std::optional<PointDrop> drop;
  if (!options.interval) drop.emplace(offset);
  std::optional<SegmentProfile> profile;
  if (drop) {
    profile.emplace(offset, *drop, budget->chord);
    joiner.follow(*profile, budget->below);
  }
  std::optional<LeftOver> left;
  if (drop && surface != nullptr) {
    left.emplace(*surface, offset, *drop, *real, frame, left_over_limits(limit),
                 real->radius() / kLatticePart, options.threads);
  }
  // Where the domain is too large for that, strips that no bound settles are looked at more
  // closely. Only the corner's ball is held by its contact between passes.
  std::optional<DoubtfulPlaces> doubts;
  if (left && real->corner() >= limit && left->spacing() > 1.01 * real->radius() / kLatticePart) {
    doubts.emplace(*surface, offset, *drop, *real, frame, left_over_limits(limit),
                   real->radius() / kLatticePart, options.threads);
  }
  std::optional<ReachProof> reach;
  std::optional<UncutProof> proof;
  if (left && deviation < limit) {
    proof.emplace(mesh, offset, *real, frame, limit - deviation, options.threads);
    reach.emplace(*surface, offset, *drop, *real, frame, deviation);
    proof->tell_reach(*reach, out_of_reach(options.outtol, limit) + deviation);
  }
  if (left) {
    stream.watch([&](const Vec3& from, const Vec3& to) {
      left->cut(from, to);
      if (doubts) doubts->cut(from, to);
      if (proof) proof->cut(from, to);
    });
  }
  if (const Status done = planner.plan(joiner, stream, doubts ? &*doubts : nullptr, report);
      !done) {
    return done.error();
  }
  if (drop && !stream.failed()) {
    WallRunOptions walls;
    walls.below = budget->below;
    walls.above = budget->above;
    walls.chord = budget->chord;
    walls.least_depth = options.outtol;
    walls.domain = frame.corners();
    // Passes at a slant end at the domain's sides, and leave corners between them.
    const auto& corners = frame.corners();
    if (corners[0].y() != corners[1].y() && corners[0].x() != corners[1].x()) {
      for (std::size_t k = 0; k < 4; ++k) {
        const PlanLine side(corners[k], corners[(k + 1) % 4]);
        for (const PassRun& run :
             fit_runs(profile->take(corners[k], corners[(k + 1) % 4], kNoContact), budget->below,
                      budget->above, join)) {
          std::vector<Vec3> tips;
          for (const Vec2& p : run) {
            const Vec2 at = side.at(p.x());
            tips.emplace_back(at.x(), at.y(), p.y() + grow);
          }
          joiner.cut(tips, options.pattern == PathPattern::kOneway);
        }
      }
    }
    std::vector<AddedRun> along_walls;
    for (std::vector<Vec3>& run : wall_runs(mesh, offset, *drop, walls)) {
      ++report.wall_runs;
      for (Vec3& tip : run) tip.z() += grow;
      along_walls.push_back({run.front().y(), std::move(run)});
    }
    cut_nearest_first(std::move(along_walls), options.pattern == PathPattern::kOneway, stream,
                      joiner);
  }
  double worst = budget->below;
  if (!stream.failed() && left) {
    report.unsettled_area = 0;  // it is looked at instead
    const ClosingOptions closing{budget->below, budget->above / 2, grow,
                                 options.pattern == PathPattern::kOneway, options.threads};
    const auto close = [&](LeftOver& look) {
      worst = std::fmax(worst, close_left_over(look, *profile, closing, stream, joiner, report));
    };
    if (doubts) {
      for (LeftOver& look : doubts->looks()) close(look);
    }
    close(*left);
    tell_left_over(*left, report);
    if (doubts) {  // which see the same more closely
      PathReport closely;
      for (LeftOver& look : doubts->looks()) tell_left_over(look, closely);
      report.left_area = std::fmax(report.left_area, closely.left_area);
      report.left_height = std::fmax(report.left_height, closely.left_height);
    }
    if (proof) {
      worst = std::fmax(worst,
                        close_unproven(*proof, *left, *profile, closing, stream, joiner, report));
    }
  }
  joiner.finish();
  if (const Status done = stream.finish(); !done) return done.error();
  report.mesh_deviation = deviation;
  report.overcut_bound = worst - grow + budget->chord + deviation + budget->blend;
  report.undercut_bound = budget->above + grow + deviation + budget->blend;
  return report;
}

}  // namespace diesink
