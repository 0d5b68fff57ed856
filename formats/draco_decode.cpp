// Draco 1.5.5 trusts what a stream claims: 92 bytes can ask for 6.9 GB. So the stream's own headers
// are read first, and what comes out is checked again.
// SPDX-License-Identifier: Apache-2.0
#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

#include <cstring>
#include <new>
#include <stdexcept>

#include "formats/draco_mesh.h"
#include "formats/draco_survey.h"

namespace diesink {
namespace {

Error wrong(std::string what) { return Error{ErrorCode::kInput, "Draco: " + std::move(what), {}}; }

std::size_t size_of_component(int component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    default:
      return 4;
  }
}

draco::DataType draco_type(int component_type) {
  switch (component_type) {
    case 5120:
      return draco::DT_INT8;
    case 5121:
      return draco::DT_UINT8;
    case 5122:
      return draco::DT_INT16;
    case 5123:
      return draco::DT_UINT16;
    case 5125:
      return draco::DT_UINT32;
    default:
      return draco::DT_FLOAT32;
  }
}

Result<std::vector<std::byte>> values_of(const draco::Mesh& mesh, const DracoRequest& request) {
  const draco::PointAttribute* const attribute = mesh.GetAttributeByUniqueId(request.unique_id);
  if (attribute == nullptr) {
    return wrong("there is no attribute " + std::to_string(request.unique_id));
  }
  if (attribute->num_components() != request.components) {
    return wrong("attribute " + std::to_string(request.unique_id) + " has " +
                 std::to_string(attribute->num_components()) + " components, its accessor " +
                 std::to_string(request.components));
  }
  if (attribute->data_type() != draco_type(request.component_type)) {
    return wrong("attribute " + std::to_string(request.unique_id) +
                 " is of another component type than its accessor");
  }
  const std::size_t size =
      size_of_component(request.component_type) * static_cast<std::size_t>(request.components);
  std::vector<std::byte> out(mesh.num_points() * size);
  for (std::uint32_t v = 0; v < mesh.num_points(); ++v) {
    const draco::AttributeValueIndex value = attribute->mapped_index(draco::PointIndex(v));
    if (value.value() >= attribute->size()) {
      return wrong("attribute " + std::to_string(request.unique_id) + " lacks a value");
    }
    // Most attributes are three floats: a size known here is copied in two instructions.
    const std::uint8_t* const from = attribute->GetAddress(value);
    if (size == 12) {
      std::memcpy(out.data() + v * std::size_t{12}, from, 12);
    } else {
      std::memcpy(out.data() + v * size, from, size);
    }
  }
  return out;
}

Result<DecodedDraco> decoded(const draco::Mesh& mesh, std::span<const DracoRequest> requests) {
  DecodedDraco out;
  out.vertex_count = mesh.num_points();
  out.indices.resize(3 * static_cast<std::size_t>(mesh.num_faces()));
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
    for (std::size_t k = 0; k < 3; ++k) {
      out.indices[3 * static_cast<std::size_t>(f) + k] = face[k].value();
      if (face[k].value() >= mesh.num_points()) {
        return wrong("triangle " + std::to_string(f) + " has vertex " +
                     std::to_string(face[k].value()) + " of " + std::to_string(mesh.num_points()));
      }
    }
  }
  for (const DracoRequest& request : requests) {
    auto values = values_of(mesh, request);
    if (!values) return values.error();
    out.attributes.push_back(std::move(*values));
  }
  return out;
}

Status check_triangles(std::size_t found, std::size_t expected) {
  if (found == expected) return ok();
  return wrong(std::to_string(found) + " triangles, expected " + std::to_string(expected));
}

}  // namespace

Result<DecodedDraco> decode_draco(std::span<const std::byte> bytes, const DracoLimits& limits,
                                  std::span<const DracoRequest> requests) {
  const auto claims = survey_draco(bytes);
  if (!claims) return claims.error();
  if (Status s = check_triangles(claims->triangles, limits.triangles); !s) return s.error();
  try {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok()) {
      const std::string reason = mesh.status().error_msg_string();
      return wrong(reason.empty() ? "the stream is damaged" : reason);
    }
    if (mesh.value() == nullptr) return wrong("the stream holds no mesh");
    const draco::Mesh& found = *mesh.value();
    if (Status s = check_triangles(found.num_faces(), limits.triangles); !s) return s.error();
    if (found.num_points() > limits.vertices) {
      return wrong(std::to_string(found.num_points()) + " vertices, expected at most " +
                   std::to_string(limits.vertices));
    }
    return decoded(found, requests);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kLimit, "Draco: not enough memory", {}};
  } catch (const std::length_error&) {
    return wrong("the stream claims more than memory can hold");
  }
}

}  // namespace diesink
