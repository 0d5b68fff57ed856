// What our own writer puts into the `extras` of nodes, materials and primitives, read back.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "formats/gltf_model.h"

namespace diesink {

// Our own extras of an object, or null. They are read leniently, for other programs may have
// changed them: what is not as we write it counts as not there.
const nlohmann::json* our_extras(const nlohmann::json& from);
std::string extras_text(const nlohmann::json& object, const char* key);
bool extras_true(const nlohmann::json& object, const char* key);

// Empty where any curve lacks its number of vertices: the segments cannot then be given to their
// curves.
std::vector<GltfCurve> curves_of_extras(const nlohmann::json& mine);
RootFrame frame_of_extras(const nlohmann::json& mine);

}  // namespace diesink
