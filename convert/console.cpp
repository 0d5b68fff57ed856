// Messages, progress and exit status.
// SPDX-License-Identifier: Apache-2.0
#include "convert/console.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace diesink {
namespace {

constexpr std::string_view kRed = "\x1b[1;31m";
constexpr std::string_view kMagenta = "\x1b[1;35m";
constexpr std::string_view kPlain = "\x1b[0m";

// Every byte to the file descriptor; the errno of the first failure, else 0.
int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor, text.data(), text.size());
    if (count < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    text.remove_prefix(static_cast<std::size_t>(count));
  }
  return 0;
}

// Puts colour around the first `word` of a message.
std::string colored(std::string text, std::string_view word, std::string_view color) {
  if (!errors_in_color()) return text;
  const std::size_t at = text.find(word);
  if (at == std::string::npos) return text;
  text.insert(at + word.size(), kPlain);
  text.insert(at, color);
  return text;
}

void say(std::string text) {
  if (text.empty() || text.back() != '\n') text += '\n';
  write_all(STDERR_FILENO, text);
}

}  // namespace

ExitStatus status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage:
      return ExitStatus::kWrongUsage;
    case ErrorCode::kUnsupported:
      return ExitStatus::kNotInThisBuild;
    case ErrorCode::kOutput:
      return ExitStatus::kNotWritten;
    case ErrorCode::kInput:
    case ErrorCode::kLimit:
      break;
  }
  return ExitStatus::kBadInput;
}

bool errors_in_color() {
  const char* no_color = std::getenv("NO_COLOR");
  return isatty(STDERR_FILENO) == 1 && (no_color == nullptr || *no_color == '\0');
}

ExitStatus report(const Error& error) {
  say(colored(to_text(error), "error:", kRed));
  return status_of(error.code);
}

ExitStatus report(const Diagnostics& diagnostics) {
  ExitStatus status = ExitStatus::kDone;
  for (const Diagnostic& each : diagnostics.all()) {
    if (each.severity == Severity::kWarning) {
      say(colored(to_text(each), "warning:", kMagenta));
      continue;
    }
    say(colored(to_text(each), "error:", kRed));
    if (status == ExitStatus::kDone) status = status_of(each.code);
  }
  return status;
}

ExitStatus report_usage(std::string_view message) {
  say(colored("diesink: error: " + std::string(message), "error:", kRed));
  return ExitStatus::kWrongUsage;
}

void report_warning(const std::string& file, std::string message) {
  say(colored(to_text(Diagnostic{Severity::kWarning, {}, std::move(message), {file, 0, 0, -1}, {}}),
              "warning:", kMagenta));
}

ExitStatus print(std::string_view text) {
  const int failure = write_all(STDOUT_FILENO, text);
  if (failure == 0) return ExitStatus::kDone;
  return report(Error{ErrorCode::kOutput, std::strerror(failure), Place{"stdout", 0, 0, -1}});
}

Progress::Progress(std::string work, bool quiet)
    : work_(std::move(work)), begun_(Clock::now()), work_begun_(begun_) {
  if (quiet || isatty(STDERR_FILENO) != 1) return;
  drawer_ = std::jthread([this](const std::stop_token& stop) { draw_until(stop); });
}

Progress::~Progress() {
  drawer_.request_stop();
  stopped_.notify_all();
}

void Progress::next(std::string work) {
  const std::scoped_lock lock(guard_);
  work_ = std::move(work);
  work_begun_ = Clock::now();
  part_ = 0;
}

void Progress::draw_until(const std::stop_token& stop) {
  using namespace std::chrono_literals;
  bool shown = false;
  std::unique_lock lock(guard_);
  while (!stopped_.wait_for(lock, stop, 200ms, [&] { return stop.stop_requested(); })) {
    const Clock::time_point now = Clock::now();
    if (now - begun_ < 1s) continue;
    write_all(STDERR_FILENO, line(now));
    shown = true;
  }
  if (shown) write_all(STDERR_FILENO, "\r\x1b[K");
}

std::string Progress::line(Clock::time_point now) const {
  const double elapsed = std::chrono::duration<double>(now - work_begun_).count();
  const double part = std::clamp(part_.load(std::memory_order_relaxed), 0.0, 1.0);
  std::string text = "\r" + work_;
  char figures[96];
  if (part > 0) {
    constexpr std::size_t kWidth = 30;
    const auto filled = static_cast<std::size_t>(part * kWidth);
    text += " [" + std::string(filled, '#') + std::string(kWidth - filled, '.') + "]";
    std::snprintf(figures, sizeof figures, " %d %%, %.1f %%/s, %.0f s left",
                  static_cast<int>(100 * part), 100 * part / elapsed, elapsed * (1 - part) / part);
  } else {
    std::snprintf(figures, sizeof figures, " ... %.0f s", elapsed);
  }
  return text + figures + "\x1b[K";
}

double Stopwatch::lap() {
  const std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - last_).count();
  last_ = now;
  return seconds;
}

}  // namespace diesink
