// The exact weld of facets that share no vertices, by all threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/vec.h"

namespace diesink {

// Gives every different position one index, in the order of first appearance: the same for any
// number of threads and any cut into waves. Positions are shared out by their hash, each part to
// one thread at a time with a table of its own; those that are new are numbered after all parts of
// a wave have met theirs.
// Needs:  finite coordinates; fewer than kMostVertices different positions. -0 and 0 are the same,
// and 0 is kept.
// Memory: 27 to 53 bytes a position beside the positions, and 40 for each corner of a wave.
class CornerWeld {
 public:
  // `expected`: how many different positions there may be; it grows as needed.
  CornerWeld(std::size_t expected, int threads);

  static constexpr std::size_t kMostVertices = 0xFF000000U;

  // How many corners a wave has best: few enough to stay near, enough for all threads.
  [[nodiscard]] std::size_t wave() const { return wave_; }

  // Writes positions begin .. end - 1 of a wave to `to`. Called by several threads, for parts of
  // their own.
  using Fill = std::function<void(std::size_t begin, std::size_t end, Vec3* to)>;

  // The next corners; their indices go to indices. Begins and ends of what `fill` is asked for are
  // multiples of three, but for the last end.
  // Needs: indices.size() <= wave().
  void add(const Fill& fill, std::span<std::uint32_t> indices);

  [[nodiscard]] std::size_t size() const { return positions_.size(); }
  // The positions found, by index; nothing can be added afterwards.
  std::vector<Vec3> take();

 private:
  // While a wave lasts the index of a new position is kFresh and the place it was met at first.
  static constexpr std::uint32_t kFresh = kMostVertices;
  static constexpr std::uint32_t kAbsent = 0xFFFFFFFFU;
  static constexpr std::size_t kMostParts = 16;
  static constexpr std::size_t kBlock = 3 * 1024;  // corners

  // The position to float: where all are floats, as in binary files, a look-up asks for this line
  // of memory alone, and for the position itself only where they are not.
  struct alignas(16) Slot {
    std::array<float, 3> key;
    std::uint32_t index;  // kAbsent where there is none
  };
  struct Part {
    std::vector<Slot> slots;  // a power of two
    std::size_t mask = 0, used = 0;
    std::vector<std::size_t> fresh;  // slots of what this wave has met first
  };
  // Of a block's corners those that a corner shortly before repeats are dropped; the others, the
  // leaders, stand part after part, in their order within each.
  struct Block {
    std::array<std::uint16_t, kBlock> leader;         // of each corner, a number
    std::array<std::uint16_t, kBlock> place;          // of each leader, by number
    std::array<std::uint16_t, kMostParts + 1> begin;  // of each part
    std::array<std::uint16_t, kMostParts> fresh_in;   // how many of each part are new
    std::size_t leaders = 0;
    bool floats = true;  // every leader is the same as its float
    std::uint32_t first_number = 0;
  };

  [[nodiscard]] std::size_t part_of(std::uint64_t hash) const { return hash >> 60 & (parts_ - 1); }
  static void make_table(Part& part, std::size_t slots);
  void grow(Part& part) const;
  void share_out(std::size_t block, std::size_t count, const Fill& fill);
  void find_or_add(std::size_t part, std::size_t blocks);
  void find_or_add(Part& part, std::size_t begin, std::size_t end);
  void number_fresh(std::size_t block);
  void settle(Part& part);

  int threads_;
  std::size_t parts_, wave_;
  bool floats_ = true;  // every position up to now is the same as its float
  std::array<Part, kMostParts> part_;
  std::vector<Vec3> positions_;
  // Of the leaders of a wave, by place in their block.
  std::vector<Vec3> corners_;
  std::vector<std::uint64_t> hashes_;
  std::vector<std::uint32_t> found_;
  std::vector<std::uint32_t> numbers_;  // of those met first
  std::vector<Block> blocks_;
};

}  // namespace diesink
