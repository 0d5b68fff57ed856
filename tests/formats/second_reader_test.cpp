// What is written is read the same by a program that did not write it: the Open Asset Import
// Library. SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include "core/mesh_tools/topology.h"
#include "formats/mesh_file.h"
#include "formats/registry.h"
#include "tests/support/die_mesh.h"
#include "tests/support/random_mesh.h"

namespace diesink {
namespace {

struct Seen {
  TriangleMesh mesh;
  std::set<std::string> names;
};

void gather(const aiScene& scene, const aiNode& node, Seen& seen) {
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& part = *scene.mMeshes[node.mMeshes[i]];
    if ((part.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0U) continue;
    seen.names.insert(part.mName.C_Str());
    seen.names.insert(node.mName.C_Str());
    const auto base = static_cast<std::uint32_t>(seen.mesh.positions.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D& p = part.mVertices[v];
      seen.mesh.positions.emplace_back(static_cast<double>(p.x), static_cast<double>(p.y),
                                       static_cast<double>(p.z));
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;
      seen.mesh.triangles.push_back(
          {base + face.mIndices[0], base + face.mIndices[1], base + face.mIndices[2]});
    }
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) gather(scene, *node.mChildren[i], seen);
}

// The mesh after one file of the format, as the other reader sees it.
Seen read_by_the_other(const TriangleMesh& mesh, const Format& format, bool ascii) {
  const std::string folder = ::testing::TempDir() + "diesink-second-" + std::to_string(::getpid());
  std::filesystem::create_directories(folder);
  const std::string path = folder + "/mesh" + std::string(format.extensions[0]);
  WriteOptions options;
  options.program_comment = "diesink test";
  options.ascii = ascii;
  options.lines = format.id != "ply";  // this reader takes PLY's edges for an error
  OutputFiles files;
  EXPECT_TRUE(write_mesh_file(path, mesh, options, files));
  EXPECT_TRUE(files.commit());
  Assimp::Importer importer;
  const aiScene* const scene = importer.ReadFile(path, aiProcess_Triangulate);
  EXPECT_NE(scene, nullptr) << format.id << ": " << importer.GetErrorString();
  Seen seen;
  if (scene != nullptr) gather(*scene, *scene->mRootNode, seen);
  std::filesystem::remove_all(folder);
  return seen;
}

TEST(SecondReader, SeesTheSameMesh) {
  TriangleMesh torus = testing::torus_mesh(40, 30);
  torus.elements = {{"S1.side", "S1", {{{200, 30, 4, 255}}}}, {"S2.top", "S2", {}}};
  for (std::size_t t = 0; t < torus.triangles.size(); ++t)
    torus.triangle_element.push_back(t < 700 ? 0 : 1);
  for (const TriangleMesh& mesh : {torus, test::die_mesh()}) {
    TriangleMesh rounded = mesh;
    for (Vec3& p : rounded.positions) p = p.cast<float>().cast<double>();
    const MeshTopology expected = topology_of(rounded);
    for (const Format* format : {&kStl, &kObj, &kPly, &kOff}) {
      for (const bool ascii : {false, true}) {
        if (ascii && (format == &kObj || format == &kOff)) continue;
        const Seen seen = read_by_the_other(mesh, *format, ascii);
        const MeshTopology topology = topology_of(seen.mesh);
        EXPECT_EQ(topology.triangles, expected.triangles) << format->id;
        EXPECT_EQ(topology.watertight, expected.watertight)
            << format->id << ascii << " " << topology.why_not;
        EXPECT_EQ(topology.boundary_edges, expected.boundary_edges) << format->id;
        EXPECT_NEAR(topology.area, expected.area, 1e-5 * expected.area) << format->id;
        EXPECT_NEAR(topology.volume, expected.volume, 1e-5 * std::abs(expected.volume) + 1e-6)
            << format->id;
        for (int side = 0; side < 2; ++side) {
          EXPECT_LT((topology.bounds[side] - expected.bounds[side]).norm(),
                    1e-5 * expected.bounds[1].norm())
              << format->id;
        }
        if (format == &kObj || (format == &kStl && ascii)) {
          for (const MeshElement& element : mesh.elements) {
            EXPECT_EQ(seen.names.count(element.name), 1U) << format->id << " " << element.name;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace diesink
