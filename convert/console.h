// What the program says: messages and summaries, progress on stderr, and the exit status.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "core/diagnostics.h"
#include "core/result.h"

namespace diesink {

enum class ExitStatus : int {
  kDone = 0,
  kWrongUsage = 1,
  kBadInput = 2,
  kNotInThisBuild = 3,
  kNotWritten = 4,
  kNotKept = 5,  // done, but what was asked could not be kept
};

ExitStatus status_of(ErrorCode code);

// True where stderr is a terminal and NO_COLOR is not set.
bool errors_in_color();

// The message on stderr, `error:` and `warning:` in colour on a terminal; gives back the exit
// status it means.
ExitStatus report(const Error& error);
// Every diagnostic in turn; the status of the first error, kDone where there are only warnings.
ExitStatus report(const Diagnostics& diagnostics);
// `error: message` of wrong usage.
ExitStatus report_usage(std::string_view message);
// `FILE: warning: message`.
void report_warning(const std::string& file, std::string message);

// A whole answer on stdout. A full disk or a closed pipe is kNotWritten, told on stderr.
ExitStatus print(std::string_view text);

// How much there is of a piece of work, where that is known: {2e6, "points"}, {bytes, "B"}.
struct WorkAmount {
  double whole = 0;
  std::string_view unit = "";  // of a string that stays
};

// A progress line on stderr: only on a terminal, only once the work has lasted over a second. A
// thread of its own draws it, so that work which cannot tell its part still shows that it goes on.
class Progress {
 public:
  // `work` is what is being done ("tessellating"); nothing is ever shown where `quiet`.
  Progress(std::string work, bool quiet, WorkAmount amount = {});
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  // part: 0..1 of the work; never goes back. Cheap to call often, from any thread.
  void update(double part) {
    double before = part_.load(std::memory_order_relaxed);
    while (part > before && !part_.compare_exchange_weak(before, part, std::memory_order_relaxed)) {
    }
  }
  // update(), for a ProgressSpan (core/parallel.h).
  [[nodiscard]] const std::function<void(double)>& told() const { return told_; }
  // The next piece of work, whose part is not known yet.
  void next(std::string work, WorkAmount amount = {});

 private:
  using Clock = std::chrono::steady_clock;
  void draw_until(const std::stop_token& stop);
  [[nodiscard]] std::string line(Clock::time_point now) const;

  const std::function<void(double)> told_ = [this](double part) { update(part); };
  std::string work_;
  WorkAmount amount_;
  Clock::time_point begun_;       // the whole
  Clock::time_point work_begun_;  // this piece
  std::uint64_t written_before_ = 0;
  std::atomic<double> part_{0};
  std::mutex guard_;  // of work_, amount_ and work_begun_
  std::condition_variable_any stopped_;
  std::jthread drawer_;  // where it is shown at all
};

// Seconds since it was made or last asked.
class Stopwatch {
 public:
  double lap();

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace diesink
