// Counting allocations: the program's operator new and delete, in place of the library's.
// SPDX-License-Identifier: Apache-2.0
#include "convert/memory_limit.h"

#include <malloc.h>

#include <atomic>
#include <cassert>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> limited{false};
// Below zero is never left standing; what is freed of before the limit adds to it.
std::atomic<std::int64_t> left{0};

}  // namespace

namespace diesink {

MemoryLimit::MemoryLimit(std::size_t bytes) {
  assert(!limited);
  left = static_cast<std::int64_t>(bytes);
  limited = true;
}

MemoryLimit::~MemoryLimit() { limited = false; }

}  // namespace diesink

// The other forms of the standard library, arrays and sized ones, call these two.
void* operator new(std::size_t size) {
  void* const memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  if (limited.load(std::memory_order_relaxed)) {
    const auto given = static_cast<std::int64_t>(::malloc_usable_size(memory));
    if (left.fetch_sub(given, std::memory_order_relaxed) < given) {
      left.fetch_add(given, std::memory_order_relaxed);
      std::free(memory);
      throw std::bad_alloc();
    }
  }
  return memory;
}

void operator delete(void* memory) noexcept {
  if (limited.load(std::memory_order_relaxed) && memory != nullptr) {
    left.fetch_add(static_cast<std::int64_t>(::malloc_usable_size(memory)),
                   std::memory_order_relaxed);
  }
  std::free(memory);
}

// Compilers that pass the size come here.
void operator delete(void* memory, std::size_t) noexcept { ::operator delete(memory); }
