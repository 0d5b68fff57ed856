// Columns that line up, counted in UTF-8 characters.
// SPDX-License-Identifier: Apache-2.0
#include "convert/text_table.h"

#include <algorithm>
#include <cassert>

namespace diesink {
namespace {

std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u;
  }));
}

bool is_number_like(const std::string& text) {
  return !text.empty() && (text[0] == '-' || (text[0] >= '0' && text[0] <= '9'));
}

void append_line(std::string& out, const std::vector<std::string>& row,
                 const std::vector<std::size_t>& widths, const std::vector<bool>& right) {
  const std::size_t start = out.size();
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i > 0) out += "  ";
    const std::string blanks(widths[i] - width_of(row[i]), ' ');
    out += right[i] ? blanks + row[i] : row[i] + blanks;
  }
  out.erase(std::max(start, out.find_last_not_of(' ') + 1));
  out += '\n';
}

}  // namespace

std::string to_table(const std::vector<std::vector<std::string>>& rows) {
  if (rows.empty()) return {};
  const std::size_t columns = rows[0].size();
  std::vector<std::size_t> widths(columns, 0);
  std::vector<bool> right(columns, rows.size() > 1);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    assert(rows[r].size() == columns);
    for (std::size_t i = 0; i < columns; ++i) {
      widths[i] = std::max(widths[i], width_of(rows[r][i]));
      if (r > 0 && !is_number_like(rows[r][i])) right[i] = false;
    }
  }
  std::string out;
  append_line(out, rows[0], widths, right);
  std::vector<std::string> dashes;
  for (const std::size_t width : widths) dashes.emplace_back(width, '-');
  append_line(out, dashes, widths, right);
  for (std::size_t r = 1; r < rows.size(); ++r) append_line(out, rows[r], widths, right);
  return out;
}

}  // namespace diesink
