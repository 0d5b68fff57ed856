// Draco mesh compression as KHR_draco_mesh_compression uses it: one primitive in, one primitive
// out. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"

namespace diesink {

// A grid of quantization common to all primitives of a file: equal positions stay equal to the bit.
// Units: those of the positions. Points must lie in [origin, origin + range] on every axis.
// Needs: origin and range that six decimals hold exactly: the library passes them on as text.
struct DracoGrid {
  std::array<float, 3> origin{0, 0, 0};
  float range = 1;
  int bits = 14;  // 1..24
};

inline constexpr int kMostDracoBits = 24;  // a float has no more

// The fewest bits, at most 24, for which a point moves by at most `tolerance`.
int draco_bits(double range, double tolerance);

// Where a decoder finds a point that was encoded on the grid.
std::array<float, 3> on_grid(const DracoGrid& grid, const std::array<float, 3>& point);

// One primitive. Needs: indices in range, finite coordinates, every vertex used by a triangle.
struct DracoSource {
  std::span<const std::array<float, 3>> coordinates;
  std::span<const std::uint32_t> position;  // of each vertex, into coordinates
  std::span<const std::array<float, 3>> normals;
  std::span<const std::uint32_t> normal;  // of each vertex, into normals; empty without
  std::span<const std::array<std::uint16_t, 4>> colors;  // of each vertex; empty without
  std::span<const std::uint32_t> indices;                // three a triangle
  std::uint32_t element = 0;  // written on every vertex where it fits 16 bits
};

struct DracoBlob {
  std::vector<std::byte> bytes;
  std::size_t vertex_count = 0, triangle_count = 0;                     // as decoded
  std::array<float, 3> low{}, high{};                                   // of the decoded positions
  int position_id = 0, normal_id = -1, color_id = -1, element_id = -1;  // -1: not written
};

// Encodes and decodes again. The decoded triangles are the given ones, each vertex at its on_grid()
// place. Speed: 0 (smallest) .. 10 (fastest). Errors: kUnsupported where the library cannot hold
// this geometry unchanged.
Result<DracoBlob> encode_draco(const DracoSource& source, const DracoGrid& grid, int speed);

// An attribute wanted from a compressed primitive, in the form its accessor names.
struct DracoRequest {
  std::uint32_t unique_id = 0;
  int component_type = 5126;  // glTF's number
  int components = 3;
};

struct DracoLimits {
  std::size_t triangles = 0;  // exactly so many are expected
  std::size_t vertices = 0;   // so many at most
};

struct DecodedDraco {
  std::vector<std::uint32_t> indices;              // three a triangle
  std::vector<std::vector<std::byte>> attributes;  // one a request, tightly packed
  std::size_t vertex_count = 0;
};

// Decodes a primitive of somebody's file. What the bytes claim is checked before anything is
// allocated. Errors: kInput where they are no Draco mesh of bitstream 2.2, claim more than they can
// hold, or differ from
//         the limits or the requests; kLimit where memory is lacking. Every index is below
//         limits.vertices.
Result<DecodedDraco> decode_draco(std::span<const std::byte> bytes, const DracoLimits& limits,
                                  std::span<const DracoRequest> requests);

}  // namespace diesink
