// Ambient occlusion of a film: what lies in a hollow gets less of the light from everywhere.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "picture/film.h"

namespace diesink {

// Darkens the pixels of hollows, as seen from the heights of the pixels around within `reach`
// pixels. `scale`: pixels a unit of length. The same film for any number of threads.
void occlude(Film& film, double scale, double reach, int threads);

}  // namespace diesink
