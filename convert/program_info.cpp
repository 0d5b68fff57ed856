// Part programs told: tables for people, the same figures as JSON.
// SPDX-License-Identifier: Apache-2.0
#include "convert/program_info.h"

#include <algorithm>
#include <vector>

#include "convert/point_text.h"
#include "convert/text_table.h"
#include "formats/json_writer.h"
#include "formats/text_number.h"

namespace diesink {
namespace {

std::string_view id_of(const PartProgram& program, int surface) {
  return surface == 0 ? std::string_view("B")
                      : program.solids[static_cast<std::size_t>(surface - 1)].id;
}

std::string_view base_type(const PartProgram& program) {
  constexpr std::array<std::string_view, 4> kTypes{"NONE", "PLANE", "FERGU", "MESH"};
  return kTypes[program.base.index()];
}

std::string_view type_of(const PartProgram& program, int surface) {
  return surface == 0 ? base_type(program)
                      : program.solids[static_cast<std::size_t>(surface - 1)].type;
}

std::string base_text(const PartProgram& program) {
  std::string text(base_type(program));
  if (const auto* plane = std::get_if<PlaneBase>(&program.base)) {
    text += " through " + point_text(plane->point) + ", normal " + point_text(plane->normal);
  } else if (const auto* ferguson = std::get_if<FergusonBase>(&program.base)) {
    text += ", " + std::to_string(ferguson->columns) + " x " + std::to_string(ferguson->rows) +
            " points, " + std::to_string(ferguson->columns - 1) + " x " +
            std::to_string(ferguson->rows - 1) + " patches";
  } else if (const auto* mesh = std::get_if<MeshBase>(&program.base)) {
    text += " " + mesh->path;
  }
  return text;
}

// The expression as it was meant, "B+S2-(...)": read back from the steps.
std::string expression_of(const PartProgram& program) {
  std::string text;
  bool first = true;  // of the expression or of a group: a leading + is left out
  for (const BooleanStep& step : program.boole) {
    if (step.kind == BooleanStep::Kind::kGroupClose) {
      text += ')';
      first = false;
      continue;
    }
    if (!first) text += step.sign == Sign::kPlus ? '+' : '-';
    first = step.kind == BooleanStep::Kind::kGroupOpen;
    text += first ? std::string_view("(") : id_of(program, step.surface);
  }
  return text;
}

std::string solids_table(const PartProgram& program) {
  std::vector<std::vector<std::string>> rows{{"solid", "type", "option", "from", "to"}};
  for (const Solid& solid : program.solids) {
    const std::array<Vec3, 2> box = bounds_of(solid.body);
    rows.push_back({solid.id, std::string(solid.type), std::to_string(solid.option),
                    point_text(box[0]), point_text(box[1])});
  }
  return to_table(rows);
}

std::string boolean_table(const PartProgram& program) {
  std::vector<std::vector<std::string>> rows{{"row", "ID", "type", "sign"}};
  for (const BooleanStep& step : program.boole) {
    if (step.kind != BooleanStep::Kind::kTerm) continue;
    rows.push_back({std::to_string(step.row), std::string(id_of(program, step.surface)),
                    std::string(type_of(program, step.surface)),
                    step.sign == Sign::kPlus ? "+" : "-"});
  }
  return to_table(rows);
}

void write_base(JsonWriter& json, const PartProgram& program) {
  json.key("base");
  if (std::holds_alternative<std::monostate>(program.base)) {
    json.null();
    return;
  }
  json.begin_object().field("type", base_type(program));
  if (const auto* plane = std::get_if<PlaneBase>(&program.base)) {
    json.key("point");
    write_point(json, plane->point);
    json.key("normal");
    write_point(json, plane->normal);
  } else if (const auto* ferguson = std::get_if<FergusonBase>(&program.base)) {
    json.field("columns", ferguson->columns).field("rows", ferguson->rows);
  } else if (const auto* mesh = std::get_if<MeshBase>(&program.base)) {
    json.field("path", mesh->path);
  }
  json.end_object();
}

}  // namespace

std::string program_info(const PartProgram& program, const ScanFigures* scan) {
  const Machining& machining = program.machining;
  std::string text =
      "part program " + program.name + ", lengths in " + std::string(name_of(program.unit)) + "\n";
  text += "  base       " + base_text(program) + "\n";
  if (scan != nullptr) text += "  scan       " + scan_text(*scan) + "\n";
  text += "  domain     x " + to_text(machining.x_range[0]) + " .. " +
          to_text(machining.x_range[1]) + ", y " + to_text(machining.y_range[0]) + " .. " +
          to_text(machining.y_range[1]) + "\n";
  text += "  grid       " + to_text(grid_line_count(machining.x_range, machining.x_interval)) +
          " x " + to_text(grid_line_count(machining.y_range, machining.y_interval)) +
          " points, intervals " + to_text(machining.x_interval) + " and " +
          to_text(machining.y_interval) + "\n";
  text += "  tolerance  " + to_text(machining.tolerance) + "\n";
  if (machining.cutter) {
    text += "  cutter     diameter " + to_text(machining.cutter->diameter) + ", corner radius " +
            to_text(machining.cutter->corner_radius) + "\n";
  }
  text += "  boole      " + expression_of(program) + "\n\n";
  if (!program.solids.empty()) text += solids_table(program) + "\n";
  return text + boolean_table(program);
}

std::string program_info_json(const PartProgram& program, const Diagnostics& diagnostics,
                              const ScanFigures* scan) {
  JsonWriter json;
  json.begin_object().key("solids").begin_array();
  for (const Solid& solid : program.solids) {
    json.begin_object()
        .field("id", solid.id)
        .field("type", solid.type)
        .field("option", solid.option);
    json.key("bounds").begin_array();
    for (const Vec3& corner : bounds_of(solid.body)) write_point(json, corner);
    json.end_array().end_object();
  }
  json.end_array().key("boole").begin_array();
  for (const BooleanStep& step : program.boole) {
    if (step.kind != BooleanStep::Kind::kTerm) continue;
    json.begin_object()
        .field("row", step.row)
        .field("id", id_of(program, step.surface))
        .field("type", type_of(program, step.surface))
        .field("sign", step.sign == Sign::kPlus ? "+" : "-")
        .end_object();
  }
  json.end_array();
  write_base(json, program);
  if (scan != nullptr) write_scan(json, *scan);
  const Machining& machining = program.machining;
  json.key("domain").begin_array();
  for (const double each : machining.x_range) json.value(each);
  for (const double each : machining.y_range) json.value(each);
  json.end_array().key("grid").begin_array();
  json.value(grid_line_count(machining.x_range, machining.x_interval));
  json.value(grid_line_count(machining.y_range, machining.y_interval)).end_array();
  json.key("warnings").begin_array();
  for (const Diagnostic& each : diagnostics.all()) json.value(to_text(each));
  json.end_array().field("units", name_of(program.unit)).field("tolerance", machining.tolerance);
  json.field("expression", expression_of(program)).end_object();
  return json.text() + "\n";
}

}  // namespace diesink
