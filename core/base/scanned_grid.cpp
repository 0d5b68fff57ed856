// Grids by scan conversion: triangles binned by tiles of the grid, each tile drawn on its own in a
// buffer that stays in the cache; several points at a time, by run-time dispatch to the machine's
// vectors. Signs and heights are those of core/base/scanned_triangle.h: a sign is taken from
// rounded arithmetic where a bound on its error allows, from the exact predicate elsewhere, and
// heights come of the same operations in the same order, so that the digits are the same.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/base/scan_tiles.h"
#include "core/base/scanned.h"
#include "core/large_array.h"
#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/base/scanned_grid.cpp"
#include "core/simd.h"

HWY_BEFORE_NAMESPACE();
namespace diesink {
namespace HWY_NAMESPACE {
namespace scan_grid_kernels {

namespace hn = hwy::HWY_NAMESPACE;
using namespace scan_grid;
using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using DL = hn::ScalableTag<std::uint64_t>;

HWY_INLINE V set(double v) { return hn::Set(D(), v); }

// x and y of a place in plan, side by side.
#if HWY_TARGET == HWY_SCALAR
struct Plan {
  double x, y;
};
HWY_INLINE Plan plan(double x, double y) { return {x, y}; }
HWY_INLINE Plan plan(const Vec3& p) { return {p.x(), p.y()}; }
HWY_INLINE Plan least(const Plan& a, const Plan& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y)};
}
HWY_INLINE Plan greatest(const Plan& a, const Plan& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y)};
}
HWY_INLINE std::array<double, 2> both(const Plan& p) { return {p.x, p.y}; }
#else
using D2 = hn::FixedTag<double, 2>;
using Plan = hn::Vec<D2>;
HWY_INLINE Plan plan(double x, double y) {
  alignas(16) const double both[2] = {x, y};
  return hn::Load(D2(), both);
}
HWY_INLINE Plan plan(const Vec3& p) { return hn::LoadU(D2(), p.data()); }
HWY_INLINE Plan least(Plan a, Plan b) { return hn::Min(a, b); }
HWY_INLINE Plan greatest(Plan a, Plan b) { return hn::Max(a, b); }
HWY_INLINE std::array<double, 2> both(Plan p) {
  std::array<double, 2> out;
  hn::StoreU(p, D2(), out.data());
  return out;
}
#endif

struct PlanBounds {
  Plan low, high;
};
HWY_INLINE PlanBounds bounds_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Plan pa = plan(a), pb = plan(b), pc = plan(c);
  return {least(least(pa, pb), pc), greatest(greatest(pa, pb), pc)};
}

// The lines that boxes can hold.
class Reaches {
 public:
  explicit Reaches(const Scene& scene)
      : scene_(scene),
        even_(scene.x.even && scene.y.even),
        origin_(plan(scene.x.origin, scene.y.origin)),
        per_length_(plan(scene.x.per_length, scene.y.per_length)),
        slack_(plan(scene.x.slack, scene.y.slack)),
        last_(plan(scene.x.last, scene.y.last)) {}

  HWY_INLINE Reach of(const PlanBounds& box) const {
#if HWY_TARGET != HWY_SCALAR
    if (HWY_LIKELY(even_)) {
      const D2 d;
      const Plan zero = hn::Zero(d), one = hn::Set(d, 1.0);
      const Plan first = (box.low - origin_) * per_length_ - slack_;
      const Plan last = (box.high - origin_) * per_length_ + slack_;
      // Cut off at one line outside, for whole numbers of 32 bits.
      const hn::Rebind<std::int32_t, D2> di;
      alignas(16) std::array<std::int32_t, 4> from{}, to{};
      hn::Store(hn::DemoteTo(di, hn::Ceil(hn::Min(hn::Max(first, zero), last_ + one))), di,
                from.data());
      hn::Store(hn::DemoteTo(di, hn::Floor(hn::Min(hn::Max(last, zero - one), last_))), di,
                to.data());
      return {from[0], from[1], to[0], to[1]};
    }
#endif
    return uneven(both(box.low), both(box.high));
  }

