// JSON text built front to back: keys stay in the order they are written.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace diesink {

// Shape:  numbers in the shortest form that reads back the same double, -0 as 0; what is not finite
// becomes null.
//         Strings are escaped; bytes that are not UTF-8 become U+FFFD, so that the text is JSON for
//         any input.
// Needs:  calls in the order of the grammar: a key before each value of an object, each begin_ with
// its end_.
class JsonWriter {
 public:
  JsonWriter& begin_object();
  JsonWriter& end_object();
  JsonWriter& begin_array();
  JsonWriter& end_array();
  JsonWriter& key(std::string_view name);
  JsonWriter& value(double number);
  JsonWriter& value(std::int64_t number);
  JsonWriter& value(std::uint64_t number);
  JsonWriter& value(int number) { return value(static_cast<std::int64_t>(number)); }
  JsonWriter& value(bool truth);
  JsonWriter& value(std::string_view text);
  JsonWriter& value(const char* text) { return value(std::string_view(text)); }
  JsonWriter& null();

  template <class T>
  JsonWriter& field(std::string_view name, const T& what) {
    return key(name).value(what);
  }

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void separate();
  std::string text_;
  std::vector<bool> first_;  // one an open object or array: nothing in it yet
  bool after_key_ = false;
};

}  // namespace diesink
