// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_scene.h"

#include "core/counted.h"

#include <algorithm>
#include <cmath>

namespace diesink {
namespace {

namespace tg = diesink_tinygltf;

NodeMatrix product(const NodeMatrix& a, const NodeMatrix& b) {
  if (a == kIdentity) return b;
  if (b == kIdentity) return a;
  NodeMatrix out{};
  for (std::size_t column = 0; column < 4; ++column) {
    for (std::size_t row = 0; row < 4; ++row) {
      double sum = 0;
      for (std::size_t k = 0; k < 4; ++k) sum += a[4 * k + row] * b[4 * column + k];
      out[4 * column + row] = sum;
    }
  }
  return out;
}

// The node's own matrix; `odd` counts rotations that are no unit quaternion.
NodeMatrix local_matrix(const tg::Node& node, std::size_t& odd) {
  NodeMatrix m = kIdentity;
  if (node.matrix.size() == 16) {
    std::copy(node.matrix.begin(), node.matrix.end(), m.begin());
    return m;
  }
  if (node.rotation.size() == 4) {
    double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2], w = node.rotation[3];
    const double length = std::sqrt(x * x + y * y + z * z + w * w);
    if (!(std::abs(length - 1) <= 1e-3)) ++odd;
    if (length > 0 && std::isfinite(length)) {
      x /= length, y /= length, z /= length, w /= length;
      m = {1 - 2 * (y * y + z * z),
           2 * (x * y + z * w),
           2 * (x * z - y * w),
           0,
           2 * (x * y - z * w),
           1 - 2 * (x * x + z * z),
           2 * (y * z + x * w),
           0,
           2 * (x * z + y * w),
           2 * (y * z - x * w),
           1 - 2 * (x * x + y * y),
           0,
           0,
           0,
           0,
           1};
    }
  }
  if (node.scale.size() == 3) {
    for (std::size_t column = 0; column < 3; ++column) {
      for (std::size_t row = 0; row < 3; ++row) m[4 * column + row] *= node.scale[column];
    }
  }
  if (node.translation.size() == 3) {
    for (std::size_t row = 0; row < 3; ++row) m[12 + row] = node.translation[row];
  }
  return m;
}

}  // namespace

GltfScene scene_of(const GltfModel& model, const std::string& file, Diagnostics& diagnostics) {
  GltfScene scene;
  scene.frame.unit = LengthUnit::kMetre;
  scene.frame.up = UpAxis::kY;
  std::size_t odd = 0;
  std::optional<RootFrame> frame;
  if (model.roots.size() == 1) {
    const std::size_t root = static_cast<std::size_t>(model.roots[0]);
    const tg::Node& node = model.file.nodes[root];
    std::size_t odd_root = 0;
    frame = frame_of(local_matrix(node, odd_root), model.nodes[root].frame);
    scene.ours = model.nodes[root].frame.has_value();
    if (!scene.ours || !model.nodes[root].unnamed) scene.name = node.name;
    if (frame) scene.frame = *frame;
  }

  struct Step {
    int node;
    NodeMatrix matrix;  // of the parent
    std::size_t depth;
  };
  constexpr std::size_t kOddDepth = 1000;
  std::size_t deepest = 0;
  std::vector<Step> open;
  for (std::size_t r = model.roots.size(); r-- > 0;) open.push_back({model.roots[r], kIdentity, 0});
  bool at_root = frame.has_value();
  while (!open.empty()) {
    const Step step = open.back();
    open.pop_back();
    deepest = std::max(deepest, step.depth);
    const tg::Node& node = model.file.nodes[static_cast<std::size_t>(step.node)];
    const NodeMatrix matrix = at_root ? kIdentity : product(step.matrix, local_matrix(node, odd));
    at_root = false;
    if (node.mesh >= 0) scene.instances.push_back({node.mesh, step.node, matrix});
    for (std::size_t c = node.children.size(); c-- > 0;) {
      open.push_back({node.children[c], matrix, step.depth + 1});
    }
  }
  if (deepest > kOddDepth) {
    diagnostics.warning("nodes are nested " + std::to_string(deepest) + " deep", Place{file});
  }
  if (odd > 0) {
    diagnostics.warning(counted(odd, "node has|nodes have| a rotation that is no unit quaternion"),
                        Place{file});
  }
  return scene;
}

}  // namespace diesink
