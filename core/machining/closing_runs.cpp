// SPDX-License-Identifier: Apache-2.0
#include "core/machining/closing_runs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/machining/interference.h"
#include "core/machining/run_order.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr std::size_t kFirstStride = 16;  // rows of the lattice
// Where points lie between the rows, each time the worst of a cell is cut.
constexpr std::size_t kMostTimes = 16;
// What runs are put over for the proof's sake.
constexpr int kMostProofs = 4;

template <class Vec>
double distance_to_move(const Vec& p, const Vec& a, const Vec& b) {
  const Vec d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0;
  return (a + t * d - p).norm();
}

// The tips that straight moves keep close to the rest, and what makes those moves safe.
std::vector<Vec3> safe_run(const std::vector<Vec3>& tips, SegmentProfile& profile,
                           const ClosingOptions& options, double beside, double& worst) {
  std::vector<Vec3> out{tips.front()};
  for (std::size_t i = 0; i + 1 < tips.size();) {
    std::size_t next = i + 1;
    const auto close = [&](std::size_t k) {
      for (std::size_t m = i + 1; m < k; ++m) {
        if (distance_to_move(tips[m], tips[i], tips[k]) > options.above ||
            distance_to_move<Vec2>(tips[m].head<2>(), tips[i].head<2>(), tips[k].head<2>()) >
                beside) {
          return false;
        }
      }
      return true;
    };
    while (next + 1 < tips.size() && close(next + 1)) ++next;
    worst = std::fmax(worst, safe_move(tips[i], tips[next], profile, options.below, out));
    i = next;
  }
  return out;
}

// What a part of a facet is that is not proven, by its corners and its middle.
struct PartSeen {
  LeftOver::Seen most;
  bool high = false;  // more than the limit stays at one of them
  bool fits = false;  // and a cutter fits there
};

constexpr std::size_t kPartsABlock = 16;

// Where it is not asked what stands over a place.
constexpr double kUncut = std::numeric_limits<double>::infinity();

// The middle of a part, then its corners. The surface itself may be another there: beside a wall
// the mesh's foot may lie under the top.
CcContact contact_of(const UncutProof& proof, const FacetPart& part, std::size_t k) {
  return {k == 0 ? part.middle() : part.p[k - 1], proof.normal(part)};
}

// Those that a cutter may reach; the others are added to unreachable_area.
std::vector<FacetPart> in_reach(const std::vector<FacetPart>& parts, const UncutProof& proof,
                                const LeftOver& left, int threads, PathReport& report) {
  std::vector<std::uint8_t> out_of_reach(parts.size());
  parallel_blocks(parts.size(), kPartsABlock, threads,
                  [&](std::size_t begin, std::size_t end, int) {
                    for (std::size_t k = begin; k < end; ++k) {
                      const FacetPart& part = parts[k];
                      bool in = false;
                      for (std::size_t c = 0; c <= part.size && !in; ++c) {
                        in = left.fits_at(contact_of(proof, part, c), kUncut);
                      }
                      // Corners are of neighbours, too.
                      for (std::size_t c = 0; c < 2 && !in; ++c) {
                        const CcContact at = contact_of(proof, part, c);
                        in = left.falls_off_at(at.p.head<2>()) &&
                             left.see(at, proof.top(at.p.head<2>())).height > 0;
                      }
                      out_of_reach[k] = in ? 0 : 1;
                    }
                  });
  std::vector<FacetPart> in;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (out_of_reach[k] != 0) {
      report.unreachable_area += parts[k].area();
    } else {
      in.push_back(parts[k]);
    }
  }
  return in;
}

