// Points in reports.
// SPDX-License-Identifier: Apache-2.0
#include "convert/point_text.h"

#include "formats/text_number.h"

namespace diesink {

std::string point_text(const Vec3& point) {
  return to_text(point.x()) + ", " + to_text(point.y()) + ", " + to_text(point.z());
}

void write_point(JsonWriter& json, const Vec3& point) {
  json.begin_array().value(point.x()).value(point.y()).value(point.z()).end_array();
}

void write_bounds(JsonWriter& json, std::span<const Vec3, 2> corners) {
  json.key("bounds").begin_array();
  for (const Vec3& corner : corners) write_point(json, corner);
  json.end_array();
}

}  // namespace diesink
