// SPDX-License-Identifier: Apache-2.0
#include "core/machining/closing_runs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

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

// Where it is not asked what stands over a place.
constexpr double kUncut = std::numeric_limits<double>::infinity();

// What a part of a facet is that is not proven, by its corners and its middle.
struct PartSeen {
  LeftOver::Seen most;
  bool high = false;  // more than the limit stays at one of them
  bool fits = false;  // and a cutter fits there
};

constexpr std::size_t kPartsABlock = 16;

// The middle of a part, then its corners. The surface itself may be another there: beside a wall
// the mesh's foot may lie under the top.
CcContact contact_of(const UncutProof& proof, const FacetPart& part, std::size_t k) {
  return {k == 0 ? part.middle() : part.p[k - 1], proof.normal(part)};
}

// Those that a cutter may reach; the others go to `narrow`.
std::vector<FacetPart> in_reach(const std::vector<FacetPart>& parts, const UncutProof& proof,
                                const LeftOver& left, int threads, std::vector<FacetPart>& narrow) {
  std::vector<std::uint8_t> reached(parts.size());
  parallel_blocks(parts.size(), kPartsABlock, threads,
                  [&](std::size_t begin, std::size_t end, int) {
                    for (std::size_t k = begin; k < end; ++k) {
                      const FacetPart& part = parts[k];
                      bool in = part.from.has_value();
                      for (std::size_t c = 0; c <= part.size && !in; ++c) {
                        in = left.fits_at(contact_of(proof, part, c), kUncut);
                      }
                      // Corners are of neighbours, too.
                      for (std::size_t c = 0; c < 2 && !in; ++c) {
                        const CcContact at = contact_of(proof, part, c);
                        in = left.falls_off_at(at.p.head<2>()) &&
                             left.see(at, proof.top(at.p.head<2>())).height > 0;
                      }
                      reached[k] = in ? 1 : 0;
                    }
                  });
  std::vector<FacetPart> in;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    (reached[k] != 0 ? in : narrow).push_back(parts[k]);
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

// Tips by the cells of a plan grid.
class TipGrid {
 public:
  explicit TipGrid(double cell) : per_(1 / cell) {}
  void add(const Vec3& tip, std::size_t number) { cells_[cell_of(tip, 0, 0)].push_back(number); }
  // Calls see(number) for those in the cells around a place until it returns true.
  template <class See>
  bool any_near(const Vec3& at, const See& see) const {
    for (const long dj : {-1L, 0L, 1L}) {
      for (const long di : {-1L, 0L, 1L}) {
        const auto cell = cells_.find(cell_of(at, di, dj));
        if (cell != cells_.end() && std::ranges::any_of(cell->second, see)) return true;
      }
    }
    return false;
  }

 private:
  [[nodiscard]] std::array<long, 2> cell_of(const Vec3& at, long di, long dj) const {
    return {std::lround(at.x() * per_) + di, std::lround(at.y() * per_) + dj};
  }
  double per_;
  std::map<std::array<long, 2>, std::vector<std::size_t>> cells_;
};

// Of the tips from which parts are known to be in reach so many that each part is kept by one.
std::vector<Vec3> pencil_tips(const std::vector<FacetPart>& parts, const UncutProof& proof,
                              double cell) {
  TipGrid taken(cell);
  std::vector<Vec3> tips;
  for (const FacetPart& part : parts) {
    if (!part.from) continue;
    if (taken.any_near(*part.from,
                       [&](std::size_t tip) { return proof.kept_from(part, tips[tip]); }))
      continue;
    taken.add(*part.from, tips.size());
    tips.push_back(*part.from);
  }
  return tips;
}

// Chains of them, each next one the nearest no further off than `far`.
std::vector<std::vector<Vec3>> chained(const std::vector<Vec3>& tips, double far) {
  TipGrid grid(far);
  for (std::size_t k = 0; k < tips.size(); ++k) grid.add(tips[k], k);
  std::vector<bool> used(tips.size());
  const auto nearest = [&](const Vec3& from) {
    std::size_t best = tips.size();
    double least = far;
    grid.any_near(from, [&](std::size_t k) {
      const double off = (tips[k] - from).norm();
      if (!used[k] && off < least) {
        least = off;
        best = k;
      }
      return false;  // all of them
    });
    return best;
  };
  std::vector<std::vector<Vec3>> runs;
  for (std::size_t k = 0; k < tips.size(); ++k) {
    if (used[k]) continue;
    std::vector<Vec3> run;
    // Both ways from here.
    for (int way = 0; way < 2; ++way) {
      for (std::size_t next = way == 0 ? k : nearest(tips[k]); next < tips.size();
           next = nearest(tips[next])) {
        used[next] = true;
        run.push_back(tips[next]);
      }
      std::reverse(run.begin(), run.end());
    }
    runs.push_back(std::move(run));
  }
  return runs;
}

void tell_unproven(const std::vector<FacetPart>& parts, const std::vector<PartSeen>& seen,
                   const LeftOver& left, PathReport& report) {
  double over = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const double height = seen[k].most.height;
    if (height > left.limits().limit) {
      over += parts[k].area();
      report.left_height = std::fmax(report.left_height, height);
    } else if (height > 0 || seen[k].fits || !seen[k].high || parts[k].from) {
      report.unsettled_area += parts[k].area();
    } else {
      report.unreachable_area += parts[k].area();
      report.unproven_area += parts[k].area();
    }
  }
  report.left_area = std::fmax(report.left_area, over);  // the lattice sees the same
}

