// The plan view of a compound surface, straight from the evaluator.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/compound/compound_surface.h"
#include "picture/camera.h"
#include "picture/film.h"
#include "picture/paint.h"

namespace diesink {

// Evaluates samples_across() squared vertical lines a pixel over the domain; nothing is seen
// outside it. The same film for any number of threads. Needs: a camera that looks down
// (View::kPlan), a palette of the surface.
void film_plan(const CompoundSurface& surface, const Camera& camera, const Paint& paint,
               int threads, Film& film);

}  // namespace diesink
