// OpenMesh reads what is written here, and is read here.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/DefaultTriMesh.hh>
#include <string>

#include "formats/registry.h"
#include "tests/formats/openmesh_reading.h"
#include "tests/formats/second_reader.h"

namespace diesink {
namespace {

using test::OtherMesh;
using test::taken_from;

OtherMesh given_to(const TriangleMesh& mesh) {
  OtherMesh other;
  for (const Vec3& p : mesh.positions) other.add_vertex({p.x(), p.y(), p.z()});
  const auto handle = [](std::uint32_t v) { return OpenMesh::VertexHandle(static_cast<int>(v)); };
  for (const std::array<std::uint32_t, 3>& t : mesh.triangles) {
    other.add_face(handle(t[0]), handle(t[1]), handle(t[2]));
  }
  return other;
}

TEST(OpenMeshReads, TheSameMesh) {
  const testing::SecondReaderFolder folder;
  for (const TriangleMesh& mesh : testing::meshes_for_second_readers()) {
    const MeshTopology expected = topology_of(testing::in_floats(mesh));
    // This reader of OFF takes a face's colour for the next face.
    TriangleMesh plain = mesh;
    for (MeshElement& element : plain.elements) element.color.reset();
    for (const Format* format : {&kStl, &kObj, &kPly, &kOff}) {
      for (const bool ascii : {false, true}) {
        if (ascii && (format == &kObj || format == &kOff)) continue;
        const std::string path = folder.write(format == &kOff ? plain : mesh, *format, ascii, true);
        OtherMesh other;
        ASSERT_TRUE(OpenMesh::IO::read_mesh(other, path)) << path;
        testing::expect_same_shape(topology_of(taken_from(other)), expected,
                                   std::string(format->id) + (ascii ? " ascii" : ""));
      }
    }
  }
}

TEST(OpenMeshWrites, WhatIsReadTheSame) {
  const testing::SecondReaderFolder folder;
  for (const TriangleMesh& mesh : testing::meshes_for_second_readers()) {
    const OtherMesh other = given_to(mesh);
    const MeshTopology expected = topology_of(testing::in_floats(taken_from(other)));
    for (const Format* format : {&kStl, &kObj, &kPly, &kOff}) {
      for (const bool binary : {false, true}) {
        if (binary && (format == &kObj || format == &kOff)) continue;
        OpenMesh::IO::Options how = OpenMesh::IO::Options::Default;
        if (binary) how += OpenMesh::IO::Options::Binary;
        const std::string path = folder.file(*format);
        ASSERT_TRUE(OpenMesh::IO::write_mesh(other, path, how, 9));
        Diagnostics diagnostics;
        const Result<MeshFile> read = read_mesh_file(path, {}, diagnostics);
        ASSERT_TRUE(read) << to_text(read.error());
        EXPECT_EQ(read->format, format);
        testing::expect_same_shape(topology_of(testing::in_floats(read->mesh)), expected,
                                   std::string(format->id) + (binary ? " binary" : ""));
      }
    }
  }
}

}  // namespace
}  // namespace diesink
