// Any bytes through one reader, DIESINK_FUZZED_FORMAT: refused, or a mesh that holds together, that
// every writer of the text and binary formats takes, and that comes back from its own format with
// the same triangles. SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>

#include "core/mesh_tools/repair.h"
#include "formats/registry.h"

namespace {

using diesink::TriangleMesh;

void require(bool holds, const char* what) {
  if (holds) return;
  std::cerr << "does not hold: " << what << '\n';
  std::abort();
}

void require_sound(const TriangleMesh& mesh) {
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t)
      require(v < mesh.positions.size(), "a triangle's vertices are there");
  }
  for (const diesink::Vec3& p : mesh.positions)
    require(p.cwiseAbs().maxCoeff() <= 1e9, "positions are within the limit");
  require(mesh.triangle_element.empty() || mesh.triangle_element.size() == mesh.triangles.size(),
          "an element a triangle");
  for (const std::uint32_t e : mesh.triangle_element)
    require(e < mesh.elements.size(), "elements are there");
  require(mesh.corner_normals.empty() || mesh.corner_normals.size() == mesh.triangles.size(),
          "normals a triangle");
  for (const auto& t : mesh.corner_normals) {
    for (const std::uint32_t n : t) require(n < mesh.normals.size(), "normals are there");
  }
  for (const diesink::Vec3& n : mesh.normals)
    require(std::abs(n.norm() - 1) < 2e-3, "normals are unit vectors");
  require(mesh.vertex_colors.empty() || mesh.vertex_colors.size() == mesh.positions.size(),
          "a colour a vertex");
  for (const diesink::MeshCurve& curve : mesh.curves) {
    for (const std::uint32_t v : curve.vertices)
      require(v < mesh.positions.size(), "a curve's vertices are there");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const diesink::Format& format = diesink::DIESINK_FUZZED_FORMAT;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  diesink::ReadOptions options;
  options.max_triangles = 100'000;
  options.threads = 1;
  diesink::Diagnostics diagnostics;
  format.matches(bytes);
  diesink::Result<TriangleMesh> mesh = format.read(bytes, options, diagnostics);
  std::string told;
  for (const diesink::Diagnostic& d : diagnostics.all()) told += to_text(d) + "\n";
  // Several threads must make the same of it.
  diesink::ReadOptions parallel = options;
  parallel.threads = 3;
  parallel.parallel_bytes = 64;
  diesink::Diagnostics of_threads;
  const diesink::Result<TriangleMesh> same = format.read(bytes, parallel, of_threads);
  std::string told_by_threads;
  for (const diesink::Diagnostic& d : of_threads.all()) told_by_threads += to_text(d) + "\n";
  require(same.has_value() == mesh.has_value(), "threads agree whether it can be read");
  if (mesh) {
    require(told_by_threads == told, "threads tell the same");
    require(same->positions == mesh->positions && same->triangles == mesh->triangles &&
                same->triangle_element == mesh->triangle_element,
            "threads read the same");
  } else {
    require(to_text(same.error()) == to_text(mesh.error()), "threads tell the same error");
  }
  if (!mesh) {
    require(!mesh.error().message.empty(), "an error says something");
    return 0;
  }
  require_sound(*mesh);
  for (const bool ascii : {false, true}) {
    diesink::WriteOptions writing;
    writing.ascii = ascii;
    writing.lines = true;
    const diesink::Result<diesink::WrittenMesh> written = format.write(*mesh, writing);
    require(written.has_value(), "what was read can be written");
    const diesink::Result<TriangleMesh> again =
        format.read(written->files[0].bytes, options, diagnostics);
    require(again.has_value(), "what was written can be read");
    require(again->triangles.size() == mesh->triangles.size(), "no triangle is lost");
  }
  const diesink::RepairReport report = repair(*mesh);
  require_sound(*mesh);
  require(report.after.degenerate == 0, "repair leaves no degenerate triangle");
  return 0;
}
