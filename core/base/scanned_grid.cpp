// Grids by scan conversion: triangles binned by bands of rows, each band drawn on its own.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>

#include "core/base/row_bins.h"
#include "core/base/scanned.h"
#include "core/compound/row_kernels.h"

namespace diesink {
namespace {

// What a band's points take in the cache while it is drawn.
constexpr std::size_t kBandBytes = std::size_t{1} << 19;
constexpr std::size_t kBytesPerPoint = 36;
constexpr std::size_t kMostBands = 1024;
// How many triangles ahead memory is asked for theirs: in random order each is somewhere else.
constexpr std::size_t kAhead = 16;

}  // namespace

void ScannedSurface::grid(std::span<const double> xs, std::span<const double> ys,
                          const ScannedGrid& out, int threads) const {
  const std::size_t columns = xs.size(), rows = ys.size();
  if (columns == 0 || rows == 0) return;
  const LineSearch x_lines(xs), y_lines(ys);
  const std::size_t per_band =
      std::max(std::max<std::size_t>(kBandBytes / kBytesPerPoint / columns, 1),
               (rows + kMostBands - 1) / kMostBands);
  const std::size_t bands = (rows + per_band - 1) / per_band;

  // The rows and columns a triangle's box can reach.
  struct Reach {
    std::size_t x0, x1, y0, y1;
  };
  const auto reach_of = [&](std::uint32_t face) {
    const PlanBox b = box_of(face);
    return Reach{x_lines.first_from(b.x0), x_lines.first_above(b.x1), y_lines.first_from(b.y0),
                 y_lines.first_above(b.y1)};
  };
  const auto ask_for = [&](std::uint32_t face) {
    for (const std::uint32_t v : triangles_[face]) __builtin_prefetch(&positions_[v]);
  };
  const std::size_t count = triangles_.size();
  const RowBins bins(count, bands, threads, [&](std::size_t i, int) {
    if (i + kAhead < count) ask_for(static_cast<std::uint32_t>(i + kAhead));
    const Reach r = reach_of(static_cast<std::uint32_t>(i));
    if (r.x0 >= r.x1 || r.y0 >= r.y1) return BandRange{};
    return BandRange{static_cast<std::uint32_t>(r.y0 / per_band),
                     static_cast<std::uint32_t>((r.y1 - 1) / per_band)};
  });

  parallel_blocks(bands, 1, threads, [&](std::size_t first_band, std::size_t last_band, int) {
    for (std::size_t band = first_band; band < last_band; ++band) {
      const std::size_t row0 = band * per_band, row1 = std::min(rows, row0 + per_band);
      const std::size_t from = row0 * columns, points = (row1 - row0) * columns;
      std::fill_n(out.z + from, points, std::numeric_limits<double>::quiet_NaN());
      std::fill_n(out.nx + from, points, 0.0);
      std::fill_n(out.ny + from, points, 0.0);
      std::fill_n(out.face + from, points, kNoFace);
      ScannedTriangle t;
      const std::span<const std::uint32_t> faces = bins.band(band);
      for (std::size_t k = 0; k < faces.size(); ++k) {
        const std::uint32_t face = faces[k];
        if (k + 2 * kAhead < faces.size()) __builtin_prefetch(&triangles_[faces[k + 2 * kAhead]]);
        if (k + kAhead < faces.size()) ask_for(faces[k + kAhead]);
        if (!triangle(face, t)) continue;
        const Reach r = reach_of(face);
        const std::size_t end_row = std::min(r.y1, row1);
        for (std::size_t j = std::max(r.y0, row0); j < end_row; ++j) {
          std::size_t begin = r.x0, end = r.x1;
          t.narrow(ys[j], x_lines, begin, end);
          const double along = t.along_row(ys[j]);
          const std::size_t row = j * columns;
          for (std::size_t i = begin; i < end; ++i) {
            const double height = t.height(along, xs[i]);
            if (out.z[row + i] >= height) continue;
            out.z[row + i] = height;
            out.nx[row + i] = t.zx;
            out.ny[row + i] = t.zy;
            out.face[row + i] = face;
          }
        }
      }
      // The slopes become normals where they stand.
      for (std::size_t j = row0; j < row1; ++j) {
        const std::size_t row = j * columns;
        slope_normals(out.nx + row, out.ny + row, columns, out.nx + row, out.ny + row,
                      out.nz + row);
        for (std::size_t i = row; i < row + columns; ++i) {
          if (out.face[i] == kNoFace) out.nx[i] = out.ny[i] = out.nz[i] = 0;
        }
      }
    }
  });
}

}  // namespace diesink
