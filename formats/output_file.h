// Files appear whole or not at all: temporary names in the target's folder, fsync, rename.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "formats/byte_sink.h"

namespace diesink {

// Several output files that are put in place together. What is written goes to a temporary file in
// the target's own folder; commit() makes them appear. Without commit(), or when it fails, nothing
// has appeared or changed and no temporary file is left. A link is followed to the file it names,
// an existing file's mode is kept; a device, a pipe and "-" (stdout) are written straight away.
// Errors: kOutput with the target's name and the system's reason.
class OutputFiles {
 public:
  OutputFiles();
  ~OutputFiles();
  OutputFiles(const OutputFiles&) = delete;
  OutputFiles& operator=(const OutputFiles&) = delete;

  // A new file at `path`, "-" for stdout. The sink lives as long as this.
  // Errors: as above; kUsage where an earlier one is the same file, by whatever name.
  Result<ByteSink*> open(const std::string& path);

  // All sinks complete: fsync of each, rename of each, fsync of each folder. Where a later rename
  // fails, the earlier ones are taken back.
  Status commit();

 private:
  class Sink;
  std::vector<std::unique_ptr<Sink>> sinks_;
};

// The files beside one target path, as writers see them.
class OutputFileSet final : public FileSet {
 public:
  OutputFileSet(OutputFiles& files, std::string target)
      : files_(files), target_(std::move(target)) {}
  Result<ByteSink*> file(std::string_view name) override;

 private:
  OutputFiles& files_;
  std::string target_;
};

// Writes and commits one file of text or bytes.
Status write_file(const std::string& target, std::string_view content);

// Bytes that the program has written to outputs so far, by all threads.
std::uint64_t bytes_written() noexcept;

// Unlinks every temporary file that is open now. Async-signal-safe: for the handler of an interrupt
// that ends the program.
void unlink_temporaries() noexcept;

}  // namespace diesink
