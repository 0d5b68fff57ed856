// The part program as checked data: what the text said, with every default filled in.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/diagnostics.h"
#include "core/geometry.h"
#include "core/units.h"

namespace diesink {

struct Solid {
  std::string id;         // upper case, "S2"
  std::string_view type;  // canonical keyword of the kinds table, "R-CYLI"
  int option = 1;
  Body body;
  Place where;
};

struct PlaneBase {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  // unit, turned upward (z > 0)
};

// Points of a Ferguson composite surface, row after row: points[j * columns + i], i along u.
struct FergusonBase {
  int columns = 0;  // m, along u
  int rows = 0;     // n, along v
  std::vector<Vec3> points;
  Place where;  // of the statement that names m and n
};

// One step of a scan's placement, in the order of the statements.
struct MeshPlacement {
  enum class Kind : std::uint8_t { kScale, kMove, kRotateX, kRotateY, kRotateZ } kind = Kind::kMove;
  Vec3 value = Vec3::Zero();  // scale or degrees in x; a move in all three
};

struct MeshBase {
  std::string path;  // as written; relative to the program's folder
  std::vector<MeshPlacement> placement;
  bool smooth_normals = false;  // NORMALS,SMOOTH
  double fill_size = 0;         // FILL,size; 0 = none
  Place where;
};

// std::monostate: no base surface (no section, or NONE).
using BaseSurface = std::variant<std::monostate, PlaneBase, FergusonBase, MeshBase>;

enum class Sign : std::int8_t { kMinus = -1, kPlus = 1 };

// The Boolean expression, left to right. A group is kGroupOpen .. kGroupClose; it is always added.
struct BooleanStep {
  enum class Kind : std::uint8_t { kTerm, kGroupOpen, kGroupClose } kind = Kind::kTerm;
  Sign sign = Sign::kPlus;
  int surface = 0;  // terms: 0 = base B, k = solids[k-1]
  int row = 0;      // terms: row of the Boolean table, from 0 (groups take no row)
};

struct Cutter {
  double diameter = 0;
  double corner_radius = 0;  // diameter/2 = ball, 0 = flat end
};

struct Machining {
  std::array<double, 2> x_range{0, 0};  // resolved: stated, or from base or solids
  std::array<double, 2> y_range{0, 0};
  double x_interval = 0;  // resolved: stated, or 1/100 of the longer side
  double y_interval = 0;
  bool y_interval_stated = false;
  double tolerance = 0.01;              // resolved: 0.01 mm in the program's unit by default
  std::optional<double> intol, outtol;  // where stated
  std::optional<Cutter> cutter;
  std::optional<double> cusp;
  std::optional<double> feed, spindle, clearance;
};

// Lines of the grid along one axis: range[0], range[0] + interval, .. and always range[1]. A last
// interval shorter than 1e-12 of the range counts as none. Needs: a range that is not empty, an
// interval above 0; a double because programs may ask for more lines than there are integers.
double grid_line_count(const std::array<double, 2>& range, double interval);

struct PartProgram {
  std::string name;  // the file's stem
  std::string file;  // as given
  LengthUnit unit = LengthUnit::kMillimetre;
  std::vector<Solid> solids;
  BaseSurface base;
  std::vector<BooleanStep> boole;
  Machining machining;
};

// Reads a whole part program: text to checked data.
// Errors: at most 20 are kept, with place and source line; warnings besides. Empty optional where
// there was an error.
//         A MESH base whose domain is not stated leaves x_range/y_range at {0, 0}: the scan is not
//         read here.
// Never throws for bad data; any byte string is accepted as input.
std::optional<PartProgram> parse_part_program(std::string_view text, std::string_view file_name,
                                              Diagnostics& diagnostics);

}  // namespace diesink
