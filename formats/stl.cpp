// STL: the reader is in stl_read.cpp.
// SPDX-License-Identifier: Apache-2.0
#include "formats/stl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "formats/byte_sink.h"
#include "formats/element_runs.h"
#include "formats/facet_rows.h"
#include "formats/float_rows.h"
#include "formats/registry.h"
#include "formats/text_number.h"
#include "formats/written_mesh.h"

namespace diesink {
namespace {

static_assert(std::endian::native == std::endian::little,
              "binary files are written as memory holds them");

// 80 bytes that never begin with "solid": the units first, since a long name is cut.
std::array<char, 80> binary_header(const TriangleMesh& mesh, const WriteOptions& options) {
  std::string text = one_line(options.program_comment);
  if (text.empty() || text.starts_with("solid")) text = "diesink";
  if (text.size() > 24) text.resize(24);
  if (mesh.unit != LengthUnit::kUnknown) text.append(" units=").append(name_of(mesh.unit));
  if (mesh.up != UpAxis::kUnknown) text.append(mesh.up == UpAxis::kZ ? " up=z" : " up=y");
  // Another program would take "COLOR=" in a name for the Magics colour mark.
  if (!mesh.name.empty() && mesh.name.find("COLOR=") == std::string::npos) {
    text.append(" name=").append(one_line(mesh.name));
  }
  std::array<char, 80> header{};
  std::memcpy(header.data(), text.data(), std::min(text.size(), header.size()));
  return header;
}

// The layout of VisCAM and SolidView: bit 15 says that a colour is there, then 5 bits each of red,
// green, blue.
std::uint16_t attribute_of(const MeshElement& element) {
  if (!element.color) return 0;
  const auto five = [&](std::size_t i) {
    return static_cast<unsigned>((*element.color)[i] * 31 + 127) / 255;
  };
  return static_cast<std::uint16_t>(0x8000U | five(0) << 10 | five(1) << 5 | five(2));
}

Result<WrittenMesh> stream_binary(const TriangleMesh& mesh, const WriteOptions& options,
                                  FileSet& files) {
  if (mesh.triangles.size() > 0xFFFFFFFFU) {
    return Error{ErrorCode::kUnsupported, "binary STL counts triangles in 32 bits", {}};
  }
  const Result<ByteSink*> sink = files.file("");
  if (!sink) return sink.error();
  WrittenMesh written;
  const double limit = static_cast<double>(std::numeric_limits<float>::max());
  if (!mesh.positions.empty()) {
    const FloatRun measured = measure_floats(mesh.positions, Vec3::Zero(), limit);
    if (!measured.within) {
      return Error{
          ErrorCode::kUnsupported, "a coordinate is too large for STL's 32-bit numbers", {}};
    }
    written.deviation = std::sqrt(measured.moved_squared);
  }

  std::vector<std::uint16_t> attributes(std::max<std::size_t>(mesh.elements.size(), 1), 0);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    attributes[e] = attribute_of(mesh.elements[e]);

  ByteWriter out(**sink);
  const std::array<char, 80> header = binary_header(mesh, options);
  out << std::string_view(header.data(), header.size());
  out.expect(mesh.triangles.size());
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  char* at = out.room(4);
  std::memcpy(at, &count, 4);
  out.wrote(at + 4);
  const bool colored =
      std::any_of(attributes.begin(), attributes.end(), [](std::uint16_t a) { return a != 0; });
  constexpr std::size_t kBlock = 1024;
  for (std::size_t first = 0; first < mesh.triangles.size(); first += kBlock) {
    const std::size_t last = std::min(mesh.triangles.size(), first + kBlock);
    at = out.room(kBlock * kStlFacetBytes);
    put_facets(mesh.positions, std::span(mesh.triangles).subspan(first, last - first), at);
    for (std::size_t i = first; colored && i < last; ++i) {
      std::memcpy(at + (i - first + 1) * kStlFacetBytes - 2, &attributes[element_of(mesh, i)], 2);
    }
    at += (last - first) * kStlFacetBytes;
    out.wrote(at);
    out.passed(last - first);
  }
  if (const Status done = out.finish(); !done) return done.error();
  return written;
}

char* put_vector(char* at, std::string_view word, const Vec3& v) {
  std::memcpy(at, word.data(), word.size());
  at += word.size();
  for (int i = 0; i < 3; ++i) {
    *at++ = ' ';
    at = put_number(at, v[i]);
  }
  *at++ = '\n';
  return at;
}

Result<WrittenMesh> stream_ascii(const TriangleMesh& mesh, FileSet& files) {
  const Result<ByteSink*> sink = files.file("");
  if (!sink) return sink.error();
  ByteWriter out(**sink);
  out.expect(mesh.triangles.size());
  const ElementRuns runs = element_runs(mesh);
  for (std::size_t e = 0; e < runs.count(); ++e) {
    // An element without triangles is no solid; a mesh without any is still a file that says so.
    if (runs.of(e).empty() && !(mesh.triangles.empty() && e == 0)) continue;
    const std::string name = one_line(e < mesh.elements.size() ? mesh.elements[e].name : mesh.name);
    const std::string_view blank = name.empty() ? "" : " ";
    out << "solid" << blank << name << '\n';
    for (const std::uint32_t i : runs.of(e)) {
      const std::array<std::uint32_t, 3>& t = mesh.triangles[i];
      constexpr std::size_t kFacetText = 512;
      char* at = out.room(kFacetText);
      at = put_vector(
          at, " facet normal",
          facet_normal(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]));
      constexpr std::string_view kLoop = "  outer loop\n", kEnd = "  endloop\n endfacet\n";
      std::memcpy(at, kLoop.data(), kLoop.size());
      at += kLoop.size();
      for (const std::uint32_t corner : t) at = put_vector(at, "   vertex", mesh.positions[corner]);
      std::memcpy(at, kEnd.data(), kEnd.size());
      out.wrote(at + kEnd.size());
      out.passed();
    }
    out << "endsolid" << blank << name << '\n';
  }
  if (const Status done = out.finish(); !done) return done.error();
  return WrittenMesh{};
}

Result<WrittenMesh> stream_stl(const TriangleMesh& mesh, const WriteOptions& options,
                               FileSet& files) {
  return options.ascii ? stream_ascii(mesh, files) : stream_binary(mesh, options, files);
}

constexpr std::array<std::string_view, 1> kExtensions{".stl"};

}  // namespace

const Format kStl{
    .id = "stl",
    .title = "STL (binary and ASCII)",
    .extensions = kExtensions,
    .positions = Keeps::kFloat32,
    .normals = Keeps::kNo,
    .lines = Keeps::kNo,
    .sharing = Keeps::kNo,
    .matches = looks_like_stl,
    .read = read_stl,
    .write = write_to_memory<stream_stl>,
    .stream = stream_stl,
    .remarks =
        "names and full precision in ASCII only; units, and colours of 15 bits, in binary only",
};

}  // namespace diesink
