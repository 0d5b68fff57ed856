// From the JSON of a glTF file to the part of it that a mesh needs, with every type and range
// checked. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/diagnostics.h"
#include "formats/gltf_model.h"

namespace diesink {

struct GltfBufferSource {
  std::string uri;
  bool has_uri = false;
  bool fallback = false;  // meshopt compression stands in for it
  std::size_t length = 0;
};

struct ReducedGltf {
  std::string text;  // the JSON for tinygltf
  std::vector<GltfBufferSource> buffers;
  GltfModel model;  // what tinygltf does not carry; model.file and model.buffers are empty
};

// Keeps asset, scenes, nodes, meshes, materials, accessors and views, of each only what is read,
// and takes our own extras and the compression extensions out of it. tinygltf gets no buffers,
// images, extras or extensions, and an accessor without a view is given one, because tinygltf
// refuses indices that have none. Errors: kInput naming the value, what was found and what was
// expected; kLimit where a file of this size holds more
//         objects than it should. What is left out is told in warnings.
Result<ReducedGltf> reduce_gltf(const nlohmann::json& json, std::size_t file_bytes,
                                const std::string& file, Diagnostics& diagnostics);

}  // namespace diesink
