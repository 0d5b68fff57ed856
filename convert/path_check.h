// What is asked of a path's verification, put together with what path and part program state.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "core/machining/verify.h"
#include "core/tessellate/tessellate.h"

namespace diesink {

// Units: the part program's; what is empty is as the path, else as the program states it.
struct CheckRequest {
  std::optional<std::array<double, 2>> cutter;  // diameter and corner radius
  std::optional<double> cusp, intol, outtol, spacing;
};

// Errors: kInput where nobody states a cutter; `path_name` is for that message.
Result<VerifyOptions> verify_options(const CheckRequest& request, const ToolPath& path,
                                     const PartProgram& program, const std::string& path_name);

// The mesh that verify_path needs: the part with a cutter's radius around its domain, much finer
// than the tolerances. Errors: what the tessellator returns.
Result<Tessellation> wide_mesh(const CompoundSurface& part, const VerifyOptions& how);

// True where no gouge beyond the tolerance is certain and no rapid move goes down into the part. A
// gouge is certain only beyond what the mesh and the search may be off.
bool is_kept(const VerifyReport& found, const VerifyOptions& how);

// One JSON object; without the lattice.
std::string to_json(const VerifyReport& report);

}  // namespace diesink
