// The one place where tinygltf is compiled. It sees JSON that gltf_reduce has written, and what it
// makes of it is checked again in 64 bits.
// SPDX-License-Identifier: Apache-2.0
#include <fstream>  // the writer in tiny_gltf.h, which nothing calls, wants it
#define TINYGLTF_IMPLEMENTATION
#include "formats/gltf_model.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "formats/glb_container.h"
#include "formats/gltf_buffers.h"
#include "formats/gltf_json.h"
#include "formats/gltf_reduce.h"

namespace diesink {
namespace {

namespace tg = diesink_tinygltf;

Error wrong(std::string what) { return Error{ErrorCode::kInput, std::move(what), {}}; }

std::string at(const char* array, std::size_t index) {
  return std::string(array) + '[' + std::to_string(index) + ']';
}

// The file as text: with its own parse, tinygltf wants no buffers and no files.
Status load_reduced(const ReducedGltf& reduced, tg::Model& model) {
  tg::TinyGLTF loader;
  loader.SetImageLoader([](tg::Image*, const int, std::string*, std::string*, int, int,
                           const unsigned char*, int, void*) { return true; },
                        nullptr);
  std::string error, warning;
  const bool loaded =
      loader.LoadASCIIFromString(&model, &error, &warning, reduced.text.c_str(),
                                 static_cast<unsigned>(reduced.text.size()), "", tg::NO_REQUIRE);
  if (loaded) return ok();
  std::replace(error.begin(), error.end(), '\n', ' ');
  return wrong("tinygltf refuses the file: " + error.substr(0, 200));
}

// Every view lies in its buffer, and every compressed one in its own.
Status check_views(const GltfModel& model) {
  for (std::size_t v = 0; v < model.file.bufferViews.size(); ++v) {
    const tg::BufferView& view = model.file.bufferViews[v];
    const std::optional<GltfMeshopt>& packed = model.meshopt[v];
    const auto within = [&](std::size_t buffer, std::uint64_t offset, std::uint64_t length,
                            const char* what) -> Status {
      const std::uint64_t size = model.buffers[buffer].bytes.size();
      if (offset <= size && length <= size - offset) return ok();
      return wrong(at("bufferViews", v) + what + " ends at byte " +
                   std::to_string(offset + length) + " of buffers[" + std::to_string(buffer) +
                   "], which has " + std::to_string(size));
    };
    if (model.buffers.empty()) continue;  // the view given to accessors that have none
    const std::size_t buffer = static_cast<std::size_t>(view.buffer);
    if (packed) {
      if (Status s = within(static_cast<std::size_t>(packed->buffer), packed->offset,
                            packed->length, ".EXT_meshopt_compression");
          !s) {
        return s;
      }
      if (packed->stride * packed->count != view.byteLength) {
        return wrong(at("bufferViews", v) + " has " + std::to_string(view.byteLength) +
                     " bytes, its compressed form " +
                     std::to_string(packed->stride * packed->count));
      }
    } else if (model.buffers[buffer].missing) {
      return wrong(at("bufferViews", v) + " is in a buffer without bytes");
    } else if (Status s = within(buffer, view.byteOffset, view.byteLength, ""); !s) {
      return s;
    }
  }
  return ok();
}

// `count` elements of `size` bytes, `stride` apart, from `offset` on in a view of `length` bytes.
bool fits(std::uint64_t offset, std::uint64_t count, std::uint64_t size, std::uint64_t stride,
          std::uint64_t length) {
  if (offset > length) return false;
  const std::uint64_t left = length - offset;
  return size <= left && (count - 1) <= (left - size) / stride;  // counts are at least 1
}

Status check_accessors(const GltfModel& model, const std::string& file, Diagnostics& diagnostics) {
  std::size_t misaligned = 0;
  for (std::size_t a = 0; a < model.file.accessors.size(); ++a) {
    const tg::Accessor& accessor = model.file.accessors[a];
    const std::uint64_t component = static_cast<std::uint64_t>(
        tg::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType)));
    const std::uint64_t size = component * static_cast<std::uint64_t>(tg::GetNumComponentsInType(
                                               static_cast<std::uint32_t>(accessor.type)));
    const auto check = [&](int view_number, std::uint64_t offset, std::uint64_t count,
                           std::uint64_t element, std::uint64_t part, const char* what) -> Status {
      const tg::BufferView& view = model.file.bufferViews[static_cast<std::size_t>(view_number)];
      const std::uint64_t stride = view.byteStride > 0 ? view.byteStride : element;
      if (stride < element) {
        return wrong(at("accessors", a) + what + " has elements of " + std::to_string(element) +
                     " bytes, its view a stride of " + std::to_string(stride));
      }
      if ((view.byteOffset + offset) % part != 0 || stride % part != 0) ++misaligned;
      if (!fits(offset, count, element, stride, view.byteLength)) {
        return wrong(at("accessors", a) + what + " has " + std::to_string(count) +
                     " elements, more than its view holds");
      }
      return ok();
    };
    if (!model.without_view[a]) {
      if (Status s =
              check(accessor.bufferView, accessor.byteOffset, accessor.count, size, component, "");
          !s) {
        return s;
      }
    }
    if (!accessor.sparse.isSparse) continue;
    const auto& sparse = accessor.sparse;
    const std::uint64_t index_size = static_cast<std::uint64_t>(
        tg::GetComponentSizeInBytes(static_cast<std::uint32_t>(sparse.indices.componentType)));
    const std::uint64_t count = static_cast<std::uint64_t>(sparse.count);
    if (Status s =
            check(sparse.indices.bufferView, static_cast<std::uint64_t>(sparse.indices.byteOffset),
                  count, index_size, index_size, ".sparse.indices");
        !s) {
      return s;
    }
    if (Status s =
            check(sparse.values.bufferView, static_cast<std::uint64_t>(sparse.values.byteOffset),
                  count, size, component, ".sparse.values");
        !s) {
      return s;
    }
  }
  if (misaligned > 0) {
    diagnostics.warning(
        std::to_string(misaligned) + " accessors are not aligned to the size of their components",
        Place{file});
  }
  return ok();
}

