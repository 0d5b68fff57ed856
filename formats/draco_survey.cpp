// Walks over a stream in the order in which draco 1.5.5 reads it, keeping nothing. Only the symbols
// of the valence traversal have to be decoded to be passed over.
// SPDX-License-Identifier: Apache-2.0
#include "formats/draco_survey.h"

#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/core/decoder_buffer.h>
#include <draco/core/varint_decoding.h>

#include <cstring>
#include <string>
#include <vector>

namespace diesink {
namespace {

constexpr std::size_t kTrianglesOfAny = 100'000;  // a stream of any length may claim so many
constexpr std::size_t kTrianglesPerByte = 64;     // a flat regular grid comes to 40
constexpr std::size_t kConnectivities = 8;  // seams of as many attributes, at the most triangles
constexpr std::size_t kComponents = 24;     // as many numbers a vertex, at the most triangles
constexpr int kMostMetadataDepth = 16;

Error wrong(std::string what) { return Error{ErrorCode::kInput, "Draco: " + std::move(what), {}}; }
Error ends_early() { return wrong("the stream ends early"); }

class Survey {
 public:
  explicit Survey(std::span<const std::byte> bytes)
      : budget_(kTrianglesOfAny + kTrianglesPerByte * bytes.size()) {
    in_.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }

  Result<DracoClaims> run();

 private:
  template <class T>
  bool fixed(T& value) {
    return in_.Decode(&value);
  }
  bool varint(std::uint32_t& value) { return draco::DecodeVarint(&value, &in_); }
  bool skip(std::uint64_t size) {
    if (size > static_cast<std::uint64_t>(in_.remaining_size())) return false;
    in_.Advance(static_cast<std::int64_t>(size));
    return true;
  }
  // A run of arithmetic-coded bits: a probability, a size, the bits.
  bool skip_coded_bits() {
    std::uint32_t size = 0;
    return skip(1) && varint(size) && skip(size);
  }
  bool skip_metadata(int depth);
  bool skip_geometry_metadata();
  bool skip_topology_splits();
  bool skip_valence_symbols();

  Status sequential();
  Status edgebreaker();
  Status attributes(bool traversal);
  Status check_claims(std::size_t connectivities) const;

  draco::DecoderBuffer in_;
  std::size_t budget_;
  DracoClaims claims_;
};

bool Survey::skip_metadata(int depth) {
  if (depth > kMostMetadataDepth) return false;
  std::uint32_t count = 0;
  if (!varint(count)) return false;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint8_t name = 0;
    std::uint32_t size = 0;
    if (!fixed(name) || !skip(name) || !varint(size) || size == 0 || !skip(size)) return false;
  }
  if (!varint(count)) return false;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint8_t name = 0;
    if (!fixed(name) || !skip(name) || !skip_metadata(depth + 1)) return false;
  }
  return true;
}

bool Survey::skip_geometry_metadata() {
  std::uint32_t count = 0;
  if (!varint(count)) return false;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint32_t id = 0;
    if (!varint(id) || !skip_metadata(0)) return false;
  }
  return skip_metadata(0);
}

bool Survey::skip_topology_splits() {
  std::uint32_t splits = 0;
  if (!varint(splits) || splits > claims_.triangles) return false;
  for (std::uint32_t i = 0; i < splits; ++i) {
    std::uint32_t delta = 0;
    if (!varint(delta) || !varint(delta)) return false;
  }
  return skip((std::uint64_t{splits} + 7) / 8);  // one bit each
}

bool Survey::skip_valence_symbols() {
  constexpr int kContexts = 6;  // valences 2 to 7
  std::size_t left = claims_.triangles;
  for (int i = 0; i < kContexts; ++i) {
    std::uint32_t count = 0;
    if (!varint(count) || count > left) return false;
    left -= count;
    if (count == 0) continue;
    std::vector<std::uint32_t> symbols(count);
    if (!draco::DecodeSymbols(count, 1, &in_, symbols.data())) return false;
  }
  return true;
}

Status Survey::check_claims(std::size_t connectivities) const {
  const std::size_t triangles = claims_.triangles;
  if (triangles > budget_ || connectivities * triangles > kConnectivities * budget_) {
    return wrong("the stream claims " + std::to_string(triangles) + " triangles with " +
                 std::to_string(connectivities) +
                 " seamed attributes, more than its bytes can hold");
  }
  if (claims_.vertices > 3 * triangles) {
    return wrong("the stream claims " + std::to_string(claims_.vertices) + " vertices for " +
                 std::to_string(triangles) + " triangles");
  }
  return ok();
}

