// SPDX-License-Identifier: Apache-2.0
#include "picture/mesh_film.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace diesink {
namespace {

constexpr std::size_t kBandRows = 16;  // of pixels: a band's samples stay in the cache

class MeshFilm {
 public:
  MeshFilm(const TriangleMesh& mesh, const Camera& camera, const Paint& paint, Film& film)
      : mesh_(mesh),
        camera_(camera),
        paint_(paint),
        film_(film),
        across_(samples_across(film.width, film.height)),
        entries_(entries_of(mesh, *paint.palette)) {
    seen_.reserve(mesh.positions.size());
    for (const Vec3& p : mesh.positions) {
      const Vec3 at = camera.project(p);
      seen_.emplace_back(at.x() * across_, at.y() * across_, at.z());
    }
  }

  void expose(int threads) {
    sort_into_bands();
    parallel_blocks(bands_, 1, threads,
                    [&](std::size_t band, std::size_t, int) { expose_band(band); });
  }

 private:
  struct Samples {
    std::size_t width = 0, first_row = 0, rows = 0;
    std::vector<float> depth;
    std::vector<std::uint32_t> triangle;
  };

  [[nodiscard]] std::array<Vec3, 3> corners(std::size_t t) const {
    const auto& [a, b, c] = mesh_.triangles[t];
    return {seen_[a], seen_[b], seen_[c]};
  }

  // First and last band a triangle touches; false where it lies outside the picture.
  bool bands_of(std::size_t t, std::size_t& first, std::size_t& last) const {
    const auto [a, b, c] = corners(t);
    const double low = std::min({a.y(), b.y(), c.y()}), high = std::max({a.y(), b.y(), c.y()});
    const double band = static_cast<double>(kBandRows) * across_;
    if (!(high >= 0) || !(low < static_cast<double>(film_.height) * across_)) return false;
    first = low > 0 ? static_cast<std::size_t>(low / band) : 0;
    last = std::min(bands_ - 1, static_cast<std::size_t>(high / band));
    return first <= last;
  }

