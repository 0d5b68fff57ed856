// Positions are quantized on one grid for the whole file: Draco's own choice, a grid a primitive,
// opens every crease. The encoder drops degenerate faces, renumbers vertices and can write what its
// decoder refuses, so each blob is decoded again and compared as geometry.
// SPDX-License-Identifier: Apache-2.0
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>

#include "core/parallel.h"
#include "formats/draco_mesh.h"

namespace diesink {
namespace {

using Float3 = std::array<float, 3>;

constexpr int kNormalBits = 10;  // octahedral: about 0.1 degrees

// The distinct positions (or normals) of one primitive.
struct Distinct {
  std::vector<std::uint32_t> number;  // of each vertex
  std::vector<std::uint32_t> source;  // of each number
};

Distinct distinct(std::span<const std::uint32_t> of_vertex) {
  Distinct out;
  out.number.resize(of_vertex.size());
  if (of_vertex.empty()) return out;
  const auto [least, most] = std::minmax_element(of_vertex.begin(), of_vertex.end());
  const std::uint32_t low = *least;
  if ((*most - low) / 16 > of_vertex.size()) {
    // Few numbers from a wide range: a table of the range would cost more than sorting.
    out.source.assign(of_vertex.begin(), of_vertex.end());
    std::sort(out.source.begin(), out.source.end());
    out.source.erase(std::unique(out.source.begin(), out.source.end()), out.source.end());
    for (std::size_t v = 0; v < of_vertex.size(); ++v) {
      const auto at = std::lower_bound(out.source.begin(), out.source.end(), of_vertex[v]);
      out.number[v] = static_cast<std::uint32_t>(at - out.source.begin());
    }
    return out;
  }
  constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  std::vector<std::uint32_t> number(*most - low + 1, kNone);
  for (std::size_t v = 0; v < of_vertex.size(); ++v) {
    std::uint32_t& n = number[of_vertex[v] - low];
    if (n == kNone) {
      n = static_cast<std::uint32_t>(out.source.size());
      out.source.push_back(of_vertex[v]);
    }
    out.number[v] = n;
  }
  return out;
}

int add_floats(draco::Mesh& mesh, draco::GeometryAttribute::Type type,
               std::span<const Float3> values, std::span<const std::uint32_t> of_vertex) {
  const Distinct parts = distinct(of_vertex);
  auto attribute = std::make_unique<draco::PointAttribute>();
  attribute->Init(type, 3, draco::DT_FLOAT32, false, parts.source.size());
  for (std::size_t i = 0; i < parts.source.size(); ++i) {
    attribute->SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(i)),
                                 values[parts.source[i]].data());
  }
  attribute->SetExplicitMapping(of_vertex.size());
  for (std::size_t v = 0; v < of_vertex.size(); ++v) {
    attribute->SetPointMapEntry(draco::PointIndex(static_cast<std::uint32_t>(v)),
                                draco::AttributeValueIndex(parts.number[v]));
  }
  return mesh.AddAttribute(std::move(attribute));
}

int add_colors(draco::Mesh& mesh, std::span<const std::array<std::uint16_t, 4>> colors) {
  auto attribute = std::make_unique<draco::PointAttribute>();
  attribute->Init(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT16, true, colors.size());
  attribute->SetIdentityMapping();
  for (std::size_t v = 0; v < colors.size(); ++v) {
    attribute->SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(v)),
                                 colors[v].data());
  }
  return mesh.AddAttribute(std::move(attribute));
}

int add_element(draco::Mesh& mesh, std::size_t vertices, std::uint32_t element) {
  const std::uint16_t value = static_cast<std::uint16_t>(element);
  auto attribute = std::make_unique<draco::PointAttribute>();
  attribute->Init(draco::GeometryAttribute::GENERIC, 1, draco::DT_UINT16, false, 1);
  attribute->SetAttributeValue(draco::AttributeValueIndex(0), &value);
  attribute->SetExplicitMapping(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    attribute->SetPointMapEntry(draco::PointIndex(static_cast<std::uint32_t>(v)),
                                draco::AttributeValueIndex(0));
  }
  return mesh.AddAttribute(std::move(attribute));
}

std::uint64_t mixed(std::uint64_t h) {
  h ^= h >> 30;
  h *= 0xBF58476D1CE4E5B9u;
  h ^= h >> 27;
  h *= 0x94D049BB133111EBu;
  return h ^ h >> 31;
}

std::uint64_t hash_of(const Float3& point) {
  std::uint64_t h = mixed(std::bit_cast<std::uint32_t>(point[0]) + 0x9E3779B97F4A7C15u);
  h = mixed(h ^ std::bit_cast<std::uint32_t>(point[1]));
  return mixed(h ^ std::bit_cast<std::uint32_t>(point[2]));
}

// Of a triangle whatever corner it begins with, and of a set of them whatever their order; the
// sense counts.
std::uint64_t triangle_hash(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  return mixed(mixed(a + 3 * b) + mixed(b + 3 * c) + mixed(c + 3 * a));
}

std::uint64_t geometry_hash(std::span<const Float3> points,
                            std::span<const std::uint32_t> indices) {
  std::vector<std::uint64_t> of_point(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) of_point[i] = hash_of(points[i]);
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    sum += triangle_hash(of_point[indices[i]], of_point[indices[i + 1]], of_point[indices[i + 2]]);
  }
  return sum;
}

