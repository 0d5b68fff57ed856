// Rasterizes the offset surface: every piece keeps the largest height in the rows it meets. Pieces
// of a fine mesh meet few points or none, so what counts is how little is done for one of them.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/lattice_drop.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/parallel.h"

namespace diesink {
namespace {

constexpr std::size_t kRowsABlock = 16;
constexpr std::size_t kPiecesAChunk = 8192;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Of the spacing: by this much regions are widened, beyond the rounding of columns.
constexpr double kWiden = 1e-9;
// Of a unit direction: what changes by less along a row does not change.
constexpr double kAlong = 1e-100;

struct Columns {
  double x0, dx, inv_dx;
  std::size_t count;

  // The columns in [a, b]; false where there are none. Casts, as floor and ceil are calls on a
  // processor without SSE4.1.
  bool in(double a, double b, std::size_t& first, std::size_t& last) const {
    const double lo = std::max((a - x0) * inv_dx - kWiden, 0.0);
    const double hi = std::min((b - x0) * inv_dx + kWiden, static_cast<double>(count - 1));
    if (!(lo <= hi)) return false;
    first = static_cast<std::size_t>(lo);
    if (static_cast<double>(first) < lo) ++first;
    last = static_cast<std::size_t>(hi);
    return first <= last;
  }
  [[nodiscard]] double at(std::size_t i) const { return x0 + static_cast<double>(i) * dx; }
};

// The rows at or above a height, by buckets as many as rows.
class RowFinder {
 public:
  explicit RowFinder(std::span<const double> ys)
      : ys_(ys), from_(ys.front()), near_(ys.size() + 1) {
    const double height = ys.back() - from_;
    inv_ = height > 0 ? static_cast<double>(ys.size()) / height : 0;
    std::size_t k = 0;
    for (std::size_t b = 0; b < near_.size(); ++b) {
      while (k < ys.size() && (ys[k] - from_) * inv_ < static_cast<double>(b)) ++k;
      near_[b] = static_cast<std::uint32_t>(k);
    }
  }
  [[nodiscard]] std::size_t at_or_above(double y) const {
    const double b = std::clamp((y - from_) * inv_, 0.0, static_cast<double>(near_.size() - 1));
    std::size_t k = near_[static_cast<std::size_t>(b)];
    while (k > 0 && ys_[k - 1] >= y) --k;
    while (k < ys_.size() && ys_[k] < y) ++k;
    return k;
  }

 private:
  std::span<const double> ys_;
  double from_, inv_ = 0;
  std::vector<std::uint32_t> near_;
};

// A piece that may meet the rows [first, end) and the columns [left, right].
struct Item {
  std::uint32_t piece = 0, first = 0, end = 0, left = 0, right = 0;
};

// Those of one chunk of pieces, by blocks of rows.
struct Chunk {
  std::vector<std::uint32_t> start;
  std::vector<Item> items;
};

class LatticeDrop {
 public:
  LatticeDrop(const OffsetSurface& offset, const Columns& columns, std::span<const double> ys,
              std::span<double> heights)
      : offset_(offset),
        cutter_(offset.cutter()),
        ball_(offset.cutter().flat() <= 0),
        columns_(columns),
        ys_(ys),
        heights_(heights),
        rows_(ys),
        edges_(offset.facets().size()),
        vertices_(edges_ + offset.edges().size()),
        chunks_((offset.piece_count() + kPiecesAChunk - 1) / kPiecesAChunk) {}

  void collect(std::size_t chunk, std::vector<Item>& found) {
    found.clear();
    const std::size_t begin = chunk * kPiecesAChunk;
    const std::size_t end = std::min(begin + kPiecesAChunk, offset_.piece_count());
    Chunk& out = chunks_[chunk];
    out.start.assign((ys_.size() + kRowsABlock - 1) / kRowsABlock + 1, 0);
    for (std::size_t k = begin; k < end; ++k) {
      const PlanBox box = offset_.box(k);
      std::size_t left, right;
      if (!columns_.in(box.x0, box.x1, left, right)) continue;
      const std::size_t first = rows_.at_or_above(box.y0);
      std::size_t last = first;
      while (last < ys_.size() && ys_[last] <= box.y1) ++last;
      if (first == last) continue;
      found.push_back({static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(first),
                       static_cast<std::uint32_t>(last), static_cast<std::uint32_t>(left),
                       static_cast<std::uint32_t>(right)});
      for (std::size_t b = first / kRowsABlock; b <= (last - 1) / kRowsABlock; ++b) {
        ++out.start[b + 1];
      }
    }
    for (std::size_t b = 1; b < out.start.size(); ++b) out.start[b] += out.start[b - 1];
    out.items.resize(out.start.back());
    std::vector<std::uint32_t> next(out.start.begin(), out.start.end() - 1);
    for (const Item& item : found) {
      for (std::size_t b = item.first / kRowsABlock; b <= (item.end - 1) / kRowsABlock; ++b) {
        out.items[next[b]++] = item;
      }
    }
  }

