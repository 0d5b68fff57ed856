// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_draco.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/counted.h"
#include "core/parallel.h"
#include "formats/gltf_color.h"

namespace diesink {
namespace {

using Float3 = std::array<float, 3>;

// The value after Draco's encoder has passed it on as text with six decimals.
float with_six_decimals(float value) {
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.begin(), text.end(), value, std::chars_format::fixed, 6).ptr;
  float read = value;
  std::from_chars(text.begin(), end, read);
  return read;
}

// The nearest value from `value` on, upward or downward, that comes through the encoder's text
// unchanged.
float passing(float value, bool upward) {
  const float towards =
      upward ? std::numeric_limits<float>::infinity() : -std::numeric_limits<float>::infinity();
  for (;;) {
    const float read = with_six_decimals(value);
    if (read == value) return value;
    // Half a decimal further rounds to the next one.
    const float next = value + (upward ? 5e-7f : -5e-7f);
    const bool beyond = upward ? read > value : read < value;
    value = beyond ? read : next != value ? next : std::nextafter(value, towards);
  }
}

// A grid over all coordinates with the given bits.
DracoGrid grid_over(const std::vector<Float3>& coordinates, int bits) {
  Float3 low = coordinates.front();
  Float3 high = low;
  for (const Float3& p : coordinates) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  DracoGrid grid;
  grid.range = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    grid.origin[k] = passing(low[k], false);
    grid.range = std::max(grid.range, high[k] - grid.origin[k]);
  }
  grid.range = grid.range > 0 ? passing(grid.range, true) : 1;
  grid.bits = bits;
  return grid;
}

// The coordinates on the grid, and the largest distance from where the mesh has them.
double put_on_grid(const TriangleMesh& mesh, const DracoGrid& grid, const GltfLayout& layout,
                   std::vector<Float3>& snapped) {
  double worst = 0;
  for (std::size_t i = 0; i < snapped.size(); ++i) {
    snapped[i] = on_grid(grid, layout.coordinates[i]);
    double squared = 0;
    for (int k = 0; k < 3; ++k) {
      const double error = static_cast<double>(snapped[i][static_cast<std::size_t>(k)]) +
                           layout.frame.offset[k] - mesh.positions[i][k];
      squared += error * error;
    }
    worst = std::max(worst, squared);
  }
  return std::sqrt(worst);
}

DracoSource source_of(const TriangleMesh& mesh, const GltfLayout& layout,
                      const GltfPrimitive& primitive, std::vector<LinearColor>& colors) {
  DracoSource source;
  source.coordinates = layout.coordinates;
  source.position = std::span(primitive.position, primitive.vertex_count);
  if (primitive.with_normals) {
    source.normals = layout.normals;
    source.normal = std::span(primitive.normal, primitive.vertex_count);
  }
  if (primitive.colored) {
    colors.resize(primitive.vertex_count);
    for (std::size_t v = 0; v < primitive.vertex_count; ++v) {
      colors[v] = linear_of(mesh.vertex_colors[primitive.position[v]]);
    }
    source.colors = colors;
  }
  source.indices = std::span(primitive.indices, primitive.index_count);
  source.element = primitive.element == MeshCurve::kNoElement ? 0 : primitive.element;
  return source;
}

}  // namespace

Status compress(const TriangleMesh& mesh, const WriteOptions& options, GltfLayout& layout) {
  if (options.quantize_bits &&
      (*options.quantize_bits < 1 || *options.quantize_bits > kMostDracoBits)) {
    return Error{ErrorCode::kUsage,
                 "cannot quantize to " + std::to_string(*options.quantize_bits) +
                     " bits, expected 1 to " + std::to_string(kMostDracoBits),
                 {}};
  }
  if (layout.coordinates.empty()) return ok();
  DracoGrid grid = grid_over(layout.coordinates, kMostDracoBits);
  const double range = static_cast<double>(grid.range);
  const double tolerance = (options.tolerance > 0 ? options.tolerance : 1e-5 * range) / 2;
  grid.bits = options.quantize_bits ? *options.quantize_bits : draco_bits(range, tolerance);
  std::vector<Float3> snapped(layout.coordinates.size());
  layout.deviation = put_on_grid(mesh, grid, layout, snapped);
  // The rounding of floats comes on top of the grid's.
  while (!options.quantize_bits && layout.deviation > tolerance && grid.bits < kMostDracoBits) {
    ++grid.bits;
    layout.deviation = put_on_grid(mesh, grid, layout, snapped);
  }
  if (layout.deviation > 2 * tolerance) {
    layout.notes.push_back("quantized to " + std::to_string(grid.bits) +
                           " bits, coarser than the tolerance");
  }

  std::size_t plain = 0, done = 0;  // elements, indices
  const double all = 3 * static_cast<double>(mesh.triangles.size());
  for (GltfPrimitive& primitive : layout.primitives) {
    if (primitive.lines) continue;
    const double begin = static_cast<double>(done) / all;
    done += primitive.index_count;
    const ProgressSpan span(begin, static_cast<double>(done) / all);
    std::vector<LinearColor> colors;
    auto blob = encode_draco(source_of(mesh, layout, primitive, colors), grid, options.draco_speed);
    tell_progress(1);
    if (!blob) {
      if (blob.error().code != ErrorCode::kUnsupported) return blob.error();
      ++plain;
      continue;
    }
    primitive.blob = static_cast<int>(layout.blobs.size());
    primitive.vertex_count = blob->vertex_count;
    primitive.index_count = 3 * blob->triangle_count;
    primitive.low = blob->low;
    primitive.high = blob->high;
    layout.blobs.push_back(std::move(*blob));
  }
  if (plain > 0) {
    layout.notes.push_back(
        counted(plain, "element|elements| that Draco cannot hold unchanged left uncompressed"));
  }
  layout.coordinates = std::move(snapped);
  return ok();
}

}  // namespace diesink
