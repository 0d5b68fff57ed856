// What is seen at every pixel before lines and lettering are drawn over it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace diesink {

inline constexpr std::uint32_t kNothingSeen = 0xFFFFFFFFu;

struct FilmPixel {
  std::array<float, 3> rgb{0, 0, 0};                      // sum over the covered part, 0..1 each
  float cover = 0;                                        // 0..1
  float depth = -std::numeric_limits<float>::infinity();  // toward the eye
  std::array<float, 3> normal{0, 0, 0};                   // in the camera's frame
  std::uint32_t element = kNothingSeen;                   // entry of the palette
};

struct Film {
  std::size_t width = 0, height = 0;
  std::vector<FilmPixel> pixels;  // top row first

  Film(std::size_t w, std::size_t h) : width(w), height(h), pixels(w * h) {}
  FilmPixel& at(std::size_t x, std::size_t y) { return pixels[y * width + x]; }
  [[nodiscard]] const FilmPixel& at(std::size_t x, std::size_t y) const {
    return pixels[y * width + x];
  }
};

// Samples a pixel in each direction: as many as keep the work within bounds.
constexpr int samples_across(std::size_t width, std::size_t height) {
  const std::size_t pixels = width * height;
  return pixels <= 600'000 ? 4 : pixels <= 1'000'000 ? 3 : pixels <= 40'000'000 ? 2 : 1;
}

}  // namespace diesink
