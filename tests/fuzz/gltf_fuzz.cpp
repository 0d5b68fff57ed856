// libFuzzer target: any bytes as a glTF or GLB file. What is read must be sound and must be written
// again.
// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <cstdlib>

#include "formats/registry.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace diesink;
  ReadOptions options;
  options.file_name = "fuzz.glb";
  Diagnostics diagnostics;
  const auto mesh = kGlb.read(std::as_bytes(std::span(data, size)), options, diagnostics);
  if (!mesh) return 0;
  for (const auto& triangle : mesh->triangles) {
    for (const std::uint32_t corner : triangle) {
      if (corner >= mesh->positions.size()) std::abort();
    }
  }
  WriteOptions write;
  write.lines = true;
  write.draco = size % 2 == 0;
  // Coordinates beyond the writer's limit are the one thing it may refuse.
  bool within = true;
  for (const Vec3& p : mesh->positions) within = within && p.cwiseAbs().maxCoeff() <= 1e9;
  if (!kGlb.write(*mesh, write) && within) std::abort();
  return 0;
}
