// The program: reads the command line, runs the chosen subcommand, ends with its exit status.
// SPDX-License-Identifier: Apache-2.0
#include <signal.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "convert/command_app.h"
#include "convert/commands.h"
#include "convert/option_pages.h"
#include "core/nearest.h"
#include "formats/output_file.h"

namespace diesink {
namespace {

constexpr std::string_view kVersionLine = "diesink " DIESINK_VERSION "\n";

// Ctrl-C: nothing half-written stays behind, and the shell sees which signal ended the program.
extern "C" void on_interrupt(int signal) {
  unlink_temporaries();
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

void handle_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    action.sa_handler = on_interrupt;
    sigemptyset(&action.sa_mask);
    sigaction(signal, &action, nullptr);
  }
  // A closed pipe and the file size limit are failed writes with a message, not a sudden end.
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);
}

// Fits a terminal of 24 rows with the prompt below it.
std::string overview() {
  std::string text(
      "diesink: compound surfaces for dies, out to every CAD/CAM tool\n"
      "usage: diesink COMMAND [OPTIONS]    (diesink COMMAND --help tells the options)\n\n");
  std::size_t widest = 0;
  for (const Command* each : all_commands()) widest = std::max(widest, each->name.size());
  for (const Command* each : all_commands()) {
    const std::string indent(6, ' ');
    text += "  " + std::string(each->name) + std::string(widest - each->name.size() + 2, ' ');
    text += std::string(each->summary) + "\n" + indent + std::string(each->example) + "\n";
  }
  return text +
         "  --version, --help, --man, --completion bash|zsh|fish\n"
         "exit: 0 done, 1 usage, 2 input, 3 not in this build, 4 not written, 5 not kept\n";
}

std::string meant(std::string_view word, const std::vector<std::string>& known) {
  const std::vector<std::string_view> words(known.begin(), known.end());
  const std::optional<std::size_t> near = nearest_word(word, words);
  return near ? "; did you mean '" + known[*near] + "'?" : "";
}

std::string unknown_option(const CLI::App& command, const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::Option* each : command.get_options()) {
    for (const std::string& name : each->get_lnames()) known.push_back("--" + name);
  }
  const std::string name = word.substr(0, word.find('='));
  return command.get_name() + " has no option '" + name + "'" + meant(name, known);
}

// CLI11's "--weld: At Most 1 required but received 2", which is about its own inside.
std::string our_words(std::string message) {
  constexpr std::string_view kMost = ": At Most 1 required but received ";
  const std::size_t at = message.find(kMost);
  if (at == std::string::npos) return message;
  const std::string times = message.substr(at + kMost.size());
  return message.substr(0, at) + ": given " + times + " times, expected once";
}

// What CLI11 found wrong, told our way. An option nobody knows comes first: the rest of the line
// was read without it.
ExitStatus report_wrong_usage(const CLI::App& command, const CLI::ParseError& problem) {
  std::string message = our_words(problem.what());
  for (const std::string& word : command.remaining()) {
    const bool is_option = word.size() > 1 && word[0] == '-';
    message = is_option ? unknown_option(command, word) : "one argument too many: '" + word + "'";
    if (is_option) break;
  }
  report_usage(message + " (diesink " + command.get_name() + " --help tells the options)");
  return ExitStatus::kWrongUsage;
}

ExitStatus run_command(const Command& command, int count, char** words) {
  const CommandApp chosen(command);
  try {
    chosen.app->parse(count, words);
  } catch (const CLI::CallForHelp&) {
    return print(chosen.app->help("diesink"));
  } catch (const CLI::ParseError& problem) {
    return report_wrong_usage(*chosen.app, problem);
  }
  chosen.common->threads = chosen.threads->value_or(0);
  return chosen.run(*chosen.common);
}

ExitStatus run_program(int count, char** words) {
  if (count < 2) {
    report_usage("a command is missing");
    return print(overview()), ExitStatus::kWrongUsage;
  }
  const std::string_view word = words[1];
  if (word == "--version") return print(kVersionLine);
  if (word == "--help" || word == "-h") return print(overview());
  if (word == "--man") return print(manual_page());
  if (word == "--completion") {
    const std::optional<std::string> text = completion(count > 2 ? words[2] : "");
    return text ? print(*text) : report_usage("--completion: expected bash, zsh or fish");
  }
  std::vector<std::string> known;
  for (const Command* each : all_commands()) {
    if (each->name == word) return run_command(*each, count - 1, words + 1);
    known.emplace_back(each->name);
  }
  return report_usage("there is no command '" + std::string(word) + "'" + meant(word, known) +
                      " (diesink --help lists them)");
}

}  // namespace
}  // namespace diesink

int main(int count, char** words) {
  diesink::handle_signals();
  try {
    return static_cast<int>(diesink::run_program(count, words));
  } catch (const std::bad_alloc&) {
    return static_cast<int>(diesink::report(
        diesink::Error{diesink::ErrorCode::kLimit, "out of memory", {"diesink", 0, 0, -1}}));
  }
}
