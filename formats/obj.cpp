// Wavefront OBJ with its material library: the reader is in obj_read.cpp.
// SPDX-License-Identifier: Apache-2.0
#include "formats/obj.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>

#include "formats/byte_sink.h"
#include "formats/element_runs.h"
#include "formats/registry.h"
#include "formats/text_number.h"
#include "formats/written_mesh.h"

namespace diesink {
namespace {

// A name at the end of its line. A backslash at the very end would join the next line to it, for
// others always and for our reader where it is all there is; behind a blank it does not, and blanks
// at the end are no part of a name.
std::string line_end(std::string name) {
  if (name.ends_with('\\')) name += ' ';
  return name;
}

struct Material {
  std::string name;
  std::optional<std::array<std::uint8_t, 4>> color;
};

struct Materials {
  std::vector<Material> list;
  std::vector<std::size_t> of_element;
};

// One material a solid, of the colour its first element has; an element of another colour gets one
// of its own, "S2:S2.wall". OBJ cannot take a material back, so where some elements have one the
// others are given kObjNoMaterial.
Materials materials_of(const TriangleMesh& mesh) {
  Materials materials;
  std::map<std::string, std::size_t> by_name;
  for (const MeshElement& element : mesh.elements) {
    std::string name =
        element.solid.empty() ? std::string(kObjNoMaterial) : one_line(element.solid);
    const bool first_colored = element.solid.empty() && element.color;
    const auto found = by_name.find(name);
    const bool differs =
        found != by_name.end() && materials.list[found->second].color != element.color;
    if (first_colored || differs) name += kObjOwnColor + one_line(element.name);
    const auto [at, is_new] = by_name.emplace(std::move(name), materials.list.size());
    if (is_new) materials.list.push_back({at->first, element.color});
    materials.of_element.push_back(at->second);
  }
  const bool any = std::any_of(materials.list.begin(), materials.list.end(), [](const Material& m) {
    return m.name != kObjNoMaterial || m.color.has_value();
  });
  if (!any) return {};
  return materials;
}

Status write_library(const Materials& materials, const WriteOptions& options, ByteSink& sink) {
  ByteWriter out(sink);
  out << "# " << line_end(one_line(options.program_comment)) << '\n';
  for (const Material& material : materials.list) {
    out << "newmtl " << line_end(material.name) << '\n';
    // Without a colour none is written: what is not there cannot be mistaken for grey.
    if (!material.color) continue;
    out << "Kd";
    for (std::size_t i = 0; i < 3; ++i) out << ' ' << (*material.color)[i] / 255.0;
    out << "\nd " << (*material.color)[3] / 255.0 << '\n';
  }
  return out.finish();
}

char* put_coordinates(char* at, std::string_view word, const Vec3& v) {
  std::memcpy(at, word.data(), word.size());
  at += word.size();
  for (int i = 0; i < 3; ++i) {
    *at++ = ' ';
    at = put_number(at, v[i]);
  }
  return at;
}

void write_vertices(const TriangleMesh& mesh, ByteWriter& out) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    char* at = put_coordinates(out.room(8 * kMaxNumberText), "v", mesh.positions[i]);
    if (!mesh.vertex_colors.empty()) {
      for (std::size_t c = 0; c < 3; ++c) {
        *at++ = ' ';
        at = put_number(at, static_cast<float>(mesh.vertex_colors[i][c]) / 255.0F);
      }
    }
    *at++ = '\n';
    out.wrote(at);
    out.passed();
  }
}

