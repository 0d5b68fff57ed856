// In a build without the viewer.
// SPDX-License-Identifier: Apache-2.0
#include "viewer/page.h"

namespace diesink {

std::optional<std::string_view> viewer_page() { return std::nullopt; }

}  // namespace diesink
