// SPDX-License-Identifier: Apache-2.0
#include "picture/canvas.h"

#include "picture/stroke_font.h"

namespace diesink {

void StrokeMask::add(const Vec2& from, const Vec2& to, double wide) {
  add(from, to, wide, [](double) { return true; });
}

Canvas::Canvas(const Film& film)
    : width_(film.width), height_(film.height), rgb_(width_ * height_) {
  for (std::size_t k = 0; k < rgb_.size(); ++k) {
    const FilmPixel& pixel = film.pixels[k];
    for (std::size_t i = 0; i < 3; ++i) rgb_[k][i] = pixel.rgb[i] + (1 - pixel.cover);
  }
}

void Canvas::blend(std::size_t k, const Rgb& color, float part) {
  for (std::size_t i = 0; i < 3; ++i) rgb_[k][i] += part * (color[i] - rgb_[k][i]);
}

void Canvas::stroke(const StrokeMask& mask, const Rgb& color, float strength) {
  for (std::size_t k = 0; k < rgb_.size(); ++k) {
    if (mask.at(k) > 0) blend(k, color, strength * mask.at(k));
  }
}

void Canvas::fill(const PixelBox& box, const Rgb& color, float strength) {
  const auto inside = [](double low, double high, std::size_t k) {
    const auto at = static_cast<double>(k);
    return static_cast<float>(std::clamp(std::min(high, at + 1) - std::max(low, at), 0.0, 1.0));
  };
  const auto bound = [](double value, std::size_t most) {
    return static_cast<std::size_t>(std::clamp(value, 0.0, static_cast<double>(most)));
  };
  for (std::size_t y = bound(box.top, height_); y < bound(std::ceil(box.bottom), height_); ++y) {
    for (std::size_t x = bound(box.left, width_); x < bound(std::ceil(box.right), width_); ++x) {
      blend(y * width_ + x, color,
            strength * inside(box.left, box.right, x) * inside(box.top, box.bottom, y));
    }
  }
}

void Canvas::strokes(std::span<const std::vector<Vec2>> strokes, double wide, const Rgb& color) {
  // A mask of the strokes' own box: a word is small beside the picture.
  Vec2 low(1e9, 1e9), high(-1e9, -1e9);
  for (const std::vector<Vec2>& each : strokes) {
    for (const Vec2& p : each) low = low.cwiseMin(p), high = high.cwiseMax(p);
  }
  const double margin = wide + 1;
  low = Vec2(std::floor(low.x() - margin), std::floor(low.y() - margin)).cwiseMax(Vec2::Zero());
  high = (high + Vec2(margin, margin))
             .cwiseMin(Vec2(static_cast<double>(width_), static_cast<double>(height_)));
  if (!(high.x() > low.x() && high.y() > low.y())) return;
  const auto left = static_cast<std::size_t>(low.x()), top = static_cast<std::size_t>(low.y());
  const std::size_t w = static_cast<std::size_t>(high.x()) - left,
                    h = static_cast<std::size_t>(high.y()) - top;
  StrokeMask mask(w, h);
  for (const std::vector<Vec2>& each : strokes) {
    for (std::size_t k = 0; k < each.size(); ++k) {
      mask.add(each[k > 0 ? k - 1 : 0] - low, each[k] - low, wide);
    }
  }
  for (std::size_t y = 0; y < h; ++y) {
    for (std::size_t x = 0; x < w; ++x) {
      const float part = mask.at(y * w + x);
      if (part > 0) blend((top + y) * width_ + left + x, color, part);
    }
  }
}

void Canvas::text(std::string_view text, const Vec2& at, double height, const Rgb& color) {
  strokes(text_strokes(text, at, height), std::max(1.0, height / 8), color);
}

void Canvas::line(const Vec2& from, const Vec2& to, double wide, const Rgb& color) {
  const std::vector<std::vector<Vec2>> one{{from, to}};
  strokes(one, wide, color);
}

std::vector<std::uint8_t> Canvas::pixels() const {
  std::vector<std::uint8_t> bytes(3 * rgb_.size());
  for (std::size_t k = 0; k < rgb_.size(); ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      bytes[3 * k + i] = static_cast<std::uint8_t>(std::clamp(rgb_[k][i], 0.0F, 1.0F) * 255 + 0.5F);
    }
  }
  return bytes;
}

}  // namespace diesink
