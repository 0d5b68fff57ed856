// SPDX-License-Identifier: Apache-2.0
#include "picture/annotate.h"

#include <cmath>

#include "formats/text_number.h"
#include "picture/stroke_font.h"

namespace diesink {
namespace {

constexpr Rgb kInk{0.12F, 0.13F, 0.16F};
constexpr int kScaleSteps = 4;  // of the numbers beside a colour scale

std::string short_number(double value, double span) {
  // Three digits of the span.
  const int decimals =
      span > 0 ? std::clamp(2 - static_cast<int>(std::floor(std::log10(span))), 0, 12) : 3;
  if (!(std::abs(value) < 1e15)) return to_text(value);
  char text[64];
  return {text, put_fixed(text, value, decimals)};
}

std::string scale_number(const Paint& paint, int step) {
  const double span = paint.high - paint.low;
  return short_number(paint.low + span * step / kScaleSteps, span);
}

std::string title_of(Coloring coloring, const std::string& unit) {
  const std::string in_unit = unit.empty() ? "" : ", " + unit;
  switch (coloring) {
    case Coloring::kHeight:
      return "height" + in_unit;
    case Coloring::kSlope:
      return "slope, deg";
    case Coloring::kDeviation:
      return "deviation" + in_unit;
    case Coloring::kElement:
      break;
  }
  return "";
}

void list_elements(const Film& film, const Paint& paint, const Layout& layout, Canvas& canvas) {
  std::vector<bool> seen(paint.palette->size(), false);
  for (const FilmPixel& each : film.pixels) {
    if (each.element != kNothingSeen) seen[each.element] = true;
  }
  std::vector<const PaletteEntry*> listed;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (seen[k] && (*paint.palette)[k].listed) listed.push_back(&(*paint.palette)[k]);
  }
  const double step = 1.9 * layout.letter;
  const auto room = static_cast<std::size_t>((layout.legend.bottom - layout.legend.top) / step);
  const std::size_t shown = listed.size() <= room ? listed.size() : room > 0 ? room - 1 : 0;
  double base = layout.legend.top + layout.letter;
  for (std::size_t k = 0; k < shown; ++k, base += step) {
    const double left = layout.legend.left;
    const double edge = std::max(1.0, layout.letter / 12);
    const PixelBox box{left, base - 1.1 * layout.letter, left + 1.5 * layout.letter,
                       base + 0.1 * layout.letter};
    canvas.fill({box.left - edge, box.top - edge, box.right + edge, box.bottom + edge}, kInk, 0.8F);
    canvas.fill(box, listed[k]->color);
    canvas.text(listed[k]->name, Vec2(left + 2.1 * layout.letter, base), layout.letter, kInk);
  }
  if (shown < listed.size() && room > 0) {
    canvas.text("+ " + std::to_string(listed.size() - shown), Vec2(layout.legend.left, base),
                layout.letter, kInk);
  }
}

void draw_scale(const Paint& paint, const Layout& layout, const std::string& unit, Canvas& canvas) {
  const double left = layout.legend.left, right = left + 1.5 * layout.letter;
  canvas.text(title_of(paint.coloring, unit), Vec2(left, layout.legend.top + layout.letter),
              layout.letter, kInk);
  const double top = std::floor(layout.legend.top + 2.5 * layout.letter);  // whole rows of pixels
  const double bottom =
      top + std::max(1.0, std::floor(std::min(layout.legend.bottom - top, 22 * layout.letter)));
  for (double y = top; y < bottom; y += 1) {
    canvas.fill({left, y, right, std::min(y + 1, bottom)},
                scale_color(paint.coloring, (bottom - y - 0.5) / (bottom - top)));
  }
  for (int step = 0; step <= kScaleSteps; ++step) {
    const double y = bottom + (top - bottom) * step / kScaleSteps;
    canvas.line(Vec2(right, y), Vec2(right + 0.4 * layout.letter, y),
                std::max(1.0, layout.letter / 10), kInk);
    canvas.text(scale_number(paint, step), Vec2(right + 0.7 * layout.letter, y + layout.letter / 2),
                layout.letter, kInk);
  }
}

void draw_scale_bar(const Camera& camera, const Layout& layout, const std::string& unit,
                    Canvas& canvas) {
  const double most =
      std::min(0.3 * (layout.surface.right - layout.surface.left), 16 * layout.letter);
  const double length = round_length(most / camera.scale), pixels = length * camera.scale;
  const double right = layout.surface.right, wide = std::max(1.2, layout.letter / 7);
  const double y = static_cast<double>(canvas.height()) - 1.2 * layout.letter;
  canvas.line(Vec2(right - pixels, y), Vec2(right, y), wide, kInk);
  for (const double x : {right - pixels, right}) {
    canvas.line(Vec2(x, y - layout.letter / 2), Vec2(x, y + layout.letter / 2), wide, kInk);
  }
  const std::string text = to_text(length) + (unit.empty() ? "" : " " + unit);
  canvas.text(
      text, Vec2(right - pixels / 2 - text_width(text, layout.letter) / 2, y - 0.8 * layout.letter),
      layout.letter, kInk);
}

void draw_axes(const Camera& camera, const Layout& layout, Canvas& canvas) {
  constexpr std::array<Rgb, 3> kColors{Rgb{0.80F, 0.20F, 0.18F}, Rgb{0.16F, 0.55F, 0.22F},
                                       Rgb{0.15F, 0.35F, 0.80F}};
  constexpr std::array<std::string_view, 3> kNames{"x", "y", "z"};
  const double length = 3 * layout.letter, wide = std::max(1.2, layout.letter / 7);
  const Vec2 origin(layout.surface.left + 2.8 * layout.letter,
                    static_cast<double>(canvas.height()) -
                        (camera.turned(Vec3::UnitX()).y() < -0.1 ? 3.0 : 1.8) * layout.letter);
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = camera.turned(Vec3::Unit(k));
    const Vec2 along(axis.x(), -axis.y());
    if (along.norm() < 0.1) continue;
    const Vec2 end = origin + length * along;
    const auto i = static_cast<std::size_t>(k);
    canvas.line(origin, end, wide, kColors[i]);
    const Vec2 middle = end + 0.8 * layout.letter * along.normalized();
    canvas.text(kNames[i],
                middle + Vec2(-text_width(kNames[i], layout.letter) / 2, layout.letter / 3),
                layout.letter, kColors[i]);
  }
}

}  // namespace