// Out of reach, yet a cutter that stands free holds what stands there deeper than may stay: beside
// a wall a path may leave far more than it has to. Keeps such parts, and tells from where.
std::vector<Vec3> held_from_beside(std::vector<FacetPart>& parts, const UncutProof& proof,
                                   const LeftOver& left, int threads) {
  std::vector<std::optional<Vec3>> found(parts.size());
  parallel_blocks(parts.size(), kPartsABlock, threads,
                  [&](std::size_t begin, std::size_t end, int) {
                    for (std::size_t k = begin; k < end; ++k) {
                      double most = 0;
                      // Corners are of neighbours, too.
                      for (std::size_t c = 0; c < 2; ++c) {
                        const CcContact at = contact_of(proof, parts[k], c);
                        if (!left.falls_off_at(at.p.head<2>())) continue;
                        const LeftOver::Seen seen = left.see(at, proof.top(at.p.head<2>()));
                        if (!(seen.height > most)) continue;
                        most = seen.height;
                        found[k] = seen.tip;
                      }
                    }
                  });
  std::vector<Vec3> tips;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (!found[k]) continue;
    tips.push_back(*found[k]);
    parts[kept++] = parts[k];
  }
  parts.resize(kept);
  return tips;
}

double area_of(const std::vector<FacetPart>& parts) {
  double sum = 0;
  for (const FacetPart& part : parts) sum += part.area();
  return sum;
}

// Those that lie together as one run.
void add_tips(const std::vector<Vec3>& tips, double spacing, std::vector<std::vector<Vec3>>& runs) {
  for (const Vec3& tip : tips) {
    const bool goes_on = !runs.empty() && (runs.back().back() - tip).norm() <= 4 * spacing;
    if (!goes_on) runs.emplace_back();
    runs.back().push_back(tip);
  }
}

// Through the tips from which parts are known to be in reach, else over the highest that is seen.
std::vector<std::vector<Vec3>> runs_over(const std::vector<FacetPart>& parts,
                                         const std::vector<PartSeen>& seen, const UncutProof& proof,
                                         double spacing) {
  std::vector<std::vector<Vec3>> runs = chained(pencil_tips(parts, proof, spacing), 4 * spacing);
  std::vector<Vec3> tips;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (!parts[k].from && seen[k].most.height > 0) tips.push_back(seen[k].most.tip);
  }
  add_tips(tips, spacing, runs);
  return runs;
}

// Of what no cutter is known to reach, most is proven to be out of reach or kept after all.
void tell_narrow(const UncutProof::Unproven& narrow, PathReport& report) {
  const double unproven = area_of(narrow.open);
  report.unreachable_area += area_of(narrow.out) + unproven;
  report.unproven_area += unproven;
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
  ClosingOptions exact = options;
  exact.above = 0;  // each tip is needed where it is
  UncutProof::Unproven found =
      proof.unproven(proof.all(), [&](const Vec2& at) { return left.stands_near(at); });
  std::vector<FacetPart> out = std::move(found.out);
  report.unreachable_area += area_of(out);
  std::vector<FacetPart> narrow;  // no cutter is known to come low enough over these
  std::vector<FacetPart> parts = in_reach(found.open, proof, left, options.threads, narrow);
  for (int times = 0;; ++times) {
    found = proof.unproven(parts, {});
    report.unreachable_area += area_of(found.out);
    out.insert(out.end(), found.out.begin(), found.out.end());
    parts = std::move(found.open);
    const std::vector<PartSeen> seen = look_at(parts, proof, left, options.threads);
    std::vector<std::vector<Vec3>> runs = runs_over(parts, seen, proof, left.spacing());
    if (times < kMostProofs) {
      add_tips(held_from_beside(out, proof, left, options.threads), left.spacing(), runs);
    }
    if (runs.empty() || times == kMostProofs) {
      tell_unproven(parts, seen, left, report);
      tell_narrow(proof.unproven(narrow, {}), report);
      report.unreachable_height = left.highest_out_of_reach();
      return worst;
    }
    std::vector<AddedRun> added;
    for (const std::vector<Vec3>& tips : runs) {
      AddedRun run{tips.front().y(), safe_run(tips, profile, exact, left.beside_run(), worst)};
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
