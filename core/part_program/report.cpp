// SPDX-License-Identifier: Apache-2.0
#include "core/part_program/report.h"

#include <algorithm>
#include <tuple>

namespace diesink {

void Report::error(const Statement& at, std::uint32_t column, std::string message, ErrorCode code) {
  ++errors_;
  messages_.push_back({Severity::kError, code, at.line, column, at.line_text, std::move(message)});
}

void Report::error(std::uint32_t line, std::string message, ErrorCode code) {
  ++errors_;
  messages_.push_back({Severity::kError, code, line, 1, {}, std::move(message)});
}

void Report::warning(const Statement& at, std::uint32_t column, std::string message) {
  messages_.push_back(
      {Severity::kWarning, ErrorCode::kInput, at.line, column, at.line_text, std::move(message)});
}

Place Report::place(const Statement& at, std::uint32_t column) const {
  return {file_, at.line, column, -1};
}

void Report::hand_over(Diagnostics& diagnostics) {
  std::stable_sort(messages_.begin(), messages_.end(), [](const Message& a, const Message& b) {
    return std::tie(a.line, a.column) < std::tie(b.line, b.column);
  });
  std::size_t errors = 0, warnings = 0;
  for (const Message& message : messages_) {
    const Place where{file_, message.line, message.column, -1};
    if (message.severity == Severity::kError) {
      if (errors++ < kMaxErrors) {
        diagnostics.error(message.text, where, std::string(message.line_text), message.code);
      }
    } else if (warnings++ < kMaxWarnings) {
      diagnostics.warning(message.text, where, std::string(message.line_text));
    }
  }
  if (warnings > kMaxWarnings) {
    diagnostics.warning(std::to_string(warnings - kMaxWarnings) + " more warnings are not shown",
                        {file_, 0, 0, -1});
  }
}

}  // namespace diesink
