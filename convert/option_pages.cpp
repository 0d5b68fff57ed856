// SPDX-License-Identifier: Apache-2.0
#include "convert/option_pages.h"

#include <CLI/App.hpp>
#include <vector>

#include "convert/command_app.h"
#include "convert/commands.h"

namespace diesink {
namespace {

struct OptionText {
  std::vector<std::string> names;    // "-o", "--output"; empty for a positional
  std::string shape;                 // "N", "plan|iso", "FILE"; empty for a flag
  std::vector<std::string> choices;  // where the shape lists them
  std::string summary;
  bool positional = false;
};

struct CommandText {
  std::string name, summary, example;
  std::vector<OptionText> options;
};

// The lower case words of "a|b|c", or of "FORMAT:{a,b,c}", which becomes "FORMAT".
std::vector<std::string> take_choices(std::string& shape) {
  std::string_view list = shape;
  const std::size_t open = shape.find(":{");
  if (open != std::string::npos) list = list.substr(open + 2, list.size() - open - 3);
  std::vector<std::string> words(1);
  for (const char each : list) {
    if (each == '|' || each == ',') {
      words.emplace_back();
    } else if (each >= 'a' && each <= 'z') {
      words.back() += each;
    } else {
      return {};
    }
  }
  if (open != std::string::npos) shape.resize(open);
  return words.size() > 1 ? words : std::vector<std::string>{};
}

std::vector<CommandText> all_texts() {
  std::vector<CommandText> texts;
  for (const Command* each : all_commands()) {
    const CommandApp command(*each);
    CommandText text{
        std::string(each->name), std::string(each->summary), std::string(each->example), {}};
    for (const CLI::Option* option : command.app->get_options()) {
      OptionText one;
      for (const std::string& name : option->get_snames()) one.names.push_back("-" + name);
      for (const std::string& name : option->get_lnames()) one.names.push_back("--" + name);
      one.positional = one.names.empty();
      const bool flag = !one.positional && option->get_items_expected_max() == 0;
      one.shape = one.positional ? option->get_name() : flag ? "" : option->get_type_name();
      one.choices = take_choices(one.shape);
      one.summary = option->get_description();
      text.options.push_back(std::move(one));
    }
    texts.push_back(std::move(text));
  }
  return texts;
}

// A line of roff: no request by accident, hyphens that can be searched for.
std::string roff(std::string_view text) {
  std::string line;
  if (!text.empty() && (text[0] == '.' || text[0] == '\'')) line = "\\&";
  for (const char each : text) {
    if (each == '\\') {
      line += "\\e";
    } else if (each == '-') {
      line += "\\-";
    } else {
      line += each;
    }
  }
  return line;
}

std::string quoted_for_shell(std::string_view text) {
  std::string line = "'";
  for (const char each : text) line += each == '\'' ? std::string("'\\''") : std::string(1, each);
  return line + "'";
}

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string line;
  for (const std::string& each : words) {
    if (!line.empty()) line += between;
    line += each;
  }
  return line;
}

std::vector<std::string> command_names(const std::vector<CommandText>& texts) {
  std::vector<std::string> names;
  for (const CommandText& each : texts) names.push_back(each.name);
  return names;
}

std::string bash(const std::vector<CommandText>& texts) {
  std::string out =
      "# bash completion of diesink\n"
      "_diesink() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words=\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    COMPREPLY=($(compgen -W '" +
      joined(command_names(texts), " ") +
      " --help --version' -- \"$word\"))\n"
      "    return\n"
      "  fi\n"
      "  case ${COMP_WORDS[1]}:$before in\n";
  for (const CommandText& command : texts) {
    for (const OptionText& option : command.options) {
      for (const std::string& name : option.names) {
        if (option.choices.empty()) continue;
        out += "    " + command.name + ":" + name + ") words='" + joined(option.choices, " ") +
               "' ;;\n";
      }
    }
  }
  out +=
      "  esac\n  if [ -z \"$words\" ] && [ \"${word#-}\" != \"$word\" ]; then\n    case "
      "${COMP_WORDS[1]} in\n";
  for (const CommandText& command : texts) {
    std::vector<std::string> names;
    for (const OptionText& option : command.options) {
      names.insert(names.end(), option.names.begin(), option.names.end());
    }
    out += "      " + command.name + ") words='" + joined(names, " ") + "' ;;\n";
  }
  return out +
         "    esac\n  fi\n"
         "  if [ -n \"$words\" ]; then\n"
         "    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
         "  else\n"
         "    compopt -o filenames\n"
         "    COMPREPLY=($(compgen -f -- \"$word\"))\n"
         "  fi\n}\ncomplete -F _diesink diesink\n";
}

std::string zsh(const std::vector<CommandText>& texts) {
  // In a specification ':' and brackets part the fields.
  const auto field = [](std::string_view text) {
    std::string line;
    for (const char each : text) {
      if (each == ':' || each == '[' || each == ']') line += '\\';
      line += each;
    }
    return line;
  };
  std::string out = "#compdef diesink\n_diesink() {\n  local -a commands\n  commands=(\n";
  for (const CommandText& each : texts) {
    out += "    " + quoted_for_shell(each.name + ":" + field(each.summary)) + "\n";
  }
  out +=
      "  )\n  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n"
      "  local command=$words[2]\n  shift words\n  (( CURRENT-- ))\n  case $command in\n";
  for (const CommandText& command : texts) {
    out += "    " + command.name + ")\n      _arguments";
    for (const OptionText& option : command.options) {
      for (const std::string& name : option.names) {
        std::string spec = name + "[" + field(option.summary) + "]";
        if (!option.choices.empty()) {
          spec += ":value:(" + joined(option.choices, " ") + ")";
        } else if (!option.shape.empty()) {
          spec += ":" + field(option.shape) + ":_files";
        }
        out += " \\\n        " + quoted_for_shell(spec);
      }
    }
    out += " \\\n        '*:file:_files' ;;\n";
  }
  return out +
         "  esac\n}\n"
         "if [ \"$funcstack[1]\" = _diesink ]; then _diesink \"$@\"; else compdef _diesink "
         "diesink; fi\n";
}

std::string fish(const std::vector<CommandText>& texts) {
  // Between single quotes fish knows \' and \\ only.
  const auto quote = [](std::string_view text) {
    std::string line = "'";
    for (const char each : text) {
      if (each == '\'' || each == '\\') line += '\\';
      line += each;
    }
    return line + "'";
  };
  std::string out = "# fish completion of diesink\n";
  for (const CommandText& each : texts) {
    out += "complete -c diesink -n __fish_use_subcommand -f -a " + each.name + " -d " +
           quote(each.summary) + "\n";
  }
  for (const CommandText& command : texts) {
    for (const OptionText& option : command.options) {
      if (option.positional) continue;
      out += "complete -c diesink -n '__fish_seen_subcommand_from " + command.name + "'";
      for (const std::string& name : option.names) {
        const bool is_long = name.starts_with("--");
        out += (is_long ? " -l " : " -s ") + name.substr(is_long ? 2 : 1);
      }
      if (!option.choices.empty()) {
        out += " -x -a '" + joined(option.choices, " ") + "'";
      } else if (!option.shape.empty()) {
        out += " -r";
      }
      out += " -d " + quote(option.summary) + "\n";
    }
  }
  return out;
}

}  // namespace

