// Memory for large arrays that are written once, front to back or all over.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

#include "core/parallel.h"

namespace diesink {

// Bytes that nothing has written yet, in large pages where the system has them: a fault fetches 2
// MB in place of 4 KB, and writes all over the array find their pages. Throws std::bad_alloc.
struct LargeMemoryDeleter {
  void operator()(void* memory) const;
};
std::unique_ptr<void, LargeMemoryDeleter> large_memory(std::size_t bytes);

// Asks for large pages for memory that was got but not written yet.
void prefer_large_pages(void* memory, std::size_t bytes);

// Has the system clear the pages of such memory now, by all threads, where they would else be
// cleared one by one as they are written first. For memory that will be written whole.
void clear_large_pages(void* memory, std::size_t bytes, int threads);

// Room in an empty vector, in large pages.
template <class T>
void reserve_large(std::vector<T>& vector, std::size_t count) {
  vector.reserve(count);
  prefer_large_pages(vector.data(), vector.capacity() * sizeof(T));
}

// The same for one that will be filled whole, its pages cleared by all threads together. Clearing
// memory is no progress: it tells nobody.
template <class T>
void reserve_cleared(std::vector<T>& vector, std::size_t count, int threads) {
  const ProgressSpan silent;
  reserve_large(vector, count);
  clear_large_pages(vector.data(), count * sizeof(T), threads);
}

// `count` values that nothing has set yet.
template <class T>
class LargeArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  LargeArray() = default;
  explicit LargeArray(std::size_t count) : memory_(large_memory(count * sizeof(T))) {}
  [[nodiscard]] T* data() const { return static_cast<T*>(memory_.get()); }

 private:
  std::unique_ptr<void, LargeMemoryDeleter> memory_;
};

}  // namespace diesink
