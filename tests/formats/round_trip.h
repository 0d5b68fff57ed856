// Meshes through files and back.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "formats/registry.h"
#include "tests/support/mesh_signature.h"
#include "tests/support/temp_path.h"

namespace diesink::testing {

// A folder for what stands beside a file.
class RoundTripFolder {
 public:
  RoundTripFolder() : path_(test::temp_path("round-trip")) {
    std::filesystem::create_directories(path_);
  }
  RoundTripFolder(const RoundTripFolder&) = delete;
  RoundTripFolder& operator=(const RoundTripFolder&) = delete;
  ~RoundTripFolder() { std::filesystem::remove_all(path_); }
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

// A format, or one of its two forms, and what of a mesh it keeps.
struct RoundTripKind {
  const char* name;
  const Format* format;
  bool ascii;
  Compared keeps;
};

// The mesh after one file of this kind. What the reading says is a failure, unless `odd` is set.
inline TriangleMesh through(const TriangleMesh& mesh, const RoundTripKind& kind,
                            const RoundTripFolder& folder, bool odd = false) {
  WriteOptions options;
  options.program_comment = "diesink test";
  options.ascii = kind.ascii;
  options.lines = true;
  options.file_stem = "mesh";
  const Result<WrittenMesh> written = kind.format->write(mesh, options);
  EXPECT_TRUE(written) << to_text(written.error());
  if (!written) return {};
  // Only what stands beside the file goes to the disk: files in place are synced, which takes its
  // time.
  for (const FileBytes& beside : std::span(written->files).subspan(1)) {
    std::ofstream(folder.file(beside.name), std::ios::binary)
        << std::string_view(static_cast<const char*>(static_cast<const void*>(beside.bytes.data())),
                            beside.bytes.size());
  }
  EXPECT_EQ(format_of_content(written->files[0].bytes, ""), kind.format);
  ReadOptions reading;
  reading.folder = folder.file("");
  Diagnostics diagnostics;
  Result<TriangleMesh> back = kind.format->read(written->files[0].bytes, reading, diagnostics);
  EXPECT_TRUE(back) << to_text(back.error());
  if (!back) return {};
  for (const Diagnostic& d : diagnostics.all()) {
    // A mesh of a unit nobody told is as large as its numbers, in metres.
    if (!odd && d.message.find("may not be the metre") == std::string::npos)
      ADD_FAILURE() << to_text(d);
  }
  return std::move(*back);
}

}  // namespace diesink::testing