 private:
  HWY_NOINLINE Reach uneven(std::array<double, 2> low, std::array<double, 2> high) const {
    const auto index = [](std::size_t line) { return static_cast<std::int32_t>(line); };
    return {index(scene_.x.search.first_from(low[0])), index(scene_.y.search.first_from(low[1])),
            index(scene_.x.search.first_above(high[0])) - 1,
            index(scene_.y.search.first_above(high[1])) - 1};
  }

  const Scene& scene_;
  bool even_;
  Plan origin_, per_length_, slack_, last_;
};

HWY_INLINE void ask_for(const Scene& scene, const std::array<std::uint32_t, 3>& vertices) {
  for (const std::uint32_t v : vertices) __builtin_prefetch(&scene.positions[v]);
}

HWY_INLINE Reach reach_of(const Scene& scene, const Reaches& reaches, std::uint32_t face) {
  const std::array<std::uint32_t, 3>& t = scene.triangles[face];
  return reaches.of(bounds_of(scene.positions[t[0]], scene.positions[t[1]], scene.positions[t[2]]));
}

// A triangle as a tile's points meet it.
struct Facet {
  ScannedTriangle t;
  std::uint64_t face;
  double doubt;  // what no edge function is off by
};

template <class DD>
using Several = hn::Vec<DD>;
template <class DD>
using Some = hn::Mask<DD>;

// The exact predicate for the points that rounded edge functions leave open.
template <class DD>
HWY_NOINLINE Some<DD> settled(DD d, const Facet& f, Several<DD> x, Several<DD> y, Some<DD> open,
                              Some<DD> covered) {
  const hn::RebindToUnsigned<DD> dl;
  const auto ones = hn::Set(dl, ~std::uint64_t{0});
  std::array<double, kPadding> xs, ys;
  std::array<std::uint64_t, kPadding> asked, yes;
  hn::StoreU(x, d, xs.data());
  hn::StoreU(y, d, ys.data());
  hn::StoreU(hn::IfThenElseZero(hn::RebindMask(dl, open), ones), dl, asked.data());
  hn::StoreU(hn::IfThenElseZero(hn::RebindMask(dl, covered), ones), dl, yes.data());
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
    if (asked[k] != 0) yes[k] = f.t.covers(xs[k], ys[k]) ? ~std::uint64_t{0} : 0;
  }
  return hn::RebindMask(d, hn::LoadU(dl, yes.data()) != hn::Zero(dl));
}

// What several points find in a triangle, of those in `here`.
template <class DD>
struct Found {
  Some<DD> covered;
  Several<DD> z;
};
template <class DD>
HWY_INLINE Found<DD> find(DD d, const Facet& f, Several<DD> x, Several<DD> y, Some<DD> here) {
  const auto set = [d](double v) { return hn::Set(d, v); };
  const ScannedTriangle& t = f.t;
  const Several<DD> dx0 = set(t.x[0]) - x, dx1 = set(t.x[1]) - x, dx2 = set(t.x[2]) - x;
  const Several<DD> dy0 = set(t.y[0]) - y, dy1 = set(t.y[1]) - y, dy2 = set(t.y[2]) - y;
  const Several<DD> least =
      hn::Min(hn::Min(dx0 * dy1 - dy0 * dx1, dx1 * dy2 - dy1 * dx2), dx2 * dy0 - dy2 * dx0);
  const Several<DD> doubt = set(f.doubt);
  Found<DD> found;
  found.covered = hn::And(least > doubt, here);
  const Some<DD> open = hn::AndNot(found.covered, hn::And(least >= hn::Neg(doubt), here));
  if (HWY_UNLIKELY(!hn::AllFalse(d, open))) {
    found.covered = settled(d, f, x, y, open, found.covered);
  }
  // along_row() and height(): z0 - zy (y0 - y) has the digits of z0 + zy (y - y0).
  const Several<DD> z = (set(t.z0) - set(t.zy) * dy0) - set(t.zx) * dx0;
  const Several<DD> low = set(t.z_low), high = set(t.z_high);
  const Several<DD> above = hn::IfThenElse(z < low, low, z);
  found.z = hn::IfThenElse(high < above, high, above);
  return found;
}

