// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_accessor.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace diesink {
namespace {

namespace tg = diesink_tinygltf;

Error wrong(std::string what) { return Error{ErrorCode::kInput, std::move(what), {}}; }

std::size_t size_of(int component_type) {
  return static_cast<std::size_t>(
      tg::GetComponentSizeInBytes(static_cast<std::uint32_t>(component_type)));
}

template <class T>
T value_at(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

// Signed fractions have two spellings of -1.
template <class T>
double fraction(T value) {
  return std::max(static_cast<double>(value) / std::numeric_limits<T>::max(), -1.0);
}

double number_at(const std::byte* from, int type, bool normalized) {
  switch (type) {
    case 5120: {
      const auto v = value_at<std::int8_t>(from);
      return normalized ? fraction(v) : v;
    }
    case 5121: {
      const auto v = value_at<std::uint8_t>(from);
      return normalized ? fraction(v) : v;
    }
    case 5122: {
      const auto v = value_at<std::int16_t>(from);
      return normalized ? fraction(v) : v;
    }
    case 5123: {
      const auto v = value_at<std::uint16_t>(from);
      return normalized ? fraction(v) : v;
    }
    case 5125:
      return value_at<std::uint32_t>(from);
    default:
      return static_cast<double>(value_at<float>(from));
  }
}

std::uint32_t index_at(const std::byte* from, int type) {
  switch (type) {
    case 5121:
      return value_at<std::uint8_t>(from);
    case 5123:
      return value_at<std::uint16_t>(from);
    default:
      return value_at<std::uint32_t>(from);
  }
}

// Copies elements that lie `stride` apart next to each other.
void gather(const std::byte* from, std::size_t stride, std::size_t size, std::size_t count,
            std::byte* to) {
  if (stride == size) {
    std::memcpy(to, from, size * count);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) std::memcpy(to + i * size, from + i * stride, size);
}

Result<std::vector<std::byte>> unpack(const GltfMeshopt& packed, std::span<const std::byte> bytes,
                                      int number) {
  const std::string name = "bufferViews[" + std::to_string(number) + "] ";
  // The codecs put at most 64 bytes into one, a few for the end apart.
  const std::size_t size = packed.count * packed.stride;
  if (size / 64 > bytes.size() + 1024) {
    return wrong(name + "claims " + std::to_string(size) + " bytes from " +
                 std::to_string(bytes.size()) + " compressed ones");
  }
  std::vector<std::byte> out(size);
  const auto* const from = reinterpret_cast<const unsigned char*>(bytes.data());
  int result = -1;
  if (packed.mode == "ATTRIBUTES" && packed.stride % 4 == 0) {
    result =
        meshopt_decodeVertexBuffer(out.data(), packed.count, packed.stride, from, bytes.size());
  } else if (packed.mode == "TRIANGLES" && packed.count % 3 == 0 &&
             (packed.stride == 2 || packed.stride == 4)) {
    result = meshopt_decodeIndexBuffer(out.data(), packed.count, packed.stride, from, bytes.size());
  } else if (packed.mode == "INDICES" && (packed.stride == 2 || packed.stride == 4)) {
    result =
        meshopt_decodeIndexSequence(out.data(), packed.count, packed.stride, from, bytes.size());
  }
  if (result != 0)
    return wrong(name + "cannot be decompressed (" + packed.mode.substr(0, 20) + ")");
  const bool plain = packed.filter.empty() || packed.filter == "NONE";
  if (packed.filter == "OCTAHEDRAL" && (packed.stride == 4 || packed.stride == 8)) {
    meshopt_decodeFilterOct(out.data(), packed.count, packed.stride);
  } else if (packed.filter == "QUATERNION" && packed.stride == 8) {
    meshopt_decodeFilterQuat(out.data(), packed.count, packed.stride);
  } else if (packed.filter == "EXPONENTIAL" && packed.stride % 4 == 0) {
    meshopt_decodeFilterExp(out.data(), packed.count, packed.stride);
  } else if (!plain) {
    return wrong(name + "has the filter " + packed.filter.substr(0, 20) + " on elements of " +
                 std::to_string(packed.stride) + " bytes");
  }
  return out;
}

}  // namespace

Result<std::span<const std::byte>> GltfAccessors::view(int number) {
  const std::size_t v = static_cast<std::size_t>(number);
  const std::optional<GltfMeshopt>& packed = model_.meshopt[v];
  const tg::BufferView& view = model_.file.bufferViews[v];
  if (!packed) {
    return model_.buffers[static_cast<std::size_t>(view.buffer)].bytes.subspan(view.byteOffset,
                                                                               view.byteLength);
  }
  if (const auto known = unpacked_.find(number); known != unpacked_.end()) {
    return std::span<const std::byte>(known->second);
  }
  auto bytes = unpack(*packed,
                      model_.buffers[static_cast<std::size_t>(packed->buffer)].bytes.subspan(
                          packed->offset, packed->length),
                      number);
  if (!bytes) return bytes.error();
  return std::span<const std::byte>(unpacked_.emplace(number, std::move(*bytes)).first->second);
}

Status GltfAccessors::put_sparse(int accessor, GltfValues& values) {
  const auto& sparse = model_.file.accessors[static_cast<std::size_t>(accessor)].sparse;
  const auto indices = view(sparse.indices.bufferView);
  if (!indices) return indices.error();
  const auto replacements = view(sparse.values.bufferView);
  if (!replacements) return replacements.error();
  const std::size_t size =
      size_of(values.component_type) * static_cast<std::size_t>(values.components);
  const std::size_t index_size = size_of(sparse.indices.componentType);
  const std::byte* index = indices->data() + sparse.indices.byteOffset;
  const std::byte* value = replacements->data() + sparse.values.byteOffset;
  std::uint32_t before = 0;
  for (int i = 0; i < sparse.count; ++i, index += index_size, value += size) {
    const std::uint32_t at = index_at(index, sparse.indices.componentType);
    if (at >= values.count) {
      return wrong("accessors[" + std::to_string(accessor) + "].sparse replaces element " +
                   std::to_string(at) + " of " + std::to_string(values.count));
    }
    // glTF 2.0, 3.6.2.3. What stands twice would have two values.
    if (i > 0 && at <= before) {
      return wrong("accessors[" + std::to_string(accessor) + "].sparse has index " +
                   std::to_string(at) + " behind " + std::to_string(before) +
                   ", expected indices that increase");
    }
    before = at;
    std::memcpy(values.bytes.data() + at * size, value, size);
  }
  return ok();
}

Result<GltfValues> GltfAccessors::values(int number, std::vector<std::byte> decoded) {
  const std::size_t a = static_cast<std::size_t>(number);
  const tg::Accessor& accessor = model_.file.accessors[a];
  GltfValues values;
  values.count = accessor.count;
  values.component_type = accessor.componentType;
  values.components = tg::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
  values.normalized = accessor.normalized;
  const std::size_t size =
      size_of(values.component_type) * static_cast<std::size_t>(values.components);
  if (!decoded.empty()) {
    values.bytes = std::move(decoded);
    values.count = values.bytes.size() / size;
  } else {
    values.bytes.resize(size * values.count);
    if (!model_.without_view[a]) {
      const auto bytes = view(accessor.bufferView);
      if (!bytes) return bytes.error();
      const std::size_t stride =
          model_.file.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride;
      gather(bytes->data() + accessor.byteOffset, stride > 0 ? stride : size, size, values.count,
             values.bytes.data());
    }
  }
  if (accessor.sparse.isSparse) {
    if (Status s = put_sparse(number, values); !s) return s.error();
  }
  return values;
}

std::vector<Vec3> to_vectors(const GltfValues& values) {
  std::vector<Vec3> out(values.count);
  const std::size_t size = size_of(values.component_type);
  const std::byte* from = values.bytes.data();
  if (values.component_type == 5126) {
    for (Vec3& v : out) {
      for (int k = 0; k < 3; ++k, from += 4) v[k] = static_cast<double>(value_at<float>(from));
    }
    return out;
  }
  for (Vec3& v : out) {
    for (int k = 0; k < 3; ++k, from += size) {
      v[k] = number_at(from, values.component_type, values.normalized);
    }
  }
  return out;
}

std::vector<std::array<double, 4>> to_colors(const GltfValues& values) {
  std::vector<std::array<double, 4>> out(values.count, {0, 0, 0, 1});
  const std::size_t size = size_of(values.component_type);
  const std::byte* from = values.bytes.data();
  for (auto& color : out) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(values.components); ++k, from += size) {
      color[k] = number_at(from, values.component_type, values.normalized);
    }
  }
  return out;
}

Result<std::vector<std::uint32_t>> to_indices(const GltfValues& values) {
  const int type = values.component_type;
  if (values.components != 1 || (type != 5121 && type != 5123 && type != 5125)) {
    return wrong("indices are not unsigned whole numbers");
  }
  std::vector<std::uint32_t> out(values.count);
  const std::size_t size = size_of(type);
  const std::byte* from = values.bytes.data();
  for (std::uint32_t& index : out) {
    index = index_at(from, type);
    from += size;
  }
  return out;
}

}  // namespace diesink
