// Messages, progress and exit status.
// SPDX-License-Identifier: Apache-2.0
#include "convert/console.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "formats/output_file.h"

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

// "1.2 M points", "640 MB", "35 points"
std::string amount_text(double value, std::string_view unit) {
  constexpr std::array<std::string_view, 4> kPrefixes{"", "k", "M", "G"};
  std::size_t k = 0;
  for (; value >= 1000 && k + 1 < kPrefixes.size(); ++k) value /= 1000;
  char number[32];
  std::snprintf(number, sizeof number, k > 0 && value < 10 ? "%.1f" : "%.0f", value);
  std::string text = number;
  if (unit == "B") return text + " " + std::string(kPrefixes[k]) + "B";
  if (k > 0) text += " " + std::string(kPrefixes[k]);
  return text + " " + std::string(unit);
}

std::string seconds_text(double seconds) {
  constexpr double kMinute = 60, kLong = 100;
  char text[32];
  if (seconds < kLong) {
    std::snprintf(text, sizeof text, "%.0f s", seconds);
  } else {
    const double minutes = std::floor(seconds / kMinute);
    std::snprintf(text, sizeof text, "%.0f min %02.0f s", minutes, seconds - kMinute * minutes);
  }
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

Progress::Progress(std::string work, bool quiet, WorkAmount amount)
    : work_(std::move(work)),
      amount_(amount),
      begun_(Clock::now()),
      work_begun_(begun_),
      written_before_(bytes_written()) {
  if (quiet || isatty(STDERR_FILENO) != 1) return;
  drawer_ = std::jthread([this](const std::stop_token& stop) { draw_until(stop); });
}

Progress::~Progress() {
  drawer_.request_stop();
  stopped_.notify_all();
}

void Progress::next(std::string work, WorkAmount amount) {
  const std::scoped_lock lock(guard_);
  work_ = std::move(work);
  amount_ = amount;
  work_begun_ = Clock::now();
  written_before_ = bytes_written();
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
  if (!(part > 0)) {
    if (amount_.whole > 0) text += " " + amount_text(amount_.whole, amount_.unit);
    // What cannot tell its part at least tells how fast it writes.
    const auto written = static_cast<double>(bytes_written() - written_before_);
    if (written > 0) {
      text += ", " + amount_text(written, "B") + ", " + amount_text(written / elapsed, "B") + "/s";
    }
    return text + " ... " + seconds_text(elapsed) + "\x1b[K";
  }
  constexpr std::size_t kWidth = 30;
  const auto filled = static_cast<std::size_t>(part * kWidth);
  text += " [" + std::string(filled, '#') + std::string(kWidth - filled, '.') + "] " +
          std::to_string(static_cast<int>(100 * part)) + " %, ";
  // The ends of things are seldom told.
  if (part >= 1) return text + "finishing ... " + seconds_text(elapsed) + "\x1b[K";
  if (amount_.whole > 0) {
    text += amount_text(part * amount_.whole / elapsed, amount_.unit) + "/s, ";
  } else {
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.1f %%/s, ", 100 * part / elapsed);
    text += rate;
  }
  return text + seconds_text(elapsed * (1 - part) / part) + " left\x1b[K";
}

double Stopwatch::lap() {
  const std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - last_).count();
  last_ = now;
  return seconds;
}

}  // namespace diesink
