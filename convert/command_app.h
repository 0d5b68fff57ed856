// A subcommand made ready to read its command line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "convert/command.h"

namespace diesink {

struct CommandApp {
  std::unique_ptr<CLI::App> app;
  Run run;
  // Where the app's options are read to.
  std::unique_ptr<CommonOptions> common;
  std::unique_ptr<std::optional<int>> threads;

  explicit CommandApp(const Command& command);
  CommandApp(CommandApp&&) noexcept;
  CommandApp& operator=(CommandApp&&) noexcept;
  ~CommandApp();
};

}  // namespace diesink
