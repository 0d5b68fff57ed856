// Work in blocks over threads, the same result for any number of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

namespace diesink {

// More are never used: what each thread needs is held for all that are asked for.
inline constexpr int kMostThreads = 1024;

// Threads to use: `asked`, or all cores where it is 0 or less; kMostThreads at most.
int thread_count(int asked);

// While one lives, parallel_blocks() called by the same thread tells how much of its work is done:
// `told` gets low + (high - low) * part, from any of its threads, once a block. Spans nest, the
// innermost counts; what a block itself does in parallel is not told.
// Needs: `told` outlives it and may be called by several threads at once; it may be empty.
class ProgressSpan {
 public:
  ProgressSpan(const std::function<void(double)>& told, double low, double high);
  // A part of this thread's innermost span.
  ProgressSpan(double low, double high);
  // Tells nobody: for work that is no part of what is told of.
  ProgressSpan();
  ProgressSpan(const ProgressSpan&) = delete;
  ProgressSpan& operator=(const ProgressSpan&) = delete;
  ~ProgressSpan();

  void tell(double part) const {
    if (told_) told_(low_ + (high_ - low_) * part);
  }

 private:
  const std::function<void(double)>& told_;
  double low_, high_;
  const ProgressSpan* outer_;
};

// For work done by one thread: tells the innermost span of this thread, if there is one.
void tell_progress(double part);

// Calls work(begin, end, worker) for consecutive blocks of [0, count), each block once, on up to
// `threads` threads (0 = all cores); worker is 0 .. threads - 1 and never in two calls at once.
// Returns when all are done. An exception of `work` (memory) is thrown again here, after the
// threads have ended.
// Needs: block >= 1; blocks that write to places of their own only.
void parallel_blocks(
    std::size_t count, std::size_t block, int threads,
    const std::function<void(std::size_t begin, std::size_t end, int worker)>& work);

}  // namespace diesink