  void drop_block(std::size_t block) {
    const std::size_t begin = block * kRowsABlock;
    const std::size_t end = std::min(begin + kRowsABlock, ys_.size());
    std::fill(heights_.begin() + static_cast<std::ptrdiff_t>(begin * columns_.count),
              heights_.begin() + static_cast<std::ptrdiff_t>(end * columns_.count), kNoContact);
    for (const Chunk& chunk : chunks_) {
      for (std::size_t k = chunk.start[block]; k < chunk.start[block + 1]; ++k) {
        Item item = chunk.items[k];
        item.first = std::max(item.first, static_cast<std::uint32_t>(begin));
        item.end = std::min(item.end, static_cast<std::uint32_t>(end));
        if (item.piece < edges_) {
          drop(offset_.facets()[item.piece], item);
        } else if (item.piece < vertices_) {
          const EdgePiece& edge = offset_.edges()[item.piece - edges_];
          if (ball_) {
            drop_ball(edge, item);
          } else {
            drop(edge, item);
          }
        } else {
          drop(offset_.vertices()[item.piece - vertices_], item);
        }
      }
    }
  }

 private:
  double* row(std::size_t j) { return heights_.data() + j * columns_.count; }

  // Between the long side and the two short ones, each from its lower end, so that neighbours get
  // the same crossings.
  void drop(const FacetPiece& facet, const Item& item) {
    const Vec3 *a = &facet.v[0], *b = &facet.v[1], *c = &facet.v[2];
    const auto under = [](const Vec3& p, const Vec3& q) {
      return p.y() != q.y() ? p.y() < q.y() : p.x() < q.x();
    };
    if (under(*b, *a)) std::swap(a, b);
    if (under(*c, *b)) std::swap(b, c);
    if (under(*b, *a)) std::swap(a, b);
    for (std::size_t j = item.first; j < item.end; ++j) {
      const double y = ys_[j];
      const bool lower = y < b->y() || c->y() == b->y();
      const Vec3 &p = lower ? *a : *b, &q = lower ? *b : *c;
      const double t = (y - a->y()) / (c->y() - a->y());
      const double s = (y - p.y()) / (q.y() - p.y());
      double x0 = a->x() + t * (c->x() - a->x()), z0 = a->z() + t * (c->z() - a->z());
      double x1 = p.x() + s * (q.x() - p.x()), z1 = p.z() + s * (q.z() - p.z());
      if (x1 < x0) {
        std::swap(x0, x1);
        std::swap(z0, z1);
      }
      std::size_t first, last;
      if (!columns_.in(x0, x1, first, last)) continue;
      const double width = x1 - x0, slope = width > 0 ? (z1 - z0) / width : 0;
      const double low = std::min(z0, z1), high = std::max(z0, z1);
      double* at = row(j);
      for (std::size_t i = first; i <= last; ++i) {
        const double z = std::min(std::max(z0 + slope * (columns_.at(i) - x0), low), high);
        at[i] = z > at[i] ? z : at[i];
      }
    }
  }

  void drop(const EdgePiece& edge, const Item& item) {
    for (std::size_t j = item.first; j < item.end; ++j) {
      const Span span = row_span(edge, cutter_, ys_[j]);
      std::size_t first, last;
      if (span.empty() || !columns_.in(span.x0, span.x1, first, last)) continue;
      double* at = row(j);
      for (std::size_t i = first; i <= last; ++i) {
        const double z = contact(edge, cutter_, columns_.at(i), ys_[j]).z;
        at[i] = z > at[i] ? z : at[i];
      }
    }
  }

