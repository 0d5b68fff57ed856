// SPDX-License-Identifier: Apache-2.0
#include "core/diagnostics.h"

#include <algorithm>
#include <string_view>

namespace diesink {
namespace {

bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xC0u) == 0x80u; }
bool is_control(char c) { return (c >= 0 && c < 0x20 && c != '\t') || c == 0x7F; }

// The source line and a caret under its column. Long lines are cut around the column, control
// characters shown as `?`: a message must not steer the terminal.
std::string caret_lines(std::string_view line, std::size_t column) {
  constexpr std::size_t kShown = 160;
  std::size_t caret = std::min(column - 1, line.size());
  if (line.size() > kShown) {
    std::size_t from = caret < kShown / 2 ? 0 : caret - kShown / 2;
    while (from > 0 && continues_character(line[from])) --from;
    line = line.substr(from, kShown);
    caret -= from;
  }
  std::string text = "\n  ";
  for (const char c : line) text += is_control(c) ? '?' : c;
  text += "\n  ";
  // Tabs are kept so that the caret stands under its column in any tab width.
  for (const char c : line.substr(0, caret)) {
    if (!continues_character(c)) text += c == '\t' ? '\t' : ' ';
  }
  return text + '^';
}

}  // namespace

std::string to_text(const Diagnostic& diagnostic) {
  const Place& at = diagnostic.where;
  std::string text = at.file.empty() ? std::string("diesink") : at.file;
  if (at.line > 0) {
    text += ':' + std::to_string(at.line);
    if (at.column > 0) text += ':' + std::to_string(at.column);
  } else if (at.byte >= 0) {
    text += ":@" + std::to_string(at.byte);
  }
  text += diagnostic.severity == Severity::kError ? ": error: " : ": warning: ";
  text += diagnostic.message;
  if (!diagnostic.source_line.empty() && at.column > 0) {
    text += caret_lines(diagnostic.source_line, at.column);
  }
  return text;
}

void Diagnostics::error(std::string message, Place where, std::string source_line, ErrorCode code) {
  all_.push_back(
      {Severity::kError, code, std::move(message), std::move(where), std::move(source_line)});
  ++errors_;
}

void Diagnostics::warning(std::string message, Place where, std::string source_line) {
  all_.push_back({Severity::kWarning, ErrorCode::kInput, std::move(message), std::move(where),
                  std::move(source_line)});
}

void Diagnostics::add(const Error& error) {
  this->error(error.message, error.where, {}, error.code);
}

std::string quoted(std::string_view text) {
  constexpr std::size_t kShown = 40;
  constexpr char kHex[] = "0123456789abcdef";
  std::string out = "\"";
  for (const char c : text.substr(0, kShown)) {
    if (c >= 0x20 && c < 0x7F) {
      out += c;
    } else {
      const unsigned byte = static_cast<unsigned char>(c);
      out += "\\x";
      out += kHex[byte >> 4];
      out += kHex[byte & 15u];
    }
  }
  if (text.size() > kShown) out += "...";
  return out + '"';
}

}  // namespace diesink