class Encoding {
 public:
  Encoding(const DracoSource& source, const DracoGrid& grid) : source_(source), grid_(grid) {
    const std::size_t vertices = source.position.size();
    mesh_.set_num_points(static_cast<std::uint32_t>(vertices));
    mesh_.SetNumFaces(source.indices.size() / 3);
    for (std::size_t f = 0; f < source.indices.size() / 3; ++f) {
      mesh_.SetFace(
          draco::FaceIndex(static_cast<std::uint32_t>(f)),
          {draco::PointIndex(source.indices[3 * f]), draco::PointIndex(source.indices[3 * f + 1]),
           draco::PointIndex(source.indices[3 * f + 2])});
    }
    position_ =
        add_floats(mesh_, draco::GeometryAttribute::POSITION, source.coordinates, source.position);
    if (!source.normal.empty()) {
      normal_ = add_floats(mesh_, draco::GeometryAttribute::NORMAL, source.normals, source.normal);
    }
    if (!source.colors.empty()) color_ = add_colors(mesh_, source.colors);
    if (source.element < 0x10000u) element_ = add_element(mesh_, vertices, source.element);
    std::vector<Float3> expected(vertices);
    for (std::size_t v = 0; v < vertices; ++v) {
      expected[v] = on_grid(grid, source.coordinates[source.position[v]]);
    }
    hash_ = geometry_hash(expected, source.indices);
  }

  // Encodes in this way and decodes; empty bytes where that does not give the geometry back.
  DracoBlob with(draco::MeshEncoderMethod method, int speed) {
    draco::ExpertEncoder encoder(mesh_);
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(method);
    encoder.SetAttributeExplicitQuantization(position_, grid_.bits, 3, grid_.origin.data(),
                                             grid_.range);
    if (normal_ >= 0) encoder.SetAttributeQuantization(normal_, kNormalBits);
    draco::EncoderBuffer buffer;
    DracoBlob blob;
    if (!encoder.EncodeToBuffer(&buffer).ok() || buffer.size() == 0) return blob;
    tell_progress(0.9);  // measured: decoding and comparing are the other tenth
    const std::byte* const begin = reinterpret_cast<const std::byte*>(buffer.data());
    std::vector<std::byte> bytes(begin, begin + buffer.size());
    blob.position_id = id(position_);
    blob.normal_id = id(normal_);
    blob.color_id = id(color_);
    blob.element_id = id(element_);
    if (comes_back(bytes, blob)) blob.bytes = std::move(bytes);
    return blob;
  }

 private:
  [[nodiscard]] int id(int attribute) const {
    return attribute < 0 ? -1 : static_cast<int>(mesh_.attribute(attribute)->unique_id());
  }

  bool comes_back(std::span<const std::byte> bytes, DracoBlob& blob) const {
    const std::size_t triangles = source_.indices.size() / 3;
    const std::array<DracoRequest, 1> request{
        {{static_cast<std::uint32_t>(blob.position_id), 5126, 3}}};
    const auto decoded = decode_draco(bytes, {triangles, 3 * triangles}, request);
    if (!decoded) return false;
    blob.triangle_count = decoded->indices.size() / 3;
    blob.vertex_count = decoded->attributes[0].size() / sizeof(Float3);
    if (blob.triangle_count != triangles || blob.triangle_count == 0) return false;
    std::vector<Float3> points(blob.vertex_count);
    std::memcpy(points.data(), decoded->attributes[0].data(), decoded->attributes[0].size());
    blob.low = blob.high = points[0];
    for (const Float3& point : points) {
      for (std::size_t k = 0; k < 3; ++k) {
        blob.low[k] = std::min(blob.low[k], point[k]);
        blob.high[k] = std::max(blob.high[k], point[k]);
      }
    }
    return geometry_hash(points, decoded->indices) == hash_;
  }

  const DracoSource& source_;
  const DracoGrid& grid_;
  draco::Mesh mesh_;
  int position_ = -1, normal_ = -1, color_ = -1, element_ = -1;
  std::uint64_t hash_ = 0;
};

}  // namespace

int draco_bits(double range, double tolerance) {
  if (!(tolerance > 0)) return kMostDracoBits;
  const double steps = std::sqrt(3.0) * range / (2 * tolerance) + 1;
  return static_cast<int>(std::clamp(std::ceil(std::log2(steps)), 1.0, double{kMostDracoBits}));
}

// The arithmetic of draco::Quantizer and draco::Dequantizer, in floats as there.
std::array<float, 3> on_grid(const DracoGrid& grid, const std::array<float, 3>& point) {
  const float most = static_cast<float>((1 << grid.bits) - 1);
  const float to_steps = most / grid.range;
  const float step = grid.range / most;
  std::array<float, 3> out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const float steps = (point[k] - grid.origin[k]) * to_steps;
    const std::int32_t nearest = static_cast<std::int32_t>(std::floor(steps + 0.5f));
    out[k] = static_cast<float>(nearest) * step + grid.origin[k];
  }
  return out;
}

Result<DracoBlob> encode_draco(const DracoSource& source, const DracoGrid& grid, int speed) {
  try {
    Encoding encoding(source, grid);
    for (const auto method : {draco::MESH_EDGEBREAKER_ENCODING, draco::MESH_SEQUENTIAL_ENCODING}) {
      DracoBlob blob = encoding.with(method, std::clamp(speed, 0, 10));
      if (!blob.bytes.empty()) return blob;
    }
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kLimit, "not enough memory to compress with Draco", {}};
  }
  return Error{ErrorCode::kUnsupported, "Draco cannot hold these triangles unchanged", {}};
}

}  // namespace diesink
