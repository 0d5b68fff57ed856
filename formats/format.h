// What a file format can do, and the table of all formats.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "core/mesh.h"
#include "core/result.h"

namespace diesink {

class FileSet;  // formats/byte_sink.h

// What a reader may use and where it looks for the files beside the one it reads.
struct ReadOptions {
  std::string file_name;  // for messages
  std::string folder;     // where external buffers may lie; empty = none are read
  std::size_t max_triangles = 50'000'000;
  std::size_t max_memory = std::size_t{8} << 30;  // bytes a mesh of the file's counts may take
  double max_coordinate = 1e9;                    // of any position, in absolute value
  int threads = 0;                                // 0 = all cores
  // Text from this size on is read by all threads; for tests smaller.
  std::size_t parallel_bytes = std::size_t{16} << 20;
  bool weld = true;  // exact weld of equal positions in formats without sharing (STL)
  // Told, now and then, how many bytes at the start will not be looked at again: whoever holds them
  // may let them go. May be empty.
  std::function<void(std::size_t)> done_with;
};

struct WriteOptions {
  std::string
      program_comment;  // "diesink 0.1.0"; never a date: the same input gives the same bytes
  std::string
      file_stem;       // of the target, for the .mtl and .bin beside it; empty = nothing beside it
  bool ascii = false;  // STL and PLY as text
  bool lines = false;  // write mesh.curves
  bool normals = true;
  bool draco = false;
  int draco_speed = 3;               // 0..10
  std::optional<int> quantize_bits;  // else the fewest that keep half of `tolerance`
  double tolerance = 0;              // length in the mesh's unit; 0 = 1e-5 of the extent
  std::string extras_json;           // figures of the report for glTF's asset.extras; empty = none
};

// One file to be put on disk. The first of a write is the target, others stand beside it by name.
struct FileBytes {
  std::string name;  // empty = the target itself, else a plain file name in its folder
  std::vector<std::byte> bytes;
};

struct WrittenMesh {
  std::vector<FileBytes> files;
  double deviation =
      0;  // largest distance between a vertex as given and as the file holds it (float, Draco)
  std::vector<std::string> notes;
};

enum class Keeps : std::uint8_t { kNo, kYes, kFloat32 };  // kFloat32: kept, rounded to float

// One row of `diesink formats`.
struct Format {
  std::string_view id;                           // "stl"
  std::string_view title;                        // "STL (binary and ASCII)"
  std::span<const std::string_view> extensions;  // ".stl", lower case
  // Everything, unless the row says otherwise.
  Keeps positions = Keeps::kYes, names = Keeps::kYes, colors = Keeps::kYes, normals = Keeps::kYes,
        lines = Keeps::kYes, units = Keeps::kYes, sharing = Keeps::kYes;
  // True where the first bytes (and the size) can only be, or very likely are, this format.
  bool (*matches)(std::span<const std::byte> bytes);
  // Null where the format is only written.
  Result<TriangleMesh> (*read)(std::span<const std::byte> bytes, const ReadOptions& options,
                               Diagnostics& diagnostics);
  Result<WrittenMesh> (*write)(const TriangleMesh& mesh, const WriteOptions& options);
  // The same straight into files, without a copy in memory: `files` of the answer stays empty. May
  // be null.
  Result<WrittenMesh> (*stream)(const TriangleMesh& mesh, const WriteOptions& options,
                                FileSet& files) = nullptr;
  std::string_view remarks = {};  // what the table's columns cannot say
};

// Every format, in the order `diesink formats` prints them.
std::span<const Format* const> all_formats();

// By content first, then by ending; null where neither tells.
const Format* format_of_content(std::span<const std::byte> bytes, std::string_view file_name);
// By ending alone (for outputs); null where unknown.
const Format* format_of_ending(std::string_view file_name);

}  // namespace diesink
