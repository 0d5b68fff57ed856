// What the readers of indexed formats do with a face once its words are read: limits, polygons,
// elements. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "formats/element_table.h"
#include "formats/format.h"

namespace diesink {

enum class FaceVerdict : std::uint8_t {
  kFine,
  kTooFew,      // fewer than three corners: left out
  kCrossing,    // a polygon that crosses itself, or is flat: cut all the same
  kOutOfRange,  // an index past the vertices
  kTooMany,     // beyond options.max_triangles
};

// Cuts faces into triangles. The positions must be there before the faces.
class FaceBuilder {
 public:
  FaceBuilder(TriangleMesh& mesh, const ReadOptions& options) : mesh_(mesh), options_(options) {}

  // `normals`: empty, or one index a corner. `element`: of the face; the table's numbers.
  FaceVerdict add(std::span<const std::uint32_t> vertices, std::span<const std::uint32_t> normals,
                  std::uint32_t element);

  // Marks a corner without a normal; such a triangle gets its own in finish().
  static constexpr std::uint32_t kNoNormal = 0xFFFFFFFFU;

  // Completes normals and element numbers; how many triangles were given a normal of their own
  // because only others came with one.
  std::size_t finish(ElementTable& elements);

 private:
  TriangleMesh& mesh_;
  const ReadOptions& options_;
  std::vector<Vec3> corners_;
  std::vector<std::array<std::uint32_t, 3>> cut_;
};

// Refuses a mesh of these counts where its positions and triangles alone take more than
// options.max_memory, before anything is allocated. Errors: kLimit, with `where`.
Status mesh_fits(std::size_t vertices, std::size_t triangles, const ReadOptions& options,
                 const Place& where);

// A colour part as files give it: 0..255 where `whole`, else 0..1.
std::uint8_t color_part(double value, bool whole);

}  // namespace diesink
