// SPDX-License-Identifier: Apache-2.0
#include "formats/byte_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace diesink {
namespace {

class FileBytesSource final : public ByteSource {
 public:
  FileBytesSource(int file, std::size_t size) : file_(file), size_(size) {}
  FileBytesSource(const FileBytesSource&) = delete;
  FileBytesSource& operator=(const FileBytesSource&) = delete;
  ~FileBytesSource() override { ::close(file_); }

  [[nodiscard]] std::size_t size() const override { return size_; }
  [[nodiscard]] const std::byte* at(std::size_t offset, std::span<std::byte> room) const override {
    for (std::size_t done = 0; done < room.size();) {
      const ssize_t got =
          ::pread(file_, room.data() + done, room.size() - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return nullptr;
      done += static_cast<std::size_t>(got);
    }
    return room.data();
  }

 private:
  int file_;
  std::size_t size_;
};

}  // namespace

std::unique_ptr<ByteSource> open_bytes(const std::string& path) {
  // Not to wait for a pipe that nobody writes.
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return nullptr;
  struct stat found {};
  if (::fstat(file, &found) != 0 || !S_ISREG(found.st_mode) || found.st_size < 0) {
    ::close(file);
    return nullptr;
  }
  return std::make_unique<FileBytesSource>(file, static_cast<std::size_t>(found.st_size));
}

}  // namespace diesink
