// Which meshes stand where in a glTF scene.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "formats/gltf_model.h"

namespace diesink {

// A mesh under a node. `matrix` takes it to the scene's coordinates less the frame's offset.
struct GltfInstance {
  int mesh = 0;
  int node = 0;
  NodeMatrix matrix = kIdentity;
};

// In the order of a walk from the roots, each node before its children. Where there is a single
// root with a unit's scale and perhaps the rotation to Y up, `frame` tells of it and the matrices
// leave it out: coordinates are then those of the program. Else they are glTF's own, metres with Y
// up.
struct GltfScene {
  RootFrame frame;
  bool ours = false;  // the root carries what our writer puts there
  std::vector<GltfInstance> instances;
  std::string name;
};

GltfScene scene_of(const GltfModel& model, const std::string& file, Diagnostics& diagnostics);

}  // namespace diesink
