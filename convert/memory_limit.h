// A bound on the memory that a part of the program may take.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace diesink {

// While it lives, operator new throws std::bad_alloc where the program, all threads together, would
// hold over `bytes` more than it held when this began. Counted are the bytes the heap really gave,
// of the libraries too; not the stacks of threads, and not what asks for an alignment of its own.
// Needs: no other one alive.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::size_t bytes);
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
  ~MemoryLimit();
};

}  // namespace diesink
