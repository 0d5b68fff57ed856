// What is written is read the same by a program that did not write it, and what that one writes is
// read here: the Open Asset Import Library.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <set>
#include <string>

#include "formats/registry.h"
#include "tests/formats/second_reader.h"

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
  const testing::SecondReaderFolder folder;
  // This reader takes PLY's edges for an error.
  const std::string path = folder.write(mesh, format, ascii, format.id != "ply");
  Assimp::Importer importer;
  const aiScene* const scene = importer.ReadFile(path, aiProcess_Triangulate);
  EXPECT_NE(scene, nullptr) << format.id << ": " << importer.GetErrorString();
  Seen seen;
  if (scene != nullptr) gather(*scene, *scene->mRootNode, seen);
  return seen;
}

TEST(SecondReader, SeesTheSameMesh) {
  for (const TriangleMesh& mesh : testing::meshes_for_second_readers()) {
    const MeshTopology expected = topology_of(testing::in_floats(mesh));
    for (const Format* format : {&kStl, &kObj, &kPly, &kOff}) {
      for (const bool ascii : {false, true}) {
        if (ascii && (format == &kObj || format == &kOff)) continue;
        const Seen seen = read_by_the_other(mesh, *format, ascii);
        testing::expect_same_shape(topology_of(seen.mesh), expected,
                                   std::string(format->id) + (ascii ? " ascii" : ""));
        if (format == &kObj || (format == &kStl && ascii)) {
          for (const MeshElement& element : mesh.elements) {
            EXPECT_EQ(seen.names.count(element.name), 1U) << format->id << " " << element.name;
          }
        }
      }
    }
  }
}

TEST(SecondWriter, IsReadTheSame) {
  struct Form {
    const char* id;  // assimp's
    const Format* format;
    const char* file;
  };
  const testing::SecondReaderFolder folder;
  for (const TriangleMesh& mesh : testing::meshes_for_second_readers()) {
    const MeshTopology expected = topology_of(testing::in_floats(mesh));
    const std::string given = folder.write(mesh, kPly, false, false);
    Assimp::Importer importer;
    const aiScene* const scene = importer.ReadFile(given, aiProcess_Triangulate);
    ASSERT_NE(scene, nullptr);
    for (const Form& form :
         {Form{"stl", &kStl, "a.stl"}, Form{"stlb", &kStl, "b.stl"}, Form{"obj", &kObj, "c.obj"},
          Form{"ply", &kPly, "d.ply"}, Form{"plyb", &kPly, "e.ply"},
          Form{"gltf2", &kGltf, "f.gltf"}, Form{"glb2", &kGlb, "g.glb"}}) {
      const std::string path = folder.beside(form.file);
      Assimp::Exporter exporter;
      ASSERT_EQ(exporter.Export(scene, form.id, path), aiReturn_SUCCESS)
          << form.id << ": " << exporter.GetErrorString();
      Diagnostics diagnostics;
      const Result<MeshFile> read = read_mesh_file(path, {}, diagnostics);
      ASSERT_TRUE(read) << form.id << ": " << to_text(read.error());
      EXPECT_EQ(read->format, form.format) << form.id;
      testing::expect_same_shape(topology_of(testing::in_floats(read->mesh)), expected, form.id);
    }
  }
}

}  // namespace
}  // namespace diesink
