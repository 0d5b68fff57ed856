// What the OBJ reader and writer share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "formats/format.h"

namespace diesink {

// The material of elements that have none, in a file where others have one.
inline constexpr std::string_view kObjNoMaterial = "none";

// Stands between the solid and the element in the material of an element that differs in colour
// from its solid.
inline constexpr char kObjOwnColor = ':';

// True where the first statement is one of OBJ's.
bool looks_like_obj(std::span<const std::byte> bytes);

// Groups become elements (or, without any, objects; or materials); polygons are cut into triangles.
// Colours are taken from the material library where options.folder is given and holds it; it is
// never looked for elsewhere.
Result<TriangleMesh> read_obj(std::span<const std::byte> bytes, const ReadOptions& options,
                              Diagnostics& diagnostics);

}  // namespace diesink
