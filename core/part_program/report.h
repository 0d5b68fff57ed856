// Gathers the messages of one part program in any order and hands them on in the order of the text.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "core/part_program/statement.h"

namespace diesink {

inline constexpr std::size_t kMaxErrors = 20;
inline constexpr std::size_t kMaxWarnings = 100;

class Report {
 public:
  explicit Report(std::string_view file) : file_(file) {}

  void error(const Statement& at, std::uint32_t column, std::string message,
             ErrorCode code = ErrorCode::kInput);
  void error(const Statement& at, const Field& field, std::string message) {
    error(at, field.column, std::move(message));
  }
  // Where no statement stands, such as the end of the text.
  void error(std::uint32_t line, std::string message, ErrorCode code = ErrorCode::kInput);
  void warning(const Statement& at, std::uint32_t column, std::string message);

  [[nodiscard]] bool has_errors() const { return errors_ > 0; }
  [[nodiscard]] std::size_t error_count() const { return errors_; }
  [[nodiscard]] Place place(const Statement& at, std::uint32_t column) const;

  // The first kMaxErrors errors and kMaxWarnings warnings by line and column, and how many warnings
  // were left out.
  void hand_over(Diagnostics& diagnostics);

 private:
  struct Message {
    Severity severity = Severity::kError;
    ErrorCode code = ErrorCode::kInput;
    std::uint32_t line = 0, column = 0;
    std::string_view line_text;
    std::string text;
  };
  std::string file_;
  std::vector<Message> messages_;
  std::size_t errors_ = 0;
};

}  // namespace diesink
