// SPDX-License-Identifier: Apache-2.0
#include "core/diagnostics.h"

namespace diesink {

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
    text += "\n  " + diagnostic.source_line + "\n  ";
    // Tabs are kept so that the caret stands under its column in any tab width.
    for (std::size_t i = 0; i + 1 < at.column; ++i) {
      text += i < diagnostic.source_line.size() && diagnostic.source_line[i] == '\t' ? '\t' : ' ';
    }
    text += '^';
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