std::string manual_page() {
  std::string page =
      ".TH DIESINK 1 \"\" \"diesink " DIESINK_VERSION
      "\"\n.SH NAME\ndiesink \\- compound surfaces for dies, out to every CAD/CAM tool\n"
      ".SH SYNOPSIS\n.B diesink\n.I COMMAND\n[\\fIOPTIONS\\fR]\n.SH COMMANDS\n";
  for (const CommandText& command : all_texts()) {
    page += ".SS " + command.name + "\n" + roff(command.summary) + "\n.PP\n.nf\n" +
            roff(command.example) + "\n.fi\n";
    for (const OptionText& option : command.options) {
      page += ".TP\n";
      std::string head =
          option.positional ? "" : "\\fB" + roff(joined(option.names, ", ")) + "\\fR";
      if (!option.shape.empty())
        head += (head.empty() ? "" : " ") + ("\\fI" + roff(option.shape) + "\\fR");
      page += head + "\n" + roff(option.summary) + "\n";
    }
  }
  return page +
         ".SH EXIT STATUS\n0 done, 1 wrong usage, 2 bad input, 3 not in this build, 4 an output "
         "could "
         "not be written, 5 done but not kept to what was asked\n";
}

std::optional<std::string> completion(std::string_view shell) {
  if (shell == "bash") return bash(all_texts());
  if (shell == "zsh") return zsh(all_texts());
  if (shell == "fish") return fish(all_texts());
  return std::nullopt;
}

}  // namespace diesink
