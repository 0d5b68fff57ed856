// Stanford PLY: the reader is in ply_read.cpp.
// SPDX-License-Identifier: Apache-2.0
#include "formats/ply.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "formats/byte_sink.h"
#include "formats/element_runs.h"
#include "formats/registry.h"
#include "formats/text_number.h"
#include "formats/written_mesh.h"

namespace diesink {
namespace {

static_assert(std::endian::native == std::endian::little,
              "binary files are written as memory holds them");

// How the mesh's normals go into the file. A vertex has room for one; where a crease gives it
// several, that one is their mean (so that vertices stay shared and the mesh closed), and the exact
// ones follow in an element of their own.
struct NormalPlan {
  std::vector<Vec3> made;  // a normal a vertex, where they are not the mesh's own one by one
  const Vec3* of_vertex = nullptr;  // null: no normals
  bool split = false;
};

// A vertex of no triangle has no normal to write but zero.
bool uses_every_position(const TriangleMesh& mesh) {
  std::vector<std::uint8_t> used(mesh.positions.size(), 0);
  std::uint8_t* const at = used.data();
  for (const auto& [a, b, c] : mesh.triangles) at[a] = at[b] = at[c] = 1;
  return std::memchr(at, 0, used.size()) == nullptr;
}

NormalPlan plan_normals(const TriangleMesh& mesh, const WriteOptions& options) {
  NormalPlan plan;
  if (!options.normals || mesh.corner_normals.empty()) return plan;
  if (mesh.normals.size() == mesh.positions.size() && mesh.corner_normals == mesh.triangles &&
      uses_every_position(mesh)) {
    plan.of_vertex = mesh.normals.data();
    return plan;
  }
  constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  std::vector<std::uint32_t> first(mesh.positions.size(), kNone);
  plan.made.assign(mesh.positions.size(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t v = mesh.triangles[t][corner], n = mesh.corner_normals[t][corner];
      if (first[v] == kNone) {
        first[v] = n;
        plan.made[v] = mesh.normals[n];
      } else if (first[v] != n) {
        plan.split = true;
      }
    }
  }
  plan.of_vertex = plan.made.data();
  if (!plan.split) return plan;
  std::vector<Vec3> sum(mesh.positions.size(), Vec3::Zero());
  std::vector<bool> several(mesh.positions.size(), false);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t v = mesh.triangles[t][corner], n = mesh.corner_normals[t][corner];
      sum[v] += mesh.normals[n];
      if (n != first[v]) several[v] = true;
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) {
    const double length = sum[v].norm();
    // Opposite normals leave the first one standing.
    if (several[v] && length > 1e-9) plan.made[v] = sum[v] / length;
  }
  return plan;
}

struct Edge {
  std::int32_t a, b, curve;
};

std::vector<Edge> edges_of(const TriangleMesh& mesh, const WriteOptions& options) {
  std::vector<Edge> edges;
  if (!options.lines) return edges;
  for (std::size_t c = 0; c < mesh.curves.size(); ++c) {
    const std::vector<std::uint32_t>& v = mesh.curves[c].vertices;
    const auto add = [&](std::uint32_t a, std::uint32_t b) {
      edges.push_back({static_cast<std::int32_t>(a), static_cast<std::int32_t>(b),
                       static_cast<std::int32_t>(c)});
    };
    for (std::size_t i = 0; i + 1 < v.size(); ++i) add(v[i], v[i + 1]);
    if (mesh.curves[c].closed && v.size() > 1) add(v.back(), v.front());
  }
  return edges;
}

// Either a space-separated line or packed little-endian values.
class Row {
 public:
  Row(ByteWriter& out, bool ascii) : out_(out), ascii_(ascii), at_(out.room(kRow)) {}
  static constexpr std::size_t kRow = 16 * kMaxNumberText;

  void real(double value) {
    if (ascii_) return text(put_number(at_, value));
    value += 0.0;  // -0 becomes 0
    raw(&value, sizeof value);
  }
  void integer(std::int32_t value) {
    if (ascii_) return text(put_integer(at_, static_cast<std::uint64_t>(value)));
    raw(&value, sizeof value);
  }
  void small(std::uint8_t value) {
    if (ascii_) return text(put_integer(at_, value));
    raw(&value, sizeof value);
  }
  void end() {
    if (ascii_) at_[-1] = '\n';
    out_.wrote(at_);
    out_.passed();
  }

