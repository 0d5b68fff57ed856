// SPDX-License-Identifier: Apache-2.0
#include "core/machining/closing_runs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/machining/interference.h"
#include "core/machining/run_order.h"

namespace diesink {
namespace {

constexpr std::size_t kFirstStride = 16;  // rows of the lattice
// Where points lie between the rows, each time the worst of a cell is cut.
constexpr std::size_t kMostTimes = 16;

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

void tell_left_over(LeftOver& left, PathReport& report) {
  const LeftOver::Rest rest = left.rest();
  report.left_area += rest.area;
  report.unsettled_area += rest.unsettled;
  report.left_height = std::fmax(report.left_height, rest.height);
  report.left_spacing = std::fmax(report.left_spacing, left.spacing());
}

}  // namespace diesink