HWY_INLINE void take(TileBuffer& tile, std::size_t at, M covered, V z, const Facet& f) {
  const D d;
  const DL dl;
  const M takes = hn::And(covered, z > hn::LoadU(d, &tile.z[at]));
  if (hn::AllFalse(d, takes)) return;
  const auto label = hn::RebindMask(dl, takes);
  hn::StoreU(hn::IfThenElse(takes, z, hn::LoadU(d, &tile.z[at])), d, &tile.z[at]);
  hn::StoreU(hn::IfThenElse(takes, set(f.t.zx), hn::LoadU(d, &tile.zx[at])), d, &tile.zx[at]);
  hn::StoreU(hn::IfThenElse(takes, set(f.t.zy), hn::LoadU(d, &tile.zy[at])), d, &tile.zy[at]);
  hn::StoreU(hn::IfThenElse(label, hn::Set(dl, f.face), hn::LoadU(dl, &tile.face[at])), dl,
             &tile.face[at]);
}

// The points [begin, end) of a row, which are among the triangle's box's.
HWY_INLINE void draw_row(TileBuffer& tile, const Facet& f, std::size_t row, std::size_t begin,
                         std::size_t end) {
  const D d;
  const V y = set(tile.ys[row]);
  for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
    const Found<D> found = find(d, f, hn::LoadU(d, &tile.xs[i]), y, hn::FirstN(d, end - i));
    take(tile, row * kStride + i, found.covered, found.z, f);
  }
}

// Points known to be covered.
HWY_INLINE void fill_row(TileBuffer& tile, const Facet& f, std::size_t row, std::size_t begin,
                         std::size_t end) {
  const D d;
  const V along = set(f.t.along_row(tile.ys[row]));
  const V low = set(f.t.z_low), high = set(f.t.z_high);
  for (std::size_t i = begin; i < end; i += hn::Lanes(d)) {
    const V z = along + set(f.t.zx) * (hn::LoadU(d, &tile.xs[i]) - set(f.t.x[0]));
    const V above = hn::IfThenElse(z < low, low, z);
    take(tile, row * kStride + i, hn::FirstN(d, end - i), hn::IfThenElse(high < above, high, above),
         f);
  }
}

// Most triangles of a fine scan have two lines each way in their box, or one: all four points are
// one vector.
#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE
#define DIESINK_SCAN_BLOCKS 1
using D4 = hn::FixedTag<double, 4>;
using DL4 = hn::FixedTag<std::uint64_t, 4>;

template <class Tag2, class Tag4, class T>
HWY_INLINE hn::Vec<Tag4> load_block(Tag2 d2, Tag4 d4, const T* at) {
  return hn::Combine(d4, hn::LoadU(d2, at + kStride), hn::LoadU(d2, at));
}
template <class Tag2, class Tag4, class T>
HWY_INLINE void store_block(Tag2 d2, Tag4 d4, hn::Vec<Tag4> v, T* at) {
  hn::StoreU(hn::LowerHalf(d2, v), d2, at);
  hn::StoreU(hn::UpperHalf(d2, v), d2, at + kStride);
  static_cast<void>(d4);
}

