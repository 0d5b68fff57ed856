// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_json.h"

#include <nlohmann/json.hpp>

namespace diesink {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kValuesOfAny = 200'000;  // up to a hundred bytes each, in the tree
constexpr std::size_t kBytesPerValue = 10;

// Counts values and depth without keeping anything, so that a bomb is known before a tree is built
// of it.
class Measure : public nlohmann::json_sax<Json> {
 public:
  explicit Measure(std::size_t most_values) : most_values_(most_values) {}

  bool null() override { return value(); }
  bool boolean(bool /*truth*/) override { return value(); }
  bool number_integer(number_integer_t /*number*/) override { return value(); }
  bool number_unsigned(number_unsigned_t /*number*/) override { return value(); }
  bool number_float(number_float_t /*number*/, const string_t& /*text*/) override {
    return value();
  }
  bool string(string_t& /*text*/) override { return value(); }
  bool binary(binary_t& /*bytes*/) override { return value(); }
  bool start_object(std::size_t /*size*/) override { return open(); }
  bool start_array(std::size_t /*size*/) override { return open(); }
  bool key(string_t& /*name*/) override { return true; }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t position, const std::string& /*last_token*/,
                   const nlohmann::detail::exception& reason) override {
    position_ = position;
    reason_ = reason.what();
    return false;
  }

  [[nodiscard]] bool too_deep() const { return depth_ > kMaxJsonDepth; }
  [[nodiscard]] bool too_many() const { return values_ > most_values_; }
  [[nodiscard]] std::size_t position() const { return position_; }
  // The library's own words after its "[json.exception...] parse error at line 1, column 2: ".
  [[nodiscard]] std::string reason() const {
    const std::size_t column = reason_.find("column ");
    const std::size_t colon = reason_.find(": ", column == std::string::npos ? 0 : column);
    return colon == std::string::npos ? reason_ : reason_.substr(colon + 2);
  }

 private:
  bool value() { return ++values_ <= most_values_; }
  bool open() { return value() && ++depth_ <= kMaxJsonDepth; }
  bool close() {
    --depth_;
    return true;
  }

  std::size_t most_values_;
  std::size_t values_ = 0;
  int depth_ = 0;
  std::size_t position_ = 0;
  std::string reason_;
};

}  // namespace

Result<nlohmann::json> parse_gltf_json(std::string_view text, std::size_t file_bytes,
                                       const std::string& file, Diagnostics& diagnostics) {
  Place where;
  where.file = file;
  const auto wrong = [&where](std::string what, ErrorCode code = ErrorCode::kInput) {
    return Error{code, std::move(what), where};
  };
  if (text.size() > kMaxJsonBytes) {
    return wrong("the JSON has " + std::to_string(text.size()) + " bytes, at most " +
                     std::to_string(kMaxJsonBytes) + " are read",
                 ErrorCode::kLimit);
  }
  if (text.starts_with("\xEF\xBB\xBF")) {
    diagnostics.warning("the JSON begins with a byte order mark", where);
    text.remove_prefix(3);
  }
  Measure measure(kValuesOfAny + file_bytes / kBytesPerValue);
  if (!Json::sax_parse(text, &measure)) {
    if (measure.too_deep()) {
      return wrong("the JSON is nested deeper than " + std::to_string(kMaxJsonDepth));
    }
    if (measure.too_many()) {
      return wrong("the JSON holds more values than a file of this size may", ErrorCode::kLimit);
    }
    where.byte = static_cast<std::int64_t>(measure.position());
    return wrong("not JSON: " + measure.reason());
  }
  Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return wrong("the JSON is no object");
  return json;
}

}  // namespace diesink
