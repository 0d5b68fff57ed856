// Source: Choi et al. 1988, overall procedure (g) and Fig. 8: repeated midpoint sampling.
// SPDX-License-Identifier: Apache-2.0
#include "core/grid/edges.h"

#include <algorithm>
#include <cmath>

#include "core/compound/compound_impl.h"
#include "core/parallel.h"

namespace diesink {
namespace {

// Where in the grid a search is made.
struct GridPlace {
  bool along_x = true;
  std::uint32_t i = 0, j = 0;
};

class EdgeSearch {
 public:
  EdgeSearch(const CompoundSurface& surface, std::vector<EdgePair>& out)
      : surface_(surface), out_(out) {}

  void between(const Vec2& from, const Vec2& to, Label first, Label last, const GridPlace& place) {
    place_ = place;
    narrow(from, to, first, last);
  }

  [[nodiscard]] Label label_at(const Vec2& p) const {
    return surface_.impl().evaluate(p.x(), p.y()).label;
  }

 private:
  void narrow(Vec2 a, Vec2 b, Label la, Label lb) {
    while (true) {
      const Vec2 mid = 0.5 * (a + b);
      if (mid == a || mid == b) break;
      const Label lm = label_at(mid);
      if (lm == la) {
        a = mid;
      } else if (lm == lb) {
        b = mid;
      } else {
        narrow(a, mid, la, lm);
        a = mid;
        la = lm;
      }
    }
    add(a, b);
  }

  [[nodiscard]] EdgeSide side(const Vec2& p) const {
    EdgeSide out{p.x(), p.y(), surface_.at(p.x(), p.y()), kNoLabel};
    if (out.datum)
      out.label = make_label(out.datum->row, static_cast<std::uint32_t>(out.datum->face));
    return out;
  }

  void add(const Vec2& a, const Vec2& b) {
    const EdgeSide first = side(a), second = side(b);
    const EdgeKind kind = kind_of(first, second, (b - a).norm());
    out_.push_back({kind, place_.along_x, place_.i, place_.j, first, second});
  }

  [[nodiscard]] EdgeKind kind_of(const EdgeSide& a, const EdgeSide& b, double gap) const {
    if (!a.datum || !b.datum) return EdgeKind::kEdge;
    const auto slope = [](const CcDatum& d) {
      return std::hypot(d.n.x(), d.n.y()) / std::max(d.n.z(), 1e-300);
    };
    // A face rises over the gap by its slope, and beside its silhouette, where the slope grows
    // without end, by the root of the gap.
    const double steep = std::min(8 * gap * (slope(*a.datum) + slope(*b.datum)),
                                  std::sqrt(8 * surface_.size() * gap));
    const double explained = 16 * surface_.tie_tolerance() + steep;
    return std::fabs(a.datum->z - b.datum->z) > explained ? EdgeKind::kJump : EdgeKind::kCrease;
  }

  const CompoundSurface& surface_;
  std::vector<EdgePair>& out_;
  GridPlace place_;
};

}  // namespace

const char* name_of(EdgeKind kind) {
  switch (kind) {
    case EdgeKind::kCrease:
      return "crease";
    case EdgeKind::kEdge:
      return "edge";
    case EdgeKind::kJump:
      break;
  }
  return "jump";
}

void find_edges_between(const CompoundSurface& surface, const Vec2& from, const Vec2& to,
                        std::vector<EdgePair>& out) {
  EdgeSearch search(surface, out);
  const Label first = search.label_at(from), last = search.label_at(to);
  if (first != last) search.between(from, to, first, last, {});
}

std::vector<EdgePair> find_edges(const CompoundSurface& surface, const GridArray& grid,
                                 int threads) {
  const std::size_t columns = grid.columns(), rows = grid.rows();
  const std::vector<double>&xs = grid.x(), &ys = grid.y();
  const std::span<const Label> label = grid.label();
  // Along x for row j in list j, along y from row j to the next in list rows + j: joined in this
  // order.
  std::vector<std::vector<EdgePair>> found(2 * rows);
  parallel_blocks(rows, 4, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      EdgeSearch along_row(surface, found[j]), along_column(surface, found[rows + j]);
      for (std::size_t i = 0; i < columns; ++i) {
        const std::size_t at = j * columns + i;
        const Vec2 here(xs[i], ys[j]);
        GridPlace place{true, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)};
        if (i + 1 < columns && label[at] != label[at + 1]) {
          along_row.between(here, Vec2(xs[i + 1], ys[j]), label[at], label[at + 1], place);
        }
        if (j + 1 < rows && label[at] != label[at + columns]) {
          place.along_x = false;
          along_column.between(here, Vec2(xs[i], ys[j + 1]), label[at], label[at + columns], place);
        }
      }
    }
  });
  std::vector<EdgePair> out;
  std::size_t count = 0;
  for (const auto& list : found) count += list.size();
  out.reserve(count);
  for (auto& list : found) {
    std::move(list.begin(), list.end(), std::back_inserter(out));
    std::vector<EdgePair>().swap(list);
  }
  return out;
}

}  // namespace diesink
