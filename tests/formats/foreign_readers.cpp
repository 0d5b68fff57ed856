// What assimp and OpenMesh see in files: a line of JSON a reader and file, for
// scripts/independent_readers.py. SPDX-License-Identifier: Apache-2.0
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/DefaultTriMesh.hh>
#include <assimp/Importer.hpp>

#include <iostream>
#include <string>

#include "core/mesh_tools/topology.h"
#include "formats/json_writer.h"
#include "tests/formats/openmesh_reading.h"

namespace {

using namespace diesink;

void gather(const aiScene& scene, const aiNode& node, const aiMatrix4x4& above,
            TriangleMesh& mesh) {
  const aiMatrix4x4 m = above * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& part = *scene.mMeshes[node.mMeshes[i]];
    if ((part.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0U) continue;
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D p = m * part.mVertices[v];
      mesh.positions.emplace_back(static_cast<double>(p.x), static_cast<double>(p.y),
                                  static_cast<double>(p.z));
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices == 3) {
        mesh.triangles.push_back(
            {base + face.mIndices[0], base + face.mIndices[1], base + face.mIndices[2]});
      }
    }
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) gather(scene, *node.mChildren[i], m, mesh);
}

bool read_by_assimp(const std::string& path, TriangleMesh& mesh) {
  Assimp::Importer importer;
  const aiScene* const scene = importer.ReadFile(path, aiProcess_Triangulate);
  if (scene == nullptr) return false;
  gather(*scene, *scene->mRootNode, aiMatrix4x4(), mesh);
  return true;
}

bool read_by_openmesh(const std::string& path, TriangleMesh& mesh) {
  test::OtherMesh other;
  if (!OpenMesh::IO::read_mesh(other, path)) return false;
  mesh = test::taken_from(other);
  return true;
}

void tell(const char* reader, const std::string& path,
          bool (*read)(const std::string&, TriangleMesh&)) {
  TriangleMesh mesh;
  JsonWriter json;
  json.begin_object().field("reader", reader).field("file", path);
  if (read(path, mesh)) {
    const MeshTopology topology = topology_of(mesh);
    json.field("triangles", topology.triangles).field("watertight", topology.watertight);
    json.key("bounds").begin_array();
    for (const Vec3& corner : topology.bounds) {
      for (const double x : corner) json.value(x);
    }
    json.end_array();
  }
  json.end_object();
  std::cout << json.text() << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string path = argv[i];
    tell("assimp", path, read_by_assimp);
    // It knows no glTF.
    if (!path.ends_with(".gltf") && !path.ends_with(".glb")) {
      tell("OpenMesh", path, read_by_openmesh);
    }
  }
}
