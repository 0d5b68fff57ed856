// libFuzzer target: any bytes as a Draco stream, with the counts that it claims.
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdint>
#include <cstdlib>

#include "formats/draco_mesh.h"
#include "formats/draco_survey.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diesink;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  const auto claims = survey_draco(bytes);
  if (!claims) return 0;
  const std::array<DracoRequest, 1> position{{{0, 5126, 3}}};
  const auto mesh = decode_draco(bytes, {claims->triangles, 3 * claims->triangles}, position);
  if (!mesh) return 0;
  for (const std::uint32_t corner : mesh->indices) {
    if (corner >= mesh->vertex_count) std::abort();
  }
  return 0;
}
