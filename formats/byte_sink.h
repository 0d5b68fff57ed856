// Where writers put bytes: a file, stdout or memory, through one buffer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "formats/format.h"

namespace diesink {

// Takes bytes in order. After an error it takes no more.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  virtual Status put(std::span<const std::byte> bytes) = 0;
};

// The files of one output: the target (empty name) and those beside it.
class FileSet {
 public:
  virtual ~FileSet() = default;
  // A new file; the sink lives as long as the set.
  // Needs: `name` empty or a plain file name, and not given before.
  virtual Result<ByteSink*> file(std::string_view name) = 0;
};

// Keeps the files in memory, in the order they were begun.
class MemoryFiles final : public FileSet {
 public:
  Result<ByteSink*> file(std::string_view name) override;
  std::vector<FileBytes> take();

 private:
  class Sink final : public ByteSink {
   public:
    Status put(std::span<const std::byte> bytes) override;
    FileBytes file;
  };
  std::vector<std::unique_ptr<Sink>> sinks_;
};

// Gathers small pieces in a buffer that stays in a core's own cache. Errors are kept until
// finish().
class ByteWriter {
 public:
  explicit ByteWriter(ByteSink& sink);

  static constexpr std::size_t kBuffer = std::size_t{1} << 18;

  // Room for `size` bytes; give one past the last written to wrote().
  // Needs: size <= kBuffer.
  char* room(std::size_t size) {
    if (kBuffer - used_ < size) flush();
    return buffer_.get() + used_;
  }
  void wrote(const char* end) { used_ = static_cast<std::size_t>(end - buffer_.get()); }

  // How many things the writer is going to put, of whatever kind: each full buffer then tells
  // (tell_progress, core/parallel.h) the share of them that has passed().
  void expect(std::size_t things) { expected_ = things; }
  void passed(std::size_t things = 1) { passed_ += things; }

  ByteWriter& operator<<(std::string_view text);
  ByteWriter& operator<<(char c);
  ByteWriter& operator<<(double number);
  ByteWriter& operator<<(std::uint64_t number);

  // The first error so far.
  [[nodiscard]] const Status& status() const { return status_; }
  // Passes on what is left; the first error of all.
  Status finish();

 private:
  void flush();

  ByteSink& sink_;
  std::unique_ptr<char[]> buffer_;
  std::size_t used_ = 0;
  std::size_t expected_ = 0, passed_ = 0;
  Status status_ = ok();
};

}  // namespace diesink
