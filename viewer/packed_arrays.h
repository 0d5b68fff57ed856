// Arrays of whole numbers in a form that deflates well and that a page unpacks fast.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "formats/json_writer.h"

namespace diesink {

// A row of named arrays. Each number is coded against one before it, the small numbers that come
// out are cut into bytes, and all low bytes stand first, then all next ones; bytes that are zero
// throughout are left out. src/packed.js is the other half.
class PackedArrays {
 public:
  // Every number less the one `components` places before it, modulo 2^32, sign in the lowest bit.
  // Needs: a size that is a multiple of `components`.
  void add(std::string_view name, std::span<const std::int32_t> values, std::size_t components);
  // Indices of vertices that are numbered in the order of their first use: the distance from the
  // next new one.
  // Needs: each at most one above the largest before it.
  void add_indices(std::string_view name, std::span<const std::uint32_t> values);

  // {"name":{"code","at","count","components","planes"}, ...}: where each begins in bytes().
  void describe(JsonWriter& json) const;
  [[nodiscard]] const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  struct Entry {
    std::string name, code;
    std::size_t at, count, components, planes;
  };
  void add_planes(std::string_view name, std::string_view code, std::size_t components,
                  std::span<const std::uint32_t> codes);

  std::vector<Entry> entries_;
  std::vector<std::uint8_t> bytes_;
};

// zlib's format, which a page's DecompressionStream("deflate") reads.
// Errors: kLimit where zlib finds no memory.
Result<std::vector<std::uint8_t>> deflated(std::span<const std::uint8_t> bytes);

std::string base64(std::span<const std::uint8_t> bytes);

}  // namespace diesink
