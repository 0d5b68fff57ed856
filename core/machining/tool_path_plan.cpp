// SPDX-License-Identifier: Apache-2.0
#include "core/machining/tool_path_plan.h"

#include <cmath>

#include "core/machining/drop.h"
#include "core/machining/reach.h"
#include "core/machining/wide_surface.h"
#include "core/number.h"
#include "core/parallel.h"
#include "core/tessellate/tessellate.h"

namespace diesink {
namespace {

constexpr std::size_t kReachSamples = 40'000;
// More passes than any machine cuts: what asks for them is a slip of the pen, and would be planned
// for weeks.
constexpr double kMostPasses = 10e6;

Error input_error(std::string message) { return {ErrorCode::kInput, std::move(message), {}}; }

Status check(const PathOptions& options) {
  if (const Result<CutterShape> cutter = CutterShape::make(options.cutter); !cutter) {
    return cutter.error();
  }
  if (!(options.intol >= 0) || !(options.outtol >= 0) || !(options.intol + options.outtol > 0) ||
      !std::isfinite(options.intol + options.outtol)) {
    return input_error("the inside and outside tolerances must not be negative, and not both 0");
  }
  return ok();
}

}  // namespace

PathOptions path_options_of(const PartProgram& program) {
  const Machining& m = program.machining;
  PathOptions options;
  options.cutter = m.cutter.value_or(Cutter{});
  options.cusp = m.cusp;
  if (!m.cusp && m.y_interval > 0) options.interval = m.y_interval;
  options.intol = m.intol.value_or(m.tolerance);
  options.outtol = m.outtol.value_or(m.tolerance);
  options.clearance = m.clearance;
  return options;
}

Status check_spacing(const PathOptions& options, const Machining& machining) {
  const auto positive = [](const std::optional<double>& v) {
    return !v || (std::isfinite(*v) && *v > 0);
  };
  if (!options.interval && !options.cusp) {
    return input_error("a tool path needs an interval or a cusp height");
  }
  if (!positive(options.interval)) {
    return input_error("the path interval must be positive (got " + number_text(*options.interval) +
                       ")");
  }
  if (!positive(options.cusp) || (options.cusp && *options.cusp >= options.cutter.diameter / 2)) {
    return input_error("the cusp height must be positive and less than the cutter's radius (got " +
                       number_text(*options.cusp) + ")");
  }
  // A ball on level ground leaves cusps h where its passes lie 2 sqrt(h (d - h)) apart.
  const double apart =
      options.interval.value_or(2 * std::sqrt(options.cusp.value_or(0) * options.cutter.diameter));
  const double across = std::hypot(machining.x_range[1] - machining.x_range[0],
                                   machining.y_range[1] - machining.y_range[0]);
  if (!(across <= kMostPasses * apart)) {
    return Error{ErrorCode::kLimit,
                 "passes " + number_text(apart) + " apart are more than the limit of 10 million",
                 {}};
  }
  return ok();
}

Result<PathReport> plan_path(const CompoundSurface& surface, const PathOptions& options,
                             PathReceiver& receiver) {
  if (const Status status = check(options); !status) return status.error();
  if (const Status spaced = check_spacing(options, surface.program().machining); !spaced) {
    return spaced.error();
  }
  const auto progress = [&](double part) {
    if (options.progress) options.progress(part);
  };
  const PartProgram& program = surface.program();
  const Machining& machining = program.machining;
  const std::array<double, 4> domain{machining.x_range[0], machining.x_range[1],
                                     machining.y_range[0], machining.y_range[1]};
  // Material around the domain counts, as far as the cutter reaches.
  const Result<CompoundSurface> wide =
      widened(surface, options.cutter.diameter / 2 + options.intol + options.outtol);
  if (!wide) return wide.error();
  TessellationOptions mesh_options;
  mesh_options.tolerance = (options.intol + options.outtol) / 8;
  mesh_options.threads = options.threads;
  mesh_options.progress = [&](double part) { progress(0.3 * part); };
  const Result<Tessellation> mesh = tessellate(*wide, mesh_options);
  if (!mesh) return mesh.error();
  progress(0.3);
  ToolPath head;
  head.name = program.name;
  head.unit = program.unit;
  head.feed = machining.feed.value_or(0);
  head.spindle = machining.spindle.value_or(0);
  const double deviation = mesh->report.deviation_where_certified();
  Result<PathReport> planned = [&] {
    const ProgressSpan span(options.progress, 0.3, 0.8);
    return options.method == PathMethod::kCc
               ? plan_cc_path(surface, mesh->mesh, deviation, options, head, receiver)
               : plan_drop_path(mesh->mesh, deviation, domain, options, head, receiver, &surface);
  }();
  if (!planned) return planned;
  progress(0.8);
  planned->uncertified_area = mesh->report.uncertified_area;
  const bool proven =
      !options.interval && !options.keep_interference && deviation < options.outtol + *options.cusp;
  if (!proven) {  // then the surface alone is looked at
    const OffsetSurface offset(mesh->mesh, *CutterShape::make(options.cutter), 0);
    const PointDrop drop(offset);
    const ProgressSpan span(options.progress, 0.8, 1);
    const UnreachableArea unreachable =
        unreachable_area(*wide, offset, drop, domain, options.outtol + mesh_options.tolerance,
                         kReachSamples, options.threads);
    planned->unreachable_area = unreachable.area;
    planned->unreachable_height = unreachable.height;
  }
  progress(1);
  return planned;
}

namespace {

class PathHolder final : public PathReceiver {
 public:
  explicit PathHolder(ToolPath& path) : path_(path) {}
  Status begin(const ToolPath& head) override {
    path_ = head;
    return ok();
  }
  Status take(std::span<const ClPoint> points) override {
    path_.points.insert(path_.points.end(), points.begin(), points.end());
    return ok();
  }

 private:
  ToolPath& path_;
};

// Calls plan(options, receiver) and keeps all it gives.
template <class Plan>
Result<PlannedPath> held(PathOptions options, const Plan& plan) {
  PlannedPath planned;
  options.cc_pass = [&](std::span<const CcContact> pass) {
    planned.cc_passes.emplace_back(pass.begin(), pass.end());
  };
  PathHolder holder(planned.path);
  Result<PathReport> report = plan(options, holder);
  if (!report) return report.error();
  planned.report = *report;
  return planned;
}

}  // namespace

Result<PlannedPath> plan_path(const CompoundSurface& surface, const PathOptions& options) {
  return held(options, [&](const PathOptions& how, PathReceiver& receiver) {
    return plan_path(surface, how, receiver);
  });
}

Result<PlannedPath> plan_drop_path(const TriangleMesh& mesh, double deviation,
                                   const std::array<double, 4>& domain,
                                   const PathOptions& options) {
  return held(options, [&](const PathOptions& how, PathReceiver& receiver) {
    return plan_drop_path(mesh, deviation, domain, how, {}, receiver);
  });
}

Result<PlannedPath> plan_cc_path(const CompoundSurface& surface, const TriangleMesh& mesh,
                                 double deviation, const PathOptions& options) {
  return held(options, [&](const PathOptions& how, PathReceiver& receiver) {
    return plan_cc_path(surface, mesh, deviation, how, {}, receiver);
  });
}

}  // namespace diesink