HWY_INLINE void draw_block(TileBuffer& tile, const Facet& f, std::size_t row, std::size_t column,
                           std::size_t rows, std::size_t columns) {
  const D2 d2;
  const D4 d4;
  const hn::FixedTag<std::uint64_t, 2> l2;
  const DL4 l4;
  constexpr std::uint64_t kYes = ~std::uint64_t{0};
  alignas(32) static constexpr std::uint64_t kHere[4][4] = {
      {kYes, 0, 0, 0}, {kYes, kYes, 0, 0}, {kYes, 0, kYes, 0}, {kYes, kYes, kYes, kYes}};
  const auto here =
      hn::RebindMask(d4, hn::MaskFromVec(hn::Load(l4, kHere[(rows - 1) * 2 + (columns - 1)])));
  const auto x2 = hn::LoadU(d2, &tile.xs[column]);
  const Found<D4> found =
      find(d4, f, hn::Combine(d4, x2, x2),
           hn::Combine(d4, hn::Set(d2, tile.ys[row + 1]), hn::Set(d2, tile.ys[row])), here);
  const std::size_t at = row * kStride + column;
  const auto z = load_block(d2, d4, &tile.z[at]);
  const auto takes = hn::And(found.covered, found.z > z);
  if (hn::AllFalse(d4, takes)) return;
  const auto put = [&](double v, double* to) {
    store_block(d2, d4, hn::IfThenElse(takes, hn::Set(d4, v), load_block(d2, d4, to)), to);
  };
  store_block(d2, d4, hn::IfThenElse(takes, found.z, z), &tile.z[at]);
  put(f.t.zx, &tile.zx[at]);
  put(f.t.zy, &tile.zy[at]);
  std::uint64_t* const face = &tile.face[at];
  store_block(
      l2, l4,
      hn::IfThenElse(hn::RebindMask(l4, takes), hn::Set(l4, f.face), load_block(l2, l4, face)),
      face);
}
#endif

void draw(const Scene& scene, const TilePlace& place, std::span<const BinnedTriangle> triangles,
          TileBuffer& tile) {
  const Reaches reaches(scene);
  const auto copy = [](std::span<const double> lines, std::size_t from, std::size_t count,
                       auto& to) {
    std::fill(to.begin(), to.end(), lines[from + count - 1]);
    std::copy_n(lines.data() + from, count, to.data());
  };
  copy(scene.x.search.lines(), place.column, place.columns, tile.xs);
  copy(scene.y.search.lines(), place.row, place.rows, tile.ys);
  for (std::size_t j = 0; j < place.rows; ++j) {
    const std::size_t from = j * kStride;
    std::fill_n(tile.z.data() + from, place.columns, -HUGE_VAL);
    std::fill_n(tile.zx.data() + from, place.columns, 0.0);
    std::fill_n(tile.zy.data() + from, place.columns, 0.0);
    std::fill_n(tile.face.data() + from, place.columns, kNoFace);
  }
  const LineSearch here(std::span<const double>(tile.xs).first(place.columns));
  // How far beyond its box the points can lie that a triangle is asked about.
  const double beyond_x = 4 * scene.x.slack * scene.x.step,
               beyond_y = 4 * scene.y.slack * scene.y.step;
  const auto column = static_cast<std::int32_t>(place.column),
             row = static_cast<std::int32_t>(place.row),
             columns = static_cast<std::int32_t>(place.columns),
             rows = static_cast<std::int32_t>(place.rows);
  Facet f;
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    if (k + kAhead < triangles.size()) ask_for(scene, triangles[k + kAhead].vertices);
    const auto [p0, p1, p2] = triangles[k].vertices;
    const Vec3 &a = scene.positions[p0], &b = scene.positions[p1], &c = scene.positions[p2];
    const PlanBounds box = bounds_of(a, b, c);
    if (!f.t.set(a, b, c)) continue;
    f.face = triangles[k].face;
    const std::array<double, 2> low = both(box.low), high = both(box.high);
    // Three roundings a product and one of the difference, as in turn(), of products that are at
    // most those of the sides.
    f.doubt = 0x1p-49 * ((high[0] - low[0]) + beyond_x) * ((high[1] - low[1]) + beyond_y);
    const Reach r = reaches.of(box);
    const auto x0 = static_cast<std::size_t>(std::max(r.x0 - column, 0)),
               x1 = static_cast<std::size_t>(std::min(r.x1 - column + 1, columns)),
               y0 = static_cast<std::size_t>(std::max(r.y0 - row, 0)),
               y1 = static_cast<std::size_t>(std::min(r.y1 - row + 1, rows));
#ifdef DIESINK_SCAN_BLOCKS
    if (x1 - x0 <= 2 && y1 - y0 <= 2) {
      draw_block(tile, f, y0, x0, y1 - y0, x1 - x0);
      continue;
    }
#endif
    // Beside many points the crossings of the edges are quicker than a test of each.
    constexpr std::size_t kWide = 24;
    if (x1 - x0 < kWide) {
      for (std::size_t j = y0; j < y1; ++j) draw_row(tile, f, j, x0, x1);
    } else {
      for (std::size_t j = y0; j < y1; ++j) {
        std::size_t begin = x0, end = x1;
        f.t.narrow(tile.ys[j], here, begin, end);
        fill_row(tile, f, j, begin, end);
      }
    }
  }
}
#undef DIESINK_SCAN_BLOCKS

