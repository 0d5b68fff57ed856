// Defaults of a verification, the mesh it runs on, and its figures as JSON.
// SPDX-License-Identifier: Apache-2.0
#include "convert/path_check.h"

#include "core/machining/wide_surface.h"
#include "formats/json_writer.h"

namespace diesink {
namespace {

// Of the mesh under the search for gouges, as a part of the tolerances' sum.
constexpr double kMeshPart = 1.0 / 32;

void place(JsonWriter& json, std::string_view key, const Vec3& p) {
  json.key(key).begin_array().value(p.x()).value(p.y()).value(p.z()).end_array();
}

}  // namespace

Result<VerifyOptions> verify_options(const CheckRequest& request, const ToolPath& path,
                                     const PartProgram& program, const std::string& path_name) {
  const Machining& m = program.machining;
  VerifyOptions how;
  const std::optional<Cutter> cutter =
      request.cutter ? std::optional<Cutter>({(*request.cutter)[0], (*request.cutter)[1]})
      : path.cutter  ? path.cutter
                     : m.cutter;
  if (!cutter) {
    return Error{
        ErrorCode::kInput,
        "no cutter: the path states none; expected CUTTER,d,r in MACHI-DEF or --cutter D,R",
        {path_name, 0, 0, -1}};
  }
  how.cutter = *cutter;
  how.intol = request.intol.value_or(path.intol > 0 ? path.intol : m.intol.value_or(m.tolerance));
  how.outtol =
      request.outtol.value_or(path.outtol > 0 ? path.outtol : m.outtol.value_or(m.tolerance));
  how.cusp = request.cusp ? request.cusp : m.cusp;
  how.spacing = request.spacing;
  how.path_deviation = path.arc_height;
  return how;
}

Result<Tessellation> wide_mesh(const CompoundSurface& part, const VerifyOptions& how) {
  const Result<CompoundSurface> surface = widened(part, how.cutter.diameter / 2);
  if (!surface) return surface.error();
  TessellationOptions options;
  const double tolerances = how.intol + how.outtol;
  options.tolerance =
      (tolerances > 0 ? tolerances : part.program().machining.tolerance) * kMeshPart;
  options.threads = how.threads;
  return tessellate(*surface, options);
}

bool is_kept(const VerifyReport& found, const VerifyOptions& how) {
  return found.max_gouge - found.bound <= how.intol && found.rapid_plunges == 0;
}

std::string to_json(const VerifyReport& r) {
  JsonWriter json;
  json.begin_object().field("max_gouge", r.max_gouge);
  place(json, "max_gouge_at", r.max_gouge_at);
  json.field("max_excess", r.max_excess);
  place(json, "max_excess_at", r.max_excess_at);
  json.field("cusp_p50", r.cusp_p50)
      .field("cusp_p99", r.cusp_p99)
      .field("cusp_max", r.cusp_max)
      .field("uncut_area", r.uncut_area)
      .field("bound", r.bound)
      .field("points", r.points)
      .field("length", r.length)
      .field("limit", r.limit)
      .field("unreachable_area", r.unreachable_area)
      .field("rapid_plunges", r.rapid_plunges)
      .field("spacing", r.spacing)
      .field("excess_bound", r.excess_bound)
      .field("proven_part", r.proven_part)
      .end_object();
  return json.text();
}

}  // namespace diesink
