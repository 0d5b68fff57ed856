// The values of glTF accessors, wherever their bytes come from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.h"
#include "formats/draco_mesh.h"
#include "formats/gltf_model.h"

namespace diesink {

// Tightly packed elements of one accessor, sparse values put in.
struct GltfValues {
  std::vector<std::byte> bytes;
  std::size_t count = 0;
  int component_type = 5126;
  int components = 1;
  bool normalized = false;
};

class GltfAccessors {
 public:
  // Needs: a model from load_gltf(), which outlives this.
  explicit GltfAccessors(const GltfModel& model) : model_(model) {}

  // `decoded` replaces the bytes of the accessor's view: what Draco gave, tightly packed; or is
  // empty. Errors: kInput where a compressed view is damaged or sparse indices are out of range or
  // do not increase.
  Result<GltfValues> values(int accessor, std::vector<std::byte> decoded = {});
  // The bytes of a view, decompressed where EXT_meshopt_compression says so.
  Result<std::span<const std::byte>> view(int number);

 private:
  Status put_sparse(int accessor, GltfValues& values);

  const GltfModel& model_;
  std::map<int, std::vector<std::byte>> unpacked_;
};

// Each element as numbers: normalized integers become fractions, floats stay what they are.
// Needs: 3 components; 3 or 4 for colours, whose missing alpha is 1.
std::vector<Vec3> to_vectors(const GltfValues& values);
std::vector<std::array<double, 4>> to_colors(const GltfValues& values);
// Errors: kInput for components that no index has.
Result<std::vector<std::uint32_t>> to_indices(const GltfValues& values);

}  // namespace diesink
