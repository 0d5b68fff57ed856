// Large texts cut where lines end, for several threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "formats/format.h"
#include "formats/parallel.h"
#include "formats/text_scanner.h"

namespace diesink {

// Into how many parts a text is worth being cut: one below options.parallel_bytes, else one a
// thread, none smaller than a quarter of that.
inline std::size_t section_count(std::size_t bytes, const ReadOptions& options) {
  if (bytes < options.parallel_bytes) return 1;
  const auto threads = static_cast<std::size_t>(thread_count(options.threads));
  const std::size_t least = std::max<std::size_t>(options.parallel_bytes / 4, 1);
  return std::clamp<std::size_t>(bytes / least, 1, threads);
}

// The rows of a text, one a line: read section by section, as many at once as there are threads,
// and handed out in their order. What memory holds at a time depends on the threads, not on the
// text.
// Needs: `count` tells how many rows a section has; `parse` reads one into a Section, knowing the
// number of its first row, and says whether it could. Both are called by several threads.
template <class Section>
class SectionWaves {
 public:
  using Count = std::function<std::size_t(TextScanner)>;
  using Parse = std::function<bool(TextScanner, std::size_t first_row, Section& section)>;

  SectionWaves(TextScanner text, const ReadOptions& options, Count count, Parse parse)
      : text_(std::move(text)),
        threads_(thread_count(options.threads)),
        size_(std::clamp<std::size_t>(options.parallel_bytes / 4, 1, std::size_t{1} << 30)),
        count_(std::move(count)),
        parse_(std::move(parse)) {}

  // The next section; null behind the last, and where one could not be parsed.
  Section* next() {
    if (taken_ == wave_.size()) read_wave();
    return taken_ < wave_.size() ? &wave_[taken_++] : nullptr;
  }

 private:
  void read_wave() {
    taken_ = 0;
    wave_.clear();
    const auto most = static_cast<std::size_t>(threads_);
    std::vector<TextScanner> texts;
    while (!failed_ && !text_.at_end() && texts.size() < most) {
      const char* const first = text_.at();
      text_.move_to(first + std::min(size_, text_.left()));
      text_.skip_line();
      texts.push_back(text_.section(first, text_.at()));
    }
    std::vector<std::size_t> rows(texts.size(), 0);
    run_parallel(texts.size(), threads_, [&](std::size_t s) { rows[s] = count_(texts[s]); });
    for (std::size_t& each : rows) each = std::exchange(row_, row_ + each);
    std::vector<Section> wave(texts.size());
    std::atomic<bool> failed{false};
    run_parallel(texts.size(), threads_, [&](std::size_t s) {
      if (!parse_(texts[s], rows[s], wave[s])) failed = true;
    });
    failed_ = failed;
    if (!failed_) wave_ = std::move(wave);
  }

  TextScanner text_;
  int threads_;
  std::size_t size_;
  Count count_;
  Parse parse_;
  std::vector<Section> wave_;
  std::size_t taken_ = 0, row_ = 0;
  bool failed_ = false;
};

}  // namespace diesink
