// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace diesink {

int thread_count(int asked) {
  if (asked > 0) return asked;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallel_blocks(
    std::size_t count, std::size_t block, int threads,
    const std::function<void(std::size_t begin, std::size_t end, int worker)>& work) {
  const std::size_t blocks = (count + block - 1) / block;
  const int workers =
      static_cast<int>(std::min(blocks, static_cast<std::size_t>(thread_count(threads))));
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failed;
  const auto run = [&](int worker) {
    try {
      for (std::size_t b = next++; b < blocks; b = next++) {
        work(b * block, std::min(count, (b + 1) * block), worker);
      }
    } catch (...) {
      next = blocks;
      const std::scoped_lock lock(failed);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (int worker = 1; worker < workers; ++worker) {
      try {
        others.emplace_back(run, worker);
      } catch (const std::system_error&) {
        break;  // fewer threads than asked for: the others do its blocks
      }
    }
    run(0);
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace diesink
