// SPDX-License-Identifier: Apache-2.0
#include "picture/plan_film.h"

#include <cmath>
#include <span>

#include "core/parallel.h"

namespace diesink {
namespace {

struct Row {
  std::vector<double> z, nx, ny, nz;
  std::vector<Label> label;

  explicit Row(std::size_t count) : z(count), nx(count), ny(count), nz(count), label(count) {}
  CcRun run() { return {z.data(), nx.data(), ny.data(), nz.data(), label.data()}; }
};

}  // namespace

void film_plan(const CompoundSurface& surface, const Camera& camera, const Paint& paint,
               int threads, Film& film) {
  const std::vector<std::uint32_t> entries = entries_of(surface, *paint.palette);
  const Machining& domain = surface.program().machining;
  const int across = samples_across(film.width, film.height);
  const auto place = [&](std::size_t sample) {
    return (static_cast<double>(sample) + 0.5) / across;
  };
  // Samples inside the domain only: ascending x, and the sample each begins at.
  std::vector<double> xs;
  std::size_t first = 0;
  for (std::size_t k = 0; k < film.width * static_cast<std::size_t>(across); ++k) {
    const double x = camera.centre.x() + (place(k) - camera.middle.x()) / camera.scale;
    if (x < domain.x_range[0]) first = k + 1;
    if (x >= domain.x_range[0] && x <= domain.x_range[1]) xs.push_back(x);
  }
  if (xs.empty()) return;
  const float part = 1.0F / static_cast<float>(across * across);
  constexpr std::size_t kRows = 4;
  parallel_blocks(film.height, kRows, threads, [&](std::size_t begin, std::size_t end, int) {
    Row row(xs.size());
    for (std::size_t j = begin; j < end; ++j) {
      for (int sub = 0; sub < across; ++sub) {
        const std::size_t line =
            j * static_cast<std::size_t>(across) + static_cast<std::size_t>(sub);
        const double y = camera.centre.y() - (place(line) - camera.middle.y()) / camera.scale;
        if (y < domain.y_range[0] || y > domain.y_range[1]) continue;
        surface.row(y, xs, row.run());
        for (std::size_t k = 0; k < xs.size(); ++k) {
          if (row.label[k] == kNoLabel) continue;
          const std::size_t sample = first + k;
          FilmPixel& pixel = film.at(sample / static_cast<std::size_t>(across), j);
          const Vec3 normal(row.nx[k], row.ny[k], row.nz[k]);
          const std::uint32_t entry = entries[row.label[k]];
          const Rgb color = paint.color(entry, Vec3(xs[k], y, row.z[k]), normal);
          const float light = part * light_on(normal);
          for (std::size_t i = 0; i < 3; ++i) pixel.rgb[i] += light * color[i];
          pixel.cover += part;
          if (pixel.element == kNothingSeen || sub == across / 2) {
            pixel.element = entry;
            pixel.depth = static_cast<float>(row.z[k] - camera.centre.z());
            pixel.normal = {static_cast<float>(normal.x()), static_cast<float>(normal.y()),
                            static_cast<float>(normal.z())};
          }
        }
      }
    }
  });
}

}  // namespace diesink
