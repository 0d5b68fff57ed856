// Work shared out to threads.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

namespace diesink {

// `asked`, or the machine's cores where it is 0; at least 1.
int thread_count(int asked);

// Runs work(0) .. work(count - 1), on at most `threads` threads. An exception of any of them, the
// one with the lowest number, is thrown here after all are done.
void run_parallel(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

}  // namespace diesink
