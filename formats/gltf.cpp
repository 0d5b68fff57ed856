// glTF 2.0 as text with a .bin beside it, and GLB: the two rows of the registry.
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstring>

#include "formats/byte_sink.h"
#include "formats/glb_container.h"
#include "formats/gltf_read.h"
#include "formats/gltf_text.h"
#include "formats/registry.h"
#include "formats/written_mesh.h"

namespace diesink {
namespace {

std::string_view word(const std::uint32_t& value) {
  return {reinterpret_cast<const char*>(&value), 4};
}

std::size_t aligned(std::size_t size) { return (size + 3) & ~std::size_t{3}; }

WrittenMesh answer_of(GltfLayout& layout) {
  WrittenMesh written;
  written.deviation = layout.deviation;
  written.notes = std::move(layout.notes);
  return written;
}

Result<WrittenMesh> stream_glb(const TriangleMesh& mesh, const WriteOptions& options,
                               FileSet& files) {
  auto layout = lay_out(mesh, options);
  if (!layout) return layout.error();
  auto text = gltf_text(*layout, mesh, options, {});
  if (!text) return text.error();
  text->resize(aligned(text->size()), ' ');
  const std::size_t buffer = layout->buffer_size;
  const Result<std::uint32_t> size = glb_size(text->size(), buffer);
  if (!size) return size.error();
  const Result<ByteSink*> sink = files.file("");
  if (!sink) return sink.error();
  ByteWriter out(**sink);
  const auto put_word = [&out](std::size_t value) {
    out << word(static_cast<std::uint32_t>(value));
  };
  out << "glTF";
  put_word(2);
  put_word(*size);
  put_word(text->size());
  out << "JSON" << *text;
  if (buffer > 0) {
    put_word(buffer);
    out << std::string_view("BIN\0", 4);
    put_buffer(*layout, mesh, out);
  }
  if (const Status done = out.finish(); !done) return done.error();
  return answer_of(*layout);
}

// A file name as a relative URI reference.
std::string to_uri(std::string_view name) {
  constexpr char kHex[] = "0123456789ABCDEF";
  std::string uri;
  for (const char c : name) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                       c == '-' || c == '.' || c == '_' || c == '~';
    if (plain) {
      uri += c;
      continue;
    }
    const unsigned char byte = static_cast<unsigned char>(c);
    uri += '%';
    uri += kHex[byte >> 4];
    uri += kHex[byte & 15];
  }
  return uri;
}

// The buffer inside the text, for outputs that can have no second file.
Result<std::string> data_uri(GltfLayout& layout, const TriangleMesh& mesh) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  MemoryFiles memory;
  const Result<ByteSink*> sink = memory.file("");
  if (!sink) return sink.error();
  ByteWriter out(**sink);
  put_buffer(layout, mesh, out);
  if (const Status done = out.finish(); !done) return done.error();
  const std::vector<FileBytes> files = memory.take();
  const std::vector<std::byte>& bytes = files.front().bytes;
  std::string uri = "data:application/octet-stream;base64,";
  uri.reserve(uri.size() + (bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t triple = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      triple = triple << 8 | (i + k < bytes.size() ? static_cast<std::uint32_t>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      uri += i + k <= bytes.size() ? kDigits[triple >> (18 - 6 * k) & 63] : '=';
    }
  }
  return uri;
}

Result<WrittenMesh> stream_gltf(const TriangleMesh& mesh, const WriteOptions& options,
                                FileSet& files) {
  auto layout = lay_out(mesh, options);
  if (!layout) return layout.error();
  const bool beside = !options.file_stem.empty();
  const std::string bin_name = options.file_stem + ".bin";
  std::string uri;
  if (layout->buffer_size > 0) {
    if (beside) {
      uri = to_uri(bin_name);
    } else {
      auto embedded = data_uri(*layout, mesh);
      if (!embedded) return embedded.error();
      uri = std::move(*embedded);
    }
  }
  const auto text = gltf_text(*layout, mesh, options, uri);
  if (!text) return text.error();
  const Result<ByteSink*> sink = files.file("");
  if (!sink) return sink.error();
  ByteWriter out(**sink);
  out << *text << '\n';
  if (const Status done = out.finish(); !done) return done.error();
  if (beside && layout->buffer_size > 0) {
    const Result<ByteSink*> bin = files.file(bin_name);
    if (!bin) return bin.error();
    ByteWriter bytes(**bin);
    put_buffer(*layout, mesh, bytes);
    if (const Status done = bytes.finish(); !done) return done.error();
  }
  return answer_of(*layout);
}

bool looks_like_glb(std::span<const std::byte> bytes) {
  return bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
}

// JSON's first character is a brace, after blanks and a byte order mark at most.
bool looks_like_gltf(std::span<const std::byte> bytes) {
  std::size_t at = 0;
  if (bytes.size() >= 3 && std::memcmp(bytes.data(), "\xEF\xBB\xBF", 3) == 0) at = 3;
  while (at < bytes.size() && std::strchr(" \t\r\n", std::to_integer<int>(bytes[at])) != nullptr &&
         bytes[at] != std::byte{0}) {
    ++at;
  }
  return at < bytes.size() && bytes[at] == std::byte{'{'};
}

constexpr std::array<std::string_view, 1> kGltfExtensions{".gltf"};
constexpr std::array<std::string_view, 1> kGlbExtensions{".glb"};

}  // namespace

const Format kGltf{
    .id = "gltf",
    .title = "glTF 2.0 with a .bin beside it",
    .extensions = kGltfExtensions,
    .positions = Keeps::kFloat32,
    .normals = Keeps::kFloat32,
    .matches = looks_like_gltf,
    .read = read_gltf,
    .write = write_to_memory<stream_gltf>,
    .stream = stream_gltf,
    .remarks = "metres and Y up by the root node's matrix; Draco",
};

const Format kGlb{
    .id = "glb",
    .title = "glTF 2.0 in one binary file",
    .extensions = kGlbExtensions,
    .positions = Keeps::kFloat32,
    .normals = Keeps::kFloat32,
    .matches = looks_like_glb,
    .read = read_gltf,
    .write = write_to_memory<stream_glb>,
    .stream = stream_glb,
    .remarks = "metres and Y up by the root node's matrix; Draco; at most 4 GiB",
};

}  // namespace diesink
