// Any bytes through one reader, DIESINK_FUZZED_FORMAT: refused, or a mesh that holds together, that
// every writer of the text and binary formats takes, and that comes back from its own format with
// the same triangles. Binary STL, which is read from its file piece by piece, comes through a file,
// too, and through one that is cut or written to meanwhile.
// SPDX-License-Identifier: Apache-2.0
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <string>

#include "core/mesh_tools/repair.h"
#include "formats/mesh_file.h"
#include "formats/registry.h"
#include "formats/stl.h"

namespace {

using diesink::TriangleMesh;

void require(bool holds, const char* what) {
  if (holds) return;
  std::cerr << "does not hold: " << what << '\n';
  std::abort();
}

void require_sound(const TriangleMesh& mesh) {
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t)
      require(v < mesh.positions.size(), "a triangle's vertices are there");
  }
  for (const diesink::Vec3& p : mesh.positions)
    require(p.cwiseAbs().maxCoeff() <= 1e9, "positions are within the limit");
  require(mesh.triangle_element.empty() || mesh.triangle_element.size() == mesh.triangles.size(),
          "an element a triangle");
  for (const std::uint32_t e : mesh.triangle_element)
    require(e < mesh.elements.size(), "elements are there");
  require(mesh.corner_normals.empty() || mesh.corner_normals.size() == mesh.triangles.size(),
          "normals a triangle");
  for (const auto& t : mesh.corner_normals) {
    for (const std::uint32_t n : t) require(n < mesh.normals.size(), "normals are there");
  }
  for (const diesink::Vec3& n : mesh.normals)
    require(std::abs(n.norm() - 1) < 2e-3, "normals are unit vectors");
  require(mesh.vertex_colors.empty() || mesh.vertex_colors.size() == mesh.positions.size(),
          "a colour a vertex");
  for (const diesink::MeshCurve& curve : mesh.curves) {
    for (const std::uint32_t v : curve.vertices)
      require(v < mesh.positions.size(), "a curve's vertices are there");
  }
}

// A file that ends at `end`, whatever it said, or in which a byte of every read but the first
// `good` is another one.
class Disturbed final : public diesink::ByteSource {
 public:
  Disturbed(std::span<const std::byte> bytes, std::size_t end, int good)
      : bytes_(bytes), end_(end), good_(good) {}
  [[nodiscard]] std::size_t size() const override { return bytes_.size(); }
  [[nodiscard]] const std::byte* at(std::size_t offset, std::span<std::byte> room) const override {
    require(offset <= bytes_.size() && room.size() <= bytes_.size() - offset,
            "only bytes of the file are asked for");
    if (offset + room.size() > end_) return nullptr;
    if (room.empty()) return room.data();
    std::memcpy(room.data(), bytes_.data() + offset, room.size());
    const int read = reads_++;
    if (read >= good_) room[static_cast<std::size_t>(read) * 37 % room.size()] ^= std::byte{0x7F};
    return room.data();
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t end_;
  int good_;
  mutable std::atomic<int> reads_{0};
};

void read_in_pieces(std::span<const std::byte> bytes, const diesink::ReadOptions& options) {
  if (!is_binary_stl(diesink::HeldBytes(bytes))) return;
  const int file = ::memfd_create("fuzz.stl", MFD_CLOEXEC);
  require(file >= 0, "a file in memory can be made");
  require(::write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()),
          "it can be written");
  const std::string path = "/proc/self/fd/" + std::to_string(file);
  diesink::Diagnostics of_file, of_bytes;
  const auto from_file = read_mesh_file(path, options, of_file);
  const auto from_bytes = read_mesh_bytes(bytes, path, options, of_bytes);
  ::close(file);
  require(from_file.has_value() == from_bytes.has_value(), "a file is read as its bytes are");
  require(of_file.all().size() == of_bytes.all().size(), "a file is told of as its bytes are");
  if (from_file) {
    require(from_file->mesh.positions == from_bytes->mesh.positions &&
                from_file->mesh.triangles == from_bytes->mesh.triangles &&
                from_file->mesh.triangle_element == from_bytes->mesh.triangle_element,
            "a file's mesh is that of its bytes");
  } else {
    require(to_text(from_file.error()) == to_text(from_bytes.error()),
            "a file's error is that of its bytes");
  }
  const std::size_t end = diesink::kStlHeaderBytes + static_cast<std::size_t>(bytes.back()) *
                                                         (bytes.size() - diesink::kStlHeaderBytes) /
                                                         256;
  const int good = static_cast<int>(bytes[1]) % 8;
  const Disturbed cut(bytes, end, 1 << 30), written(bytes, bytes.size(), good);
  for (const Disturbed* const source : {&cut, &written}) {
    diesink::Diagnostics diagnostics;
    const diesink::Result<TriangleMesh> mesh = read_binary_stl(*source, options, diagnostics);
    if (mesh) require_sound(*mesh);
    if (!mesh) require(!mesh.error().message.empty(), "an error says something");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const diesink::Format& format = diesink::DIESINK_FUZZED_FORMAT;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  diesink::ReadOptions options;
  options.max_triangles = 100'000;
  options.threads = 1;
  diesink::Diagnostics diagnostics;
  format.matches(bytes);
  diesink::Result<TriangleMesh> mesh = format.read(bytes, options, diagnostics);
  std::string told;
  for (const diesink::Diagnostic& d : diagnostics.all()) told += to_text(d) + "\n";
  // Several threads must make the same of it.
  diesink::ReadOptions parallel = options;
  parallel.threads = 3;
  parallel.parallel_bytes = 64;
  diesink::Diagnostics of_threads;
  const diesink::Result<TriangleMesh> same = format.read(bytes, parallel, of_threads);
  std::string told_by_threads;
  for (const diesink::Diagnostic& d : of_threads.all()) told_by_threads += to_text(d) + "\n";
  require(same.has_value() == mesh.has_value(), "threads agree whether it can be read");
  if (mesh) {
    require(told_by_threads == told, "threads tell the same");
    require(same->positions == mesh->positions && same->triangles == mesh->triangles &&
                same->triangle_element == mesh->triangle_element,
            "threads read the same");
  } else {
    require(to_text(same.error()) == to_text(mesh.error()), "threads tell the same error");
  }
  if (&format == &diesink::kStl) {
    read_in_pieces(bytes, options);
    read_in_pieces(bytes, parallel);
  }
  if (!mesh) {
    require(!mesh.error().message.empty(), "an error says something");
    return 0;
  }
  require_sound(*mesh);
  for (const bool ascii : {false, true}) {
    diesink::WriteOptions writing;
    writing.ascii = ascii;
    writing.lines = true;
    const diesink::Result<diesink::WrittenMesh> written = format.write(*mesh, writing);
    require(written.has_value(), "what was read can be written");
    const diesink::Result<TriangleMesh> again =
        format.read(written->files[0].bytes, options, diagnostics);
    require(again.has_value(), "what was written can be read");
    require(again->triangles.size() == mesh->triangles.size(), "no triangle is lost");
  }
  const diesink::RepairReport report = repair(*mesh);
  require_sound(*mesh);
  require(report.after.degenerate == 0, "repair leaves no degenerate triangle");
  return 0;
}
