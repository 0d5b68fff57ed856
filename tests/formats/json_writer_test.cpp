// JSON text: the grammar, escapes, numbers, and strings that are not UTF-8.
// SPDX-License-Identifier: Apache-2.0
#include "formats/json_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

namespace diesink {
namespace {

TEST(JsonWriter, KeepsTheOrderAndSeparates) {
  JsonWriter json;
  json.begin_object()
      .field("b", 1)
      .key("a")
      .begin_array()
      .value(true)
      .null()
      .begin_object()
      .end_object();
  json.end_array().field("c", "x").key("e").begin_array().end_array().end_object();
  EXPECT_EQ(json.text(), R"({"b":1,"a":[true,null,{}],"c":"x","e":[]})");
}

TEST(JsonWriter, WritesNumbersShortestAndOnlyFiniteOnes) {
  JsonWriter json;
  json.begin_array().value(0.1).value(-0.0).value(1e300).value(std::nan(""));
  json.value(std::numeric_limits<double>::infinity())
      .value(std::numeric_limits<std::uint64_t>::max());
  json.value(std::numeric_limits<std::int64_t>::min()).end_array();
  EXPECT_EQ(json.text(), "[0.1,0,1e+300,null,null,18446744073709551615,-9223372036854775808]");
}

TEST(JsonWriter, EscapesWhatJsonForbids) {
  JsonWriter json;
  json.value(std::string_view("a\"b\\c\nd\te\x01\x7F\0z", 13));
  EXPECT_EQ(json.text(), R"("a\"b\\c\nd\te\u0001\u007f\u0000z")");
}

TEST(JsonWriter, ReplacesBytesThatAreNotUtf8) {
  const auto text = [](std::string_view bytes) { return JsonWriter().value(bytes).text(); };
  EXPECT_EQ(text("\xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80"),
            "\"\xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80\"");
  const std::string bad = "\xEF\xBF\xBD";
  EXPECT_EQ(text("\xFF"), '"' + bad + '"');
  EXPECT_EQ(text("\xC0\x80"), '"' + bad + bad + '"');                      // overlong
  EXPECT_EQ(text("\xED\xA0\x80"), '"' + bad + bad + bad + '"');            // surrogate
  EXPECT_EQ(text("\xE2\x82"), '"' + bad + bad + '"');                      // cut short
  EXPECT_EQ(text("\xF4\x90\x80\x80"), '"' + bad + bad + bad + bad + '"');  // beyond Unicode
}

// A parser that did not write it accepts any string of bytes and gives back what was valid.
TEST(JsonWriter, AnyBytesGiveJsonThatParses) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> byte(0, 255), length(0, 40);
  for (int run = 0; run < 2000; ++run) {
    std::string bytes;
    for (int left = length(random); left > 0; --left) bytes += static_cast<char>(byte(random));
    JsonWriter json;
    json.begin_object().field(bytes, bytes).end_object();
    const nlohmann::json parsed = nlohmann::json::parse(json.text(), nullptr, false);
    ASSERT_FALSE(parsed.is_discarded()) << json.text();
    ASSERT_EQ(parsed.size(), 1u);
  }
  std::string ascii;
  for (int c = 0; c < 128; ++c) ascii += static_cast<char>(c);
  EXPECT_EQ(nlohmann::json::parse(JsonWriter().value(ascii).text()).get<std::string>(), ascii);
}

}  // namespace
}  // namespace diesink
