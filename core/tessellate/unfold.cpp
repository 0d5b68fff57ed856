// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/unfold.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "core/pair_key.h"

namespace diesink {
namespace {

using Corners = std::array<std::uint32_t, 3>;

// Rings of neighbours that are dug out at most, and triangles of a patch.
constexpr int kRings = 6;
constexpr std::size_t kMostTriangles = 400;
// Passes of flips over a patch at most.
constexpr int kPasses = 20;

// Twice the area in plan; 0 where rounding could turn it.
double turn(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double left = (b.x() - a.x()) * (c.y() - a.y());
  const double right = (b.y() - a.y()) * (c.x() - a.x());
  const double det = left - right;
  return std::fabs(det) > 0x1p-50 * (std::fabs(left) + std::fabs(right)) ? det : 0;
}

// A patch of the plan: a loop of vertices and others inside it, triangulated.
class Patch {
 public:
  Patch(const std::vector<Vec3>& positions, const UnfoldRules& rules)
      : positions_(positions), rules_(rules) {}

  // False where that does not go.
  bool lay(std::vector<std::uint32_t> loop, const std::vector<std::uint32_t>& inner) {
    triangles.clear();
    if (!clip_ears(std::move(loop))) return false;
    return std::all_of(inner.begin(), inner.end(), [&](std::uint32_t v) { return insert(v); });
  }

  // Flips edges while the larger bound of their two triangles falls.
  void flip() {
    for (int pass = 0; pass < kPasses; ++pass) {
      bool any = false;
      for (std::size_t t = 0; t < triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) any = flip(t, k) || any;
      }
      if (!any) return;
    }
  }

  [[nodiscard]] double worst() const {
    double most = 0;
    for (const Corners& t : triangles) most = std::fmax(most, rules_.bound(t[0], t[1], t[2]));
    return most;
  }

  std::vector<Corners> triangles;

 private:
  [[nodiscard]] double turn_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return turn(positions_[a], positions_[b], positions_[c]);
  }
  [[nodiscard]] bool is_right(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return turn_of(a, b, c) > 0 && !rules_.is_wrong(a, b, c);
  }
  [[nodiscard]] bool covers(const Corners& t, std::uint32_t v) const {
    return turn_of(t[0], t[1], v) >= 0 && turn_of(t[1], t[2], v) >= 0 &&
           turn_of(t[2], t[0], v) >= 0;
  }

  // Always the ear with the least bound.
  bool clip_ears(std::vector<std::uint32_t> loop) {
    while (loop.size() >= 3) {
      const std::size_t n = loop.size();
      std::size_t best = n;
      double least = 0;
      for (std::size_t k = 0; k < n; ++k) {
        const Corners ear{loop[(k + n - 1) % n], loop[k], loop[(k + 1) % n]};
        if (!is_right(ear[0], ear[1], ear[2])) continue;
        bool empty = true;
        for (std::size_t j = 0; j < n && empty; ++j) {
          if (std::find(ear.begin(), ear.end(), loop[j]) == ear.end())
            empty = !covers(ear, loop[j]);
        }
        if (!empty) continue;
        const double bound = rules_.bound(ear[0], ear[1], ear[2]);
        if (best == n || bound < least) {
          best = k;
          least = bound;
        }
      }
      if (best == n) return false;
      triangles.push_back({loop[(best + n - 1) % n], loop[best], loop[(best + 1) % n]});
      loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(best));
      if (loop.size() == 2) return true;
    }
    return false;
  }

  bool insert(std::uint32_t v) {
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const Corners c = triangles[t];
      if (!covers(c, v)) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        if (turn_of(c[k], c[(k + 1) % 3], v) == 0) return split_edge(t, k, v);
      }
      for (std::size_t k = 0; k < 3; ++k) {
        if (!is_right(c[k], c[(k + 1) % 3], v)) return false;
      }
      triangles[t] = {c[0], c[1], v};
      triangles.push_back({c[1], c[2], v});
      triangles.push_back({c[2], c[0], v});
      return true;
    }
    return false;
  }

  bool split_edge(std::size_t t, std::size_t k, std::uint32_t v) {
    const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3],
                        c = triangles[t][(k + 2) % 3];
    std::size_t other = 0, side = 0;
    if (!across(a, b, other, side)) return false;
    const std::uint32_t d = triangles[other][(side + 2) % 3];
    const Corners parts[4] = {{a, v, c}, {v, b, c}, {b, v, d}, {v, a, d}};
    for (const Corners& p : parts) {
      if (!is_right(p[0], p[1], p[2])) return false;
    }
    triangles[t] = parts[0];
    triangles[other] = parts[2];
    triangles.push_back(parts[1]);
    triangles.push_back(parts[3]);
    return true;
  }

  // The triangle on the other side of the edge from a to b, and its side from b to a.
  bool across(std::uint32_t a, std::uint32_t b, std::size_t& other, std::size_t& side) const {
    for (other = 0; other < triangles.size(); ++other) {
      for (side = 0; side < 3; ++side) {
        if (triangles[other][side] == b && triangles[other][(side + 1) % 3] == a) return true;
      }
    }
    return false;
  }

  bool flip(std::size_t t, std::size_t k) {
    const Corners one = triangles[t];
    const std::uint32_t a = one[k], b = one[(k + 1) % 3], c = one[(k + 2) % 3];
    std::size_t other = 0, side = 0;
    if (!across(a, b, other, side)) return false;
    const Corners two = triangles[other];
    const std::uint32_t d = two[(side + 2) % 3];
    if (!is_right(a, d, c) || !is_right(d, b, c)) return false;
    const double before =
        std::fmax(rules_.bound(one[0], one[1], one[2]), rules_.bound(two[0], two[1], two[2]));
    const double after = std::fmax(rules_.bound(a, d, c), rules_.bound(d, b, c));
    if (!(after < before * (1 - 1e-9))) return false;
    triangles[t] = {a, d, c};
    triangles[other] = {d, b, c};
    return true;
  }

  const std::vector<Vec3>& positions_;
  const UnfoldRules& rules_;
};

