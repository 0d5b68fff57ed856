// Writes glTF and GLB files of every kind the writer knows into a folder, for second readers to
// look at.
// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <fstream>
#include <string>

#include "formats/registry.h"
#include "tests/support/die_mesh.h"

namespace {

using namespace diesink;

bool write(const std::string& folder, const std::string& name, const TriangleMesh& mesh,
           WriteOptions options) {
  options.program_comment = "diesink";
  for (const Format* format : {&kGlb, &kGltf}) {
    options.file_stem = name;
    const auto written = format->write(mesh, options);
    if (!written) {
      std::fprintf(stderr, "%s: %s\n", name.c_str(), written.error().message.c_str());
      return false;
    }
    for (const FileBytes& file : written->files) {
      const std::string path =
          folder + '/' +
          (file.name.empty() ? name + std::string(format->extensions[0]) : file.name);
      std::ofstream out(path, std::ios::binary);
      out.write(reinterpret_cast<const char*>(file.bytes.data()),
                static_cast<std::streamsize>(file.bytes.size()));
      if (!out.flush()) return false;
    }
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  const std::string folder = argv[1];
  const TriangleMesh plain = test::die_mesh();
  WriteOptions options;
  bool ok = write(folder, "plain", plain, options);
  options.lines = true;
  options.extras_json = R"({"report":{"triangles":320,"certified_deviation":0.0049}})";
  ok = write(folder, "lines", plain, options) && ok;
  TriangleMesh colored = test::die_mesh(30, 60, 3);
  for (std::size_t v = 0; v < colored.positions.size(); ++v) {
    colored.vertex_colors.push_back({static_cast<std::uint8_t>(v), static_cast<std::uint8_t>(v / 2),
                                     90, static_cast<std::uint8_t>(v % 3 == 0 ? 128 : 255)});
  }
  ok = write(folder, "colors", colored, options) && ok;
  ok = write(folder, "far", test::die_mesh(12, 60, 0, Vec3(4e5, -7e5, 1234.5)), options) && ok;
  ok = write(folder, "large", test::die_mesh(300, 60, 2), options) && ok;
  TriangleMesh inch = plain;
  inch.unit = LengthUnit::kInch;
  inch.name.clear();
  ok = write(folder, "inch with blanks & umlauts \xC3\xA4", inch, options) && ok;
  TriangleMesh metre = plain;
  metre.unit = LengthUnit::kMetre;
  metre.up = UpAxis::kY;
  ok = write(folder, "metre", metre, options) && ok;
  TriangleMesh bare;
  bare.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  bare.triangles = {{0, 1, 2}};
  ok = write(folder, "bare", bare, options) && ok;
  ok = write(folder, "empty", TriangleMesh{}, options) && ok;
  options.draco = true;
  options.tolerance = 0.01;
  ok = write(folder, "draco", plain, options) && ok;
  ok = write(folder, "draco_colors", colored, options) && ok;
  ok =
      write(folder, "draco_far", test::die_mesh(12, 60, 0, Vec3(4e5, -7e5, 1234.5)), options) && ok;
  ok = write(folder, "draco_bare", bare, options) && ok;
  ok = write(folder, "draco_large", test::die_mesh(300, 60, 2), options) && ok;
  options.draco_speed = 10;
  ok = write(folder, "draco_fast", plain, options) && ok;
  return ok ? 0 : 1;
}
