// SPDX-License-Identifier: Apache-2.0
#include "core/large_array.h"

#include <cstdlib>
#include <new>

#include "core/parallel.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace diesink {
namespace {

// The size of a large page on every 64-bit machine of today; below one there is nothing to gain.
constexpr std::size_t kPage = std::size_t{1} << 21;

}  // namespace

void prefer_large_pages(void* memory, std::size_t bytes) {
#ifdef __linux__
  // The whole pages inside; refused, it changes nothing but the time.
  void* from = memory;
  std::size_t left = bytes;
  if (std::align(kPage, kPage, from, left) == nullptr) return;
  static_cast<void>(madvise(from, left / kPage * kPage, MADV_HUGEPAGE));
#else
  static_cast<void>(memory);
  static_cast<void>(bytes);
#endif
}

void clear_large_pages(void* memory, std::size_t bytes, int threads) {
#if defined(__linux__) && defined(MADV_POPULATE_WRITE)
  void* from = memory;
  std::size_t left = bytes;
  if (std::align(kPage, kPage, from, left) == nullptr) return;
  parallel_blocks(left / kPage, 1, threads, [&](std::size_t begin, std::size_t end, int) {
    // Older systems do not know it, which changes nothing but the time.
    static_cast<void>(madvise(static_cast<std::byte*>(from) + begin * kPage, (end - begin) * kPage,
                              MADV_POPULATE_WRITE));
  });
#else
  static_cast<void>(memory);
  static_cast<void>(bytes);
  static_cast<void>(threads);
#endif
}

std::unique_ptr<void, LargeMemoryDeleter> large_memory(std::size_t bytes) {
  const std::size_t align = bytes < kPage ? 64 : kPage;
  const std::size_t whole = (bytes / align + 1) * align;
  std::unique_ptr<void, LargeMemoryDeleter> memory(std::aligned_alloc(align, whole));
  if (!memory) throw std::bad_alloc();
  prefer_large_pages(memory.get(), whole);
  return memory;
}

void LargeMemoryDeleter::operator()(void* memory) const { std::free(memory); }

}  // namespace diesink
