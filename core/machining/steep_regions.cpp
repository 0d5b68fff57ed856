// SPDX-License-Identifier: Apache-2.0
#include "core/machining/steep_regions.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace diesink {

// Those that touch each other, by union and find over runs in the order of y.
std::vector<std::vector<AddedRun>> SteepRegions::grouped(std::vector<AddedRun> runs) const {
  std::sort(runs.begin(), runs.end(), [](const AddedRun& p, const AddedRun& q) {
    return p.y != q.y ? p.y < q.y : p.tips.front().x() < q.tips.front().x();
  });
  std::vector<std::size_t> parent(runs.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t k) {
    while (parent[k] != k) k = parent[k] = parent[parent[k]];
    return k;
  };
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for (std::size_t j = i; j-- > 0 && runs[i].y - runs[j].y <= gap_;) {
      if (runs[j].tips.front().x() > runs[i].tips.back().x() ||
          runs[j].tips.back().x() < runs[i].tips.front().x()) {
        continue;
      }
      const std::size_t a = root(i), b = root(j);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<std::vector<AddedRun>> regions;
  std::vector<std::size_t> place(runs.size());
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const std::size_t r = root(k);
    if (r == k) {
      place[k] = regions.size();
      regions.emplace_back();
    }
    regions[place[r]].push_back(std::move(runs[k]));
  }
  return regions;
}

std::vector<std::vector<AddedRun>> SteepRegions::finished(double reached, bool down) {
  std::vector<std::vector<AddedRun>> done;
  std::vector<AddedRun> open;
  for (std::vector<AddedRun>& region : grouped(std::move(runs_))) {
    const double end = down ? region.front().y - gap_ : region.back().y + gap_;
    if (down ? end > reached : end < reached) {
      done.push_back(std::move(region));
    } else {
      std::move(region.begin(), region.end(), std::back_inserter(open));
    }
  }
  runs_ = std::move(open);
  return done;
}

std::vector<std::vector<AddedRun>> SteepRegions::all() {
  std::vector<std::vector<AddedRun>> regions = grouped(std::move(runs_));
  runs_.clear();
  return regions;
}

}  // namespace diesink
