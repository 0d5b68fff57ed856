// SPDX-License-Identifier: Apache-2.0
#include "formats/glb_container.h"

#include "core/counted.h"

#include <cstdint>
#include <cstring>

namespace diesink {
namespace {

constexpr std::size_t kHeader = 12, kChunkHeader = 8;
constexpr std::uint32_t kJson = 0x4E4F534A, kBin = 0x004E4942;

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, 4);
  return word;
}

Place place(const std::string& file, std::size_t at) {
  Place where;
  where.file = file;
  where.byte = static_cast<std::int64_t>(at);
  return where;
}

}  // namespace

Result<std::uint32_t> glb_size(std::uint64_t json, std::uint64_t buffer) {
  const std::uint64_t size =
      kHeader + kChunkHeader + json + (buffer > 0 ? kChunkHeader + buffer : 0);
  if (size <= 0xFFFFFFFFu) return static_cast<std::uint32_t>(size);
  return Error{ErrorCode::kUnsupported,
               "a GLB holds at most 4294967295 bytes and this mesh needs " + std::to_string(size) +
                   "; write .gltf, .ply or .stl",
               {}};
}

Result<GlbParts> split_glb(std::span<const std::byte> bytes, const std::string& file,
                           Diagnostics& diagnostics) {
  const auto wrong = [&file](std::string what, std::size_t at) {
    return Error{ErrorCode::kInput, std::move(what), place(file, at)};
  };
  if (bytes.size() < kHeader || std::memcmp(bytes.data(), "glTF", 4) != 0) {
    return wrong("the file does not begin with a GLB header", 0);
  }
  if (word_at(bytes, 4) != 2) {
    return wrong("GLB version " + std::to_string(word_at(bytes, 4)) + ", expected 2", 4);
  }
  const std::size_t length = word_at(bytes, 8);
  if (length > bytes.size()) {
    return wrong("the header claims " + std::to_string(length) + " bytes, the file has " +
                     std::to_string(bytes.size()),
                 8);
  }
  if (length < kHeader + kChunkHeader) {
    return wrong("the header claims " + std::to_string(length) + " bytes, expected at least 20", 8);
  }
  if (length < bytes.size()) {
    diagnostics.warning(
        counted(bytes.size() - length,
                "byte after the end of the GLB is|bytes after the end of the GLB are| left out"),
        place(file, length));
  }

  GlbParts parts;
  std::size_t others = 0;
  bool first = true;
  for (std::size_t at = kHeader; at < length; first = false) {
    if (length - at < kChunkHeader) return wrong("the last chunk has no room for its header", at);
    const std::size_t size = word_at(bytes, at);
    const std::uint32_t kind = word_at(bytes, at + 4);
    if (size > length - at - kChunkHeader) {
      return wrong("a chunk claims " + std::to_string(size) + " bytes where " +
                       std::to_string(length - at - kChunkHeader) + " are left",
                   at);
    }
    if (size % 4 != 0) {
      return wrong("a chunk of " + std::to_string(size) + " bytes, expected a multiple of 4", at);
    }
    const std::span<const std::byte> content = bytes.subspan(at + kChunkHeader, size);
    if (first && kind != kJson) return wrong("the first chunk is not JSON", at + 4);
    if (first) {
      parts.json = content;
    } else if (kind == kBin && !parts.has_buffer && others == 0) {
      parts.buffer = content;
      parts.has_buffer = true;
    } else {
      ++others;
    }
    at += kChunkHeader + size;
  }
  if (others > 0) {
    diagnostics.warning(
        counted(others,
                "chunk of the GLB is of no known kind or stands in the wrong place, and is|"
                "chunks of the GLB are of no known kind or stand in the wrong place, and are|"
                " left out"),
        place(file, kHeader));
  }
  return parts;
}

}  // namespace diesink
