// Meshes told: lines for people, the same figures as JSON.
// SPDX-License-Identifier: Apache-2.0
#include "convert/mesh_info.h"

#include <array>
#include <string_view>

#include "convert/point_text.h"
#include "core/counted.h"
#include "formats/json_writer.h"
#include "formats/text_number.h"

namespace diesink {
namespace {

std::string_view name_of(UpAxis up) {
  switch (up) {
    case UpAxis::kY:
      return "y";
    case UpAxis::kZ:
      return "z";
    case UpAxis::kUnknown:
      break;
  }
  return "unknown";
}

std::string names_text(const TriangleMesh& mesh) {
  constexpr std::size_t kShown = 12;
  std::string text;
  std::size_t named = 0;
  for (const MeshElement& each : mesh.elements) {
    if (each.name.empty()) continue;
    if (++named <= kShown) text += (text.empty() ? "" : " ") + each.name;
  }
  if (named > kShown) text += " and " + std::to_string(named - kShown) + " more";
  return named == 0 ? "none" : text;
}

std::string crossings_text(const MeshCrossings& crossings) {
  if (crossings.pairs == 0) return "none";
  return counted(crossings.pairs, "pair|pairs| of triangles, ") + "the first " +
         std::to_string(crossings.first[0]) + " and " + std::to_string(crossings.first[1]) +
         " near " + point_text(crossings.at);
}

}  // namespace

std::string mesh_info(const MeshFile& file, const MeshTopology& topology,
                      const MeshCrossings* crossings) {
  const auto count = [](std::size_t number) { return std::to_string(number); };
  const auto told = [](std::string_view name) {
    return name == "unknown" ? std::string("not told") : std::string(name);
  };
  std::string text = std::string(file.format->title) + "\n";
  text += "  units       " + told(diesink::name_of(file.mesh.unit)) + "\n";
  text += "  up          " + told(name_of(file.mesh.up)) + "\n";
  text += "  vertices    " + count(topology.vertices) + "\n";
  text += "  triangles   " + count(topology.triangles) + "\n";
  if (const std::size_t alone = vertices_alone(file.mesh); alone > 0) {
    text += "  unused      " + counted(alone, "vertex|vertices| of no triangle or line\n");
  }
  if (topology.lines > 0) text += "  lines       " + count(topology.lines) + " segments\n";
  text += "  shells      " + count(topology.shells) + "\n";
  text += "  watertight  " + (topology.watertight ? "yes" : "no: " + topology.why_not) + "\n";
  if (crossings != nullptr) text += "  crossings   " + crossings_text(*crossings) + "\n";
  text += "  area        " + to_text(topology.area) + "\n";
  text += "  volume      " +
          (topology.watertight ? to_text(topology.volume) : "unknown: not watertight") + "\n";
  text += "  from        " + point_text(topology.bounds[0]) + "\n";
  text += "  to          " + point_text(topology.bounds[1]) + "\n";
  text += "  groups      " + names_text(file.mesh) + "\n";
  return text;
}

std::string mesh_info_json(const MeshFile& file, const MeshTopology& topology,
                           const Diagnostics& diagnostics, const MeshCrossings* crossings) {
  JsonWriter json;
  json.begin_object()
      .field("format", file.format->id)
      .field("vertices", topology.vertices)
      .field("triangles", topology.triangles)
      .field("lines", topology.lines)
      .field("shells", topology.shells)
      .field("boundary_loops", topology.boundary_loops)
      .field("nonmanifold_edges", topology.nonmanifold_edges)
      .field("watertight", topology.watertight)
      .field("area", topology.area)
      .field("volume", topology.volume);
  write_bounds(json, topology.bounds);
  json.field("units", diesink::name_of(file.mesh.unit)).field("up", name_of(file.mesh.up));
  json.key("names").begin_array();
  for (const MeshElement& each : file.mesh.elements) {
    if (!each.name.empty()) json.value(each.name);
  }
  json.end_array()
      .field("why_not_watertight", topology.why_not)
      .field("boundary_edges", topology.boundary_edges)
      .field("misoriented_edges", topology.misoriented_edges)
      .field("nonmanifold_vertices", topology.nonmanifold_vertices)
      .field("degenerate", topology.degenerate)
      .field("flat", topology.flat)
      .field("duplicates", topology.duplicates)
      .field("unused_vertices", vertices_alone(file.mesh));
  if (crossings != nullptr) {
    json.field("crossing_pairs", crossings->pairs)
        .field("crossing_triangles", crossings->triangles)
        .key("first_crossing");
    if (crossings->pairs == 0) {
      json.null();
    } else {
      const auto [x, y, z] = std::array{crossings->at.x(), crossings->at.y(), crossings->at.z()};
      json.begin_object().key("triangles").begin_array();
      for (const std::uint32_t t : crossings->first) json.value(std::size_t{t});
      json.end_array().key("at").begin_array().value(x).value(y).value(z).end_array().end_object();
    }
  }
  json.key("warnings").begin_array();
  for (const Diagnostic& each : diagnostics.all()) json.value(to_text(each));
  json.end_array().end_object();
  return json.text() + "\n";
}

}  // namespace diesink