// The tile's points to where they belong, the slopes as normals.
void write(const TilePlace& place, std::size_t columns, const TileBuffer& tile,
           const ScannedGrid& out) {
  const D d;
  const DL dl;
  const V one = set(1), zero = hn::Zero(d);
  const V none = set(std::numeric_limits<double>::quiet_NaN());
  const auto no_face = hn::Set(dl, std::uint64_t{kNoFace});
  for (std::size_t j = 0; j < place.rows; ++j) {
    const std::size_t to = (place.row + j) * columns + place.column;
    const auto points = [&](std::size_t i, const auto& store) {
      const std::size_t at = j * kStride + i;
      const V a = hn::LoadU(d, &tile.zx[at]), b = hn::LoadU(d, &tile.zy[at]);
      const M there = hn::RebindMask(d, hn::LoadU(dl, &tile.face[at]) != no_face);
      const V up = hn::IfThenElse(there, one / hn::Sqrt((a * a + b * b) + one), zero);
      store(hn::IfThenElse(there, hn::LoadU(d, &tile.z[at]), none), out.z + to + i);
      store(hn::Neg(a) * up, out.nx + to + i);
      store(hn::Neg(b) * up, out.ny + to + i);
      store(up, out.nz + to + i);
    };
    std::size_t i = 0;
    for (; i + hn::Lanes(d) <= place.columns; i += hn::Lanes(d)) {
      points(i, [&](V v, double* p) { hn::StoreU(v, d, p); });
    }
    if (i < place.columns) {
      const M some = hn::FirstN(d, place.columns - i);
      points(i, [&](V v, double* p) { hn::BlendedStore(v, some, d, p); });
    }
    const std::uint64_t* const face = &tile.face[j * kStride];
    for (std::size_t k = 0; k < place.columns; ++k) {
      out.face[to + k] = static_cast<std::uint32_t>(face[k]);
    }
  }
}

}  // namespace scan_grid_kernels

using namespace scan_grid;

