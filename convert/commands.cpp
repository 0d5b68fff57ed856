// The table of subcommands.
// SPDX-License-Identifier: Apache-2.0
#include "convert/commands.h"

#include <array>

namespace diesink {

std::span<const Command* const> all_commands() {
  static constexpr std::array kCommands{&kExportCommand,  &kCcCommand,      &kClCommand,
                                        &kVerifyCommand,  &kConvertCommand, &kInfoCommand,
                                        &kPreviewCommand, &kViewCommand,    &kFormatsCommand};
  return kCommands;
}

}  // namespace diesink