class Unfolder {
 public:
  Unfolder(const std::vector<Vec3>& positions, const UnfoldRules& rules,
           std::vector<Corners>& triangles)
      : positions_(positions), rules_(rules), triangles_(triangles) {}

  void run() {
    std::vector<std::uint32_t> wrong;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      if (is_wrong(t)) wrong.push_back(t);
    }
    if (wrong.empty()) return;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) add(t);
    for (const std::uint32_t t : wrong) {
      if (is_wrong(t)) dig(t);
    }
  }

 private:
  [[nodiscard]] bool is_wrong(std::uint32_t t) const {
    const Corners& c = triangles_[t];
    return rules_.is_wrong(c[0], c[1], c[2]);
  }
  void add(std::uint32_t t) {
    const Corners& c = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) {
      side_of_[pair_key(c[k], c[(k + 1) % 3])] = t;
      around_[c[k]].push_back(t);
    }
  }
  void remove(std::uint32_t t) {
    const Corners& c = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) {
      side_of_.erase(pair_key(c[k], c[(k + 1) % 3]));
      std::erase(around_[c[k]], t);
    }
  }

  void dig(std::uint32_t seed);
  [[nodiscard]] bool loop_of(const std::vector<std::uint32_t>& hole,
                             std::vector<std::uint32_t>& loop) const;

  const std::vector<Vec3>& positions_;
  const UnfoldRules& rules_;
  std::vector<Corners>& triangles_;
  std::unordered_map<std::uint64_t, std::uint32_t> side_of_;  // triangle on the left of a side
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> around_;
};

// The vertices round a set of triangles, if that is one loop that runs through none twice.
bool Unfolder::loop_of(const std::vector<std::uint32_t>& hole,
                       std::vector<std::uint32_t>& loop) const {
  const std::unordered_set<std::uint32_t> in(hole.begin(), hole.end());
  std::unordered_map<std::uint32_t, std::uint32_t> next;
  std::uint32_t first = 0;
  for (const std::uint32_t t : hole) {
    const Corners& c = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto twin = side_of_.find(pair_key(c[(k + 1) % 3], c[k]));
      if (twin != side_of_.end() && in.contains(twin->second)) continue;
      if (!next.emplace(c[k], c[(k + 1) % 3]).second) return false;
      first = c[k];
    }
  }
  loop.clear();
  std::uint32_t v = first;
  do {
    loop.push_back(v);
    const auto step = next.find(v);
    if (step == next.end()) return false;
    v = step->second;
  } while (v != first && loop.size() <= next.size());
  return loop.size() == next.size();
}

// Ring by ring, until the patch can be laid anew.
void Unfolder::dig(std::uint32_t seed) {
  std::vector<std::uint32_t> hole{seed}, loop, inner;
  Patch patch(positions_, rules_);
  for (int ring = 0; ring < kRings; ++ring) {
    // First what shares a side with the seed, then all that touches the hole.
    std::vector<std::uint32_t> grown = hole;
    for (const std::uint32_t t : hole) {
      const Corners& c = triangles_[t];
      for (std::size_t k = 0; k < 3; ++k) {
        if (ring > 0) {
          const std::vector<std::uint32_t>& near = around_.at(c[k]);
          grown.insert(grown.end(), near.begin(), near.end());
        } else if (const auto twin = side_of_.find(pair_key(c[(k + 1) % 3], c[k]));
                   twin != side_of_.end()) {
          grown.push_back(twin->second);
        }
      }
    }
    hole = std::move(grown);
    std::sort(hole.begin(), hole.end());
    hole.erase(std::unique(hole.begin(), hole.end()), hole.end());
    if (hole.size() > kMostTriangles) return;
    if (!loop_of(hole, loop)) continue;
    inner.clear();
    double before = 0;
    for (const std::uint32_t t : hole) {
      const Corners& c = triangles_[t];
      before = std::fmax(before, rules_.bound(c[0], c[1], c[2]));
      for (const std::uint32_t v : c) {
        if (std::find(loop.begin(), loop.end(), v) == loop.end()) inner.push_back(v);
      }
    }
    std::sort(inner.begin(), inner.end());
    inner.erase(std::unique(inner.begin(), inner.end()), inner.end());
    if (!patch.lay(loop, inner) || patch.triangles.size() != hole.size()) continue;
    patch.flip();
    if (!(patch.worst() <= std::fmax(rules_.tolerance, before))) continue;
    for (const std::uint32_t t : hole) remove(t);
    for (std::size_t k = 0; k < hole.size(); ++k) {
      triangles_[hole[k]] = patch.triangles[k];
      add(hole[k]);
    }
    return;
  }
}

}  // namespace

void unfold(const std::vector<Vec3>& positions, const UnfoldRules& rules,
            std::vector<std::array<std::uint32_t, 3>>& triangles) {
  Unfolder(positions, rules, triangles).run();
}

}  // namespace diesink
