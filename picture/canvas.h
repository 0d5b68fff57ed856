// The finished picture, and anti-aliased strokes and boxes drawn on it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/vec.h"
#include "picture/camera.h"
#include "picture/film.h"
#include "picture/paint.h"

namespace diesink {

// How much of each pixel a set of strokes covers, 0..1; strokes that cross do not add up.
class StrokeMask {
 public:
  StrokeMask(std::size_t width, std::size_t height)
      : width_(width), height_(height), cover_(width * height, 0) {}
  // A straight stroke `wide` pixels across with round ends. `seen`: whether it shows where the
  // stroke is at part 0..1 of its length; empty = everywhere.
  void add(const Vec2& from, const Vec2& to, double wide);
  template <class Seen>
  void add(const Vec2& from, const Vec2& to, double wide, const Seen& seen);
  [[nodiscard]] float at(std::size_t k) const { return cover_[k]; }

 private:
  std::size_t width_, height_;
  std::vector<float> cover_;
};

class Canvas {
 public:
  // The film over white.
  explicit Canvas(const Film& film);
  void stroke(const StrokeMask& mask, const Rgb& color, float strength);
  void fill(const PixelBox& box, const Rgb& color, float strength = 1);
  void text(std::string_view text, const Vec2& at, double height, const Rgb& color);
  void line(const Vec2& from, const Vec2& to, double wide, const Rgb& color);

  [[nodiscard]] std::size_t width() const { return width_; }
  [[nodiscard]] std::size_t height() const { return height_; }
  // 8-bit RGB, top row first.
  [[nodiscard]] std::vector<std::uint8_t> pixels() const;

 private:
  void blend(std::size_t k, const Rgb& color, float part);
  void strokes(std::span<const std::vector<Vec2>> strokes, double wide, const Rgb& color);

  std::size_t width_, height_;
  std::vector<Rgb> rgb_;
};

template <class Seen>
void StrokeMask::add(const Vec2& from, const Vec2& to, double wide, const Seen& seen) {
  const double reach = wide / 2 + 0.5;
  const double limit = 1e6;  // far outside any picture, and safe to round
  const auto bound = [&](double value, double most) {
    return value > 0 ? (value < most ? value : most) : 0.0;
  };
  if (!(std::abs(from.x()) < limit && std::abs(from.y()) < limit && std::abs(to.x()) < limit &&
        std::abs(to.y()) < limit)) {
    return;
  }
  const auto w = static_cast<double>(width_), h = static_cast<double>(height_);
  const auto left = static_cast<std::size_t>(bound(std::min(from.x(), to.x()) - reach, w));
  const auto right = static_cast<std::size_t>(bound(std::max(from.x(), to.x()) + reach + 1, w));
  const auto top = static_cast<std::size_t>(bound(std::min(from.y(), to.y()) - reach, h));
  const auto bottom = static_cast<std::size_t>(bound(std::max(from.y(), to.y()) + reach + 1, h));
  const Vec2 along = to - from;
  const double length2 = along.squaredNorm();
  for (std::size_t y = top; y < bottom; ++y) {
    for (std::size_t x = left; x < right; ++x) {
      const Vec2 off = Vec2(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5) - from;
      const double t = length2 > 0 ? bound(off.dot(along) / length2, 1.0) : 0.0;
      const double part = reach - (off - t * along).norm();
      if (part <= 0) continue;
      float& cover = cover_[y * width_ + x];
      const auto add = static_cast<float>(std::min({part, 1.0, wide}));
      if (add > cover && seen(t)) cover = add;
    }
  }
}

}  // namespace diesink
