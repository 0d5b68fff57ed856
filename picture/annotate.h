// What is written around a picture: the legend, the scale bar and the axes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "picture/camera.h"
#include "picture/canvas.h"
#include "picture/film.h"
#include "picture/paint.h"

namespace diesink {

struct Layout {
  double letter = 0;  // height of capitals, pixels
  PixelBox surface;   // where the surface goes
  PixelBox legend;    // empty (left == right) where there is none
};

// Room for the longest name or number of the legend at the right, and for the scale bar and axes at
// the bottom; `unit` is what a scale says behind its name; `bare`: all of it for the surface.
Layout make_layout(std::size_t width, std::size_t height, const Paint& paint,
                   const std::string& unit, bool bare);

// A length of 1, 2 or 5 times a power of ten, the largest not above `most`.
// Needs: most > 0.
double round_length(double most);

// The elements the film has seen with their colours, as many as there is room for, or the scale of
// heights, slopes or deviations; a scale bar in `unit`; the axes that are not seen end on.
void annotate(const Film& film, const Camera& camera, const Paint& paint, const Layout& layout,
              const std::string& unit, Canvas& canvas);

}  // namespace diesink
