// SPDX-License-Identifier: Apache-2.0
#include "convert/command_app.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <string>

#include "convert/arguments.h"
#include "core/parallel.h"

namespace diesink {

CommandApp::CommandApp(const Command& command)
    : app(std::make_unique<CLI::App>(std::string(command.summary), std::string(command.name))),
      run(command.setup(*app)),
      common(std::make_unique<CommonOptions>()),
      threads(std::make_unique<std::optional<int>>()) {
  add_whole_number(*app, "--threads", *threads, "threads to use (default: all cores)", 1,
                   kMostThreads);
  app->add_flag("--quiet", common->quiet, "no progress and no summary");
  if (command.reports) {
    app->add_flag("--json", common->json, "one JSON object on stdout, nothing else there");
  }
  app->footer("\nExample:\n  " + std::string(command.example));
}

CommandApp::CommandApp(CommandApp&&) noexcept = default;
CommandApp& CommandApp::operator=(CommandApp&&) noexcept = default;
CommandApp::~CommandApp() = default;

}  // namespace diesink