void write_faces(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, bool normals,
                 ByteWriter& out) {
  for (const std::uint32_t i : triangles) {
    char* at = out.room(8 * kMaxNumberText);
    *at++ = 'f';
    for (std::size_t corner = 0; corner < 3; ++corner) {
      *at++ = ' ';
      const char* const vertex = at;
      at = put_integer(at, std::uint64_t{mesh.triangles[i][corner]} + 1);
      if (!normals) continue;
      const auto size = at - vertex;
      *at++ = '/';
      *at++ = '/';
      if (mesh.corner_normals[i][corner] == mesh.triangles[i][corner]) {
        std::array<char, 10> text;  // as long as an index can be
        std::memcpy(text.data(), vertex, text.size());
        std::memcpy(at, text.data(), text.size());
        at += size;
      } else {
        at = put_integer(at, std::uint64_t{mesh.corner_normals[i][corner]} + 1);
      }
    }
    *at++ = '\n';
    out.wrote(at);
    out.passed();
  }
}

void write_lines(const TriangleMesh& mesh, ByteWriter& out) {
  for (const MeshCurve& curve : mesh.curves) {
    if (curve.vertices.empty()) continue;
    out << "g " << line_end(curve_label(mesh, curve)) << "\nl";
    for (const std::uint32_t v : curve.vertices) out << ' ' << std::uint64_t{v} + 1;
    if (curve.closed) out << ' ' << std::uint64_t{curve.vertices.front()} + 1;
    out << '\n';
  }
}

Result<WrittenMesh> stream_obj(const TriangleMesh& mesh, const WriteOptions& options,
                               FileSet& files) {
  const Result<ByteSink*> sink = files.file("");
  if (!sink) return sink.error();
  const Materials materials = options.file_stem.empty() ? Materials{} : materials_of(mesh);

  ByteWriter out(**sink);
  out << "# " << line_end(one_line(options.program_comment)) << '\n';
  if (!mesh.name.empty()) out << "# name: " << line_end(one_line(mesh.name)) << '\n';
  if (mesh.unit != LengthUnit::kUnknown) out << "# units: " << name_of(mesh.unit) << '\n';
  if (mesh.up != UpAxis::kUnknown) out << "# up: " << (mesh.up == UpAxis::kZ ? 'z' : 'y') << '\n';
  const std::string library = options.file_stem + ".mtl";
  if (!materials.list.empty()) out << "mtllib " << library << '\n';

  const bool normals = options.normals && !mesh.corner_normals.empty();
  out.expect(mesh.positions.size() + (normals ? mesh.normals.size() : 0) + mesh.triangles.size());
  write_vertices(mesh, out);
  if (normals) {
    for (const Vec3& n : mesh.normals) {
      char* at = put_coordinates(out.room(8 * kMaxNumberText), "vn", n);
      *at++ = '\n';
      out.wrote(at);
      out.passed();
    }
  }
  const ElementRuns runs = element_runs(mesh);
  std::size_t material = materials.list.size();
  for (std::size_t e = 0; e < runs.count(); ++e) {
    if (runs.of(e).empty()) continue;
    if (e < mesh.elements.size()) {
      out << (mesh.elements[e].name.empty() ? "g" : "g ")
          << line_end(one_line(mesh.elements[e].name)) << '\n';
    }
    if (!materials.list.empty() && materials.of_element[e] != material) {
      material = materials.of_element[e];
      out << "usemtl " << line_end(materials.list[material].name) << '\n';
    }
    write_faces(mesh, runs.of(e), normals, out);
  }
  if (options.lines) write_lines(mesh, out);
  if (const Status done = out.finish(); !done) return done.error();

  if (!materials.list.empty()) {
    const Result<ByteSink*> beside = files.file(library);
    if (!beside) return beside.error();
    if (const Status done = write_library(materials, options, **beside); !done) return done.error();
  }
  return WrittenMesh{};
}

constexpr std::array<std::string_view, 1> kExtensions{".obj"};

}  // namespace

const Format kObj{
    .id = "obj",
    .title = "Wavefront OBJ with .mtl",
    .extensions = kExtensions,
    .matches = looks_like_obj,
    .read = read_obj,
    .write = write_to_memory<stream_obj>,
    .stream = stream_obj,
    .remarks =
        "units and up axis as comments; colours of elements in the .mtl, of vertices without alpha",
};

}  // namespace diesink
