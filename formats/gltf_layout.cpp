// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_layout.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "formats/byte_sink.h"
#include "formats/gltf_color.h"
#include "formats/gltf_draco.h"

namespace diesink {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are little endian");

using Float3 = std::array<float, 3>;

constexpr double kLargestCoordinate = 1e9;

std::size_t aligned(std::size_t size) { return (size + 3) & ~std::size_t{3}; }

// The positions as floats about the frame's offset, and how far that moves them.
Status set_coordinates(const TriangleMesh& mesh, GltfLayout& layout) {
  layout.coordinates.resize(mesh.positions.size());
  const Vec3 offset = layout.frame.offset;
  double worst = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3& p = mesh.positions[i];
    double squared = 0;
    bool within = true;
    for (int k = 0; k < 3; ++k) {
      within = within && std::abs(p[k]) <= kLargestCoordinate;  // false for NaN
      // Adding zero turns -0 into 0: one spelling for one point.
      const float f = static_cast<float>(p[k] - offset[k]) + 0.0f;
      layout.coordinates[i][static_cast<std::size_t>(k)] = f;
      const double error = static_cast<double>(f) + offset[k] - p[k];
      squared += error * error;
    }
    if (!within) {
      return Error{
          ErrorCode::kInput,
          "vertex " + std::to_string(i) + " has a coordinate that is not finite or beyond 1e9",
          {}};
    }
    worst = std::max(worst, squared);
  }
  layout.deviation = std::sqrt(worst);
  return ok();
}

// Unit normals as floats; a note tells of those that had no direction.
void set_normals(const TriangleMesh& mesh, GltfLayout& layout) {
  std::size_t without = 0;
  layout.normals.resize(mesh.normals.size());
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    Vec3 n = mesh.normals[i];
    const double length = n.norm();
    if (!(length > 0) || !std::isfinite(length)) {
      n = Vec3::UnitZ();
      ++without;
    } else if (std::abs(length - 1) > 1e-3) {
      n /= length;
    }
    for (int k = 0; k < 3; ++k) {
      layout.normals[i][static_cast<std::size_t>(k)] = static_cast<float>(n[k]) + 0.0f;
    }
  }
  if (without > 0) {
    layout.notes.push_back(std::to_string(without) +
                           " normals without a direction are written as 0 0 1");
  }
}

Status set_lines(const TriangleMesh& mesh, GltfLines& lines) {
  for (const MeshCurve& curve : mesh.curves) {
    const std::size_t count = curve.vertices.size();
    if (count < 2) continue;
    const std::uint32_t first = static_cast<std::uint32_t>(lines.position.size());
    for (const std::uint32_t vertex : curve.vertices) {
      if (vertex >= mesh.positions.size()) {
        return Error{ErrorCode::kInput, "a curve has a vertex beyond those of the mesh", {}};
      }
      lines.position.push_back(vertex);
    }
    const std::uint32_t last = static_cast<std::uint32_t>(lines.position.size() - 1);
    for (std::uint32_t v = first; v < last; ++v) lines.index.insert(lines.index.end(), {v, v + 1});
    if (curve.closed && count > 2) lines.index.insert(lines.index.end(), {last, first});
    lines.curves.push_back(&curve);
  }
  return ok();
}

// Tells of vertices that no primitive uses: glTF has no place for them.
void note_left_out(const TriangleMesh& mesh, GltfLayout& layout) {
  const std::size_t count = mesh.positions.size();
  if (layout.split.used_positions == count) return;
  std::vector<bool> used(count, false);
  for (const std::uint32_t position : layout.split.position) used[position] = true;
  for (const std::uint32_t position : layout.lines.position) used[position] = true;
  const std::ptrdiff_t left_out = std::count(used.begin(), used.end(), false);
  if (left_out > 0) {
    layout.notes.push_back(std::to_string(left_out) +
                           " vertices that belong to no triangle are left out");
  }
}

void set_primitives(const TriangleMesh& mesh, GltfLayout& layout) {
  const SplitMesh& split = layout.split;
  for (const SplitPrimitive& part : split.primitives) {
    GltfPrimitive primitive;
    primitive.element = part.element;
    primitive.indices = split.triangles[part.first_triangle].data();
    primitive.position = split.position.data() + part.first_vertex;
    if (!split.normal.empty()) primitive.normal = split.normal.data() + part.first_vertex;
    primitive.colored = !mesh.vertex_colors.empty();
    primitive.vertex_count = part.vertex_count;
    primitive.index_count = 3 * part.triangle_count;
    layout.primitives.push_back(primitive);
  }
  if (!layout.lines.index.empty()) {
    GltfPrimitive primitive;
    primitive.lines = true;
    primitive.indices = layout.lines.index.data();
    primitive.position = layout.lines.position.data();
    primitive.vertex_count = layout.lines.position.size();
    primitive.index_count = layout.lines.index.size();
    layout.primitives.push_back(primitive);
  }
}

void set_bounds(const std::vector<Float3>& coordinates, GltfPrimitive& primitive) {
  primitive.low = primitive.high = coordinates[primitive.position[0]];
  for (std::size_t v = 0; v < primitive.vertex_count; ++v) {
    const Float3& p = coordinates[primitive.position[v]];
    for (std::size_t k = 0; k < 3; ++k) {
      primitive.low[k] = std::min(primitive.low[k], p[k]);
      primitive.high[k] = std::max(primitive.high[k], p[k]);
    }
  }
}

