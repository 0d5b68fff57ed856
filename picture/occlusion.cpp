// Source: the estimator of McGuire, Osman, Bukowski and Hennessy, "The alchemy screen-space ambient
// obscurance algorithm" (2011), on a fixed pattern instead of a random one: the same picture
// always.
// SPDX-License-Identifier: Apache-2.0
#include "picture/occlusion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"

namespace diesink {
namespace {

constexpr std::size_t kEvery = 2;  // pixels between the places it is found at
constexpr float kStrength = 0.9F, kDarkest = 0.45F;

struct Tap {
  int dx = 0, dy = 0;
};

// Three rings of eight, each turned against the last.
std::vector<Tap> taps_within(double reach) {
  std::vector<Tap> taps;
  for (int ring = 1; ring <= 3; ++ring) {
    for (int k = 0; k < 8; ++k) {
      const double angle = (k + ring / 3.0) * std::numbers::pi / 4, radius = reach * ring / 3.0;
      taps.push_back({static_cast<int>(std::lround(radius * std::cos(angle))),
                      static_cast<int>(std::lround(radius * std::sin(angle)))});
    }
  }
  return taps;
}

float open_part(const Film& film, const std::vector<Tap>& taps, std::size_t x, std::size_t y,
                float scale, float reach) {
  const FilmPixel& here = film.at(x, y);
  if (here.element == kNothingSeen) return 1;
  float sum = 0;
  for (const Tap& tap : taps) {
    const auto i = static_cast<std::ptrdiff_t>(x) + tap.dx,
               j = static_cast<std::ptrdiff_t>(y) + tap.dy;
    if (i < 0 || j < 0 || i >= static_cast<std::ptrdiff_t>(film.width) ||
        j >= static_cast<std::ptrdiff_t>(film.height)) {
      continue;
    }
    const FilmPixel& there = film.at(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
    if (there.element == kNothingSeen) continue;
    const auto dx = static_cast<float>(tap.dx), dy = static_cast<float>(-tap.dy);
    const float dz = (there.depth - here.depth) * scale;
    const float length = std::sqrt(dx * dx + dy * dy + dz * dz) + 1e-6F;
    const float above = (dx * here.normal[0] + dy * here.normal[1] + dz * here.normal[2]) / length;
    // What stands far in front hides nothing of the light around.
    const float near = 1 / (1 + length * length / (reach * reach));
    sum += std::max(0.0F, above - 0.08F) * near;
  }
  return std::max(kDarkest, 1 - kStrength * 2 * sum / static_cast<float>(taps.size()));
}

}  // namespace

void occlude(Film& film, double scale, double reach, int threads) {
  if (reach < 2 || film.width < 2 * kEvery || film.height < 2 * kEvery) return;
  const std::vector<Tap> taps = taps_within(reach);
  const std::size_t width = film.width / kEvery, height = film.height / kEvery;
  std::vector<float> open(width * height);
  parallel_blocks(height, 8, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      for (std::size_t i = 0; i < width; ++i) {
        open[j * width + i] = open_part(film, taps, i * kEvery, j * kEvery,
                                        static_cast<float>(scale), static_cast<float>(reach));
      }
    }
  });
  parallel_blocks(film.height, 16, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t y = begin; y < end; ++y) {
      for (std::size_t x = 0; x < film.width; ++x) {
        FilmPixel& pixel = film.at(x, y);
        if (pixel.cover == 0) continue;
        // The mean of the nine around smooths the pattern of the taps away.
        const std::size_t ci = std::min(x / kEvery, width - 1),
                          cj = std::min(y / kEvery, height - 1);
        float sum = 0, count = 0;
        for (std::size_t j = cj > 0 ? cj - 1 : 0; j <= std::min(cj + 1, height - 1); ++j) {
          for (std::size_t i = ci > 0 ? ci - 1 : 0; i <= std::min(ci + 1, width - 1); ++i) {
            sum += open[j * width + i];
            count += 1;
          }
        }
        for (float& each : pixel.rgb) each *= sum / count;
      }
    }
  });
}

}  // namespace diesink
