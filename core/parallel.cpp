// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace diesink {
namespace {

thread_local const ProgressSpan* innermost_span = nullptr;
const std::function<void(double)> nobody;

}  // namespace

ProgressSpan::ProgressSpan(const std::function<void(double)>& told, double low, double high)
    : told_(told), low_(low), high_(high), outer_(std::exchange(innermost_span, this)) {}

ProgressSpan::ProgressSpan(double low, double high)
    : told_(innermost_span != nullptr ? innermost_span->told_ : nobody),
      low_(low),
      high_(high),
      outer_(innermost_span) {
  if (outer_ != nullptr) {
    const double whole = outer_->high_ - outer_->low_;
    low_ = outer_->low_ + whole * low;
    high_ = outer_->low_ + whole * high;
  }
  innermost_span = this;
}

ProgressSpan::~ProgressSpan() { innermost_span = outer_; }

int thread_count(int asked) {
  if (asked > 0) return asked;
  // Asked of the system once: it opens files for it.
  static const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return cores;
}

void tell_progress(double part) {
  if (innermost_span != nullptr) innermost_span->tell(part);
}

void parallel_blocks(
    std::size_t count, std::size_t block, int threads,
    const std::function<void(std::size_t begin, std::size_t end, int worker)>& work) {
  const std::size_t blocks = (count + block - 1) / block;
  const int workers =
      static_cast<int>(std::min(blocks, static_cast<std::size_t>(thread_count(threads))));
  std::atomic<std::size_t> next{0}, done{0};
  // Away while this thread works on a block: what that does in parallel is no part of these blocks.
  const ProgressSpan* const span = std::exchange(innermost_span, nullptr);
  std::exception_ptr failure;
  std::mutex failed;
  const auto run = [&](int worker) {
    try {
      for (std::size_t b = next++; b < blocks; b = next++) {
        work(b * block, std::min(count, (b + 1) * block), worker);
        if (span != nullptr) span->tell(static_cast<double>(++done) / static_cast<double>(blocks));
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
  innermost_span = span;
  if (failure) std::rethrow_exception(failure);
}

}  // namespace diesink
