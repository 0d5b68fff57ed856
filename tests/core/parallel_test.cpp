// Work in blocks over threads, and what it tells of itself.
// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <mutex>
#include <new>
#include <stdexcept>
#include <thread>
#include <vector>

namespace diesink {
namespace {

class Told {
 public:
  const std::function<void(double)> tell = [this](double part) {
    const std::scoped_lock lock(guard_);
    parts_.push_back(part);
  };
  // In ascending order: threads may pass one another between counting and telling.
  std::vector<double> parts() {
    std::sort(parts_.begin(), parts_.end());
    return parts_;
  }

 private:
  std::mutex guard_;
  std::vector<double> parts_;
};

void nothing(std::size_t, std::size_t, int) {}

TEST(Parallel, NoMoreThreadsThanCanBeHeld) {
  EXPECT_EQ(thread_count(3), 3);
  EXPECT_GE(thread_count(-1), 1);
  EXPECT_EQ(thread_count(std::numeric_limits<int>::max()), kMostThreads);
}

TEST(Parallel, EveryBlockOnce) {
  for (const int threads : {1, 2, 5}) {
    std::vector<std::atomic<int>> seen(103);
    parallel_blocks(seen.size(), 10, threads, [&](std::size_t begin, std::size_t end, int worker) {
      EXPECT_LT(worker, threads);
      for (std::size_t k = begin; k < end; ++k) ++seen[k];
    });
    for (const auto& each : seen) EXPECT_EQ(each, 1);
  }
}

// The threads that help are shared by all callers and by what blocks do in parallel themselves.
TEST(Parallel, CallersAndBlocksWithinBlocksShareTheThreads) {
  const auto sum = [](int rounds) {
    std::atomic<long> total{0};
    for (int round = 0; round < rounds; ++round) {
      parallel_blocks(6, 1, 3, [&](std::size_t outer, std::size_t, int) {
        parallel_blocks(10, 3, 4, [&](std::size_t begin, std::size_t end, int worker) {
          EXPECT_LT(worker, 4);
          for (std::size_t k = begin; k < end; ++k) total += static_cast<long>(10 * outer + k);
        });
      });
    }
    return total.load();
  };
  std::array<long, 3> of{};
  {
    std::vector<std::jthread> callers;
    for (long& each : of) callers.emplace_back([&] { each = sum(200); });
  }
  for (const long each : of) EXPECT_EQ(each, 200 * 59 * 30);
}

TEST(Parallel, WhatAHelperThrowsReachesTheCaller) {
  for (int round = 0; round < 100; ++round) {
    EXPECT_THROW(parallel_blocks(40, 1, 4,
                                 [](std::size_t begin, std::size_t, int) {
                                   if (begin == 33) throw std::bad_alloc();
                                 }),
                 std::bad_alloc);
  }
}

TEST(ProgressSpan, TellsEveryBlockWithinItsEnds) {
  for (const int threads : {1, 4}) {
    Told told;
    {
      const ProgressSpan span(told.tell, 0.2, 0.6);
      parallel_blocks(40, 10, threads, nothing);
    }
    const std::vector<double> parts = told.parts();
    ASSERT_EQ(parts.size(), 4u);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_DOUBLE_EQ(parts[k], 0.2 + 0.1 * static_cast<double>(k + 1));
    }
    parallel_blocks(40, 10, threads, nothing);  // after its end nothing more
    EXPECT_EQ(told.parts().size(), 4u);
  }
}

TEST(ProgressSpan, WhatABlockDoesInParallelIsNotTold) {
  Told told;
  const ProgressSpan span(told.tell, 0, 1);
  parallel_blocks(3, 1, 1,
                  [](std::size_t, std::size_t, int) { parallel_blocks(50, 1, 2, nothing); });
  EXPECT_EQ(told.parts().size(), 3u);
}

TEST(ProgressSpan, TheInnermostCountsAndAnEmptyOneIsSilent) {
  Told outer, inner;
  const ProgressSpan one(outer.tell, 0, 1);
  {
    const ProgressSpan two(inner.tell, 0, 1);
    parallel_blocks(2, 1, 1, nothing);
    const std::function<void(double)> none;
    const ProgressSpan three(none, 0, 1);
    parallel_blocks(2, 1, 1, nothing);
  }
  parallel_blocks(5, 1, 1, nothing);
  EXPECT_EQ(inner.parts().size(), 2u);
  EXPECT_EQ(outer.parts().size(), 5u);
}

TEST(ProgressSpan, OneThreadTellsItself) {
  tell_progress(0.5);  // nobody listens
  Told told;
  const ProgressSpan span(told.tell, 0.5, 1);
  tell_progress(0.5);
  EXPECT_EQ(told.parts(), std::vector<double>{0.75});
}

TEST(ProgressSpan, StaysInForceAfterWorkThatThrows) {
  Told told;
  const ProgressSpan span(told.tell, 0, 1);
  EXPECT_THROW(
      parallel_blocks(2, 1, 1,
                      [](std::size_t, std::size_t, int) { throw std::runtime_error("no memory"); }),
      std::runtime_error);
  EXPECT_TRUE(told.parts().empty());
  parallel_blocks(2, 1, 1, nothing);
  EXPECT_EQ(told.parts().size(), 2u);
}

}  // namespace
}  // namespace diesink
