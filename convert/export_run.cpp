// From a surface to mesh files, tile by tile.
// SPDX-License-Identifier: Apache-2.0
#include "convert/export_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "convert/paths.h"
#include "core/parallel.h"
#include "core/tessellate/tile_cuts.h"

namespace diesink {
namespace {

// Share of the tolerance the tessellator leaves for what the files add: Draco's grid, or rounding
// to 32-bit floats; that needs more only where the tolerance is tiny beside the coordinates.
constexpr double kDracoShare = 0.25;
constexpr double kLeastShare = 0.01;
constexpr double kMostShare = 0.5;

double share_for_files(const std::vector<MeshTarget>& targets, const MeshOutputOptions& options,
                       double tolerance, double largest_coordinate) {
  if (options.draco) return kDracoShare;
  const bool rounded = std::any_of(targets.begin(), targets.end(), [](const MeshTarget& each) {
    return each.format->positions == Keeps::kFloat32;
  });
  // Half a unit in the last of a float's 24 bits, in three axes.
  const double rounding = std::sqrt(3.0) * std::ldexp(largest_coordinate, -24) / tolerance;
  if (!rounded || rounding > kMostShare) return kLeastShare;  // beyond all help: told by the status
  return std::max(kLeastShare, rounding);
}

std::string tile_name(const std::array<int, 2>& tile) {
  return "_" + std::to_string(tile[0]) + "_" + std::to_string(tile[1]);
}

}  // namespace

Exporter::Exporter(const ExportOptions& options, const CommonOptions& common,
                   const CompoundSurface& surface, std::vector<MeshTarget> targets)
    : options_(options),
      common_(common),
      surface_(surface),
      targets_(std::move(targets)),
      tolerance_(options.tolerance.value_or(surface.program().machining.tolerance)) {}

Status Exporter::make_all() {
  const auto& [columns, rows] = options_.tiles;
  if (columns * rows > 1) cuts_ = tile_cuts(surface_, options_.tiles, made_tolerance());
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      if (Status made = make_tile({i, j}); !made) return made.error();
    }
  }
  if (figures_.triangles == 0) {
    return Error{ErrorCode::kInput,
                 "no vertical line of the domain meets the surface: nothing to tessellate",
                 {surface_.program().file}};
  }
  const Machining& m = surface_.program().machining;  // the domain, whatever of it is empty
  figures_.surface.domain = {m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]};
  return ok();
}

Status Exporter::finish(Stopwatch& whole) {
  figures_.surface.certified_deviation += written_deviation_;
  Stopwatch watch;
  // The report stands beside the meshes or not at all, so its own last milliseconds are not in
  // it.
  figures_.seconds.total += whole.lap();
  if (!options_.report_path.empty()) {
    Result<ByteSink*> sink = files_.open(options_.report_path);
    if (!sink) return sink.error();
    const std::string text = to_json(figures_, true) + "\n";
    if (Status put = (*sink)->put(std::as_bytes(std::span(text))); !put) return put.error();
  }
  if (Status done = files_.commit(); !done) return done.error();
  figures_.seconds.write += watch.lap();
  figures_.seconds.total += whole.lap();
  return ok();
}

std::string Exporter::summary() const {
  const TessellationReport& report = figures_.surface;
  char line[256];
  std::snprintf(line, sizeof line,
                "%s: %zu triangles, %zu vertices, %zu elements; deviation at most %.3g "
                "(tolerance %.3g); %.3f s\n",
                surface_.program().name.c_str(), figures_.triangles, figures_.vertices,
                report.elements.size(), report.certified_deviation, report.tolerance,
                figures_.seconds.total);
  std::string text = line;
  for (const std::string& path : written_) text += "  " + path + "  " + size_text(path) + "\n";
  return text;
}

// What the files leave of the tolerance.
double Exporter::made_tolerance() const {
  return tolerance_ * (1 - share_for_files(targets_, options_.mesh, tolerance_, surface_.size()));
}

Status Exporter::make_tile(const std::array<int, 2>& tile) {
  progress_.next("tessellating");
  TessellationOptions how;
  how.scheme = options_.scheme;
  how.creases = options_.creases;
  how.tolerance = made_tolerance();
  if (options_.feature_angle) how.feature_angle = *options_.feature_angle;
  how.solid = options_.solid;
  how.floor = options_.floor;
  how.tiles = options_.tiles;
  how.tile = tile;
  if (cuts_) how.cuts = &*cuts_;
  how.threads = common_.threads;
  const double count = options_.tiles[0] * options_.tiles[1];
  const double before = tile[1] * options_.tiles[0] + tile[0];
  how.progress = [&](double part) { progress_.update((before + part) / count); };
  Result<Tessellation> made = tessellate(surface_, how);
  if (!made) return made.error();
  if (made->mesh.triangles.empty()) {
    notes_.emplace_back(surface_.program().file, "tile " + std::to_string(tile[0]) + "," +
                                                     std::to_string(tile[1]) +
                                                     " has no surface and no file");
    return ok();
  }
  add_tile(figures_, *made, figures_.triangles == 0);
  figures_.surface.tolerance = tolerance_;
  Stopwatch watch;
  progress_.next("writing", {static_cast<double>(made->mesh.triangles.size()), "triangles"});
  group_triangles(made->mesh, options_.groups);
  Status written = write_tile(*made, tile);
  figures_.seconds.write += watch.lap();
  return written;
}

Status Exporter::write_tile(const Tessellation& made, const std::array<int, 2>& tile) {
  WriteOptions write;
  write.lines = options_.lines;
  // Writers that quantize keep half of what they are told.
  write.tolerance = 2 * kDracoShare * tolerance_;
  ExportReport own;
  add_tile(own, made, true);
  own.surface.tolerance = tolerance_;
  write.extras_json = to_json(own, false);
  const auto share = [&](std::size_t files) {
    return static_cast<double>(files) / static_cast<double>(targets_.size());
  };
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    const MeshTarget& target = targets_[i];
    const ProgressSpan span(progress_.told(), share(i), share(i + 1));
    MeshTarget to = target;
    if (options_.tiles != std::array{1, 1}) to.path = before_ending(target.path, tile_name(tile));
    Result<WrittenMesh> done = write_mesh(files_, to, made.mesh, options_.mesh, write);
    if (!done) return done.error();
    if (options_.lines && target.format->lines == Keeps::kNo) {
      notes_.emplace_back(to.path, std::string(target.format->title) + " keeps no lines");
    }
    written_deviation_ = std::max(written_deviation_, done->deviation);
    for (const std::string& note : done->notes) notes_.emplace_back(to.path, note);
    if (to.path != "-") written_.push_back(to.path);
  }
  return ok();
}

}  // namespace diesink
