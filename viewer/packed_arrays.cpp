// SPDX-License-Identifier: Apache-2.0
#include "viewer/packed_arrays.h"

#include <zlib.h>

#include <algorithm>
#include <array>

namespace diesink {

void PackedArrays::add(std::string_view name, std::span<const std::int32_t> values,
                       std::size_t components) {
  std::vector<std::uint32_t> codes(values.size());
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto before = static_cast<std::uint32_t>(k < components ? 0 : values[k - components]);
    const std::uint32_t change = static_cast<std::uint32_t>(values[k]) - before;
    codes[k] = (change << 1) ^ ((change >> 31) != 0 ? 0xFFFFFFFFU : 0U);
  }
  add_planes(name, "delta", components, codes);
}

void PackedArrays::add_indices(std::string_view name, std::span<const std::uint32_t> values) {
  std::vector<std::uint32_t> codes(values.size());
  std::uint32_t next = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    codes[k] = next - values[k];
    if (values[k] == next) ++next;
  }
  add_planes(name, "index", 1, codes);
}

void PackedArrays::add_planes(std::string_view name, std::string_view code, std::size_t components,
                              std::span<const std::uint32_t> codes) {
  std::uint32_t any = 0;
  for (const std::uint32_t each : codes) any |= each;
  std::size_t planes = 0;
  for (; any != 0; any >>= 8) ++planes;
  entries_.push_back({std::string(name), std::string(code), bytes_.size(),
                      codes.size() / components, components, planes});
  for (std::size_t plane = 0; plane < planes; ++plane) {
    // One component after the other: neighbours in the stream are neighbours in space.
    for (std::size_t c = 0; c < components; ++c) {
      for (std::size_t k = c; k < codes.size(); k += components) {
        bytes_.push_back(static_cast<std::uint8_t>(codes[k] >> (8 * plane)));
      }
    }
  }
}

void PackedArrays::describe(JsonWriter& json) const {
  json.begin_object();
  for (const Entry& each : entries_) {
    json.key(each.name)
        .begin_object()
        .field("code", each.code)
        .field("at", static_cast<std::uint64_t>(each.at))
        .field("count", static_cast<std::uint64_t>(each.count))
        .field("components", static_cast<std::uint64_t>(each.components))
        .field("planes", static_cast<std::uint64_t>(each.planes))
        .end_object();
  }
  json.end_object();
}

Result<std::vector<std::uint8_t>> deflated(std::span<const std::uint8_t> bytes) {
  constexpr int kLevel = 6;
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), kLevel) !=
      Z_OK) {
    return Error{ErrorCode::kLimit, "no memory to compress the page", {}};
  }
  packed.resize(size);
  return packed;
}

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - k);
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 3; ++i) word = word << 8 | (i < count ? bytes[k + i] : 0U);
    for (std::size_t i = 0; i < 4; ++i) {
      text += i <= count ? kDigits[word >> (18 - 6 * i) & 63] : '=';
    }
  }
  return text;
}

}  // namespace diesink
