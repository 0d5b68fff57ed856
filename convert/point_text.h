// Points in reports.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "core/vec.h"
#include "formats/json_writer.h"

namespace diesink {

// "1, 2.5, -3", in the shortest form that reads back the same.
std::string point_text(const Vec3& point);

// [1,2.5,-3]
void write_point(JsonWriter& json, const Vec3& point);

// "bounds":[[0,0,0],[1,2.5,3]], the low corner first
void write_bounds(JsonWriter& json, std::span<const Vec3, 2> corners);

}  // namespace diesink
