// `diesink formats`: what each format reads, writes and keeps, from the registry itself.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/App.hpp>
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "convert/commands.h"
#include "convert/text_table.h"
#include "formats/format.h"
#include "formats/json_writer.h"

namespace diesink {
namespace {

struct Property {
  std::string_view name;
  Keeps Format::*kept;
};
constexpr std::array<Property, 7> kProperties{{{"positions", &Format::positions},
                                               {"names", &Format::names},
                                               {"colors", &Format::colors},
                                               {"normals", &Format::normals},
                                               {"lines", &Format::lines},
                                               {"units", &Format::units},
                                               {"sharing", &Format::sharing}}};

std::string_view word_of(Keeps kept) {
  switch (kept) {
    case Keeps::kYes:
      return "yes";
    case Keeps::kFloat32:
      return "float";
    case Keeps::kNo:
      break;
  }
  return "no";
}

std::string endings_of(const Format& format) {
  std::string text;
  for (const std::string_view ending : format.extensions) {
    text += (text.empty() ? "" : " ") + std::string(ending);
  }
  return text;
}

std::string as_json() {
  JsonWriter json;
  json.begin_object().key("formats").begin_array();
  for (const Format* format : all_formats()) {
    json.begin_object().field("id", format->id).field("title", format->title);
    json.key("endings").begin_array();
    for (const std::string_view ending : format->extensions) json.value(ending);
    json.end_array();
    json.field("reads", format->read != nullptr).field("writes", format->write != nullptr);
    for (const Property& each : kProperties) json.field(each.name, word_of(format->*each.kept));
    json.field("remarks", format->remarks).end_object();
  }
  json.end_array().end_object();
  return json.text() + "\n";
}

std::string as_table() {
  std::vector<std::vector<std::string>> rows{{"format", "endings", "reads", "writes"}};
  for (const Property& each : kProperties) rows[0].emplace_back(each.name);
  rows[0].emplace_back("remarks");
  for (const Format* format : all_formats()) {
    std::vector<std::string> row{std::string(format->title), endings_of(*format),
                                 format->read != nullptr ? "yes" : "no",
                                 format->write != nullptr ? "yes" : "no"};
    for (const Property& each : kProperties) row.emplace_back(word_of(format->*each.kept));
    row.emplace_back(format->remarks);
    rows.push_back(std::move(row));
  }
  return to_table(rows);
}

Run setup(CLI::App&) {
  return [](const CommonOptions& common) { return print(common.json ? as_json() : as_table()); };
}

}  // namespace

const Command kFormatsCommand{"formats", "what each format reads, writes and keeps",
                              "diesink formats", true, setup};

}  // namespace diesink
