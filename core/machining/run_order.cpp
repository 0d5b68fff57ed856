// SPDX-License-Identifier: Apache-2.0
#include "core/machining/run_order.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diesink {
namespace {

// One end of a run, where cutting it may begin.
struct Entry {
  Vec3 at;
  std::uint32_t run = 0;
  bool turned = false;
};

}  // namespace

void cut_nearest_first(std::vector<AddedRun> runs, bool oneway, const PathStream& stream,
                       PathJoiner& joiner) {
  std::vector<Entry> entries;
  for (std::uint32_t k = 0; k < runs.size(); ++k) {
    entries.push_back({runs[k].tips.front(), k, false});
    if (!oneway) entries.push_back({runs[k].tips.back(), k, true});
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& p, const Entry& q) { return p.at.y() < q.at.y(); });
  std::vector<std::uint8_t> done(runs.size(), 0);
  for (std::size_t left = runs.size(); left > 0; --left) {
    const Vec3 from = stream.empty() ? entries.front().at : stream.last();
    const auto middle = std::partition_point(entries.begin(), entries.end(),
                                             [&](const Entry& e) { return e.at.y() < from.y(); });
    // Outward from here in y, until no nearer one can come.
    double best = std::numeric_limits<double>::infinity();
    const Entry* next = nullptr;
    const auto look = [&](const Entry& e) {
      if (std::fabs(e.at.y() - from.y()) > best) return false;
      if (done[e.run]) return true;
      const double far = (e.at - from).norm();
      if (far < best || (far == best && &e < next)) {
        best = far;
        next = &e;
      }
      return true;
    };
    for (auto e = middle; e != entries.end() && look(*e);) ++e;
    for (auto e = middle; e != entries.begin() && look(*(e - 1));) --e;
    done[next->run] = 1;
    std::vector<Vec3>& tips = runs[next->run].tips;
    if (next->turned) std::reverse(tips.begin(), tips.end());
    joiner.cut(tips, oneway);
    // What is done must not be looked over again and again.
    if (left % 64 == 0) std::erase_if(entries, [&](const Entry& e) { return done[e.run] != 0; });
  }
}

}  // namespace diesink
