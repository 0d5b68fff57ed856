// Sorting by rows of cells: which items reach into which row, and over which of its columns; in
// parallel, the same for any thread count.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_array.h"
#include "core/parallel.h"

namespace diesink {

// The cells an item's box reaches into, both ends included; none where x0 > x1.
struct CellRange {
  std::uint16_t x0 = 1, x1 = 0, y0 = 1, y1 = 0;
};

class RowBins {
 public:
  struct Entry {
    std::uint32_t item;
    std::uint16_t x0, x1;
  };

  // range_of(i) gives the cells of item i; it is called once an item.
  // Needs: less than 2^32 items.
  template <class RangeOf>
  RowBins(std::size_t count, std::size_t rows, int threads, const RangeOf& range_of)
      : start_(rows + 1, 0) {
    // Each chunk counts for itself and later writes to places of its own, after those of the
    // chunks before it: items stay ascending within a row.
    constexpr std::size_t kChunks = 32;
    const std::size_t chunk = std::max<std::size_t>(count / kChunks + 1, 4096);
    const std::size_t chunks = (count + chunk - 1) / chunk;
    std::vector<std::size_t> place(chunks * rows, 0);
    const LargeArray<CellRange> ranges(count);
    parallel_blocks(count, chunk, threads, [&](std::size_t begin, std::size_t end, int) {
      std::size_t* mine = place.data() + begin / chunk * rows;
      for (std::size_t i = begin; i < end; ++i) {
        const CellRange r = range_of(i);
        ranges.data()[i] = r;
        if (r.x0 > r.x1) continue;
        for (std::size_t y = r.y0; y <= r.y1; ++y) ++mine[y];
      }
    });
    std::size_t total = 0;
    for (std::size_t y = 0; y < rows; ++y) {
      start_[y] = total;
      for (std::size_t c = 0; c < chunks; ++c) {
        const std::size_t n = place[c * rows + y];
        place[c * rows + y] = total;
        total += n;
      }
    }
    start_[rows] = total;
    entries_ = LargeArray<Entry>(total);
    parallel_blocks(count, chunk, threads, [&](std::size_t begin, std::size_t end, int) {
      std::size_t* mine = place.data() + begin / chunk * rows;
      for (std::size_t i = begin; i < end; ++i) {
        const CellRange r = ranges.data()[i];
        if (r.x0 > r.x1) continue;
        for (std::size_t y = r.y0; y <= r.y1; ++y) {
          entries_.data()[mine[y]++] = {static_cast<std::uint32_t>(i), r.x0, r.x1};
        }
      }
    });
  }

  // Items ascend.
  [[nodiscard]] std::span<const Entry> row(std::size_t y) const {
    return {entries_.data() + start_[y], start_[y + 1] - start_[y]};
  }

 private:
  std::vector<std::size_t> start_;
  LargeArray<Entry> entries_;
};

}  // namespace diesink
