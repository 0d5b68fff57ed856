// The formats there are, each defined at the end of its own source file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "formats/format.h"

namespace diesink {

extern const Format kStl;
extern const Format kObj;
extern const Format kPly;
extern const Format kOff;
extern const Format kGltf;
extern const Format kGlb;

}  // namespace diesink
