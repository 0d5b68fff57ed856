// Highway, with the instruction sets that are worth a copy of the code: SSE2, AVX2 and AVX-512.
// SPDX-License-Identifier: Apache-2.0
//
// Define HWY_TARGET_INCLUDE before; no include guard, it is included once an instruction set.
// Users fuse no product with a sum (no MulAdd): every copy gives the same digits.

#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#endif
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
