// A whole input file in memory, within limits.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "core/result.h"

namespace diesink {

inline constexpr std::size_t kMaxFileBytes = std::size_t{2} << 30;

class InputBytes {
 public:
  InputBytes() = default;
  InputBytes(std::unique_ptr<std::byte[]> bytes, std::size_t size)
      : bytes_(std::move(bytes)), size_(size) {}
  [[nodiscard]] std::span<const std::byte> bytes() const { return {bytes_.get(), size_}; }
  // Gives the memory of the first `count` bytes back to the system, whole pages of it: they read as
  // anything from now on.
  void forget(std::size_t count);

 private:
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_ = 0, forgotten_ = 0;
};

// Reads a regular file, a pipe or, for "-", stdin; a large file by `threads` threads (0 = all
// cores). Read rather than mapped: a file that shrinks meanwhile must not end the program.
// Errors: kInput where it cannot be opened or read, or is a folder or device; kLimit above
//         `max_bytes`, or where memory for it is lacking.
Result<InputBytes> read_file(const std::string& path, std::size_t max_bytes = kMaxFileBytes,
                             int threads = 1);

}  // namespace diesink
