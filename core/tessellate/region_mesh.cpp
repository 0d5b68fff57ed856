// Rounds: every region refines by itself, then the arcs that any of them wants split are split for
// both sides. Source: Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh
// generation", 1995, with the segments shared by independent triangulations.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/region_mesh.h"

#include <algorithm>
#include <memory>
#include <numeric>

#include "core/parallel.h"
#include "core/tessellate/floor_border.h"
#include "core/tessellate/region_mesher.h"

namespace diesink {

Result<std::vector<RegionMesh>> mesh_regions(const CompoundSurface::Impl& surface,
                                             const Arrangement& arrangement, ArcSamples& samples,
                                             const RegionOptions& options) {
  const TriangleDeviation deviation(surface);
  std::vector<std::unique_ptr<RegionMesher>> regions;
  std::vector<std::uint32_t> region_of;
  for (std::uint32_t k = 0; k < arrangement.regions.size(); ++k) {
    const Label label = arrangement.regions[k].label;
    if (label == kNoLabel) continue;
    if (options.skip_base &&
        surface.steps[surface.step_of_row[static_cast<std::size_t>(row_of(label))]].solid < 0)
      continue;
    region_of.push_back(k);
    regions.push_back(
        std::make_unique<RegionMesher>(surface, arrangement, samples, deviation, options, k));
  }
  std::vector<std::vector<std::uint32_t>> users(arrangement.arcs.size());
  for (std::uint32_t r = 0; r < regions.size(); ++r) {
    for (const auto& loop : arrangement.regions[region_of[r]].loops) {
      for (const ArcUse& use : loop) {
        if (users[use.arc].empty() || users[use.arc].back() != r) users[use.arc].push_back(r);
      }
    }
  }
  std::vector<std::vector<RegionMesher::Chord>> asked(regions.size());
  // Regions of the round: those not yet done, or with a segment that has changed. The heaviest come
  // first, lest one thread be left alone with them.
  std::vector<std::uint32_t> heaviest_first(regions.size());
  std::iota(heaviest_first.begin(), heaviest_first.end(), 0U);
  std::vector<double> weight;
  for (const std::unique_ptr<RegionMesher>& region : regions) weight.push_back(region->weight());
  std::stable_sort(heaviest_first.begin(), heaviest_first.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return weight[a] > weight[b]; });
  std::vector<std::uint32_t> active = heaviest_first;
  std::vector<char> touched(regions.size());
  std::vector<char> to_build(regions.size(), 1);
  std::vector<std::size_t> crossings(regions.size(), 0);
  std::size_t floor_crossings = 0;
  bool any_build = true, given_up = false;
  // Chords that cross are split down to the distance at which points are told apart at all.
  const double least = 1e-9 * surface.size;
  for (int round = 0; round < options.rounds + 40; ++round) {
    const bool refining = round < options.rounds;
    parallel_blocks(active.size(), 1, options.threads,
                    [&](std::size_t begin, std::size_t end, int) {
                      for (std::size_t k = begin; k < end; ++k) {
                        const std::uint32_t r = active[k];
                        asked[r].clear();
                        // Twice where refining finds that another way has to be taken.
                        do {
                          if (to_build[r] || regions[r]->broken()) {
                            asked[r] = regions[r]->build();
                            to_build[r] = !asked[r].empty() ? 1 : 0;
                          }
                          if (!to_build[r]) asked[r] = regions[r]->refine();
                        } while (regions[r]->broken());
                      }
                    });
    // Borders that truly overlap would be split for ever, and where none of the chords that cross
    // can be split any more, the next round would find the same.
    const auto is_hopeless = [&](const std::vector<RegionMesher::Chord>& chords,
                                 std::size_t crossings_so_far) {
      return crossings_so_far > options.crossings ||
             std::none_of(chords.begin(), chords.end(), [&](const RegionMesher::Chord& chord) {
               return samples.can_split(chord[0], chord[1], least);
             });
    };
    for (std::size_t r = 0; r < regions.size(); ++r) {
      if (!to_build[r]) continue;
      crossings[r] += asked[r].size();
      if (!is_hopeless(asked[r], crossings[r])) continue;
      asked[r].clear();
      if (options.to_the_end && regions[r]->lay_in_plan()) {
        crossings[r] = 0;
        continue;
      }
      given_up = true;
      to_build[r] = 0;
    }
    if (given_up && !options.to_the_end) break;
    bool split_any = false;
    std::fill(touched.begin(), touched.end(), 0);
    // Splits a chord for all regions beside it; false where it is too short or stays.
    const auto split = [&](const RegionMesher::Chord& chord, double shortest,
                           const ArcSamples::Aim& aim) {
      const ArcSamples::Split made = samples.split(chord[0], chord[1], shortest, aim);
      if (made.point == ArcSamples::kNone) return false;
      for (const std::uint32_t user : users[made.arc]) {
        regions[user]->take_split(chord, made.point);
        touched[user] = 1;
        if (regions[user]->broken()) to_build[user] = 1;
      }
      return true;
    };
    const std::vector<char> building = to_build;  // as it was asked: a split may break a region
    for (std::size_t r = 0; r < regions.size(); ++r) {
      // Nor does it help to split on and on where borders overlap in plan alone.
      const bool turned = !building[r] && regions[r]->urgent();
      if (turned) crossings[r] += asked[r].size();
      const bool urgent = building[r] || (turned && crossings[r] <= options.crossings);
      for (const RegionMesher::Chord& chord : asked[r]) {
        split_any = true;
        if ((refining || urgent) && split(chord, urgent ? least : options.shortest,
                                          {regions[r]->label(), regions[r]->aim_of(chord)}))
          continue;
        // Too short, or split already by the other side: a kept segment is told to both.
        regions[r]->keep(chord);
        touched[r] = 1;
      }
    }
    any_build = std::any_of(to_build.begin(), to_build.end(), [](char b) { return b != 0; });
    if (!split_any && !any_build && options.floor) {
      const std::vector<RegionMesher::Chord> crossing =
          crossings_of_floor(floor_border(arrangement, samples));
      floor_crossings += crossing.size();
      if (!crossing.empty() && is_hopeless(crossing, floor_crossings)) {
        given_up = true;
        break;
      }
      for (const RegionMesher::Chord& chord : crossing) {
        if (split(chord, least, {})) split_any = true;
      }
      any_build = std::any_of(to_build.begin(), to_build.end(), [](char b) { return b != 0; });
    }
    if (!split_any && !any_build) break;
    active.clear();
    for (const std::uint32_t r : heaviest_first) {
      if (touched[r] || to_build[r]) active.push_back(r);
    }
  }
  if (any_build || given_up) {
    return Error{ErrorCode::kInput,
                 "the border of a surface element crosses itself at the least distance: the part "
                 "is finer than its coordinates can tell",
                 {surface.program.file}};
  }
  std::vector<RegionMesh> meshes(regions.size());
  parallel_blocks(regions.size(), 1, options.threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t r = heaviest_first[k];
      meshes[r] = regions[r]->finish();
      regions[r].reset();  // its triangulation is several times as large
    }
  });
  return meshes;
}

}  // namespace diesink
