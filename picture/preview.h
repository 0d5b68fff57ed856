// A shaded picture of a compound surface or of a mesh.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/compound/compound_surface.h"
#include "core/mesh.h"
#include "core/result.h"
#include "picture/camera.h"
#include "picture/paint.h"

namespace diesink {

struct PreviewOptions {
  View view = View::kIso;
  Coloring coloring = Coloring::kElement;
  std::array<int, 2> size{1600, 1200};  // pixels
  bool bare = false;                    // no legend, scale bar and axes
  int threads = 0;                      // 0 = all cores
  // Called now and then with the part done, 0..1, from any thread; may be empty.
  std::function<void(double)> progress;
};

struct Picture {
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // 8 bits each, top row first
};

// The plan view comes straight from the evaluator; the others, and deviations, from a mesh: to a
// fifth of a pixel, closed with sides and a floor; for deviations to the program's tolerance. Where
// tessellate() has no creases (a scanned base) it is the plain grid of the program's intervals,
// without lines. The same bytes for any number of threads. Errors: those of tessellate(); kLimit
// where memory does not hold the picture.
Result<Picture> preview(const CompoundSurface& surface, const PreviewOptions& options);

// Errors: kInput for a mesh without triangles; kUsage for deviations, which need a surface.
Result<Picture> preview(const TriangleMesh& mesh, const PreviewOptions& options);

}  // namespace diesink
