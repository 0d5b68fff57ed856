// Work shared out to threads, piece by piece.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

#include "core/parallel.h"

namespace diesink {

// Runs work(0) .. work(count - 1), on at most `threads` threads. An exception of one of them is
// thrown here after all are done.
inline void run_parallel(std::size_t count, int threads,
                         const std::function<void(std::size_t)>& work) {
  parallel_blocks(count, 1, threads, [&](std::size_t piece, std::size_t, int) { work(piece); });
}

}  // namespace diesink
