// Reads the headers of a Draco stream without decoding it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/result.h"

namespace diesink {

struct DracoClaims {
  std::size_t triangles = 0;
  std::size_t vertices = 0;    // at most; decoding splits some
  std::size_t components = 0;  // of all attributes together, those of 8 bytes counted twice
};

// What the stream claims to hold: a mesh of bitstream 2.2, up to the headers of its attributes.
// Errors: kInput where the bytes end early, are no such mesh, or claim more than so many bytes can
// hold: above
//         100,000 triangles at most 64 a byte, and no more attributes than a vertex can sensibly
//         have.
// Source: Draco bitstream specification 2.2, and the order in which draco 1.5.5 reads.
Result<DracoClaims> survey_draco(std::span<const std::byte> bytes);

}  // namespace diesink