 private:
  void text(char* after) {
    *after = ' ';
    at_ = after + 1;
  }
  void raw(const void* value, std::size_t size) {
    std::memcpy(at_, value, size);
    at_ += size;
  }

  ByteWriter& out_;
  bool ascii_;
  char* at_;
};

void write_header(const TriangleMesh& mesh, const WriteOptions& options, const NormalPlan& normals,
                  std::size_t edges, ByteWriter& out) {
  out << "ply\nformat " << (options.ascii ? "ascii" : "binary_little_endian") << " 1.0\n";
  out << "comment " << one_line(options.program_comment) << '\n';
  if (!mesh.name.empty()) out << "comment name " << one_line(mesh.name) << '\n';
  if (mesh.unit != LengthUnit::kUnknown) out << "comment units " << name_of(mesh.unit) << '\n';
  if (mesh.up != UpAxis::kUnknown)
    out << "comment up " << (mesh.up == UpAxis::kZ ? 'z' : 'y') << '\n';
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const MeshElement& element = mesh.elements[e];
    const std::uint64_t number = e;
    out << "comment element " << number << ' ' << one_line(element.name) << '\n';
    if (!element.solid.empty())
      out << "comment solid " << number << ' ' << one_line(element.solid) << '\n';
    if (element.color) {
      out << "comment color " << number;
      for (const std::uint8_t part : *element.color) out << ' ' << std::uint64_t{part};
      out << '\n';
    }
  }
  for (std::size_t c = 0; options.lines && c < mesh.curves.size(); ++c) {
    out << "comment curve " << std::uint64_t{c} << ' ' << curve_label(mesh, mesh.curves[c]) << '\n';
  }
  out << "element vertex " << std::uint64_t{mesh.positions.size()}
      << "\nproperty double x\nproperty double y\nproperty double z\n";
  if (normals.of_vertex != nullptr)
    out << "property double nx\nproperty double ny\nproperty double nz\n";
  if (!mesh.vertex_colors.empty()) {
    out << "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  }
  out << "element face " << std::uint64_t{mesh.triangles.size()}
      << "\nproperty list uchar int vertex_indices\n";
  if (!mesh.elements.empty()) out << "property int element\n";
  if (normals.split) {
    // Three numbers, as OpenMesh's reader does not step over a second list.
    out << "property int normal1\nproperty int normal2\nproperty int normal3\nelement normal "
        << std::uint64_t{mesh.normals.size()}
        << "\nproperty double nx\nproperty double ny\nproperty double nz\n";
  }
  if (edges > 0) {
    out << "element edge " << std::uint64_t{edges}
        << "\nproperty int vertex1\nproperty int vertex2\nproperty int curve\n";
  }
  out << "end_header\n";
}

// Packed rows of `width` bytes, in blocks: put(begin, end, to) writes those of a block.
template <class Put>
void put_blocks(ByteWriter& out, std::size_t count, std::size_t width, Put put) {
  constexpr std::size_t kBlock = 1024;
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t end = std::min(count, begin + kBlock);
    char* const to = out.room((end - begin) * width);
    put(begin, end, to);
    out.wrote(to + (end - begin) * width);
    out.passed(end - begin);
  }
}

char* put_packed(char* to, const Vec3& v) {
  for (int i = 0; i < 3; ++i, to += sizeof(double)) {
    const double value = v[i] + 0.0;  // -0 becomes 0
    std::memcpy(to, &value, sizeof value);
  }
  return to;
}

