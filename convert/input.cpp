// Reading part programs for the subcommands.
// SPDX-License-Identifier: Apache-2.0
#include "convert/input.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "convert/paths.h"
#include "formats/format.h"
#include "formats/input_file.h"

namespace diesink {
namespace {

constexpr std::size_t kBinaryLook = 4096;  // bytes in which a binary file has a zero
constexpr std::size_t kMaxProgramBytes = std::size_t{16} << 20;

bool same_word(std::string_view a, std::string_view b) {
  const auto upper = [](char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  };
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(),
                                            [&](char x, char y) { return upper(x) == upper(y); });
}

// The keyword of the first statement; empty where there is none.
std::string_view first_keyword(std::string_view text) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  constexpr std::string_view kBlank = " \t\r\n";
  while (true) {
    const std::size_t start = text.find_first_not_of(kBlank);
    if (start == text.npos) return {};
    text.remove_prefix(start);
    if (text[0] != '#' && text.substr(0, 2) != "$$") break;
    const std::size_t end = text.find('\n');
    if (end == text.npos) return {};
    text.remove_prefix(end);
  }
  return text.substr(0, text.find_first_of(" \t\r\n,$#"));
}

}  // namespace

bool is_part_program(std::span<const std::byte> bytes, const std::string& path) {
  constexpr std::array<std::string_view, 5> kFirst{"SOLID-DEF", "BSURF-DEF", "BOOLE-DEF",
                                                   "MACHI-DEF", "UNITS"};
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string_view keyword = first_keyword(text);
  if (std::any_of(kFirst.begin(), kFirst.end(),
                  [&](std::string_view each) { return same_word(keyword, each); })) {
    return true;
  }
  // A binary mesh by that name is a mesh all the same.
  const bool binary = text.substr(0, kBinaryLook).find('\0') != text.npos;
  return has_ending(path, ".part") && !(binary && format_of_content(bytes, "") != nullptr);
}

Loaded<PartProgram> load_part_program(const std::string& path, Diagnostics& diagnostics) {
  const Result<InputBytes> file = read_file(path, kMaxProgramBytes);
  if (!file) return {std::nullopt, report(file.error())};
  return load_part_program(file->bytes(), path, diagnostics);
}

Loaded<PartProgram> load_part_program(std::span<const std::byte> bytes, const std::string& path,
                                      Diagnostics& diagnostics) {
  std::optional<PartProgram> program =
      parse_part_program({reinterpret_cast<const char*>(bytes.data()), bytes.size()},
                         path == "-" ? "stdin" : path, diagnostics);
  const ExitStatus status = report(diagnostics);
  if (!program) return {std::nullopt, status};
  return {std::move(program), ExitStatus::kDone};
}

}  // namespace diesink
