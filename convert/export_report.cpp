// Figures of an export: put together over tiles, and as JSON.
// SPDX-License-Identifier: Apache-2.0
#include "convert/export_report.h"

#include <algorithm>
#include <string_view>

#include "convert/point_text.h"
#include "formats/element_runs.h"
#include "formats/json_writer.h"

namespace diesink {
namespace {

void write_elements(JsonWriter& json, const TessellationReport& report) {
  json.key("elements").begin_array();
  for (const ElementReport& each : report.elements) {
    const std::size_t dot = each.name.find('.');
    json.begin_object()
        .field("solid", each.solid)
        .field("type", each.type)
        .field("face", dot == each.name.npos ? std::string_view(each.name)
                                             : std::string_view(each.name).substr(dot + 1))
        .field("sign", each.sign)
        .field("triangles", each.triangles)
        .field("area", each.area)
        .field("max_deviation", each.max_deviation)
        .end_object();
  }
  json.end_array();
}

void write_curves(JsonWriter& json, const TessellationReport& report) {
  json.key("curves").begin_array();
  for (const CurveReport& each : report.curves) {
    json.begin_object().field("kind", name_of(each.kind)).key("between").begin_array();
    for (const std::string& name : each.between) {
      if (!name.empty()) json.value(name);
    }
    json.end_array().field("length", each.length).field("closed", each.closed).end_object();
  }
  json.end_array();
}

// Where the mesh is not certified.
void write_doubts(JsonWriter& json, const TessellationReport& report) {
  json.key("doubts").begin_array();
  for (const MeshDoubt& each : report.doubts) {
    json.begin_object().key("place").begin_array();
    for (const double coordinate : {each.place.x(), each.place.y(), each.place.z()})
      json.value(coordinate);
    json.end_array()
        .field("element", each.element)
        .field("what", each.what)
        .field("area", each.area)
        .end_object();
  }
  json.end_array().field("doubt_count", report.doubt_count);
}

}  // namespace

void add_tile(ExportReport& report, const Tessellation& tile, bool first) {
  report.triangles += tile.mesh.triangles.size();
  report.vertices += tile.mesh.positions.size();
  TessellationReport& sum = report.surface;
  const TessellationReport& one = tile.report;
  if (first) {
    sum = one;
    return;
  }
  sum.crease_vertices += one.crease_vertices;
  sum.jump_vertices += one.jump_vertices;
  sum.corner_vertices += one.corner_vertices;
  sum.certified_deviation = std::max(sum.certified_deviation, one.certified_deviation);
  sum.uncertified_area += one.uncertified_area;
  sum.crease_offset = std::max(sum.crease_offset, one.crease_offset);
  sum.area += one.area;
  sum.volume += one.volume;
  sum.watertight = sum.watertight && one.watertight;
  sum.domain = {std::min(sum.domain[0], one.domain[0]), std::max(sum.domain[1], one.domain[1]),
                std::min(sum.domain[2], one.domain[2]), std::max(sum.domain[3], one.domain[3])};
  sum.bounds = {sum.bounds[0].cwiseMin(one.bounds[0]), sum.bounds[1].cwiseMax(one.bounds[1])};
  for (std::size_t k = report.element_at.size(); k < sum.elements.size(); ++k) {
    report.element_at.emplace(sum.elements[k].name, k);
  }
  for (const ElementReport& each : one.elements) {
    const auto [known, fresh] = report.element_at.try_emplace(each.name, sum.elements.size());
    if (fresh) {
      sum.elements.push_back(each);
      continue;
    }
    ElementReport& same = sum.elements[known->second];
    same.triangles += each.triangles;
    same.area += each.area;
    same.max_deviation = std::max(same.max_deviation, each.max_deviation);
  }
  sum.curves.insert(sum.curves.end(), one.curves.begin(), one.curves.end());
  for (const MeshDoubt& doubt : one.doubts) {
    if (sum.doubts.size() < TessellationReport::kMostDoubts) sum.doubts.push_back(doubt);
  }
  sum.doubt_count += one.doubt_count;
  sum.seconds_evaluate += one.seconds_evaluate;
  sum.seconds_tessellate += one.seconds_tessellate;
}

bool is_kept(const TessellationReport& report) {
  return report.certified_deviation <= report.tolerance && report.uncertified_area <= 0;
}

std::string to_json(const ExportReport& report, bool run) {
  const TessellationReport& surface = report.surface;
  JsonWriter json;
  json.begin_object()
      .field("triangles", report.triangles)
      .field("vertices", report.vertices)
      .field("crease_vertices", surface.crease_vertices)
      .field("jump_vertices", surface.jump_vertices)
      .field("corner_vertices", surface.corner_vertices)
      .field("tolerance", surface.tolerance)
      .field("certified_deviation", surface.certified_deviation)
      .field("uncertified_area", surface.uncertified_area)
      .field("area", surface.area)
      .field("volume", surface.volume)
      .field("watertight", surface.watertight);
  json.key("domain").begin_array();
  for (const double each : surface.domain) json.value(each);
  json.end_array();
  write_bounds(json, surface.bounds);
  write_elements(json, surface);
  write_curves(json, surface);
  if (surface.doubt_count > 0) write_doubts(json, surface);
  if (report.scan) write_scan(json, *report.scan, surface.crease_offset);
  if (run) {
    json.key("seconds")
        .begin_object()
        .field("parse", report.seconds.parse)
        .field("evaluate", surface.seconds_evaluate)
        .field("tessellate", surface.seconds_tessellate)
        .field("write", report.seconds.write)
        .field("total", report.seconds.total)
        .end_object()
        .field("threads", report.threads);
  }
  json.field("version", DIESINK_VERSION).end_object();
  return json.text();
}

}  // namespace diesink
