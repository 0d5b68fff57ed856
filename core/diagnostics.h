// Errors and warnings gathered while something is read; readers report several in one run.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace diesink {

enum class Severity : std::uint8_t { kWarning, kError };

struct Diagnostic {
  Severity severity = Severity::kError;
  ErrorCode code = ErrorCode::kInput;  // meaningful for errors
  std::string message;                 // what was found, what was expected; no place, no newline
  Place where;
  std::string source_line;  // text of the line at `where`, for the caret line; may be empty
};

// `FILE:LINE:COLUMN: error: message`, then, where a source line is known, that line and a caret
// under the column.
std::string to_text(const Diagnostic& diagnostic);

// `"text"` for a message: at most 40 bytes of it, bytes outside printable ASCII as \xNN.
std::string quoted(std::string_view text);

class Diagnostics {
 public:
  void error(std::string message, Place where, std::string source_line = {},
             ErrorCode code = ErrorCode::kInput);
  void warning(std::string message, Place where, std::string source_line = {});
  void add(const Error& error);

  [[nodiscard]] bool has_errors() const { return errors_ > 0; }
  [[nodiscard]] std::size_t error_count() const { return errors_; }
  [[nodiscard]] const std::vector<Diagnostic>& all() const { return all_; }

 private:
  std::vector<Diagnostic> all_;
  std::size_t errors_ = 0;
};

}  // namespace diesink
