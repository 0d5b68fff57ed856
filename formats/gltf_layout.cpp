// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_layout.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>

#include "core/counted.h"
#include "core/parallel.h"
#include "formats/byte_sink.h"
#include "formats/float_rows.h"
#include "formats/gltf_color.h"
#include "formats/gltf_draco.h"

namespace diesink {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are little endian");

using Float3 = std::array<float, 3>;

constexpr double kLargestCoordinate = 1e9;

// Of the work on a compressed file, the share that encoding and decoding take (measured: 97 %).
constexpr double kDracoWork = 0.97;

std::size_t aligned(std::size_t size) { return (size + 3) & ~std::size_t{3}; }

// A position as the file has it, about the frame's offset.
Float3 float_position(const Vec3& p, const Vec3& offset) {
  // Adding zero turns -0 into 0: one spelling for one point.
  return {static_cast<float>(p.x() - offset.x()) + 0.0f,
          static_cast<float>(p.y() - offset.y()) + 0.0f,
          static_cast<float>(p.z() - offset.z()) + 0.0f};
}

// The coordinates of a run of positions at their lowest and highest. Needs: one at least.
std::array<Vec3, 2> box_of(std::span<const Vec3> run) {
  const FloatRun measured = measure_floats(run, Vec3::Zero(), kLargestCoordinate);
  return {measured.low, measured.high};
}

// Checks the positions, sets their frame, and finds how far floats move them: in one go over them
// where the mesh is about the origin, as most are.
Status measure_positions(const TriangleMesh& mesh, GltfLayout& layout) {
  const std::span<const Vec3> all = mesh.positions;
  double worst = 0;
  bool all_within = true;
  Vec3 low = all.empty() ? Vec3(Vec3::Zero()) : all.front(), high = low;
  const auto for_runs = [&](const Vec3& offset, auto use) {
    for (std::size_t first = 0; first < all.size(); first += GltfLayout::kBoxed) {
      const std::size_t size = std::min(all.size() - first, GltfLayout::kBoxed);
      use(measure_floats(all.subspan(first, size), offset, kLargestCoordinate));
    }
  };
  layout.boxes.reserve(all.size() / GltfLayout::kBoxed + 1);
  for_runs(Vec3::Zero(), [&](const FloatRun& run) {
    layout.boxes.push_back({run.low, run.high});
    low = low.cwiseMin(run.low);
    high = high.cwiseMax(run.high);
    worst = std::max(worst, run.moved_squared);
    all_within &= run.within;
  });
  layout.frame = frame_for(mesh, low, high);
  if (!layout.frame.offset.isZero(0)) {
    worst = 0;
    for_runs(layout.frame.offset,
             [&](const FloatRun& run) { worst = std::max(worst, run.moved_squared); });
  }
  if (!all_within) {
    const auto within = [](const Vec3& p) {
      return std::abs(p.x()) <= kLargestCoordinate && std::abs(p.y()) <= kLargestCoordinate &&
             std::abs(p.z()) <= kLargestCoordinate;
    };
    const auto first = std::find_if_not(mesh.positions.begin(), mesh.positions.end(), within);
    return Error{ErrorCode::kInput,
                 "vertex " + std::to_string(first - mesh.positions.begin()) +
                     " has a coordinate that is not finite or beyond 1e9",
                 {}};
  }
  layout.deviation = std::sqrt(worst);
  return ok();
}

// How far the square of a normal's length may be from 1, a thousandth of the length: such a normal
// stays as it is.
constexpr double kUnitSlack = 2e-3;
bool is_unit(const Vec3& n) { return std::abs(n.squaredNorm() - 1) <= kUnitSlack; }

bool has_direction(const Vec3& n) {
  const double length = n.norm();
  return length > 0 && std::isfinite(length);
}

// A normal as the file has it, of unit length.
Float3 turned_to_unit(const Vec3& n) {
  return float_position(has_direction(n) ? Vec3(n / n.norm()) : Vec3(Vec3::UnitZ()), Vec3::Zero());
}
// `all_unit` is cleared where one was not.
inline Float3 float_normal(const Vec3& n, bool& all_unit) {
  if (!is_unit(n)) [[unlikely]] {
    all_unit = false;
    return turned_to_unit(n);
  }
  return {static_cast<float>(n.x()) + 0.0f, static_cast<float>(n.y()) + 0.0f,
          static_cast<float>(n.z()) + 0.0f};
}

void note_lost_normals(const TriangleMesh& mesh, GltfLayout& layout) {
  const std::ptrdiff_t without =
      std::count_if(mesh.normals.begin(), mesh.normals.end(),
                    [](const Vec3& n) { return !is_unit(n) && !has_direction(n); });
  if (without > 0) {
    layout.notes.push_back(
        counted(static_cast<std::size_t>(without),
                "normal without a direction is|normals without a direction are| written as 0 0 1"));
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
  // Runs in order that leave no gap, as those of a mesh made element by element.
  std::size_t covered = 0;
  for (const SplitPrimitive& part : layout.split.primitives) {
    if (!part.as_given || part.first_vertex > covered) break;
    covered = std::max<std::size_t>(covered, part.first_vertex + part.vertex_count);
  }
  if (covered == count) return;
  std::vector<bool> used(count, false);
  for (const SplitPrimitive& part : layout.split.primitives) {
    const auto first = used.begin() + part.first_vertex;
    if (part.as_given) std::fill(first, first + part.vertex_count, true);
  }
  for (const std::uint32_t position : layout.split.position) used[position] = true;
  for (const std::uint32_t position : layout.lines.position) used[position] = true;
  const std::ptrdiff_t left_out = std::count(used.begin(), used.end(), false);
  if (left_out > 0) {
    layout.notes.push_back(counted(
        static_cast<std::size_t>(left_out),
        "vertex that belongs to no triangle is|vertices that belong to no triangle are| left out"));
  }
}

void set_primitives(const TriangleMesh& mesh, GltfLayout& layout) {
  const SplitMesh& split = layout.split;
  for (const SplitPrimitive& part : split.primitives) {
    GltfPrimitive primitive;
    primitive.element = part.element;
    primitive.with_normals = layout.with_normals;
    if (part.as_given) {
      primitive.base = part.first_vertex;
      primitive.indices = mesh.triangles[part.first_triangle].data();
    } else {
      primitive.indices = split.triangles[part.first_triangle].data();
      primitive.position = split.position.data() + part.first_vertex;
      if (primitive.with_normals) primitive.normal = split.normal.data() + part.first_vertex;
    }
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

// Calls `use` with what gives the positions of the primitive's vertices as the file has them.
template <class Use>
void for_positions(const GltfLayout& layout, const TriangleMesh& mesh,
                   const GltfPrimitive& primitive, Use use) {
  if (!layout.coordinates.empty()) {
    use([&](std::size_t v) { return layout.coordinates[primitive.position_of(v)]; });
  } else if (primitive.position == nullptr) {
    use([first = mesh.positions.data() + primitive.base,
         offset = layout.frame.offset](std::size_t v) { return float_position(first[v], offset); });
  } else {
    use([all = mesh.positions.data(), number = primitive.position, offset = layout.frame.offset](
            std::size_t v) { return float_position(all[number[v]], offset); });
  }
}

using Box = std::array<Vec3, 2>;

// Of a run of the mesh's own positions.
Box box_of_run(const GltfLayout& layout, const TriangleMesh& mesh, const GltfPrimitive& primitive) {
  const std::size_t begin = primitive.base, end = begin + primitive.vertex_count;
  constexpr std::size_t kBoxed = GltfLayout::kBoxed;
  Box bounds{mesh.positions[begin], mesh.positions[begin]};
  const auto add = [&bounds](const Box& box) {
    bounds = {bounds[0].cwiseMin(box[0]), bounds[1].cwiseMax(box[1])};
  };
  for (std::size_t at = begin; at < end;) {
    const std::size_t next = std::min(end, (at / kBoxed + 1) * kBoxed);
    const bool whole = at % kBoxed == 0 && (next % kBoxed == 0 || next == mesh.positions.size());
    add(whole ? layout.boxes[at / kBoxed]
              : box_of(std::span(mesh.positions).subspan(at, next - at)));
    at = next;
  }
  return bounds;
}

// Of the positions with these numbers.
Box box_of_listed(const std::vector<Vec3>& all, std::span<const std::uint32_t> numbers) {
  // Every second one has a box of its own: the next need not wait for the last.
  std::array<Box, 2> boxes;
  boxes.fill({all[numbers.front()], all[numbers.front()]});
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    const Vec3& p = all[numbers[v]];
    auto& [low, high] = boxes[v % 2];
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return {boxes[0][0].cwiseMin(boxes[1][0]), boxes[0][1].cwiseMax(boxes[1][1])};
}

void set_bounds(const GltfLayout& layout, const TriangleMesh& mesh, GltfPrimitive& primitive) {
  if (!layout.coordinates.empty()) {
    primitive.low = primitive.high = layout.coordinates[primitive.position_of(0)];
    for (std::size_t v = 1; v < primitive.vertex_count; ++v) {
      const Float3& p = layout.coordinates[primitive.position_of(v)];
      for (std::size_t k = 0; k < 3; ++k) {
        primitive.low[k] = std::min(primitive.low[k], p[k]);
        primitive.high[k] = std::max(primitive.high[k], p[k]);
      }
    }
    return;
  }
  // Rounding keeps the order of numbers, so what is least before it is least after it.
  const Box box = primitive.position == nullptr
                      ? box_of_run(layout, mesh, primitive)
                      : box_of_listed(mesh.positions, {primitive.position, primitive.vertex_count});
  primitive.low = float_position(box[0], layout.frame.offset);
  primitive.high = float_position(box[1], layout.frame.offset);
}

// Gives every view, and every primitive in it, a place.
void set_places(const TriangleMesh& mesh, GltfLayout& layout) {
  auto& views = layout.views;
  for (GltfPrimitive& primitive : layout.primitives) {
    if (primitive.blob >= 0) continue;
    set_bounds(layout, mesh, primitive);
    const auto place = [&views](GltfViewKind kind, std::size_t size) {
      const std::size_t at = views[kind].size;
      views[kind].size += size;
      return at;
    };
    primitive.index_at = primitive.short_indices() ? place(kShortIndices, 2 * primitive.index_count)
                                                   : place(kLongIndices, 4 * primitive.index_count);
    primitive.position_at = place(kPositions, primitive.vertex_count * sizeof(Float3));
    if (primitive.with_normals) {
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

// Values block by block: `put(begin, size, to)` writes a block of them straight into the writer's
// buffer.
constexpr std::size_t kBlock = 2048;
template <class Value, class Put>
void put_blocks(ByteWriter& out, std::size_t count, Put put) {
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t size = std::min(count - begin, kBlock);
    char* const to = out.room(size * sizeof(Value));
    put(begin, size, to);
    out.wrote(to + size * sizeof(Value));
    out.passed(size * sizeof(Value));
  }
}

// The same one by one: get(i) is a value. A block on the stack is nobody else's, which lets the
// compiler take several values at a time.
template <class Value, class Get>
void put_values(ByteWriter& out, std::size_t count, Get get) {
  put_blocks<Value>(out, count, [&get](std::size_t begin, std::size_t size, char* to) {
    std::array<Value, kBlock> block;
    for (std::size_t i = 0; i < size; ++i) block[i] = get(begin + i);
    std::memcpy(to, block.data(), size * sizeof(Value));
  });
}

void put_padding(ByteWriter& out, std::size_t size) {
  for (std::size_t i = size; i < aligned(size); ++i) out << '\0';
  out.passed(aligned(size) - size);
}

void put_view(const GltfLayout& layout, const TriangleMesh& mesh, GltfViewKind kind,
              const GltfPrimitive& primitive, ByteWriter& out, bool& all_unit) {
  const std::uint32_t* const indices = primitive.indices;
  const std::uint32_t base = primitive.position == nullptr ? primitive.base : 0;
  switch (kind) {
    case kShortIndices:
      if (!primitive.short_indices()) break;
      put_blocks<std::uint16_t>(out, primitive.index_count,
                                [=](std::size_t begin, std::size_t size, char* to) {
                                  put_shorts({indices + begin, size}, base, to);
                                });
      break;
    case kLongIndices:
      if (primitive.short_indices()) break;
      put_blocks<std::uint32_t>(out, primitive.index_count,
                                [=](std::size_t begin, std::size_t size, char* to) {
                                  put_longs({indices + begin, size}, base, to);
                                });
      break;
    case kPositions:
      if (layout.coordinates.empty() && primitive.position == nullptr) {
        const std::span<const Vec3> run(mesh.positions.data() + primitive.base,
                                        primitive.vertex_count);
        put_blocks<Float3>(out, run.size(), [&](std::size_t begin, std::size_t size, char* to) {
          put_floats(run.subspan(begin, size), layout.frame.offset, to);
        });
        break;
      }
      for_positions(layout, mesh, primitive, [&](auto position) {
        put_values<Float3>(out, primitive.vertex_count, position);
      });
      break;
    case kNormals:
      if (!primitive.with_normals) break;
      if (primitive.normal == nullptr) {
        const std::span<const Vec3> run(mesh.normals.data() + primitive.base,
                                        primitive.vertex_count);
        put_blocks<Float3>(out, run.size(), [&](std::size_t begin, std::size_t size, char* to) {
          if (put_unit_floats(run.subspan(begin, size), kUnitSlack, to)) return;
          for (std::size_t v = begin; v < begin + size; ++v, to += sizeof(Float3)) {
            const Float3 normal = float_normal(run[v], all_unit);
            std::memcpy(to, &normal, sizeof normal);
          }
        });
      } else {
        put_values<Float3>(out, primitive.vertex_count,
                           [all = mesh.normals.data(), number = primitive.normal, &all_unit](
                               std::size_t v) { return float_normal(all[number[v]], all_unit); });
      }
      break;
    case kColors:
      if (!primitive.colored) break;
      put_values<LinearColor>(out, primitive.vertex_count, [&](std::size_t v) {
        return linear_of(mesh.vertex_colors[primitive.position_of(v)]);
      });
      break;
    case kViewKinds:
      break;
  }
}

}  // namespace

Result<GltfLayout> lay_out(const TriangleMesh& mesh, const WriteOptions& options) {
  GltfLayout layout;
  if (Status status = measure_positions(mesh, layout); !status) return status.error();
  const bool with_normals =
      options.normals && !mesh.normals.empty() && !mesh.corner_normals.empty();
  auto split = split_by_element(mesh, with_normals, !options.draco);
  if (!split) return split.error();
  layout.split = std::move(*split);
  layout.with_normals = with_normals;
  if (with_normals && options.draco) note_lost_normals(mesh, layout);
  if (options.lines) {
    if (Status status = set_lines(mesh, layout.lines); !status) return status.error();
  }
  note_left_out(mesh, layout);
  set_primitives(mesh, layout);
  if (options.draco) {
    for (const Vec3& p : mesh.positions) {
      layout.coordinates.push_back(float_position(p, layout.frame.offset));
    }
    if (with_normals) {
      bool all_unit = true;
      for (const Vec3& n : mesh.normals) layout.normals.push_back(float_normal(n, all_unit));
    }
    const ProgressSpan span(0, kDracoWork);
    if (Status status = compress(mesh, options, layout); !status) return status.error();
    layout.normals = {};
  }
  set_places(mesh, layout);
  return layout;
}

void put_buffer(GltfLayout& layout, const TriangleMesh& mesh, ByteWriter& out) {
  // Compressing was all the work where there is any of it.
  const ProgressSpan span(layout.blobs.empty() ? 0 : kDracoWork, 1);
  out.expect(layout.buffer_size);
  bool all_unit = true;
  for (int kind = 0; kind < kViewKinds; ++kind) {
    for (const GltfPrimitive& primitive : layout.primitives) {
      if (primitive.blob < 0) {
        put_view(layout, mesh, static_cast<GltfViewKind>(kind), primitive, out, all_unit);
      }
    }
    put_padding(out, layout.views[static_cast<std::size_t>(kind)].size);
  }
  for (const DracoBlob& blob : layout.blobs) {
    out << std::string_view(reinterpret_cast<const char*>(blob.bytes.data()), blob.bytes.size());
    put_padding(out, blob.bytes.size());
    out.passed(blob.bytes.size());
  }
  if (!all_unit) note_lost_normals(mesh, layout);
}

}  // namespace diesink
