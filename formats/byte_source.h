// Bytes that a reader takes piece by piece: of memory, or of a file that need not be held.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace diesink {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual std::size_t size() const = 0;
  // The bytes from `offset` on, room.size() of them: where they are, or copied into `room`. Null
  // where they cannot be read, since the file has been cut meanwhile or its disk fails. May be
  // called by several threads. Needs: offset + room.size() <= size().
  [[nodiscard]] virtual const std::byte* at(std::size_t offset,
                                            std::span<std::byte> room) const = 0;
};

// Bytes in memory, which must outlive this.
class HeldBytes final : public ByteSource {
 public:
  explicit HeldBytes(std::span<const std::byte> bytes) : bytes_(bytes) {}
  [[nodiscard]] std::size_t size() const override { return bytes_.size(); }
  [[nodiscard]] const std::byte* at(std::size_t offset, std::span<std::byte>) const override {
    return bytes_.data() + offset;
  }

 private:
  std::span<const std::byte> bytes_;
};

// A regular file, read where it is asked for; null where `path` is none or cannot be opened.
std::unique_ptr<ByteSource> open_bytes(const std::string& path);

}  // namespace diesink
