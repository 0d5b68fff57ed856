// A subcommand of the program, and the table of all of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <string_view>

#include "convert/console.h"

namespace CLI {
class App;
}

namespace diesink {

// What every subcommand takes.
struct CommonOptions {
  int threads = 0;     // 0 = all cores
  bool quiet = false;  // no progress and no summary; warnings and errors stay
  bool json = false;   // one JSON object on stdout and nothing else there
};

// Does the work once the options are read.
using Run = std::function<ExitStatus(const CommonOptions&)>;

// One subcommand: one file `<name>_command.cpp` and one line in the table of commands.cpp.
struct Command {
  std::string_view name;
  std::string_view summary;  // one line of `diesink --help`
  std::string_view example;  // a whole command line that works from the checkout's folder
  bool reports;              // has --json
  // Adds the options to `app` (see arguments.h) and gives back what runs when this command is
  // chosen.
  Run (*setup)(CLI::App& app);
};

// In the order `diesink --help` prints them.
std::span<const Command* const> all_commands();

}  // namespace diesink
