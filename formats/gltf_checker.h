// Takes values out of JSON objects and checks each: the first fault is kept, later calls give
// defaults. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/result.h"

namespace diesink {

class JsonChecker {
 public:
  using Json = nlohmann::json;
  static constexpr std::uint64_t kMost = std::uint64_t{1} << 53;  // whole in a double

  // The object that the next calls look into: "accessors[3]".
  void enter(const char* what, std::size_t index) {
    what_ = what;
    index_ = index;
    inner_ = "";
  }
  void inside(const char* inner) { inner_ = inner; }

  [[nodiscard]] bool failed() const { return error_.has_value(); }
  [[nodiscard]] const Error& error() const { return *error_; }
  void fail(const std::string& problem) {
    if (!error_) error_ = Error{ErrorCode::kInput, path() + problem, {}};
  }
  void fail_limit(std::string problem) {
    if (!error_) error_ = Error{ErrorCode::kLimit, std::move(problem), {}};
  }

  static const Json* find(const Json& object, const char* key) {
    const auto it = object.find(key);
    return it == object.end() ? nullptr : &*it;
  }

  // A whole number in [low, high]. Without the key `missing` is given, or it is a fault where that
  // is empty.
  std::uint64_t whole(const Json& object, const char* key, std::uint64_t low, std::uint64_t high,
                      std::optional<std::uint64_t> missing) {
    const Json* const found = find(object, key);
    if (found == nullptr) {
      if (!missing) fail(std::string(" has no ") + key);
      return missing.value_or(low);
    }
    const std::optional<std::uint64_t> value = whole_value(*found);
    if (!value || *value < low || *value > high) {
      fail(std::string(".") + key + " is " + shown(*found) + ", expected a whole number from " +
           std::to_string(low) + " to " + std::to_string(high));
      return low;
    }
    return *value;
  }

  // An index below `count`, or -1 without the key.
  int index(const Json& object, const char* key, std::size_t count) {
    const Json* const found = find(object, key);
    return found == nullptr ? -1 : index_value(*found, key, count);
  }
  int index_value(const Json& found, const char* key, std::size_t count) {
    const std::optional<std::uint64_t> value = whole_value(found);
    if (!value || *value >= count) {
      fail(std::string(".") + key + " is " + shown(found) + ", expected an index below " +
           std::to_string(count));
      return -1;
    }
    return static_cast<int>(*value);
  }

  std::string text(const Json& object, const char* key) {
    const Json* const found = find(object, key);
    if (found == nullptr) return {};
    if (!found->is_string()) {
      fail(std::string(".") + key + " is " + shown(*found) + ", expected a string");
      return {};
    }
    return found->get<std::string>();
  }

  // True or false; false without the key.
  bool truth(const Json& object, const char* key) {
    const Json* const found = find(object, key);
    if (found == nullptr) return false;
    if (!found->is_boolean()) {
      fail(std::string(".") + key + " is " + shown(*found) + ", expected true or false");
      return false;
    }
    return found->get<bool>();
  }

  // An array, or null without the key.
  const Json* array(const Json& object, const char* key) { return part(object, key, true); }
  const Json* object(const Json& object, const char* key) { return part(object, key, false); }

  // An array of `size` finite numbers; empty without the key.
  std::vector<double> numbers(const Json& object, const char* key, std::size_t size) {
    const Json* const found = array(object, key);
    if (found == nullptr) return {};
    std::vector<double> out;
    for (const Json& value : *found) {
      if (value.is_number()) out.push_back(value.get<double>());
    }
    if (out.size() != size || found->size() != size) {
      fail(std::string(".") + key + " is not an array of " + std::to_string(size) + " numbers");
      return {};
    }
    return out;
  }

  // A value short enough for a message.
  static std::string shown(const Json& value) {
    if (value.is_object()) return "an object";
    if (value.is_array()) return "an array";
    std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
    if (text.size() > 40) text = text.substr(0, 37) + "...";
    return text;
  }

 private:
  static std::optional<std::uint64_t> whole_value(const Json& value) {
    if (value.is_number_unsigned()) return value.get<std::uint64_t>();
    if (value.is_number_float()) {
      const double number = value.get<double>();
      if (number >= 0 && number <= static_cast<double>(kMost) &&
          number == static_cast<double>(static_cast<std::uint64_t>(number))) {
        return static_cast<std::uint64_t>(number);
      }
    }
    return std::nullopt;
  }

  const Json* part(const Json& object, const char* key, bool is_array) {
    const Json* const found = find(object, key);
    if (found == nullptr) return nullptr;
    if (is_array ? !found->is_array() : !found->is_object()) {
      fail(std::string(".") + key + " is " + shown(*found) + ", expected an " +
           (is_array ? "array" : "object"));
      return nullptr;
    }
    return found;
  }

  [[nodiscard]] std::string path() const {
    std::string path = what_;
    if (index_ != kNoIndex) path += '[' + std::to_string(index_) + ']';
    return path + inner_;
  }

 public:
  static constexpr std::size_t kNoIndex = ~std::size_t{0};

 private:
  const char* what_ = "";
  std::size_t index_ = kNoIndex;
  const char* inner_ = "";
  std::optional<Error> error_;
};

}  // namespace diesink
