// SPDX-License-Identifier: Apache-2.0
#include "formats/input_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <memory>
#include <new>

#include "core/large_array.h"
#include "core/parallel.h"

namespace diesink {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value_ > STDIN_FILENO) ::close(value_);
  }
  [[nodiscard]] int value() const { return value_; }

 private:
  int value_;
};

Error cannot_read(const std::string& path, const char* reason) {
  return {ErrorCode::kInput, std::string("cannot read: ") + reason, {path}};
}

Error too_large(const std::string& path, std::size_t max_bytes) {
  return {ErrorCode::kLimit,
          "the file is larger than the limit of " + std::to_string(max_bytes) + " bytes",
          {path}};
}

constexpr std::size_t kLargePage = std::size_t{1} << 21;

// Copying out of the system's cache takes longer than one core needs to: what is there is read in
// blocks, until one comes out shorter than it should. How many bytes are there in a row.
std::size_t read_blocks(int file, std::byte* to, std::size_t size, int threads) {
  constexpr std::size_t kBlock = std::size_t{8} << 20;
  std::atomic<std::size_t> whole{size};
  parallel_blocks(size, kBlock, threads, [&](std::size_t begin, std::size_t end, int) {
    while (begin < end) {
      const ssize_t got = ::pread(file, to + begin, end - begin, static_cast<off_t>(begin));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      begin += static_cast<std::size_t>(got);
    }
    if (begin == end) return;
    for (std::size_t least = whole; begin < least && !whole.compare_exchange_weak(least, begin);) {
    }
  });
  return whole;
}

}  // namespace

void InputBytes::forget(std::size_t count) {
  // Pages that belong to these bytes alone; what the system makes of the advice is its own affair.
  const std::size_t page = kLargePage;
  void* first = bytes_.get() + forgotten_;
  std::size_t space = std::min(count, size_) - std::min(forgotten_, std::min(count, size_));
  if (std::align(page, page, first, space) == nullptr) return;
  const std::size_t whole = space / page * page;
  ::madvise(first, whole, MADV_DONTNEED);
  forgotten_ = static_cast<std::size_t>(static_cast<std::byte*>(first) - bytes_.get()) + whole;
}

Result<InputBytes> read_file(const std::string& path, std::size_t max_bytes, int threads) {
  const Descriptor file(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.value() < 0) return cannot_read(path, std::strerror(errno));
  struct stat found {};
  if (::fstat(file.value(), &found) != 0) return cannot_read(path, std::strerror(errno));
  if (S_ISDIR(found.st_mode)) return cannot_read(path, "it is a folder");
  if (S_ISBLK(found.st_mode) || (S_ISCHR(found.st_mode) && file.value() != STDIN_FILENO)) {
    return cannot_read(path, "it is a device, expected a file");
  }
  const bool regular = S_ISREG(found.st_mode);
  if (regular && static_cast<std::uintmax_t>(found.st_size) > max_bytes)
    return too_large(path, max_bytes);

  // One byte more than the file is said to hold: the read that finds its end needs no second
  // buffer.
  std::size_t capacity =
      regular ? static_cast<std::size_t>(found.st_size) + 1 : std::size_t{1} << 16;
  std::unique_ptr<std::byte[]> bytes(new (std::nothrow) std::byte[capacity]);
  std::size_t size = 0;
  if (bytes && capacity > 4 * kLargePage && file.value() != STDIN_FILENO) {
    prefer_large_pages(bytes.get(), capacity);
    size = read_blocks(file.value(), bytes.get(), capacity - 1, threads);
    // What is missing has its reason told by the next read, or has been cut off meanwhile.
    if (::lseek(file.value(), static_cast<off_t>(size), SEEK_SET) < 0) {
      return cannot_read(path, std::strerror(errno));
    }
  }
  while (bytes) {
    const ssize_t got =
        ::read(file.value(), bytes.get() + size, std::min<std::size_t>(capacity - size, 1U << 30));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return cannot_read(path, std::strerror(errno));
    if (got == 0) return InputBytes(std::move(bytes), size);
    size += static_cast<std::size_t>(got);
    if (size > max_bytes) return too_large(path, max_bytes);
    if (size < capacity) continue;
    std::unique_ptr<std::byte[]> larger(new (std::nothrow) std::byte[capacity * 2]);
    if (larger) std::memcpy(larger.get(), bytes.get(), size);
    bytes = std::move(larger);
    capacity *= 2;
  }
  return Error{ErrorCode::kLimit, "not enough memory to hold the file", {path}};
}

}  // namespace diesink
