// SPDX-License-Identifier: Apache-2.0
#include "core/large_array.h"

#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace diesink {

std::unique_ptr<void, LargeMemoryDeleter> large_memory(std::size_t bytes) {
  // The size of a large page on every 64-bit machine of today; below one there is nothing to gain.
  constexpr std::size_t kPage = std::size_t{1} << 21;
  const std::size_t align = bytes < kPage ? 64 : kPage;
  const std::size_t whole = (bytes / align + 1) * align;
  std::unique_ptr<void, LargeMemoryDeleter> memory(std::aligned_alloc(align, whole));
  if (!memory) throw std::bad_alloc();
#ifdef __linux__
  // Refused, it changes nothing but the time.
  if (align == kPage) static_cast<void>(madvise(memory.get(), whole, MADV_HUGEPAGE));
#endif
  return memory;
}

void LargeMemoryDeleter::operator()(void* memory) const { std::free(memory); }

}  // namespace diesink
