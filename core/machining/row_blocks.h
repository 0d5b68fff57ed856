// Which pieces of an offset surface meet which rows: shared by the lattice drop and the passes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/machining/offset_surface.h"

namespace diesink {

// For ascending rows, taken in blocks, the pieces that may meet a row of each block.
class RowBlocks {
 public:
  struct Item {
    std::uint32_t piece = 0, first = 0, last = 0;  // rows first..last of all rows may meet it
  };

  RowBlocks(const OffsetSurface& offset, std::span<const double> ys, std::size_t block)
      : block_(block), start_((ys.size() + block - 1) / block + 1, 0) {
    std::vector<Item> rows;
    rows.reserve(offset.piece_count());
    for (std::size_t k = 0; k < offset.piece_count(); ++k) {
      const PlanBox box = offset.box(k);
      const auto first = std::lower_bound(ys.begin(), ys.end(), box.y0);
      const auto last = std::upper_bound(first, ys.end(), box.y1);
      if (first == last) continue;
      rows.push_back({static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(first - ys.begin()),
                      static_cast<std::uint32_t>(last - ys.begin() - 1)});
    }
    for (const Item& item : rows) {
      for (std::size_t b = item.first / block; b <= item.last / block; ++b) ++start_[b + 1];
    }
    for (std::size_t b = 0; b + 1 < start_.size(); ++b) start_[b + 1] += start_[b];
    items_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (const Item& item : rows) {
      for (std::size_t b = item.first / block; b <= item.last / block; ++b)
        items_[next[b]++] = item;
    }
  }

  // Calls visit(piece, row) for every piece and every row of [begin, end) it may meet.
  // Needs: begin is a multiple of the block and [begin, end) lies within one block.
  template <class Visit>
  void for_each(std::size_t begin, std::size_t end, const Visit& visit) const {
    const std::size_t b = begin / block_;
    for (std::size_t k = start_[b]; k < start_[b + 1]; ++k) {
      const Item& item = items_[k];
      const std::size_t last = std::min<std::size_t>(item.last + 1, end);
      for (std::size_t row = std::max<std::size_t>(item.first, begin); row < last; ++row) {
        visit(item.piece, row);
      }
    }
  }

 private:
  std::size_t block_;
  std::vector<std::size_t> start_;
  std::vector<Item> items_;
};

}  // namespace diesink