  void sort_into_bands() {
    bands_ = (film_.height + kBandRows - 1) / kBandRows;
    start_.assign(bands_ + 1, 0);
    std::size_t first = 0, last = 0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (!bands_of(t, first, last)) continue;
      for (std::size_t k = first; k <= last; ++k) ++start_[k + 1];
    }
    for (std::size_t k = 0; k < bands_; ++k) start_[k + 1] += start_[k];
    of_band_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (!bands_of(t, first, last)) continue;
      for (std::size_t k = first; k <= last; ++k)
        of_band_[next[k]++] = static_cast<std::uint32_t>(t);
    }
  }

  void draw(std::size_t t, Samples& samples) const {
    const auto [a, b, c] = corners(t);
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0 || !std::isfinite(area)) return;  // seen from its edge
    const double zx =
        ((b.z() - a.z()) * (c.y() - a.y()) - (c.z() - a.z()) * (b.y() - a.y())) / area;
    const double zy =
        ((b.x() - a.x()) * (c.z() - a.z()) - (c.x() - a.x()) * (b.z() - a.z())) / area;
    // Nearly on edge the plane runs away between samples.
    const double z_low = std::min({a.z(), b.z(), c.z()}), z_high = std::max({a.z(), b.z(), c.z()});
    const double top = static_cast<double>(samples.first_row);
    const double low = std::ceil(std::max(std::min({a.y(), b.y(), c.y()}) - 0.5, top));
    const double high = std::floor(std::min(std::max({a.y(), b.y(), c.y()}) - 0.5,
                                            top + static_cast<double>(samples.rows) - 1));
    const double x_low = std::max(0.0, std::min({a.x(), b.x(), c.x()}) - 0.5);
    const double x_high =
        std::min(static_cast<double>(samples.width) - 1, std::max({a.x(), b.x(), c.x()}) - 0.5);
    const std::array<std::pair<const Vec3*, const Vec3*>, 3> edges{{{&a, &b}, {&b, &c}, {&c, &a}}};
    for (double row = low; row <= high; row += 1) {
      const double y = row + 0.5;
      double from = x_low, to = x_high;
      for (const auto& [p, q] : edges) {
        const double dx = q->x() - p->x(), dy = q->y() - p->y();
        if (dy == 0) continue;  // the rows end there anyway
        const double x = p->x() + (y - p->y()) * dx / dy - 0.5;
        // Inside lies to the left of a rising edge for a positive area, else to the right.
        if ((dy > 0) == (area > 0)) {
          to = std::min(to, x);
        } else {
          from = std::max(from, x);
        }
      }
      const std::size_t line = (static_cast<std::size_t>(row) - samples.first_row) * samples.width;
      for (double column = std::ceil(from); column <= to; column += 1) {
        const double z = a.z() + zx * (column + 0.5 - a.x()) + zy * (y - a.y());
        const auto depth = static_cast<float>(std::clamp(z, z_low, z_high));
        const std::size_t k = line + static_cast<std::size_t>(column);
        if (!(depth > samples.depth[k])) continue;
        samples.depth[k] = depth;
        samples.triangle[k] = static_cast<std::uint32_t>(t);
      }
    }
  }

  // Colour, light and normal of a triangle at a place of the picture in samples.
  void shade(std::uint32_t t, double x, double y, float part, bool keep, FilmPixel& pixel) const {
    const auto [a, b, c] = corners(t);
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    const double wb = std::clamp(
        ((x - a.x()) * (c.y() - a.y()) - (y - a.y()) * (c.x() - a.x())) / area, 0.0, 1.0);
    const double wc = std::clamp(
        ((b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x())) / area, 0.0, 1.0 - wb);
    const double wa = 1 - wb - wc;
    const auto& [i, j, k] = mesh_.triangles[t];
    const Vec3 point = wa * mesh_.positions[i] + wb * mesh_.positions[j] + wc * mesh_.positions[k];
    Vec3 normal;
    if (mesh_.corner_normals.empty()) {
      normal =
          (mesh_.positions[j] - mesh_.positions[i]).cross(mesh_.positions[k] - mesh_.positions[i]);
    } else {
      const auto& [l, m, n] = mesh_.corner_normals[t];
      normal = wa * mesh_.normals[l] + wb * mesh_.normals[m] + wc * mesh_.normals[n];
    }
    const double length = normal.norm();
    normal = length > 0 ? Vec3(normal / length) : camera_.toward;
    const std::uint32_t entry =
        entries_[mesh_.triangle_element.empty() ? 0 : mesh_.triangle_element[t]];
    const Vec3 turned = camera_.turned(normal);
    const Rgb color = paint_.color(entry, point, normal);
    const float light = part * light_on(turned);
    for (std::size_t s = 0; s < 3; ++s) pixel.rgb[s] += light * color[s];
    pixel.cover += part;
    if (!keep) return;
    const double side = turned.z() < 0 ? -1 : 1;
    pixel.element = entry;
    pixel.depth = static_cast<float>(camera_.toward.dot(point - camera_.centre));
    pixel.normal = {static_cast<float>(side * turned.x()), static_cast<float>(side * turned.y()),
                    static_cast<float>(side * turned.z())};
  }

  void resolve(const Samples& samples, std::size_t column, std::size_t row) const {
    const auto across = static_cast<std::size_t>(across_);
    FilmPixel& pixel = film_.at(column, row);
    const float part = 1.0F / static_cast<float>(across_ * across_);
    const std::size_t corner = (row * across - samples.first_row) * samples.width + column * across;
    std::array<std::uint32_t, 16> triangles{};
    std::size_t count = 0;
    for (std::size_t j = 0; j < across; ++j) {
      for (std::size_t i = 0; i < across; ++i) {
        const std::uint32_t t = samples.triangle[corner + j * samples.width + i];
        if (t != kNothingSeen &&
            std::find(triangles.begin(), triangles.begin() + static_cast<std::ptrdiff_t>(count),
                      t) == triangles.begin() + static_cast<std::ptrdiff_t>(count)) {
          triangles[count++] = t;
        }
      }
    }
    // Each triangle once, in the middle of its samples.
    std::size_t most = 0;
    for (std::size_t s = 0; s < count; ++s) {
      std::size_t hits = 0;
      double x = 0, y = 0;
      for (std::size_t j = 0; j < across; ++j) {
        for (std::size_t i = 0; i < across; ++i) {
          if (samples.triangle[corner + j * samples.width + i] != triangles[s]) continue;
          ++hits;
          x += static_cast<double>(column * across + i) + 0.5;
          y += static_cast<double>(row * across + j) + 0.5;
        }
      }
      const auto n = static_cast<double>(hits);
      shade(triangles[s], x / n, y / n, part * static_cast<float>(hits), hits > most, pixel);
      most = std::max(most, hits);
    }
  }

  void expose_band(std::size_t band) const {
    const auto across = static_cast<std::size_t>(across_);
    const std::size_t begin = band * kBandRows, end = std::min(begin + kBandRows, film_.height);
    Samples samples;
    samples.width = film_.width * across;
    samples.first_row = begin * across;
    samples.rows = (end - begin) * across;
    samples.depth.assign(samples.width * samples.rows, -std::numeric_limits<float>::infinity());
    samples.triangle.assign(samples.width * samples.rows, kNothingSeen);
    for (std::size_t k = start_[band]; k < start_[band + 1]; ++k) draw(of_band_[k], samples);
    for (std::size_t row = begin; row < end; ++row) {
      for (std::size_t column = 0; column < film_.width; ++column) resolve(samples, column, row);
    }
  }

  const TriangleMesh& mesh_;
  const Camera& camera_;
  const Paint& paint_;
  Film& film_;
  int across_;
  std::vector<std::uint32_t> entries_;
  std::vector<Vec3> seen_;  // positions in samples, depth in z
  std::size_t bands_ = 0;
  std::vector<std::size_t> start_;
  std::vector<std::uint32_t> of_band_;
};

}  // namespace

void film_mesh(const TriangleMesh& mesh, const Camera& camera, const Paint& paint, int threads,
               Film& film) {
  MeshFilm(mesh, camera, paint, film).expose(threads);
}

}  // namespace diesink
