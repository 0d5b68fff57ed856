// SPDX-License-Identifier: Apache-2.0
#include "core/result.h"

#include "core/diagnostics.h"

namespace diesink {

std::string to_text(const Error& error) {
  return to_text(Diagnostic{Severity::kError, error.code, error.message, error.where, {}});
}

}  // namespace diesink
