// What the tests with readers and writers of others have in common.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh_tools/topology.h"
#include "formats/mesh_file.h"
#include "tests/support/die_mesh.h"
#include "tests/support/random_mesh.h"
#include "tests/support/temp_path.h"

namespace diesink::testing {

// A closed mesh of two elements, and a die.
inline std::vector<TriangleMesh> meshes_for_second_readers() {
  TriangleMesh torus = torus_mesh(40, 30);
  torus.elements = {{"S1.side", "S1", {{{200, 30, 4, 255}}}}, {"S2.top", "S2", {}}};
  for (std::size_t t = 0; t < torus.triangles.size(); ++t)
    torus.triangle_element.push_back(t < 700 ? 0 : 1);
  return {torus, test::die_mesh()};
}

// A folder that goes with the object.
class SecondReaderFolder {
 public:
  SecondReaderFolder() : path_(test::temp_path("second")) {
    std::filesystem::create_directories(path_);
  }
  SecondReaderFolder(const SecondReaderFolder&) = delete;
  SecondReaderFolder& operator=(const SecondReaderFolder&) = delete;
  ~SecondReaderFolder() { std::filesystem::remove_all(path_); }
  // The name of a file of this format.
  [[nodiscard]] std::string file(const Format& format) const {
    return path_ + "/mesh" + std::string(format.extensions[0]);
  }
  [[nodiscard]] std::string beside(const std::string& name) const { return path_ + "/" + name; }
  // Puts the mesh there.
  [[nodiscard]] std::string write(const TriangleMesh& mesh, const Format& format, bool ascii,
                                  bool lines) const {
    WriteOptions options;
    options.program_comment = "diesink test";
    options.ascii = ascii;
    options.lines = lines;
    OutputFiles files;
    EXPECT_TRUE(write_mesh_file(file(format), mesh, options, files));
    EXPECT_TRUE(files.commit());
    return file(format);
  }

 private:
  std::string path_;
};

inline TriangleMesh in_floats(TriangleMesh mesh) {
  for (Vec3& p : mesh.positions) p = p.cast<float>().cast<double>();
  return mesh;
}

// The same triangles, closed as much, as large, in the same place, as far as floats go.
inline void expect_same_shape(const MeshTopology& seen, const MeshTopology& expected,
                              const std::string& what) {
  EXPECT_EQ(seen.triangles, expected.triangles) << what;
  EXPECT_EQ(seen.watertight, expected.watertight) << what << " " << seen.why_not;
  EXPECT_EQ(seen.boundary_edges, expected.boundary_edges) << what;
  EXPECT_NEAR(seen.area, expected.area, 1e-5 * expected.area) << what;
  EXPECT_NEAR(seen.volume, expected.volume, 1e-5 * std::abs(expected.volume) + 1e-6) << what;
  for (std::size_t side = 0; side < 2; ++side) {
    EXPECT_LT((seen.bounds[side] - expected.bounds[side]).norm(), 1e-5 * expected.bounds[1].norm())
        << what;
  }
}

}  // namespace diesink::testing
