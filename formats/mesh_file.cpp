// SPDX-License-Identifier: Apache-2.0
#include "formats/mesh_file.h"

#include <new>
#include <stdexcept>

#include "core/mesh_tools/topology.h"
#include "core/parallel.h"
#include "formats/registry.h"
#include "formats/stl.h"

namespace diesink {
namespace {

// Nothing that bad data asks for may leave as an exception.
template <class Answer, class Work>
Result<Answer> guarded(const std::string& path, const std::string& no_memory, Work work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kLimit, no_memory, {path}};
  } catch (const std::length_error&) {
    return Error{ErrorCode::kLimit, "more than memory can hold", {path}};
  }
}

// Every format's triangles alike: kept, but told.
void warn_of_odd_faces(const TriangleMesh& mesh, const Format& format, const ReadOptions& options,
                       Diagnostics& diagnostics) {
  const std::string& path = options.file_name;
  const bool welded = format.sharing == Keeps::kNo && options.weld;
  const OddFaces odd = odd_faces(mesh, welded, options.threads);
  const auto warn = [&](std::size_t count, std::string_view one, std::string_view many) {
    if (count == 0) return;
    diagnostics.warning(std::to_string(count) + " " + std::string(count == 1 ? one : many), {path});
  };
  warn(odd.degenerate, "triangle is degenerate: two of its corners coincide",
       "triangles are degenerate: two of their corners coincide");
  warn(odd.duplicates, "triangle repeats another", "triangles repeat another");
}

Error named(Error error, const std::string& path) {
  if (error.where.file.empty()) error.where.file = path;
  return error;
}

// Reads with `read` and looks at what has come.
template <class Read>
Result<MeshFile> read_guarded(const Format& format, const ReadOptions& options,
                              Diagnostics& diagnostics, Read read) {
  const std::string no_memory =
      "reading it takes more memory than there is, or than the limit of " +
      std::to_string(options.max_memory >> 20) + " MiB";
  return guarded<MeshFile>(options.file_name, no_memory, [&]() -> Result<MeshFile> {
    Result<TriangleMesh> mesh = [&] {
      const ProgressSpan span(0, 0.9);
      return read();
    }();
    if (!mesh) return named(mesh.error(), options.file_name);
    const ProgressSpan span(0.9, 1);
    warn_of_odd_faces(*mesh, format, options, diagnostics);
    return MeshFile{std::move(*mesh), &format};
  });
}

}  // namespace

std::size_t bytes_in_pieces(const std::string& path, std::size_t max_bytes) {
  if (path == "-") return 0;
  const std::unique_ptr<ByteSource> bytes = open_bytes(path);
  return bytes && bytes->size() <= max_bytes && is_binary_stl(*bytes) ? bytes->size() : 0;
}

Result<MeshFile> read_mesh_pieces(const std::string& path, ReadOptions options,
                                  Diagnostics& diagnostics) {
  options.file_name = path;
  const std::unique_ptr<ByteSource> bytes = open_bytes(path);
  if (!bytes || bytes->size() < kStlHeaderBytes) {
    return Error{ErrorCode::kInput, "cannot read: the file has changed meanwhile", {path}};
  }
  return read_guarded(kStl, options, diagnostics,
                      [&] { return read_binary_stl(*bytes, options, diagnostics); });
}

Result<MeshFile> read_mesh_file(const std::string& path, ReadOptions options,
                                Diagnostics& diagnostics, std::size_t max_bytes) {
  if (bytes_in_pieces(path, max_bytes) > 0) {
    return read_mesh_pieces(path, std::move(options), diagnostics);
  }
  Result<InputBytes> input = read_file(path, max_bytes, options.threads);
  if (!input) return input.error();
  options.done_with = [&](std::size_t count) { input->forget(count); };
  return read_mesh_bytes(input->bytes(), path, std::move(options), diagnostics);
}

Result<MeshFile> read_mesh_bytes(std::span<const std::byte> bytes, const std::string& path,
                                 ReadOptions options, Diagnostics& diagnostics) {
  options.file_name = path;
  if (path != "-") {
    const std::size_t slash = path.rfind('/');
    options.folder = slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
  }
  if (bytes.empty()) return Error{ErrorCode::kInput, "the file is empty, expected a mesh", {path}};
  const Format* const format = format_of_content(bytes, path);
  if (format == nullptr || format->read == nullptr) {
    return Error{ErrorCode::kInput,
                 "not a mesh of a known format, expected one of " + endings_of_formats(false),
                 {path}};
  }
  return read_guarded(*format, options, diagnostics,
                      [&] { return format->read(bytes, options, diagnostics); });
}

Result<WrittenMesh> write_mesh_file(const std::string& path, const TriangleMesh& mesh,
                                    WriteOptions options, OutputFiles& files,
                                    const Format* format) {
  if (format == nullptr) format = format_of_ending(path);
  if (format == nullptr || format->write == nullptr) {
    return Error{ErrorCode::kUsage,
                 "unknown ending of an output file, expected one of " + endings_of_formats(true),
                 {path}};
  }
  if (path != "-" && !path.starts_with("/dev/")) {
    const std::size_t slash = path.rfind('/');
    options.file_stem = slash == std::string::npos ? path : path.substr(slash + 1);
    const std::size_t dot = options.file_stem.rfind('.');
    if (dot != std::string::npos && dot > 0) options.file_stem.resize(dot);
  }
  return guarded<WrittenMesh>(path, "not enough memory", [&]() -> Result<WrittenMesh> {
    OutputFileSet set(files, path);
    if (format->stream != nullptr) {
      Result<WrittenMesh> written = format->stream(mesh, options, set);
      if (!written) return named(written.error(), path);
      return written;
    }
    Result<WrittenMesh> written = format->write(mesh, options);
    if (!written) return named(written.error(), path);
    for (const FileBytes& file : written->files) {
      const Result<ByteSink*> sink = set.file(file.name);
      if (!sink) return sink.error();
      if (const Status put = (*sink)->put(file.bytes); !put) return put.error();
    }
    written->files.clear();
    return written;
  });
}

std::string endings_of_formats(bool written) {
  std::string text;
  for (const Format* format : all_formats()) {
    if (written ? format->write == nullptr : format->read == nullptr) continue;
    for (const std::string_view extension : format->extensions) {
      if (!text.empty()) text += ' ';
      text += extension;
    }
  }
  return text;
}

}  // namespace diesink
