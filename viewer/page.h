// The viewer's page as the build bundled it from page.html, style.css, src/ and three.js.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

namespace diesink {

// HTML with kHeadMark and kBodyMark where a scene's figures and arrays go; empty in a build that
// had no esbuild or three.js.
std::optional<std::string_view> viewer_page();

inline constexpr std::string_view kHeadMark = "@DIESINK_HEAD@";
inline constexpr std::string_view kBodyMark = "@DIESINK_BODY@";

}  // namespace diesink
