// The manual page and the completions of shells, from the options the commands themselves read.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace diesink {

// In roff, for man(1).
std::string manual_page();

// For "bash", "zsh" or "fish": commands, options, the words an option may have, and files.
std::optional<std::string> completion(std::string_view shell);

}  // namespace diesink
