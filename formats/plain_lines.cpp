// SPDX-License-Identifier: Apache-2.0
//
// The loops have no branch and count in bytes, so that the compiler takes many characters at a
// time.
#include "formats/plain_lines.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

namespace diesink {
namespace {

using Byte = std::uint8_t;

constexpr std::size_t kAhead = 3;    // characters behind one that are looked at
constexpr std::size_t kBlock = 128;  // so that counts of a block fit a byte

// Calls look(at) for blocks of the text as characters, each with kAhead more that may be read; what
// is no longer the text is `filler`. Ends where `look` says false.
template <class Look>
bool for_blocks(std::string_view text, char filler, Look look) {
  std::size_t at = 0;
  for (; at + kBlock + kAhead <= text.size(); at += kBlock) {
    if (!look(reinterpret_cast<const Byte*>(text.data() + at))) return false;
  }
  // The last two.
  std::array<Byte, 2 * kBlock + kAhead> rest;
  rest.fill(static_cast<Byte>(filler));
  if (at < text.size()) std::memcpy(rest.data(), text.data() + at, text.size() - at);
  return look(rest.data()) && look(rest.data() + kBlock);
}

Byte is(bool holds) { return holds ? Byte{1} : Byte{0}; }

Byte is_control(Byte c) { return static_cast<Byte>(is(c < ' ') & is(c != '\n')); }

}  // namespace

std::optional<std::size_t> plain_row_count(std::string_view text) {
  if (text.empty()) return 0;
  if (static_cast<Byte>(text.front()) <= ' ') return std::nullopt;
  std::size_t ends = 0;
  const bool plain = for_blocks(text, 'x', [&ends](const Byte* c) {
    Byte found = 0, odd = 0;
    for (std::size_t i = 0; i < kBlock; ++i) {
      const Byte end = is(c[i] == '\n');
      found = static_cast<Byte>(found + end);
      odd |= static_cast<Byte>((end & is(c[i + 1] <= ' ')) | is_control(c[i]) | is(c[i] == '#'));
    }
    ends += found;
    return odd == 0;
  });
  if (!plain) return std::nullopt;
  return ends + (text.back() == '\n' ? 0 : 1);
}

std::optional<ObjCounts> plain_obj_counts(std::string_view text) {
  ObjCounts counts;
  // The statement at the very start is behind no line's end.
  std::array<char, 1 + kAhead> start{'\n', 'x', 'x', 'x'};
  std::memcpy(start.data() + 1, text.data(), std::min(text.size(), kAhead));
  const auto look = [&counts](const Byte* c, std::size_t size) {
    Byte vertices = 0, textures = 0, normals = 0, odd = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const Byte end = is(c[i] == '\n');
      const Byte v = static_cast<Byte>(end & is(c[i + 1] == 'v'));
      const Byte blank = is(c[i + 3] == ' ');
      const Byte vertex = static_cast<Byte>(v & is(c[i + 2] == ' '));
      const Byte texture = static_cast<Byte>(v & is(c[i + 2] == 't') & blank);
      const Byte normal = static_cast<Byte>(v & is(c[i + 2] == 'n') & blank);
      vertices = static_cast<Byte>(vertices + vertex);
      textures = static_cast<Byte>(textures + texture);
      normals = static_cast<Byte>(normals + normal);
      odd |= static_cast<Byte>((v ^ (vertex | texture | normal)) | (end & is(c[i + 1] == ' ')) |
                               is_control(c[i]) | is(c[i] == '\\'));
    }
    counts.vertices += vertices;
    counts.textures += textures;
    counts.normals += normals;
    return odd == 0;
  };
  if (!look(reinterpret_cast<const Byte*>(start.data()), 1)) return std::nullopt;
  if (!for_blocks(text, 'x', [&look](const Byte* c) { return look(c, kBlock); })) {
    return std::nullopt;
  }
  return counts;
}

}  // namespace diesink
