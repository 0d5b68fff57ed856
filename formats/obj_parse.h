// The statements of an OBJ file, or of a section of one, before they are put together.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/vec.h"
#include "formats/element_table.h"
#include "formats/format.h"
#include "formats/text_scanner.h"
#include "formats/text_sections.h"

namespace diesink {

// Of the comments in front of the first vertex so many are looked at.
inline constexpr std::size_t kMaxObjComments = 64;

// How many vertices, texture coordinates and normals there are.
struct ObjCounts {
  std::size_t vertices = 0, textures = 0, normals = 0;
};

// A statement that holds for the faces after it, or a line.
struct ObjEvent {
  enum class Kind : std::uint8_t { kGroup, kObject, kMaterial, kLibrary, kLine };
  Kind kind = Kind::kGroup;
  std::size_t face = 0;   // number of faces before it in the section
  std::string_view name;  // or, for a line, where its statement is
  std::size_t first = 0;  // a line's vertices in line_vertices
  std::size_t count = 0;
};

struct alignas(kOwnLines) ObjSection {
  // Of the file in front of the section, where it is `counted`. Most sections can be read without
  // knowing it, all at once: those that count backwards cannot, and stop with `needs_counts`; of
  // the others `ahead` says how many vertices have to be in front for no face to name one behind
  // itself.
  bool counted = false, needs_counts = false;
  ObjCounts before;
  std::int64_t ahead = 0;
  std::vector<Vec3> positions;
  std::vector<Color> colors;  // empty, or one a position
  std::vector<Vec3> normals;
  // Faces one after the other, numbers from 0. Sizes are empty where all have three corners,
  // normals where none has.
  std::vector<std::uint32_t> face_vertices;
  std::vector<std::uint32_t> face_normals;
  std::vector<std::uint32_t> face_sizes;
  std::size_t faces = 0;
  std::vector<std::uint32_t> line_vertices;
  std::vector<ObjEvent> events;
  std::vector<std::string_view> comments;  // in front of its vertices, for units and up axis
  std::size_t textures = 0;                // vt statements
  std::uint64_t last_texture = 0;          // the largest number a face uses, from 1
  Tally odd_weights, uncolored, points, unknown, forward, partial_normals, no_direction,
      bad_texture;
  std::string_view first_unknown;
};

// The counts of a section, told from the lines' first words alone.
ObjCounts count_obj(TextScanner section);

// Reads a section, which is empty but for `before` where that is counted.
Status parse_obj(TextScanner text, const ReadOptions& options, ObjSection& section);

// The start of the face with this number in the section, for messages.
const char* find_obj_face(TextScanner text, std::size_t face);

}  // namespace diesink
