// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace diesink {
namespace {

thread_local const ProgressSpan* innermost_span = nullptr;
const std::function<void(double)> nobody;

// Threads that wait for work and stay: to start one costs 20 to 40 us, and a die of 10 ms calls for
// help some ten times.
class Helpers {
 public:
  // Never destroyed: its threads wait until the process ends.
  static Helpers& all() {
    static Helpers* const helpers = new Helpers;
    return *helpers;
  }

  // Calls run(0) here and run(1) .. run(workers - 1) on threads that are free meanwhile; those
  // nobody took up when run(0) is done are not called. Returns when all are done.
  // Needs: run() throws nothing, and does all there is to do whoever calls it.
  void help(int workers, const std::function<void(int)>& run) {
    Job job{&run, 1, workers, 0};
    {
      const std::scoped_lock lock(guard_);
      for (; threads_ < workers - 1; ++threads_) {
        try {
          std::thread([this] { serve(); }).detach();
        } catch (const std::system_error&) {
          break;  // fewer threads than asked for: the others do its blocks
        }
      }
      jobs_.push_back(&job);
    }
    if (workers > 2) {
      wake_.notify_all();
    } else {
      wake_.notify_one();
    }
    run(0);
    std::unique_lock lock(guard_);
    std::erase(jobs_, &job);
    done_.wait(lock, [&] { return job.running == 0; });
  }

 private:
  struct Job {
    const std::function<void(int)>* run;
    int next, workers;  // workers next .. workers - 1 are still to be taken up
    int running;        // on threads of ours
  };

  void serve() {
    std::unique_lock lock(guard_);
    for (;;) {
      wake_.wait(lock, [this] { return !jobs_.empty(); });
      Job& job = *jobs_.back();  // the youngest: older ones may wait for it
      const int worker = job.next++;
      if (job.next == job.workers) jobs_.pop_back();
      ++job.running;
      lock.unlock();
      (*job.run)(worker);
      lock.lock();
      if (--job.running == 0) done_.notify_all();
    }
  }

  std::mutex guard_;
  std::condition_variable wake_, done_;
  std::vector<Job*> jobs_;
  int threads_ = 0;
};

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

ProgressSpan::ProgressSpan() : ProgressSpan(nobody, 0, 1) {}

ProgressSpan::~ProgressSpan() { innermost_span = outer_; }

int thread_count(int asked) {
  if (asked > 0) return std::min(asked, kMostThreads);
  // Asked of the system once: it opens files for it.
  static const int cores =
      std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMostThreads);
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
  if (workers > 1) {
    Helpers::all().help(workers, run);
  } else {
    run(0);
  }
  innermost_span = span;
  if (failure) std::rethrow_exception(failure);
}

}  // namespace diesink