Status Survey::sequential() {
  std::uint32_t triangles = 0, points = 0;
  std::uint8_t method = 0;
  if (!varint(triangles) || !varint(points) || !fixed(method)) return ends_early();
  claims_.triangles = triangles;
  claims_.vertices = points;
  if (Status s = check_claims(0); !s) return s;
  const std::uint64_t indices = std::uint64_t{triangles} * 3;
  if (method == 0) {
    std::vector<std::uint32_t> symbols(indices);
    if (!draco::DecodeSymbols(static_cast<std::uint32_t>(indices), 1, &in_, symbols.data())) {
      return wrong("the indices are damaged");
    }
    return ok();
  }
  if (points >= 1u << 16 && points < 1u << 21) {
    std::uint32_t index = 0;
    for (std::uint64_t i = 0; i < indices; ++i) {
      if (!varint(index)) return ends_early();
    }
    return ok();
  }
  const std::uint64_t size = points < 256 ? 1 : points < (1u << 16) ? 2 : 4;
  return skip(indices * size) ? ok() : Status(ends_early());
}

Status Survey::edgebreaker() {
  constexpr std::uint8_t kStandard = 0, kValence = 2;
  std::uint8_t traversal = 0, connectivities = 0;
  std::uint32_t vertices = 0, triangles = 0, symbols = 0, splits = 0;
  if (!fixed(traversal) || !varint(vertices) || !varint(triangles) || !fixed(connectivities) ||
      !varint(symbols) || !varint(splits)) {
    return ends_early();
  }
  claims_.triangles = triangles;
  claims_.vertices = vertices;
  if (Status s = check_claims(connectivities); !s) return s;
  if (symbols > triangles || splits > symbols) return wrong("more symbols than triangles");
  if (!skip_topology_splits()) return wrong("the topology splits are damaged");
  if (traversal != kStandard && traversal != kValence) {
    return wrong("unknown traversal " + std::to_string(traversal));
  }
  if (traversal == kStandard) {
    std::uint64_t size = 0;
    if (!draco::DecodeVarint(&size, &in_) || !skip(size)) return ends_early();
  }
  if (!skip_coded_bits()) return ends_early();  // start faces
  for (int i = 0; i < connectivities; ++i) {
    if (!skip_coded_bits()) return ends_early();  // seams
  }
  if (traversal == kValence && !skip_valence_symbols()) {
    return wrong("the traversal's symbols are damaged");
  }
  return ok();
}

Status Survey::attributes(bool traversal) {
  std::uint8_t decoders = 0;
  if (!fixed(decoders)) return ends_early();
  // Which connectivity, which kind, which traversal.
  if (traversal && !skip(std::uint64_t{decoders} * 3)) return ends_early();
  for (int d = 0; d < decoders; ++d) {
    std::uint32_t count = 0;
    if (!varint(count) || count > static_cast<std::uint64_t>(in_.remaining_size())) {
      return ends_early();
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      std::uint8_t kind = 0, type = 0, components = 0, normalized = 0;
      std::uint32_t id = 0;
      if (!fixed(kind) || !fixed(type) || !fixed(components) || !fixed(normalized) || !varint(id)) {
        return ends_early();
      }
      // 64-bit integers and doubles take twice the room.
      const bool is_long = type == 7 || type == 8 || type == 10;
      claims_.components += std::size_t{components} * (is_long ? 2 : 1) + 1;
    }
    if (claims_.components * claims_.triangles > kComponents * budget_) {
      return wrong("the stream claims more attributes than its bytes can hold");
    }
    if (!skip(count)) return ends_early();  // how each is coded
  }
  return ok();
}

Result<DracoClaims> Survey::run() {
  constexpr std::uint8_t kMesh = 1;
  constexpr std::uint16_t kHasMetadata = 0x8000;
  char magic[5];
  std::uint8_t major = 0, minor = 0, geometry = 0, method = 0;
  std::uint16_t flags = 0;
  if (!in_.Decode(magic, sizeof magic) || std::memcmp(magic, "DRACO", sizeof magic) != 0) {
    return wrong("the stream does not begin with DRACO");
  }
  if (!fixed(major) || !fixed(minor) || !fixed(geometry) || !fixed(method) || !fixed(flags)) {
    return ends_early();
  }
  if (major != 2 || minor != 2) {
    return wrong("bitstream " + std::to_string(major) + "." + std::to_string(minor) +
                 ", expected 2.2");
  }
  if (geometry != kMesh || method > 1) return wrong("the stream holds no triangle mesh");
  in_.set_bitstream_version(DRACO_BITSTREAM_VERSION(2, 2));
  if ((flags & kHasMetadata) != 0 && !skip_geometry_metadata()) {
    return wrong("the metadata are damaged");
  }
  const bool traversal = method == 1;
  if (Status s = traversal ? edgebreaker() : sequential(); !s) return s.error();
  if (Status s = attributes(traversal); !s) return s.error();
  return claims_;
}

}  // namespace

Result<DracoClaims> survey_draco(std::span<const std::byte> bytes) { return Survey(bytes).run(); }

}  // namespace diesink