// Ranges of the triangles [begin, end), and how many reach into each tile.
void range_kernel(const Scene& scene, std::size_t begin, std::size_t end, std::size_t count,
                  TileRange* ranges, std::uint32_t* per_tile) {
  using namespace scan_grid_kernels;
  const Reaches reaches(scene);
  for (std::size_t i = begin; i < end; ++i) {
    if (i + kAhead < count) ask_for(scene, scene.triangles[i + kAhead]);
    const Reach r = reach_of(scene, reaches, static_cast<std::uint32_t>(i));
    if (r.x0 > r.x1 || r.y0 > r.y1) {
      ranges[i].packed = TileRange::kNone;
      continue;
    }
    const std::uint32_t x0 = static_cast<std::uint32_t>(r.x0) >> scene.column_bits,
                        x1 = static_cast<std::uint32_t>(r.x1) >> scene.column_bits,
                        y0 = static_cast<std::uint32_t>(r.y0) >> scene.row_bits,
                        y1 = static_cast<std::uint32_t>(r.y1) >> scene.row_bits;
    const std::uint32_t tile = y0 * scene.tile_columns + x0;
    if (HWY_LIKELY(x0 == x1 && y0 == y1)) {
      ranges[i].packed = tile;
      ++per_tile[tile];
      continue;
    }
    const std::uint32_t more_x = x1 - x0, more_y = y1 - y0;
    ranges[i].packed = more_x > TileRange::kMostMore || more_y > TileRange::kMostMore
                           ? TileRange::kMany
                           : tile | more_x << TileRange::kTileBits |
                                 more_y << (TileRange::kTileBits + TileRange::kMoreBits);
    for (std::uint32_t y = y0; y <= y1; ++y) {
      for (std::uint32_t x = x0; x <= x1; ++x) ++per_tile[y * scene.tile_columns + x];
    }
  }
}

// Writes the triangles [begin, end) to their places in the tiles' lists.
void sort_kernel(const Scene& scene, std::size_t begin, std::size_t end, const TileRange* ranges,
                 std::size_t* place, BinnedTriangle* binned) {
  using namespace scan_grid_kernels;
  const Reaches reaches(scene);
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint32_t packed = ranges[i].packed;
    const auto face = static_cast<std::uint32_t>(i);
    if (packed == TileRange::kNone) continue;
    std::uint32_t tile = packed & ((1u << TileRange::kTileBits) - 1), more_x, more_y;
    if (HWY_UNLIKELY(packed == TileRange::kMany)) {
      const Reach r = reach_of(scene, reaches, face);
      const std::uint32_t x0 = static_cast<std::uint32_t>(r.x0) >> scene.column_bits,
                          y0 = static_cast<std::uint32_t>(r.y0) >> scene.row_bits;
      tile = y0 * scene.tile_columns + x0;
      more_x = (static_cast<std::uint32_t>(r.x1) >> scene.column_bits) - x0;
      more_y = (static_cast<std::uint32_t>(r.y1) >> scene.row_bits) - y0;
    } else {
      more_x = packed >> TileRange::kTileBits & TileRange::kMostMore;
      more_y = packed >> (TileRange::kTileBits + TileRange::kMoreBits);
    }
    for (std::uint32_t y = 0; y <= more_y; ++y) {
      for (std::uint32_t x = 0; x <= more_x; ++x) {
        binned[place[tile + y * scene.tile_columns + x]++] = {face, scene.triangles[i]};
      }
    }
  }
}

