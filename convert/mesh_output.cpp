// Output options, targets by their endings, and writing through formats and OutputFiles.
// SPDX-License-Identifier: Apache-2.0
#include "convert/mesh_output.h"

#include <CLI/App.hpp>
#include <algorithm>

#include "convert/arguments.h"
#include "convert/paths.h"
#include "core/counted.h"
#include "core/mesh_tools/topology.h"
#include "formats/draco_mesh.h"
#include "formats/element_runs.h"
#include "formats/mesh_file.h"

namespace diesink {
namespace {

Error usage(std::string message) {
  return {ErrorCode::kUsage, std::move(message), {"diesink", 0, 0, -1}};
}

bool has_id(const Format& format, std::initializer_list<std::string_view> ids) {
  return std::find(ids.begin(), ids.end(), format.id) != ids.end();
}
bool has_ascii_form(const Format& format) { return has_id(format, {"stl", "ply"}); }
bool has_draco_form(const Format& format) { return has_id(format, {"gltf", "glb"}); }

bool as_ascii(const MeshTarget& target, const MeshOutputOptions& options) {
  return has_ascii_form(*target.format) && (options.ascii || target.path == "-");
}

Result<const Format*> format_of_target(const std::string& path, std::string_view stdout_format) {
  if (path == "-") {
    for (const Format* format : all_formats()) {
      if (format->id == stdout_format) return format;
    }
    return usage("no format '" + std::string(stdout_format) + "' can go to stdout");
  }
  const Format* format = format_of_ending(path);
  if (format == nullptr || format->write == nullptr) {
    return usage("'" + path + "' has no ending that can be written: " + endings_of_formats(true));
  }
  return format;
}

// Names that a line of text cannot hold as they are: it ends at a line break, and blanks around a
// name are not its own.
std::size_t names_changed_in_text(const TriangleMesh& mesh) {
  const auto odd = [](const MeshElement& each) {
    const std::string& name = each.name;
    return !name.empty() && (name.front() == ' ' || name.back() == ' ' || one_line(name) != name);
  };
  return static_cast<std::size_t>(std::count_if(mesh.elements.begin(), mesh.elements.end(), odd));
}

}  // namespace

void add_mesh_output_options(CLI::App& app, MeshOutputOptions& options) {
  app.add_flag("--ascii", options.ascii, "STL and PLY as text");
  app.add_flag("--draco", options.draco, "glTF and GLB with Draco compression");
  add_whole_number(app, "--draco-speed", options.draco_speed,
                   "0 smallest .. 10 fastest (default 3)", 0, 10);
  add_whole_number(app, "--quantize", options.quantize_bits,
                   "bits a coordinate with --draco (default: the fewest that keep the tolerance)",
                   1, kMostDracoBits);
}

void add_stdout_format(CLI::App& app, std::string& format) {
  app.add_option("--format", format,
                 "format of an output to stdout: obj, off, ply or stl (default obj)")
      ->check(CLI::IsMember({"obj", "off", "ply", "stl"}))
      ->type_name("FORMAT");
}

Result<std::vector<MeshTarget>> mesh_targets(const std::vector<std::string>& paths,
                                             std::string_view stdout_format,
                                             const MeshOutputOptions& options) {
  std::vector<MeshTarget> targets;
  for (const std::string& path : paths) {
    if (std::count(paths.begin(), paths.end(), path) > 1) {
      return usage("'" + path + "' is given twice as output");
    }
    Result<const Format*> format = format_of_target(path, stdout_format);
    if (!format) return format.error();
    if (path != "-") {
      if (Status there = check_folder(path); !there) return there.error();
    }
    targets.push_back({path, *format});
  }
  const auto any = [&](bool (*has)(const Format&)) {
    return std::any_of(targets.begin(), targets.end(),
                       [&](const MeshTarget& each) { return has(*each.format); });
  };
  if (options.ascii && !any(has_ascii_form)) return usage("--ascii is for .stl and .ply outputs");
  if (options.draco && !any(has_draco_form)) return usage("--draco is for .gltf and .glb outputs");
  if (!options.draco && (options.draco_speed || options.quantize_bits)) {
    return usage("--draco-speed and --quantize need --draco");
  }
  return targets;
}

Result<WrittenMesh> write_mesh(OutputFiles& files, const MeshTarget& target,
                               const TriangleMesh& mesh, const MeshOutputOptions& options,
                               WriteOptions write) {
  write.program_comment = "diesink " DIESINK_VERSION;
  write.ascii = as_ascii(target, options);
  write.draco = has_draco_form(*target.format) && options.draco;
  write.draco_speed = options.draco_speed.value_or(write.draco_speed);
  write.quantize_bits = options.quantize_bits;
  return write_mesh_file(target.path, mesh, std::move(write), files, target.format);
}

std::vector<std::string> lost_in(const MeshTarget& target, const TriangleMesh& mesh,
                                 const MeshOutputOptions& options) {
  const Format& format = *target.format;
  const bool ascii = as_ascii(target, options);
  const bool stl = format.id == "stl";  // its two kinds keep different things
  struct Part {
    Keeps kept;
    bool held;
    const char* name;
  };
  const bool colored = (!stl && !mesh.vertex_colors.empty()) ||
                       std::any_of(mesh.elements.begin(), mesh.elements.end(),
                                   [](const MeshElement& each) { return each.color.has_value(); });
  const bool named = std::any_of(mesh.elements.begin(), mesh.elements.end(),
                                 [](const MeshElement& each) { return !each.name.empty(); });
  const std::string title = stl ? (ascii ? "ASCII STL" : "binary STL") : std::string(format.title);
  std::vector<std::string> lost;
  if (stl) {
    if (!mesh.vertex_colors.empty())
      lost.push_back(title + " keeps no colours of vertices: they are left out");
    if (const std::size_t alone = vertices_alone(mesh); alone > 0) {
      lost.push_back(counted(alone,
                             "vertex that belongs to no triangle is|vertices that belong to no "
                             "triangle are| left out"));
    }
  }
  for (const Part& part :
       {Part{stl && !ascii ? Keeps::kNo : format.names, named, "names of groups"},
        Part{stl && ascii ? Keeps::kNo : format.colors, colored, "colours"},
        Part{stl && ascii ? Keeps::kNo : format.units,
             mesh.unit != LengthUnit::kUnknown || mesh.up != UpAxis::kUnknown, "units and up axis"},
        Part{format.normals, !mesh.normals.empty(), "normals"},
        Part{format.lines, !mesh.curves.empty(), "lines"}}) {
    if (part.held && part.kept == Keeps::kNo) {
      lost.push_back(title + " keeps no " + part.name + ": they are left out");
    }
  }
  const bool as_text = stl ? ascii : has_id(format, {"obj", "ply"});
  if (const std::size_t changed = as_text ? names_changed_in_text(mesh) : 0; changed > 0) {
    lost.push_back(
        counted(changed, "name has|names have| blanks around or control characters, which " +
                             title + " cannot hold: the first go, the others become _"));
  }
  return lost;
}

std::vector<std::string> assumed_in(const MeshTarget& target, const TriangleMesh& mesh) {
  const bool no_unit = mesh.unit == LengthUnit::kUnknown, no_up = mesh.up == UpAxis::kUnknown;
  // The others have the numbers as they are.
  if (!has_id(*target.format, {"gltf", "glb"}) || (!no_unit && !no_up)) return {};
  std::string text = std::string(no_unit && no_up ? "unit and up axis are"
                                 : no_unit        ? "the unit is"
                                                  : "the up axis is") +
                     " not told: glTF, which is in metres and Y up, gets the mesh as ";
  text += no_unit ? (no_up ? "mm and Z up" : "mm") : "Z up";
  text +=
      no_unit ? (no_up ? "; --units-in and --up-in say" : "; --units-in says") : "; --up-in says";
  return {text + " otherwise"};
}

}  // namespace diesink