Layout make_layout(std::size_t width, std::size_t height, const Paint& paint,
                   const std::string& unit, bool bare) {
  const auto w = static_cast<double>(width), h = static_cast<double>(height);
  Layout layout;
  const double margin = 0.03 * std::min(w, h);
  layout.surface = {margin, margin, w - margin, h - margin};
  layout.letter = std::max(7.0, std::min(w, h) / 75);
  if (bare) return layout;
  double widest = 0;
  if (paint.coloring == Coloring::kElement) {
    for (const PaletteEntry& each : *paint.palette) {
      if (each.listed) widest = std::max(widest, text_width(each.name, layout.letter));
    }
  } else {
    widest = text_width(title_of(paint.coloring, unit), layout.letter) - 2 * layout.letter;
    for (int step = 0; step <= kScaleSteps; ++step) {
      widest = std::max(widest, text_width(scale_number(paint, step), layout.letter));
    }
  }
  layout.surface.bottom -= 4 * layout.letter;
  if (widest > 0) {
    // Names of somebody's file may be of any length: a third of the picture at most.
    layout.legend = {w - margin - std::min(w / 3, widest + 2.5 * layout.letter), margin, w - margin,
                     h - margin};
    layout.surface.right = layout.legend.left - margin;
  }
  return layout;
}

double round_length(double most) {
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double step : {5.0, 2.0}) {
    if (step * power <= most) return step * power;
  }
  return power;
}

void annotate(const Film& film, const Camera& camera, const Paint& paint, const Layout& layout,
              const std::string& unit, Canvas& canvas) {
  if (layout.legend.right > layout.legend.left) {
    if (paint.coloring == Coloring::kElement) {
      list_elements(film, paint, layout, canvas);
    } else {
      draw_scale(paint, layout, unit, canvas);
    }
  }
  draw_scale_bar(camera, layout, unit, canvas);
  draw_axes(camera, layout, canvas);
}

}  // namespace diesink
