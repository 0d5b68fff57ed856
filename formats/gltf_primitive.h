// The arrays of one glTF primitive, wherever they are kept and however compressed.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "core/vec.h"
#include "formats/gltf_accessor.h"
#include "formats/gltf_model.h"

namespace diesink {

// glTF's numbers of primitive.mode.
enum GltfMode {
  kPoints,
  kLineList,
  kLineLoop,
  kLineStrip,
  kTriangleList,
  kTriangleStrip,
  kTriangleFan
};

// Warnings by what they say, told once with how often.
class GltfWarnings {
 public:
  void add(const std::string& text) { ++count_[text]; }
  void tell(const std::string& file, Diagnostics& diagnostics) const;

 private:
  std::map<std::string, std::size_t> count_;
};

// Needs: indices below positions.size(), finite positions; the reader sees to both.
struct GltfArrays {
  std::vector<Vec3> positions;                      // in the node's coordinates
  std::vector<Vec3> normals;                        // empty or one a vertex
  std::vector<std::array<std::uint8_t, 4>> colors;  // empty or one a vertex
  std::vector<std::uint32_t> indices;               // also where the file has none
};

class GltfPrimitives {
 public:
  // Needs: a model from load_gltf(), which outlives this, as the warnings do.
  GltfPrimitives(const GltfModel& model, GltfWarnings& warnings)
      : model_(model), accessors_(model), warnings_(warnings) {}

  // Errors: kInput where types, lengths, indices or compressed bytes are wrong; the message begins
  // with the place.
  Result<GltfArrays> read(int mesh, std::size_t p);

 private:
  using Indices = std::vector<std::uint32_t>;

  [[nodiscard]] Error wrong(const std::string& what) const {
    return Error{ErrorCode::kInput, place_ + what, {}};
  }
  Status decompress(const diesink_tinygltf::Primitive& primitive, const GltfDraco& draco,
                    std::map<std::string, std::vector<std::byte>>& attributes, Indices& indices);
  Status set_attributes(const diesink_tinygltf::Primitive& primitive,
                        std::map<std::string, std::vector<std::byte>>& decoded, GltfArrays& out);
  void check_bounds(const diesink_tinygltf::Accessor& accessor, bool packed,
                    const std::vector<Vec3>& positions);
  [[nodiscard]] Status check_indices(const GltfArrays& arrays) const;

  const GltfModel& model_;
  GltfAccessors accessors_;
  GltfWarnings& warnings_;
  std::string place_;  // "meshes[0].primitives[2] ", for messages
};

}  // namespace diesink
