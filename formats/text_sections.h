// Large texts cut where lines end, for several threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "formats/format.h"
#include "formats/parallel.h"
#include "formats/text_scanner.h"

namespace diesink {

// What one thread fills stands in lines of memory of its own, of which caches may take two at a
// time: an array grows with every row, and its end would be fetched back from another core each
// time.
inline constexpr std::size_t kOwnLines = 128;

// Into how many parts a text is worth being cut: one below options.parallel_bytes and for one
// thread, else several a thread, so that one that is slower or comes later is not waited for; none
// smaller than a quarter of parallel_bytes.
inline std::size_t section_count(std::size_t bytes, const ReadOptions& options) {
  const auto threads = static_cast<std::size_t>(thread_count(options.threads));
  if (bytes < options.parallel_bytes || threads == 1) return 1;
  constexpr std::size_t kOfAThread = 8;
  const std::size_t least = std::max<std::size_t>(options.parallel_bytes / 4, 1);
  return std::clamp<std::size_t>(bytes / least, 1, kOfAThread * threads);
}

// The rows of a text, one a line: sections of it are read by all threads and handed out in their
// order, while those behind are being read. What memory holds at a time depends on the threads, not
// on the text.
// Needs: `count` tells how many rows a section has; `parse` reads one into a Section that may hold
// an earlier one's rows, knowing the number of its first row and how many there are, and says
// whether it could. Both are called by several threads.
template <class Section>
class SectionQueue {
 public:
  using Count = std::function<std::size_t(TextScanner)>;
  using Parse =
      std::function<bool(TextScanner, std::size_t first_row, std::size_t rows, Section& section)>;

  SectionQueue(TextScanner text, const ReadOptions& options, Count count, Parse parse)
      : text_(std::move(text)),
        size_(std::clamp<std::size_t>(options.parallel_bytes / 4, 1, kMostSection)),
        count_(std::move(count)),
        parse_(std::move(parse)) {
    const auto threads = static_cast<std::size_t>(thread_count(options.threads));
    slots_ = std::vector<Slot>(2 * threads + 1);
    others_.reserve(threads - 1);
    for (std::size_t t = 1; t < threads; ++t) {
      try {
        others_.emplace_back([this] { read_on(); });
      } catch (const std::exception&) {
        break;  // fewer threads than asked for: the others read its sections
      }
    }
  }
  SectionQueue(const SectionQueue&) = delete;
  SectionQueue& operator=(const SectionQueue&) = delete;
  ~SectionQueue() {
    {
      const std::scoped_lock lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
  }

  // The next section, until the next call; null behind the last, and where one could not be parsed.
  // Throws what reading it threw.
  Section* next() {
    std::unique_lock lock(mutex_);
    if (handed_out_) {
      slots_[taken_++ % slots_.size()].state = State::kFree;
      handed_out_ = false;
      changed_.notify_all();
    }
    while (true) {
      Slot& slot = slots_[taken_ % slots_.size()];
      if (slot.state == State::kFailed) {
        ended_ = true;
        changed_.notify_all();
        if (slot.thrown) std::rethrow_exception(slot.thrown);
        return nullptr;
      }
      if (slot.state == State::kRead) {
        handed_out_ = true;
        return &slot.section;
      }
      if (slot.state == State::kFree && text_.at_end()) return nullptr;
      if (can_begin()) {
        read_one(lock);
      } else {
        changed_.wait(lock);
      }
    }
  }

 private:
  // Small enough that its rows are still in the cache when they are handed out.
  static constexpr std::size_t kMostSection = std::size_t{1} << 17;

  enum class State : std::uint8_t { kFree, kBegun, kRead, kFailed };
  struct alignas(kOwnLines) Slot {
    State state = State::kFree;
    Section section;
    std::exception_ptr thrown;
  };

  [[nodiscard]] bool can_begin() const {
    return !ended_ && !text_.at_end() && begun_ - taken_ < slots_.size();
  }

  void read_on() {
    std::unique_lock lock(mutex_);
    while (!ended_ && !text_.at_end()) {
      if (can_begin()) {
        read_one(lock);
      } else {
        changed_.wait(lock);
      }
    }
  }

  // Cuts the next section off the text, and reads it without the lock. Counting its rows, which
  // tells where those behind it begin, takes a small part of reading them.
  void read_one(std::unique_lock<std::mutex>& lock) {
    Slot& slot = slots_[begun_++ % slots_.size()];
    slot.state = State::kBegun;
    const char* const first = text_.at();
    text_.move_to(first + std::min(size_, text_.left()));
    text_.skip_line();
    bool parsed = false;
    try {
      const TextScanner section = text_.section(first, text_.at());
      const std::size_t rows = count_(section);
      const std::size_t row = std::exchange(row_, row_ + rows);
      lock.unlock();
      parsed = parse_(section, row, rows, slot.section);
    } catch (...) {
      slot.thrown = std::current_exception();
    }
    if (!lock.owns_lock()) lock.lock();
    slot.state = parsed ? State::kRead : State::kFailed;
    changed_.notify_all();
  }

  TextScanner text_;  // behind the sections begun
  std::size_t size_;
  Count count_;
  Parse parse_;
  std::mutex mutex_;  // guards all below, and text_
  std::condition_variable changed_;
  std::vector<Slot> slots_;
  std::size_t begun_ = 0, taken_ = 0, row_ = 0;
  bool handed_out_ = false, ended_ = false;
  std::vector<std::jthread> others_;  // the first to go, so that they find the rest
};

}  // namespace diesink
