// From part programs on the command line to surfaces.
// SPDX-License-Identifier: Apache-2.0
#include "convert/input.h"
#include "convert/mesh_frame.h"
#include "formats/mesh_file.h"

namespace diesink {
namespace {

// A path of the program, which counts from its folder.
std::string beside(const std::string& program_file, const std::string& path) {
  const std::size_t slash = program_file.rfind('/');
  if (path.empty() || path[0] == '/' || slash == std::string::npos) return path;
  return program_file.substr(0, slash + 1) + path;
}

Result<TriangleMesh> read_scan(const PartProgram& program, const MeshBase& base,
                               Diagnostics& diagnostics) {
  const std::string path = beside(program.file, base.path);
  // stdin is the program's, never the scan's.
  Result<MeshFile> file = read_mesh_file(path == "-" ? "./-" : path, {}, diagnostics);
  if (!file) {
    Error error = file.error();
    if (error.where.line > 0 || error.where.byte >= 0) {
      error.message += ", as the base surface of " + program.file;
    } else {  // nowhere in the scan: where the program names it
      error.message = error.where.file + ": " + error.message;
      error.where = base.where;
    }
    return error;
  }
  TriangleMesh& mesh = file->mesh;
  MeshFrame frame;
  if (mesh.unit == LengthUnit::kUnknown) frame.unit_in = program.unit;
  if (mesh.up == UpAxis::kUnknown) frame.up_in = UpAxis::kZ;
  frame.unit_out = program.unit;
  frame.up_out = UpAxis::kZ;
  std::vector<std::string> warnings;
  if (Status done = change_frame(mesh, frame, warnings); !done) return done.error();
  for (const std::string& each : warnings) diagnostics.warning(each, {path});
  return std::move(mesh);
}

}  // namespace

std::optional<CompoundSurface> surface_of(const PartProgram& program, Diagnostics& diagnostics) {
  std::optional<TriangleMesh> scan;
  if (const MeshBase* base = std::get_if<MeshBase>(&program.base)) {
    Result<TriangleMesh> mesh = read_scan(program, *base, diagnostics);
    if (!mesh) diagnostics.add(mesh.error());
    if (diagnostics.has_errors()) return std::nullopt;
    scan = std::move(*mesh);
  }
  Result<CompoundSurface> surface = CompoundSurface::make(program, std::move(scan));
  if (surface) return std::move(*surface);
  diagnostics.add(surface.error());
  return std::nullopt;
}

Loaded<CompoundSurface> make_surface(const PartProgram& program, Diagnostics* diagnostics) {
  Diagnostics own;
  std::optional<CompoundSurface> surface = surface_of(program, own);
  if (diagnostics != nullptr) {
    for (const Diagnostic& each : own.all()) {
      if (each.severity == Severity::kWarning) diagnostics->warning(each.message, each.where);
    }
  }
  return {std::move(surface), report(own)};
}

Loaded<CompoundSurface> load_surface(const std::string& path) {
  Diagnostics diagnostics;
  const Loaded<PartProgram> program = load_part_program(path, diagnostics);
  if (!program.value) return {std::nullopt, program.status};
  return make_surface(*program.value);
}

}  // namespace diesink