// Gives every view, and every primitive in it, a place.
void set_places(GltfLayout& layout) {
  auto& views = layout.views;
  for (GltfPrimitive& primitive : layout.primitives) {
    if (primitive.blob >= 0) continue;
    set_bounds(layout.coordinates, primitive);
    const auto place = [&views](GltfViewKind kind, std::size_t size) {
      const std::size_t at = views[kind].size;
      views[kind].size += size;
      return at;
    };
    primitive.index_at = primitive.short_indices() ? place(kShortIndices, 2 * primitive.index_count)
                                                   : place(kLongIndices, 4 * primitive.index_count);
    primitive.position_at = place(kPositions, primitive.vertex_count * sizeof(Float3));
    if (primitive.normal != nullptr) {
      primitive.normal_at = place(kNormals, primitive.vertex_count * sizeof(Float3));
    }
    if (primitive.colored) {
      primitive.color_at = place(kColors, primitive.vertex_count * sizeof(LinearColor));
    }
  }
  views[kPositions].stride = views[kNormals].stride = sizeof(Float3);
  views[kColors].stride = sizeof(LinearColor);
  for (GltfView& view : views) {
    view.offset = layout.buffer_size;
    layout.buffer_size += aligned(view.size);
  }
  for (const DracoBlob& blob : layout.blobs) {
    layout.blob_at.push_back(layout.buffer_size);
    layout.buffer_size += aligned(blob.bytes.size());
  }
}

// Writes values of `size` bytes through the writer's own buffer, a block at a time.
template <class Put>
void put_values(ByteWriter& out, std::size_t count, std::size_t size, Put put) {
  const std::size_t block = ByteWriter::kBuffer / 4 / size;
  for (std::size_t begin = 0; begin < count; begin += block) {
    const std::size_t end = std::min(count, begin + block);
    char* at = out.room((end - begin) * size);
    for (std::size_t i = begin; i < end; ++i, at += size) put(i, at);
    out.wrote(at);
  }
}

void put_padding(ByteWriter& out, std::size_t size) {
  for (std::size_t i = size; i < aligned(size); ++i) out << '\0';
}

void put_view(const GltfLayout& layout, const TriangleMesh& mesh, GltfViewKind kind,
              const GltfPrimitive& primitive, ByteWriter& out) {
  const std::size_t vertices = primitive.vertex_count;
  switch (kind) {
    case kShortIndices:
      if (!primitive.short_indices()) break;
      put_values(out, primitive.index_count, 2, [&](std::size_t i, char* at) {
        const std::uint16_t index = static_cast<std::uint16_t>(primitive.indices[i]);
        std::memcpy(at, &index, 2);
      });
      break;
    case kLongIndices:
      if (primitive.short_indices()) break;
      put_values(out, primitive.index_count, 4,
                 [&](std::size_t i, char* at) { std::memcpy(at, &primitive.indices[i], 4); });
      break;
    case kPositions:
      put_values(out, vertices, sizeof(Float3), [&](std::size_t v, char* at) {
        std::memcpy(at, layout.coordinates[primitive.position[v]].data(), sizeof(Float3));
      });
      break;
    case kNormals:
      if (primitive.normal == nullptr) break;
      put_values(out, vertices, sizeof(Float3), [&](std::size_t v, char* at) {
        std::memcpy(at, layout.normals[primitive.normal[v]].data(), sizeof(Float3));
      });
      break;
    case kColors:
      if (!primitive.colored) break;
      put_values(out, vertices, sizeof(LinearColor), [&](std::size_t v, char* at) {
        const LinearColor color = linear_of(mesh.vertex_colors[primitive.position[v]]);
        std::memcpy(at, color.data(), sizeof(LinearColor));
      });
      break;
    case kViewKinds:
      break;
  }
}

}  // namespace

Result<GltfLayout> lay_out(const TriangleMesh& mesh, const WriteOptions& options) {
  GltfLayout layout;
  layout.frame = frame_for(mesh);
  if (Status status = set_coordinates(mesh, layout); !status) return status.error();
  const bool with_normals =
      options.normals && !mesh.normals.empty() && !mesh.corner_normals.empty();
  auto split = split_by_element(mesh, with_normals);
  if (!split) return split.error();
  layout.split = std::move(*split);
  if (with_normals) set_normals(mesh, layout);
  if (options.lines) {
    if (Status status = set_lines(mesh, layout.lines); !status) return status.error();
  }
  note_left_out(mesh, layout);
  set_primitives(mesh, layout);
  if (options.draco) {
    if (Status status = compress(mesh, options, layout); !status) return status.error();
  }
  set_places(layout);
  return layout;
}

void put_buffer(const GltfLayout& layout, const TriangleMesh& mesh, ByteWriter& out) {
  for (int kind = 0; kind < kViewKinds; ++kind) {
    for (const GltfPrimitive& primitive : layout.primitives) {
      if (primitive.blob < 0) {
        put_view(layout, mesh, static_cast<GltfViewKind>(kind), primitive, out);
      }
    }
    put_padding(out, layout.views[static_cast<std::size_t>(kind)].size);
  }
  for (const DracoBlob& blob : layout.blobs) {
    out << std::string_view(reinterpret_cast<const char*>(blob.bytes.data()), blob.bytes.size());
    put_padding(out, blob.bytes.size());
  }
}

}  // namespace diesink