std::vector<PartSeen> look_at(const std::vector<FacetPart>& parts, const UncutProof& proof,
                              const LeftOver& left, int threads) {
  std::vector<PartSeen> seen(parts.size());
  parallel_blocks(parts.size(), kPartsABlock, threads,
                  [&](std::size_t begin, std::size_t end, int) {
                    for (std::size_t k = begin; k < end; ++k) {
                      const FacetPart& part = parts[k];
                      // The highest where a cutter fits, else the highest.
                      double most = 0, highest = 0;
                      CcContact worst;
                      for (std::size_t c = 0; c <= part.size; ++c) {
                        const CcContact at = contact_of(proof, part, c);
                        const double top = proof.top(at.p.head<2>());
                        if (proof.keeps(part, at.p, top)) continue;
                        const double stays = (top - at.p.z()) * at.n.z();
                        const bool fits = left.fits_at(at, top);
                        if (seen[k].high && (seen[k].fits && !fits)) continue;
                        if (seen[k].high && fits == seen[k].fits && !(stays > most)) continue;
                        seen[k].high = true;
                        seen[k].fits = fits;
                        most = stays;
                        worst = at;
                        highest = top;
                      }
                      if (seen[k].high) seen[k].most = left.see(worst, highest);
                    }
                  });
  return seen;
}

void tell_unproven(const std::vector<FacetPart>& parts, const std::vector<PartSeen>& seen,
                   const LeftOver& left, PathReport& report) {
  double over = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const double height = seen[k].most.height;
    if (height > left.limits().limit) {
      over += parts[k].area();
      report.left_height = std::fmax(report.left_height, height);
    } else if (height > 0 || seen[k].fits || !seen[k].high) {
      report.unsettled_area += parts[k].area();
    } else {
      report.unreachable_area += parts[k].area();
    }
  }
  report.left_area = std::fmax(report.left_area, over);  // the lattice sees the same
}

}  // namespace

double close_left_over(LeftOver& left, SegmentProfile& profile, const ClosingOptions& options,
                       const PathStream& stream, PathJoiner& joiner, PathReport& report) {
  double worst = 0;
  std::size_t again = 0;
  for (std::size_t stride = kFirstStride; again < kMostTimes;
       stride = std::max(stride / 2, std::size_t{1})) {
    if (stride == 1) ++again;
    std::vector<AddedRun> runs;
    for (const std::vector<Vec3>& tips : left.open_runs(stride)) {
      AddedRun run{tips.front().y(), safe_run(tips, profile, options, left.beside_run(), worst)};
      for (Vec3& tip : run.tips) tip.z() += options.lift;
      runs.push_back(std::move(run));
    }
    if (runs.empty() && stride == 1) break;
    report.closing_runs += runs.size();
    cut_nearest_first(std::move(runs), options.oneway, stream, joiner);
  }
  return worst;
}

double close_unproven(UncutProof& proof, LeftOver& left, SegmentProfile& profile,
                      const ClosingOptions& options, const PathStream& stream, PathJoiner& joiner,
                      PathReport& report) {
  double worst = 0;
  std::vector<FacetPart> parts =
      in_reach(proof.unproven(proof.all(), [&](const Vec2& at) { return left.stands_near(at); }),
               proof, left, options.threads, report);
  for (int times = 0;; ++times) {
    parts = proof.unproven(parts, {});
    const std::vector<PartSeen> seen = look_at(parts, proof, left, options.threads);
    const bool last = times == kMostProofs;
    std::vector<std::vector<Vec3>> runs;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (!(seen[k].most.height > 0)) continue;
      const Vec3& tip = seen[k].most.tip;
      const bool goes_on = !runs.empty() && (runs.back().back() - tip).norm() <= 4 * left.spacing();
      if (!goes_on) runs.emplace_back();
      runs.back().push_back(tip);
    }
    if (runs.empty() || last) {
      tell_unproven(parts, seen, left, report);
      return worst;
    }
    std::vector<AddedRun> added;
    for (const std::vector<Vec3>& tips : runs) {
      AddedRun run{tips.front().y(), safe_run(tips, profile, options, left.beside_run(), worst)};
      for (Vec3& tip : run.tips) tip.z() += options.lift;
      added.push_back(std::move(run));
    }
    report.closing_runs += added.size();
    cut_nearest_first(std::move(added), options.oneway, stream, joiner);
  }
}

void tell_left_over(LeftOver& left, PathReport& report) {
  const LeftOver::Rest rest = left.rest();
  report.left_area += rest.area;
  report.unsettled_area += rest.unsettled;
  report.left_height = std::fmax(report.left_height, rest.height);
  report.left_spacing = std::fmax(report.left_spacing, left.spacing());
}

}  // namespace diesink
