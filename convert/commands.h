// The subcommands there are, each defined at the end of its own source file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "convert/command.h"

namespace diesink {

extern const Command kCcCommand;
extern const Command kClCommand;
extern const Command kConvertCommand;
extern const Command kExportCommand;
extern const Command kFormatsCommand;
extern const Command kInfoCommand;
extern const Command kPreviewCommand;
extern const Command kVerifyCommand;
extern const Command kViewCommand;

}  // namespace diesink
