// `diesink info`: what a part program or a mesh file holds.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <memory>
#include <string>

#include "convert/commands.h"
#include "convert/input.h"
#include "convert/program_info.h"

namespace diesink {
namespace {

struct Options {
  std::string file;
};

ExitStatus tell_program(const std::string& path, const CommonOptions& common) {
  Diagnostics diagnostics;
  const Loaded<PartProgram> program = load_part_program(path, diagnostics);
  if (!program.value) return program.status;
  return print(common.json ? program_info_json(*program.value, diagnostics)
                           : program_info(*program.value));
}

Run setup(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  app.add_option("FILE", options->file, "part program or mesh")->required()->type_name("");
  return [options](const CommonOptions& common) { return tell_program(options->file, common); };
}

}  // namespace

const Command kInfoCommand{"info", "what a part program or a mesh holds",
                           "diesink info fixtures/parts/fig6.part", true, setup};

}  // namespace diesink
