// Sorting by rows: which items reach into which band, in parallel, the same for any thread count.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/parallel.h"

namespace diesink {

// The bands an item reaches into, both included; none where first > last.
struct BandRange {
  std::uint32_t first = 1, last = 0;
};

class RowBins {
 public:
  // range_of(i, worker) gives the bands of item i; it is called once an item.
  template <class RangeOf>
  RowBins(std::size_t count, std::size_t bands, int threads, const RangeOf& range_of)
      : start_(bands + 1, 0) {
    // Each chunk counts for itself and later writes to places of its own, after those of the
    // chunks before it: items stay ascending within a band.
    constexpr std::size_t kChunks = 32;
    const std::size_t chunk = std::max<std::size_t>(count / kChunks + 1, 4096);
    const std::size_t chunks = (count + chunk - 1) / chunk;
    std::vector<std::size_t> place(chunks * bands, 0);
    const auto ranges = std::make_unique_for_overwrite<BandRange[]>(count);
    parallel_blocks(count, chunk, threads, [&](std::size_t begin, std::size_t end, int worker) {
      std::size_t* mine = place.data() + begin / chunk * bands;
      for (std::size_t i = begin; i < end; ++i) {
        const BandRange r = range_of(i, worker);
        ranges[i] = r;
        if (r.first > r.last) continue;
        for (std::uint32_t b = r.first; b <= r.last; ++b) ++mine[b];
      }
    });
    std::size_t total = 0;
    for (std::size_t b = 0; b < bands; ++b) {
      start_[b] = total;
      for (std::size_t c = 0; c < chunks; ++c) {
        const std::size_t n = place[c * bands + b];
        place[c * bands + b] = total;
        total += n;
      }
    }
    start_[bands] = total;
    items_ = std::make_unique_for_overwrite<std::uint32_t[]>(total);
    parallel_blocks(count, chunk, threads, [&](std::size_t begin, std::size_t end, int) {
      std::size_t* mine = place.data() + begin / chunk * bands;
      for (std::size_t i = begin; i < end; ++i) {
        const BandRange r = ranges[i];
        if (r.first > r.last) continue;
        for (std::uint32_t b = r.first; b <= r.last; ++b) {
          items_[mine[b]++] = static_cast<std::uint32_t>(i);
        }
      }
    });
  }

  // Ascending.
  [[nodiscard]] std::span<const std::uint32_t> band(std::size_t b) const {
    return {items_.get() + start_[b], start_[b + 1] - start_[b]};
  }

 private:
  std::vector<std::size_t> start_;
  std::unique_ptr<std::uint32_t[]> items_;
};

}  // namespace diesink
