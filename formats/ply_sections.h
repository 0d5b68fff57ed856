// The values in the body of a large ASCII PLY file, read by all threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "formats/ply_header.h"
#include "formats/text_sections.h"

namespace diesink {

// Some of the file's rows.
struct PlySection {
  std::vector<double> values;         // row after row; a list's length stands before its items
  std::vector<std::uint32_t> starts;  // where each row begins, from `begin`
  const char* begin = nullptr;
  const char* end = nullptr;  // behind the last row
  Tally longer;               // rows with more values than the header announces
};

// Takes the place of AsciiValues (formats/ply_values.h) where every row is a line and says nothing
// wrong. Where that is not so, or whatever else is wrong with the file, reading fails with an error
// nobody should see: AsciiValues reads the file once more and tells it.
class PlySectionValues {
 public:
  // `text`: at the first row. `header` must outlive this.
  PlySectionValues(TextScanner& text, const PlyHeader& header, const ReadOptions& options);

  // Whether the file is large enough, and its rows are simple enough to be told from the header.
  static bool fit(const TextScanner& text, const PlyHeader& header, const ReadOptions& options);

  static constexpr std::size_t bytes(PlyType) { return 2; }
  [[nodiscard]] std::size_t left() const { return text_.left() + 1; }

  bool read(PlyType, double& value) {
    if (at_ == last_) return fail();
    value = *at_++;
    return true;
  }
  const char* begin_row();
  void end_row() { ++row_; }
  // Moves the text's cursor behind the last row.
  void finish() { text_.move_to(end_); }
  std::optional<Error> failed;
  Tally longer;

 private:
  bool fail();

  TextScanner& text_;  // stays at the first row until finish()
  std::unique_ptr<SectionQueue<PlySection>> sections_;
  const PlySection* section_ = nullptr;
  std::size_t row_ = 0;  // within the section
  const double* at_ = nullptr;
  const double* last_ = nullptr;
  const char* end_;
};

}  // namespace diesink
