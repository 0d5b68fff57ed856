// Highway, with the instruction sets that are worth a copy of the code: SSE2, AVX2 and AVX-512 on
// x86. Define HWY_TARGET_INCLUDE before. Nothing here or in its users may fuse a product and a sum
// (no MulAdd): the same digits come out of every copy. SPDX-License-Identifier: Apache-2.0 No
// include guard: it is included once for each instruction set.

#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#endif
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