// Nodes form trees: each has one parent at most, and a scene's nodes have none. Fills in the roots
// to be read.
Status check_nodes(GltfModel& model, const std::string& file, Diagnostics& diagnostics) {
  const std::vector<tg::Node>& nodes = model.file.nodes;
  std::vector<int> parent(nodes.size(), -1);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    for (const int child : nodes[n].children) {
      const std::size_t c = static_cast<std::size_t>(child);
      if (c == n) return wrong(at("nodes", n) + " is its own child");
      if (parent[c] >= 0) {
        return wrong(at("nodes", c) + " is a child of nodes[" + std::to_string(parent[c]) +
                     "] and of nodes[" + std::to_string(n) + "]");
      }
      parent[c] = static_cast<int>(n);
    }
  }
  // With one parent each, what no root leads to is a cycle.
  std::vector<int> reached;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (parent[n] < 0) reached.push_back(static_cast<int>(n));
  }
  model.roots = reached;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const tg::Node& node = nodes[static_cast<std::size_t>(reached[i])];
    reached.insert(reached.end(), node.children.begin(), node.children.end());
  }
  if (reached.size() < nodes.size()) return wrong("the nodes form a cycle");

  for (std::size_t s = 0; s < model.file.scenes.size(); ++s) {
    std::vector<int> roots = model.file.scenes[s].nodes;
    for (const int root : roots) {
      if (parent[static_cast<std::size_t>(root)] >= 0) {
        return wrong(at("scenes", s) + " names nodes[" + std::to_string(root) +
                     "], which is the child of another");
      }
    }
    std::sort(roots.begin(), roots.end());
    if (std::adjacent_find(roots.begin(), roots.end()) != roots.end()) {
      return wrong(at("scenes", s) + " names a node twice");
    }
  }
  if (model.file.scenes.empty()) return ok();
  const std::size_t scene =
      model.file.defaultScene < 0 ? 0 : static_cast<std::size_t>(model.file.defaultScene);
  if (model.file.scenes.size() > 1) {
    diagnostics.warning(
        "of " + std::to_string(model.file.scenes.size()) + " scenes only one is read", Place{file});
  }
  if (model.file.scenes[scene].nodes.size() < model.roots.size()) {
    diagnostics.warning("nodes that do not belong to the scene are not read", Place{file});
  }
  model.roots = model.file.scenes[scene].nodes;
  return ok();
}

// Sizes agree with what was checked before tinygltf parsed it again.
bool same_sizes(const GltfModel& model) {
  if (model.file.nodes.size() != model.nodes.size() ||
      model.file.materials.size() != model.materials.size() ||
      model.file.meshes.size() != model.primitives.size() ||
      model.file.accessors.size() != model.without_view.size() ||
      model.file.bufferViews.size() != model.meshopt.size()) {
    return false;
  }
  for (std::size_t m = 0; m < model.primitives.size(); ++m) {
    if (model.file.meshes[m].primitives.size() != model.primitives[m].size()) return false;
  }
  return true;
}

Result<GltfModel> load(std::span<const std::byte> bytes, const ReadOptions& options,
                       Diagnostics& diagnostics) {
  GlbParts parts;
  const bool binary = bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
  if (binary) {
    auto split = split_glb(bytes, options.file_name, diagnostics);
    if (!split) return split.error();
    parts = *split;
  } else {
    parts.json = bytes;
  }
  auto json = parse_gltf_json(
      std::string_view(reinterpret_cast<const char*>(parts.json.data()), parts.json.size()),
      bytes.size(), options.file_name, diagnostics);
  if (!json) {
    // Counted from the beginning of the file.
    if (binary && json.error().where.byte >= 0) json.error().where.byte += 20;
    return json.error();
  }
  auto reduced = reduce_gltf(*json, bytes.size(), options.file_name, diagnostics);
  if (!reduced) return reduced.error();
  *json = nullptr;  // before tinygltf makes a tree of its own
  GltfModel model = std::move(reduced->model);
  if (Status s = load_reduced(*reduced, model.file); !s) return s.error();
  if (!same_sizes(model)) return wrong("tinygltf reads other numbers of things than the file has");
  auto buffers =
      resolve_buffers(reduced->buffers, parts.buffer, parts.has_buffer, options, diagnostics);
  if (!buffers) return buffers.error();
  model.buffers = std::move(*buffers);
  if (Status s = check_views(model); !s) return s.error();
  if (Status s = check_accessors(model, options.file_name, diagnostics); !s) return s.error();
  if (Status s = check_nodes(model, options.file_name, diagnostics); !s) return s.error();
  return model;
}

}  // namespace

Result<GltfModel> load_gltf(std::span<const std::byte> bytes, const ReadOptions& options,
                            Diagnostics& diagnostics) {
  auto model = load(bytes, options, diagnostics);
  if (!model && model.error().where.file.empty()) model.error().where.file = options.file_name;
  return model;
}

}  // namespace diesink