void write_vertices(const TriangleMesh& mesh, bool ascii, const NormalPlan& normals,
                    ByteWriter& out) {
  const bool colored = !mesh.vertex_colors.empty();
  if (!ascii) {
    const Vec3* const positions = mesh.positions.data();
    const Vec3* const normal = normals.of_vertex;
    const std::size_t width = sizeof(Vec3) * (normal == nullptr ? 1 : 2) + (colored ? 4 : 0);
    put_blocks(out, mesh.positions.size(), width,
               [=, &mesh](std::size_t begin, std::size_t end, char* to) {
                 for (std::size_t v = begin; v < end; ++v) {
                   to = put_packed(to, positions[v]);
                   if (normal != nullptr) to = put_packed(to, normal[v]);
                   if (!colored) continue;
                   std::memcpy(to, mesh.vertex_colors[v].data(), 4);
                   to += 4;
                 }
               });
    return;
  }
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    Row row(out, ascii);
    for (int i = 0; i < 3; ++i) row.real(mesh.positions[v][i]);
    if (normals.of_vertex != nullptr) {
      for (int i = 0; i < 3; ++i) row.real(normals.of_vertex[v][i]);
    }
    if (colored) {
      for (const std::uint8_t part : mesh.vertex_colors[v]) row.small(part);
    }
    row.end();
  }
}

void write_faces(const TriangleMesh& mesh, bool ascii, bool split, ByteWriter& out) {
  const bool named = !mesh.elements.empty();
  if (!ascii) {
    const std::size_t width = 13 + (named ? 4 : 0) + (split ? 12 : 0);
    const auto* const triangles = mesh.triangles.data();
    const auto* const normals = mesh.corner_normals.data();
    put_blocks(out, mesh.triangles.size(), width,
               [=, &mesh](std::size_t begin, std::size_t end, char* to) {
                 for (std::size_t t = begin; t < end; ++t) {
                   *to = 3;
                   std::memcpy(to + 1, &triangles[t], 12);
                   to += 13;
                   if (named) {
                     const std::uint32_t element = element_of(mesh, t);
                     std::memcpy(to, &element, 4);
                     to += 4;
                   }
                   if (!split) continue;
                   std::memcpy(to, &normals[t], 12);
                   to += 12;
                 }
               });
    return;
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Row row(out, ascii);
    row.small(3);
    for (const std::uint32_t v : mesh.triangles[t]) row.integer(static_cast<std::int32_t>(v));
    if (named) row.integer(static_cast<std::int32_t>(element_of(mesh, t)));
    if (split) {
      for (const std::uint32_t n : mesh.corner_normals[t])
        row.integer(static_cast<std::int32_t>(n));
    }
    row.end();
  }
}

Result<WrittenMesh> stream_ply(const TriangleMesh& mesh, const WriteOptions& options,
                               FileSet& files) {
  if (mesh.positions.size() > 0x7FFFFFFFU || mesh.normals.size() > 0x7FFFFFFFU) {
    return Error{ErrorCode::kUnsupported, "PLY counts vertices in 31 bits", {}};
  }
  const Result<ByteSink*> sink = files.file("");
  if (!sink) return sink.error();
  ByteWriter out(**sink);
  const NormalPlan normals = plan_normals(mesh, options);
  const std::vector<Edge> edges = edges_of(mesh, options);
  write_header(mesh, options, normals, edges.size(), out);
  out.expect(mesh.positions.size() + mesh.triangles.size() +
             (normals.split ? mesh.normals.size() : 0) + edges.size());
  write_vertices(mesh, options.ascii, normals, out);
  write_faces(mesh, options.ascii, normals.split, out);
  if (normals.split) {
    for (const Vec3& n : mesh.normals) {
      Row row(out, options.ascii);
      for (int i = 0; i < 3; ++i) row.real(n[i]);
      row.end();
    }
  }
  for (const Edge& edge : edges) {
    Row row(out, options.ascii);
    row.integer(edge.a);
    row.integer(edge.b);
    row.integer(edge.curve);
    row.end();
  }
  if (const Status done = out.finish(); !done) return done.error();
  return WrittenMesh{};
}

constexpr std::array<std::string_view, 1> kExtensions{".ply"};

}  // namespace

const Format kPly{
    .id = "ply",
    .title = "Stanford PLY (binary and ASCII)",
    .extensions = kExtensions,
    .matches = looks_like_ply,
    .read = read_ply,
    .write = write_to_memory<stream_ply>,
    .stream = stream_ply,
    .remarks = "names, colours of elements, units and up axis as comments",
};

}  // namespace diesink