  // As contact(), most of whose work is the same for all points of a row.
  void drop_ball(const EdgePiece& e, const Item& item) {
    const double r = cutter_.radius(), lead = e.slope / e.stretch;
    const bool across = std::fabs(e.dx) > kAlong, along = std::fabs(e.dy) > kAlong;
    const double inv_dx = across ? 1 / e.dx : 0, inv_dy = along ? 1 / e.dy : 0;
    for (std::size_t j = item.first; j < item.end; ++j) {
      const double oy = ys_[j] - e.y;
      // u = dx ox + dy oy and w = dx oy - dy ox within their runs.
      double lo = -kInfinity, hi = kInfinity;
      const double at_u = e.dy * oy, at_w = e.dx * oy;
      if (across) {
        const double p = (e.u0 - at_u) * inv_dx, q = (e.u1 - at_u) * inv_dx;
        lo = std::min(p, q);
        hi = std::max(p, q);
      } else if (at_u < e.u0 || at_u > e.u1) {
        continue;
      }
      if (along) {
        const double p = (at_w - e.w0) * inv_dy, q = (at_w - e.w1) * inv_dy;
        lo = std::max(lo, std::min(p, q));
        hi = std::min(hi, std::max(p, q));
      } else if (at_w < e.w0 || at_w > e.w1) {
        continue;
      }
      std::size_t first, last;
      if (!columns_.in(e.x + lo, e.x + hi, first, last)) continue;
      double* at = row(j);
      for (std::size_t i = first; i <= last; ++i) {
        const double ox = columns_.at(i) - e.x;
        const double u = at_u + e.dx * ox, w = at_w - e.dy * ox;
        const double below = (r - w) * (r + w);
        if (below < 0) continue;
        const double half = std::sqrt(below), s = u + lead * half;
        const double z = s >= 0 && s <= e.length
                             ? e.z + e.slope * u + e.stretch * half - r
                             : contact(e, cutter_, columns_.at(i), ys_[j]).z;  // at its end
        at[i] = z > at[i] ? z : at[i];
      }
    }
  }

  void drop(const VertexPiece& v, const Item& item) {
    const double flat = cutter_.flat(), r = cutter_.corner();
    // Of the squared radius: rounding of the rim.
    const double reach = cutter_.radius() * cutter_.radius() * (1 + 2e-12);
    const double slack = -v.slack;
    const std::size_t left = item.left, right = item.right;
    for (std::size_t j = item.first; j < item.end; ++j) {
      const double oy = ys_[j] - v.y;
      const double a = v.a[1] * oy, b = v.b[1] * oy;
      double* at = row(j);
      for (std::size_t i = left; i <= right; ++i) {
        const double ox = columns_.at(i) - v.x, rho2 = ox * ox + oy * oy;
        if (rho2 > reach || v.a[0] * ox + a < slack || v.b[0] * ox + b < slack) continue;
        double z = v.z;
        if (flat <= 0) {
          z += std::sqrt(std::max(r * r - rho2, 0.0)) - r;
        } else {
          z -= cutter_.height(std::sqrt(rho2));
        }
        at[i] = z > at[i] ? z : at[i];
      }
    }
  }

  const OffsetSurface& offset_;
  const CutterShape& cutter_;
  bool ball_;
  const Columns columns_;
  std::span<const double> ys_;
  std::span<double> heights_;
  const RowFinder rows_;
  std::size_t edges_, vertices_;  // where they begin among the pieces
  std::vector<Chunk> chunks_;
};

}  // namespace

void drop_lattice(const OffsetSurface& offset, double x0, double dx, std::size_t columns,
                  std::span<const double> ys, std::span<double> heights, int threads) {
  if (columns == 0 || ys.empty()) return;
  LatticeDrop drop(offset, {x0, dx, 1 / dx, columns}, ys, heights);
  const std::size_t chunks = (offset.piece_count() + kPiecesAChunk - 1) / kPiecesAChunk;
  std::vector<std::vector<Item>> found(static_cast<std::size_t>(thread_count(threads)));
  parallel_blocks(chunks, 1, threads, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t k = begin; k < end; ++k) {
      drop.collect(k, found[static_cast<std::size_t>(worker)]);
    }
  });
  parallel_blocks((ys.size() + kRowsABlock - 1) / kRowsABlock, 1, threads,
                  [&](std::size_t begin, std::size_t end, int) {
                    for (std::size_t k = begin; k < end; ++k) drop.drop_block(k);
                  });
}

}  // namespace diesink
