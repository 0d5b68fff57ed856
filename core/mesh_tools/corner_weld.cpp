// SPDX-License-Identifier: Apache-2.0
#include "core/mesh_tools/corner_weld.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

#include "core/large_array.h"
#include "core/mesh_tools/position_hash.h"
#include "core/parallel.h"

namespace diesink {
namespace {

// As many as a position may take before a table is too full: at three fifths look-ups still end
// after two slots, most of them.
constexpr std::size_t kFullUsed = 3, kFullSlots = 5;

// Of finite numbers without -0.
bool same(const Vec3& a, const Vec3& b) {
  std::array<std::uint64_t, 3> x, y;
  std::memcpy(x.data(), a.data(), sizeof x);
  std::memcpy(y.data(), b.data(), sizeof y);
  return ((x[0] ^ y[0]) | (x[1] ^ y[1]) | (x[2] ^ y[2])) == 0;
}

using Key = std::array<float, 3>;

Key key_of(const Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}
Vec3 widened(const Key& key) {
  return {static_cast<double>(key[0]), static_cast<double>(key[1]), static_cast<double>(key[2])};
}
// To the bit: of different bits the positions differ, too.
bool same(const Key& a, const Key& b) {
  std::array<std::uint32_t, 3> x, y;
  std::memcpy(x.data(), a.data(), sizeof x);
  std::memcpy(y.data(), b.data(), sizeof y);
  return ((x[0] ^ y[0]) | (x[1] ^ y[1]) | (x[2] ^ y[2])) == 0;
}

}  // namespace

CornerWeld::CornerWeld(std::size_t expected, int threads) : threads_(thread_count(threads)) {
  // A block stays in the cache of its core; several threads take many at a time, since each wave
  // has them wait for one another.
  parts_ = threads_ == 1 ? 1 : kMostParts;
  wave_ = kBlock * (threads_ == 1 ? 1 : 64);
  const std::size_t slots = std::bit_ceil(std::max<std::size_t>(2 * expected / parts_, 64));
  const ProgressSpan silent;
  parallel_blocks(parts_, 1, slots < 4096 ? 1 : threads_,
                  [&](std::size_t p, std::size_t, int) { make_table(part_[p], slots); });
  reserve_large(positions_, expected);
}

void CornerWeld::make_table(Part& part, std::size_t slots) {
  // Looked up all over: every look-up finds its page.
  part.slots = {};
  reserve_large(part.slots, slots);
  part.slots.assign(slots, {{}, kAbsent});
  part.mask = slots - 1;
}

void CornerWeld::grow(Part& part) const {
  const std::vector<Slot> old = std::move(part.slots);
  make_table(part, 2 * old.size());
  part.fresh.clear();
  for (const Slot& slot : old) {
    if (slot.index == kAbsent) continue;
    const std::uint64_t hash = slot.index >= kFresh ? hashes_[slot.index - kFresh]
                               : floats_            ? hash_of(widened(slot.key))
                                                    : hash_of(positions_[slot.index]);
    std::size_t at = static_cast<std::size_t>(hash) & part.mask;
    while (part.slots[at].index != kAbsent) at = (at + 1) & part.mask;
    part.slots[at] = slot;
    if (slot.index >= kFresh) part.fresh.push_back(at);
  }
}

// The leaders of a block, part after part.
void CornerWeld::share_out(std::size_t block, std::size_t count, const Fill& fill) {
  const std::size_t begin = block * kBlock, size = std::min(count - begin, kBlock);
  Block& shared = blocks_[block];
  std::array<Vec3, kBlock> corners;
  std::array<std::uint64_t, kBlock> hashes;
  fill(begin, begin + size, corners.data());
  // Neighbours in the file share most of their corners, and what the nearest cache remembers needs
  // no look-up in the table.
  constexpr std::uint16_t kNobody = 0xFFFF;
  std::array<std::uint16_t, 4096> latest;
  latest.fill(kNobody);
  std::uint16_t leaders = 0;
  bool floats = true;
  for (std::size_t i = 0; i < size; ++i) {
    const Vec3 corner = corners[i] + Vec3::Zero();  // -0 becomes 0
    const std::uint64_t hash = hash_of(corner);
    std::uint16_t& last = latest[hash % latest.size()];
    if (last == kNobody || !same(corners[last], corner)) {
      last = leaders++;
      corners[last] = corner;  // never in front of what is still to come
      hashes[last] = hash;
      floats &= same(widened(key_of(corner)), corner);
    }
    shared.leader[i] = last;
  }
  shared.leaders = leaders;
  shared.floats = floats;
  shared.begin.fill(0);
  for (std::size_t i = 0; i < leaders; ++i) ++shared.begin[part_of(hashes[i])];
  std::uint16_t before = 0;
  for (std::uint16_t& each : shared.begin) {
    before = static_cast<std::uint16_t>(before + each);
    each = static_cast<std::uint16_t>(before - each);
  }
  std::array<std::uint16_t, kMostParts + 1> next = shared.begin;
  for (std::size_t i = 0; i < leaders; ++i) {
    const std::uint16_t place = next[part_of(hashes[i])]++;
    shared.place[i] = place;
    corners_[begin + place] = corners[i];
    hashes_[begin + place] = hashes[i];
  }
}

// All leaders of a part, in their order.
void CornerWeld::find_or_add(std::size_t part_number, std::size_t blocks) {
  Part& part = part_[part_number];
  for (std::size_t b = 0; b < blocks; ++b) {
    Block& block = blocks_[b];
    const std::size_t end = b * kBlock + block.begin[part_number + 1];
    const std::size_t fresh_before = part.used;
    constexpr std::size_t kBatch = 64;
    for (std::size_t at = b * kBlock + block.begin[part_number]; at < end; at += kBatch) {
      find_or_add(part, at, std::min(end, at + kBatch));
    }
    block.fresh_in[part_number] = static_cast<std::uint16_t>(part.used - fresh_before);
  }
}

void CornerWeld::find_or_add(Part& part, std::size_t begin, std::size_t end) {
  const Vec3* const corners = corners_.data();
  const Vec3* const known = positions_.data();
  const std::uint64_t* const hashes = hashes_.data();
  Slot* slots = part.slots.data();
  std::size_t mask = part.mask;
  // Many at once, which hides the memory's latency: first the slots, then the positions they name.
  for (std::size_t at = begin; at < end; ++at) __builtin_prefetch(&slots[hashes[at] & mask]);
  if (!floats_) {
    for (std::size_t at = begin; at < end; ++at) {
      const std::uint32_t index = slots[hashes[at] & mask].index;
      if (index < kFresh) __builtin_prefetch(&known[index]);
    }
  }
  for (std::size_t at = begin; at < end; ++at) {
    const std::uint64_t hash = hashes[at];
    const Key key = key_of(corners[at]);
    std::size_t place = static_cast<std::size_t>(hash) & mask;
    std::uint32_t index = kAbsent;
    for (; (index = slots[place].index) != kAbsent; place = (place + 1) & mask) {
      if (same(slots[place].key, key) &&
          (floats_ || same(index < kFresh ? known[index] : corners[index - kFresh], corners[at]))) {
        break;
      }
    }
    if (index == kAbsent) {
      index = static_cast<std::uint32_t>(kFresh + at);
      slots[place] = {key, index};
      part.fresh.push_back(place);
      if (++part.used * kFullSlots > (mask + 1) * kFullUsed) {
        grow(part);
        slots = part.slots.data();
        mask = part.mask;
      }
    }
    found_[at] = index;
  }
}

// The final numbers of the leaders of a block that were met first.
void CornerWeld::number_fresh(std::size_t block) {
  const std::size_t begin = block * kBlock;
  const Block& shared = blocks_[block];
  std::uint32_t number = shared.first_number;
  for (std::size_t i = 0; i < shared.leaders; ++i) {
    const std::size_t place = begin + shared.place[i];
    if (found_[place] != kFresh + place) continue;
    positions_[number] = corners_[place];
    numbers_[place] = number++;
  }
}

void CornerWeld::settle(Part& part) {
  for (const std::size_t place : part.fresh) {
    std::uint32_t& index = part.slots[place].index;
    index = numbers_[index - kFresh];
  }
  part.fresh.clear();
}

void CornerWeld::add(const Fill& fill, std::span<std::uint32_t> indices) {
  const std::size_t count = indices.size();
  assert(count <= wave_);
  // A wave is a small part of whatever is told of.
  const ProgressSpan silent;
  const std::size_t blocks = (count + kBlock - 1) / kBlock;
  if (blocks > blocks_.size()) {
    corners_.resize(blocks * kBlock);
    hashes_.resize(blocks * kBlock);
    found_.resize(blocks * kBlock);
    numbers_.resize(blocks * kBlock);
    blocks_.resize(blocks);
  }
  parallel_blocks(blocks, 1, threads_,
                  [&](std::size_t b, std::size_t, int) { share_out(b, count, fill); });
  for (const Block& block : std::span(blocks_).first(blocks)) floats_ &= block.floats;
  parallel_blocks(parts_, 1, threads_,
                  [&](std::size_t p, std::size_t, int) { find_or_add(p, blocks); });
  std::size_t total = positions_.size();
  for (Block& block : std::span(blocks_).first(blocks)) {
    block.first_number = static_cast<std::uint32_t>(total);
    for (std::size_t p = 0; p < parts_; ++p) total += block.fresh_in[p];
  }
  assert(total < kMostVertices);
  positions_.resize(total);
  parallel_blocks(blocks, 1, threads_, [&](std::size_t b, std::size_t, int) { number_fresh(b); });
  parallel_blocks(blocks + parts_, 1, threads_, [&](std::size_t piece, std::size_t, int) {
    if (piece >= blocks) return settle(part_[piece - blocks]);
    const std::size_t begin = piece * kBlock, size = std::min(count - begin, kBlock);
    const Block& block = blocks_[piece];
    std::array<std::uint32_t, kBlock> of_leader;
    for (std::size_t i = 0; i < block.leaders; ++i) {
      const std::uint32_t found = found_[begin + block.place[i]];
      of_leader[i] = found < kFresh ? found : numbers_[found - kFresh];
    }
    for (std::size_t i = 0; i < size; ++i) indices[begin + i] = of_leader[block.leader[i]];
  });
}

std::vector<Vec3> CornerWeld::take() {
  for (Part& part : part_) part = {};
  return std::move(positions_);
}

}  // namespace diesink
