// One run of `diesink export`: the tiles of a surface, tessellated and written, and their figures.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "convert/command.h"
#include "convert/export_report.h"
#include "convert/mesh_groups.h"
#include "convert/mesh_output.h"
#include "core/compound/compound_surface.h"
#include "formats/output_file.h"

namespace diesink {

// Units: the part program's.
struct ExportOptions {
  std::optional<double> tolerance;  // default TOLER
  MeshScheme scheme = MeshScheme::kAdaptive;
  bool creases = true;                  // kGrid only: insert the edge points
  std::optional<double> feature_angle;  // degrees, of a scanned base; default 30
  bool solid = false;                   // close it with skirts and a floor
  std::optional<double> floor;          // height of the floor
  bool lines = false;                   // crease and edge curves as lines
  MeshGroups groups = MeshGroups::kElement;
  std::array<int, 2> tiles{1, 1};
  std::string report_path;  // where the figures go as JSON; empty = nowhere
  MeshOutputOptions mesh;
};

// The tiles one after the other, all files put in place together at the end: before finish() none
// has appeared.
class Exporter {
 public:
  // Needs: everything given by reference outlives this.
  Exporter(const ExportOptions& options, const CommonOptions& common,
           const CompoundSurface& surface, std::vector<MeshTarget> targets);

  ExportReport& figures() { return figures_; }
  // What a format could not keep: path and note.
  [[nodiscard]] const std::vector<std::pair<std::string, std::string>>& notes() const {
    return notes_;
  }

  Status make_all();

  // The report file, and everything in place.
  Status finish(Stopwatch& whole);

  // What was written, for people.
  [[nodiscard]] std::string summary() const;

 private:
  [[nodiscard]] double made_tolerance() const;
  Status make_tile(const std::array<int, 2>& tile);
  Status write_tile(const Tessellation& made, const std::array<int, 2>& tile);

  const ExportOptions& options_;
  const CommonOptions& common_;
  const CompoundSurface& surface_;
  std::vector<MeshTarget> targets_;
  double tolerance_ = 0;
  std::optional<TileCuts> cuts_;
  double written_deviation_ = 0;
  ExportReport figures_;
  OutputFiles files_;
  std::vector<std::pair<std::string, std::string>> notes_;  // path and note
  std::vector<std::string> written_;
  Progress progress_{"tessellating", common_.quiet};
};

}  // namespace diesink
