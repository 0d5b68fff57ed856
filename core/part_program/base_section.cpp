// BSURF-DEF: the base surface B.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/base/ferguson.h"
#include "core/number.h"
#include "core/part_program/sections.h"
#include "core/solids/frame.h"

namespace diesink {
namespace {

const std::vector<std::string_view> kBases = {"FERGU", "PLANE", "MESH", "NONE"};

// `first` is the field that holds m.
BaseSurface read_ferguson(const Statement& header, std::size_t first, const StatementList& rest,
                          Report& report) {
  if (header.field_count != first + 2) {
    report.error(header, header.column,
                 std::string(first == 1 ? "FERGU" : "a grid of points") +
                     " takes 2 numbers, m points a row and n rows (got " +
                     std::to_string(header.field_count - first) + ')');
    return {};
  }
  FergusonBase base;
  base.where = report.place(header, header.column);
  constexpr int kMost = static_cast<int>(kMaxStatements);
  const bool columns =
      read_count(header, first, 2, kMost, "a row has 2 to 100000 points", base.columns, report);
  const bool rows =
      read_count(header, first + 1, 2, kMost, "a grid has 2 to 100000 rows", base.rows, report);
  if (!columns || !rows) return {};
  const std::size_t expected =
      static_cast<std::size_t>(base.columns) * static_cast<std::size_t>(base.rows);
  bool good = true;
  for (const Statement* s : rest) {
    double first_number = 0;
    const bool keyword = read_number(s->fields[0].text, first_number) == NumberFault::kNotANumber &&
                         !s->fields[0].text.empty() && s->field_count != 3;
    if (keyword) {
      report.error(*s, s->column,
                   "unknown statement " + quoted(s->body) + "; a base point x,y,z is expected");
      good = false;
      continue;
    }
    if (base.points.size() == expected) {
      report.error(*s, s->column,
                   "too many base points: " + std::to_string(base.columns) + " x " +
                       std::to_string(base.rows) + " are " + std::to_string(expected));
      return {};
    }
    Vec3 point = Vec3::Zero();
    good = read_numbers(*s, 0, 3, true, "a base point", point.data(), report) && good;
    base.points.push_back(point);
  }
  if (base.points.size() < expected) {
    report.error(header, header.fields[first],
                 "too few base points: " + std::to_string(base.columns) + " x " +
                     std::to_string(base.rows) + " are " + std::to_string(expected) + " (got " +
                     std::to_string(base.points.size()) + ')');
    return {};
  }
  if (good) {
    const Status plan = FergusonSurface::check_plan(base);
    if (!plan) report.error(header, header.fields[first], plan.error().message);
  }
  return base;
}

BaseSurface read_plane(const Statement& header, const StatementList& rest, Report& report) {
  PlaneBase plane;
  const Statement *point = nullptr, *normal = nullptr;
  if (header.field_count != 1) {
    read_numbers(header, 1, 1, true, "PLANE", &plane.point[2], report);
  }
  for (const Statement* s : rest) {
    const std::string keyword = upper_case(s->fields[0].text);
    if ((keyword != "P1" && keyword != "NOR") || header.field_count != 1) {
      report.error(
          *s, s->column,
          header.field_count != 1
              ? "PLANE,z takes no further statement (got " + quoted(s->body) + ')'
              : "unknown statement " + quoted(s->fields[0].text) + "; PLANE takes P1 and NOR");
      continue;
    }
    const Statement*& given = keyword == "P1" ? point : normal;
    if (given != nullptr) {
      report.error(*s, s->column,
                   keyword + " was already given at line " + std::to_string(given->line));
      continue;
    }
    given = s;
    if (keyword == "P1") {
      read_numbers(*s, 1, 3, true, keyword, plane.point.data(), report);
    } else if (read_numbers(*s, 1, 3, false, keyword, plane.normal.data(), report)) {
      const bool zero = plane.normal.isZero(0);
      if (!zero) plane.normal = unit(plane.normal);
      // A hundred metres of height a millimetre: no surface, but a wall given by last digits.
      constexpr double kLeastUpward = 1e-5;
      if (zero || std::fabs(plane.normal[2]) < kLeastUpward) {
        report.error(*s, s->fields[zero ? 1 : 3],
                     zero ? "NOR must not be the zero vector"
                          : "NOR lies in plan: a base plane must not be vertical (k must not be 0, "
                            "nor below 1e-5 of the length)");
      }
    }
  }
  if (header.field_count == 1 && (point == nullptr || normal == nullptr)) {
    report.error(header, header.column,
                 std::string("PLANE lacks ") +
                     (point != nullptr    ? "NOR"
                      : normal != nullptr ? "P1"
                                          : "P1 and NOR") +
                     "; it takes P1 and NOR, or is PLANE,z");
  }
  if (plane.normal[2] < 0) plane.normal = (-plane.normal).array() + 0.0;
  return plane;
}

BaseSurface read_mesh(const Statement& header, const StatementList& rest, Report& report) {
  MeshBase mesh;
  mesh.where = report.place(header, header.column);
  if (header.field_count < 2 || header.fields[1].text.empty()) {
    report.error(header, header.column, "MESH takes the path of a mesh file");
  } else {
    // The rest of the statement: a path may hold commas.
    mesh.path = header.body.substr(header.fields[1].column - header.column);
    mesh.where.column = header.fields[1].column;
    if (std::ranges::any_of(mesh.path, [](char c) { return (c >= 0 && c < 0x20) || c == 0x7F; })) {
      report.error(header, header.fields[1],
                   "the path " + quoted(mesh.path) + " holds a control character");
    }
  }
  using Kind = MeshPlacement::Kind;
  struct Step {
    std::string_view keyword;
    Kind kind;
    std::size_t numbers;
  };
  constexpr Step kSteps[] = {{"SCALE", Kind::kScale, 1},
                             {"MOVE", Kind::kMove, 3},
                             {"ROTX", Kind::kRotateX, 1},
                             {"ROTY", Kind::kRotateY, 1},
                             {"ROTZ", Kind::kRotateZ, 1}};
  const std::vector<std::string_view> known = {"SCALE", "MOVE",    "ROTX", "ROTY",
                                               "ROTZ",  "NORMALS", "FILL"};
  const Statement *normals = nullptr, *fill = nullptr;
  for (const Statement* s : rest) {
    const std::string keyword = upper_case(s->fields[0].text);
    const auto step = std::ranges::find(kSteps, keyword, &Step::keyword);
    if (step != std::end(kSteps)) {
      MeshPlacement placement{step->kind, Vec3::Zero()};
      if (!read_numbers(*s, 1, step->numbers, step->kind == Kind::kMove, keyword,
                        placement.value.data(), report)) {
        continue;
      }
      if (step->kind == Kind::kScale && placement.value[0] <= 0) {
        report.error(*s, s->fields[1],
                     "SCALE must be greater than 0 (got " + number_text(placement.value[0]) + ')');
      }
      mesh.placement.push_back(placement);
    } else if (keyword == "NORMALS" || keyword == "FILL") {
      const Statement*& given = keyword == "FILL" ? fill : normals;
      if (given != nullptr) {
        report.error(*s, s->column,
                     keyword + " was already given at line " + std::to_string(given->line));
        continue;
      }
      given = s;
      if (keyword == "FILL") {
        if (read_numbers(*s, 1, 1, true, keyword, &mesh.fill_size, report) && mesh.fill_size <= 0) {
          report.error(*s, s->fields[1],
                       "FILL must be greater than 0 (got " + number_text(mesh.fill_size) + ')');
        }
      } else if (s->field_count != 2 || upper_case(s->fields[1].text) != "SMOOTH") {
        report.error(*s, s->fields[s->field_count > 1 ? 1 : 0], "NORMALS takes the word SMOOTH");
      } else {
        mesh.smooth_normals = true;
      }
    } else {
      report.error(*s, s->column,
                   "unknown statement " + quoted(s->fields[0].text) + "; MESH takes " +
                       word_list(known) + suggestion(keyword, known));
    }
  }
  return mesh;
}

}  // namespace

BaseSurface read_base(const Section& section, Report& report) {
  if (section.statements.empty()) {
    report.error(*section.header, section.header->column,
                 "BSURF-DEF is empty; " + word_list(kBases, "or") + " is expected");
    return {};
  }
  const Statement& header = *section.statements.front();
  const StatementList rest(section.statements.begin() + 1, section.statements.end());
  const std::string keyword = upper_case(header.fields[0].text);
  double number = 0;
  if (read_number(keyword, number) != NumberFault::kNotANumber) {
    return read_ferguson(header, 0, rest, report);
  }
  if (keyword == "FERGU") return read_ferguson(header, 1, rest, report);
  if (keyword == "PLANE") return read_plane(header, rest, report);
  if (keyword == "MESH") return read_mesh(header, rest, report);
  if (keyword == "NONE") {
    if (header.field_count > 1) report.error(header, header.column, "NONE stands alone");
    if (!rest.empty()) {
      report.error(*rest[0], rest[0]->column,
                   "NONE takes no further statement (got " + quoted(rest[0]->body) + ')');
    }
    return {};
  }
  report.error(header, header.column,
               "unknown base surface " + quoted(header.fields[0].text) + "; " +
                   word_list(kBases, "or") + " is expected" + suggestion(keyword, kBases));
  return {};
}

}  // namespace diesink
