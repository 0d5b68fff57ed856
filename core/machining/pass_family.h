// The passes of the paper's method, straight or along isoparametric curves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "core/machining/cc_pass.h"
#include "core/machining/tool_path_plan.h"
#include "core/part_program/part_program.h"
#include "core/result.h"

namespace diesink {

// The passes of one path: numbered by a position that grows from `first` to `last`.
class PassFamily {
 public:
  virtual ~PassFamily() = default;
  [[nodiscard]] virtual double first() const = 0;
  [[nodiscard]] virtual double last() const = 0;
  [[nodiscard]] virtual PlanCurve curve(double position) const = 0;
  // Step of the position whose pass lies `distance` away, square to the pass, at a point of it.
  [[nodiscard]] virtual double step(double position, double s, double distance) const = 0;
};

// Errors: kInput for curves u or v without a Ferguson base.
Result<std::unique_ptr<PassFamily>> make_pass_family(const PartProgram& program,
                                                     const PathOptions& options);

}  // namespace diesink
