// Object File Format: the reader is in off_read.cpp.
// SPDX-License-Identifier: Apache-2.0
#include "formats/off.h"

#include <algorithm>
#include <array>

#include "formats/byte_sink.h"
#include "formats/element_runs.h"
#include "formats/registry.h"
#include "formats/text_number.h"
#include "formats/written_mesh.h"

namespace diesink {
namespace {

Result<WrittenMesh> stream_off(const TriangleMesh& mesh, const WriteOptions& options,
                               FileSet& files) {
  const Result<ByteSink*> sink = files.file("");
  if (!sink) return sink.error();
  ByteWriter out(**sink);
  out.expect(mesh.positions.size() + mesh.triangles.size());
  const bool vertex_colors = !mesh.vertex_colors.empty();
  out << (vertex_colors ? "COFF\n" : "OFF\n") << std::uint64_t{mesh.positions.size()} << ' '
      << std::uint64_t{mesh.triangles.size()} << " 0\n";

  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    char* at = out.room(8 * kMaxNumberText);
    for (int k = 0; k < 3; ++k) {
      at = put_number(at, mesh.positions[i][k]);
      *at++ = ' ';
    }
    for (std::size_t c = 0; vertex_colors && c < 4; ++c) {
      at = put_integer(at, mesh.vertex_colors[i][c]);
      *at++ = ' ';
    }
    at[-1] = '\n';
    out.wrote(at);
    out.passed();
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    char* at = out.room(8 * kMaxNumberText);
    *at++ = '3';
    for (const std::uint32_t corner : mesh.triangles[i]) {
      *at++ = ' ';
      at = put_integer(at, corner);
    }
    const std::uint32_t e = element_of(mesh, i);
    if (e < mesh.elements.size() && mesh.elements[e].color) {
      for (const std::uint8_t part : *mesh.elements[e].color) {
        *at++ = ' ';
        at = put_integer(at, part);
      }
    }
    *at++ = '\n';
    out.wrote(at);
    out.passed();
  }
  // Behind the data, where nobody looks: OpenMesh's reader takes a comment for the counts.
  out << "# " << one_line(options.program_comment) << '\n';
  if (!mesh.name.empty()) out << "# name: " << one_line(mesh.name) << '\n';
  if (mesh.unit != LengthUnit::kUnknown) out << "# units: " << name_of(mesh.unit) << '\n';
  if (mesh.up != UpAxis::kUnknown) out << "# up: " << (mesh.up == UpAxis::kZ ? 'z' : 'y') << '\n';
  if (const Status done = out.finish(); !done) return done.error();
  return WrittenMesh{};
}

constexpr std::array<std::string_view, 1> kExtensions{".off"};

}  // namespace

const Format kOff{
    .id = "off",
    .title = "Object File Format",
    .extensions = kExtensions,
    .names = Keeps::kNo,
    .normals = Keeps::kNo,
    .lines = Keeps::kNo,
    .matches = looks_like_off,
    .read = read_off,
    .write = write_to_memory<stream_off>,
    .stream = stream_off,
    .remarks = "units and up axis as comments",
};

}  // namespace diesink