void tile_kernel(const Scene& scene, const TilePlace& place,
                 std::span<const BinnedTriangle> triangles, TileBuffer& tile,
                 const ScannedGrid& out) {
  using namespace scan_grid_kernels;
  draw(scene, place, triangles, tile);
  write(place, scene.x.search.lines().size(), tile, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace diesink
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace diesink {

HWY_EXPORT(range_kernel);
HWY_EXPORT(sort_kernel);
HWY_EXPORT(tile_kernel);

namespace {

// The tiles' triangles, ascending within each.
class TileBins {
 public:
  TileBins(const scan_grid::Scene& scene, std::size_t count, std::size_t tiles, int threads)
      : start_(tiles + 1, 0) {
    // Each chunk counts for itself and later writes to places of its own, after those of the
    // chunks before it.
    constexpr std::size_t kChunks = 32;
    const std::size_t chunk = std::max<std::size_t>(count / kChunks + 1, 4096);
    const std::size_t chunks = (count + chunk - 1) / chunk;
    const LargeArray<scan_grid::TileRange> ranges(count);
    std::vector<std::uint32_t> counts(chunks * tiles, 0);
    {
      const ProgressSpan span(0, 0.7);
      parallel_blocks(count, chunk, threads, [&](std::size_t begin, std::size_t end, int) {
        HWY_DYNAMIC_DISPATCH(range_kernel)
        (scene, begin, end, count, ranges.data(), counts.data() + begin / chunk * tiles);
      });
    }
    std::vector<std::size_t> places(chunks * tiles);
    std::size_t total = 0;
    for (std::size_t t = 0; t < tiles; ++t) {
      start_[t] = total;
      for (std::size_t c = 0; c < chunks; ++c) {
        places[c * tiles + t] = total;
        total += counts[c * tiles + t];
      }
    }
    start_[tiles] = total;
    binned_ = LargeArray<scan_grid::BinnedTriangle>(total);
    const ProgressSpan span(0.7, 1);
    parallel_blocks(count, chunk, threads, [&](std::size_t begin, std::size_t end, int) {
      HWY_DYNAMIC_DISPATCH(sort_kernel)
      (scene, begin, end, ranges.data(), places.data() + begin / chunk * tiles, binned_.data());
    });
  }

  [[nodiscard]] std::span<const scan_grid::BinnedTriangle> of(std::size_t tile) const {
    return {binned_.data() + start_[tile], start_[tile + 1] - start_[tile]};
  }

 private:
  std::vector<std::size_t> start_;
  LargeArray<scan_grid::BinnedTriangle> binned_;
};

// Bits of a tile's side: as wide as a buffer holds, and no wider than leaves work for all threads
// where a grid is small.
unsigned tile_bits(std::size_t lines, std::size_t most) {
  constexpr std::size_t kTilesAcross = 8, kLeast = 8;
  unsigned bits = 0;
  while ((std::size_t{2} << bits) <= most &&
         ((std::size_t{1} << bits) < kLeast || lines >> bits > kTilesAcross)) {
    ++bits;
  }
  return bits;
}

}  // namespace

void ScannedSurface::grid(std::span<const double> xs, std::span<const double> ys,
                          const ScannedGrid& out, int threads) const {
  using namespace scan_grid;
  const std::size_t columns = xs.size(), rows = ys.size();
  if (columns == 0 || rows == 0) return;
  Scene scene{GridLines(xs),
              GridLines(ys),
              positions_.data(),
              triangles_.data(),
              tile_bits(columns, kMostColumns),
              tile_bits(rows, kMostRows),
              0};
  const std::size_t tile_columns = ((columns - 1) >> scene.column_bits) + 1,
                    tile_rows = ((rows - 1) >> scene.row_bits) + 1;
  scene.tile_columns = static_cast<std::uint32_t>(tile_columns);
  const TileBins bins = [&] {
    const ProgressSpan span(0, 0.4);
    return TileBins(scene, triangles_.size(), tile_columns * tile_rows, threads);
  }();
  const ProgressSpan span(0.4, 1);
  std::vector<std::unique_ptr<TileBuffer>> buffers(static_cast<std::size_t>(thread_count(threads)));
  parallel_blocks(
      tile_columns * tile_rows, 1, threads, [&](std::size_t tile, std::size_t, int worker) {
        std::unique_ptr<TileBuffer>& buffer = buffers[static_cast<std::size_t>(worker)];
        if (!buffer) buffer = std::make_unique<TileBuffer>();
        TilePlace place;
        place.column = tile % tile_columns << scene.column_bits;
        place.row = tile / tile_columns << scene.row_bits;
        place.columns = std::min(columns - place.column, std::size_t{1} << scene.column_bits);
        place.rows = std::min(rows - place.row, std::size_t{1} << scene.row_bits);
        HWY_DYNAMIC_DISPATCH(tile_kernel)(scene, place, bins.of(tile), *buffer, out);
      });
}

}  // namespace diesink
#endif  // HWY_ONCE
