// What the STL reader and writer share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "formats/byte_source.h"
#include "formats/format.h"

namespace diesink {

inline constexpr std::size_t kStlHeaderBytes = 84;  // 80 of text and the count
inline constexpr std::size_t kStlFacetBytes = 50;

bool looks_like_stl(std::span<const std::byte> bytes);

// Binary where 84 + 50·n is the size, whatever the first word says; else ASCII where it begins with
// "solid". Elements: one a named solid of an ASCII file, one a colour of a binary one. Facets whose
// normal opposes their vertices' turn are counted in a warning; the vertices are believed.
Result<TriangleMesh> read_stl(std::span<const std::byte> bytes, const ReadOptions& options,
                              Diagnostics& diagnostics);

// Whether it is a binary file to the byte: 84 + 50·n of them.
bool is_binary_stl(const ByteSource& bytes);

// The two kinds. Needs: kStlHeaderBytes at least of a binary file.
Result<TriangleMesh> read_binary_stl(const ByteSource& bytes, const ReadOptions& options,
                                     Diagnostics& diagnostics);
Result<TriangleMesh> read_ascii_stl(std::string_view text, const ReadOptions& options,
                                    Diagnostics& diagnostics);

}  // namespace diesink
