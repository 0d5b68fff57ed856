// SPDX-License-Identifier: Apache-2.0
#include "picture/paint.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <unordered_map>

namespace diesink {
namespace {

constexpr Rgb hex(std::uint32_t code) {
  return {static_cast<float>(code >> 16 & 255) / 255.0F,
          static_cast<float>(code >> 8 & 255) / 255.0F, static_cast<float>(code & 255) / 255.0F};
}

constexpr Rgb kBaseColor = hex(0xD6CFBF), kBlockColor = hex(0xB4B7BC), kPlainColor = hex(0xAEBBC9);
constexpr Rgb kUnknownColor = hex(0xBDBDBD);  // a wall has no height to compare
constexpr std::array kHues{hex(0x5B8FD6), hex(0xE8924A), hex(0x5FAF6A), hex(0xD9646A),
                           hex(0x9678C4), hex(0xC9A227), hex(0x45B3B5), hex(0xD57FB2),
                           hex(0x8FA63C), hex(0xA4755C)};
constexpr std::array kHeightScale{hex(0x440154), hex(0x472D7B), hex(0x3B528B),
                                  hex(0x2C728E), hex(0x21918C), hex(0x28AE80),
                                  hex(0x5EC962), hex(0xADDC30), hex(0xFDE725)};
constexpr std::array kSlopeScale{hex(0xFFF7CF), hex(0xFED976), hex(0xFD8D3C), hex(0xE31A1C),
                                 hex(0x800026)};
constexpr std::array kDeviationScale{hex(0x2166AC), hex(0x67A9CF), hex(0xD1E5F0), hex(0xF7F7F7),
                                     hex(0xFDDBC7), hex(0xEF8A62), hex(0xB2182B)};

Rgb mixed(const Rgb& a, const Rgb& b, float t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

Rgb on_scale(std::span<const Rgb> scale, double t) {
  // Written so that a NaN takes the low end.
  const double at = t > 0 ? std::min(t, 1.0) * static_cast<double>(scale.size() - 1) : 0;
  const auto k = std::min(static_cast<std::size_t>(at), scale.size() - 2);
  return mixed(scale[k], scale[k + 1], static_cast<float>(at - static_cast<double>(k)));
}

// The faces of one solid keep its hue and differ in lightness.
Rgb shade_of(std::size_t solid, std::size_t face) {
  constexpr std::array<float, 4> kToWhite{0, 0.30F, 0.16F, 0.42F};
  return mixed(kHues[solid % kHues.size()], {1, 1, 1}, kToWhite[face % kToWhite.size()]);
}

Rgb wall_shade(std::size_t solid) { return mixed(kHues[solid % kHues.size()], {0, 0, 0}, 0.18F); }

}  // namespace

Palette palette_of(const CompoundSurface& surface) {
  Palette palette{{"B", kBaseColor}};
  const std::vector<Solid>& solids = surface.program().solids;
  for (std::size_t k = 0; k < solids.size(); ++k) {
    std::size_t shade = 0;
    for (const std::uint8_t number : face_numbers(solids[k].body)) {
      palette.push_back(
          {solids[k].id + "." + face_name(solids[k].body, number), shade_of(k, shade++)});
    }
    palette.push_back({solids[k].id + ".wall", wall_shade(k)});
  }
  palette.push_back({"B.wall", mixed(kBaseColor, {0, 0, 0}, 0.18F)});
  palette.push_back({"skirt", kBlockColor, false, true});
  palette.push_back({"floor", kBlockColor, false, true});
  return palette;
}

Palette palette_of(const TriangleMesh& mesh) {
  Palette palette;
  std::unordered_map<std::string, std::pair<std::size_t, std::size_t>> solids;  // place, faces
  for (const MeshElement& each : mesh.elements) {
    const std::string& solid = each.solid.empty() ? each.name : each.solid;
    auto& [place, faces] = solids.try_emplace(solid, solids.size(), 0).first->second;
    Rgb color = solid == "B" ? kBaseColor : shade_of(place, faces++);
    if (mesh.elements.size() == 1) color = kPlainColor;
    if (each.color) {
      for (std::size_t i = 0; i < 3; ++i) color[i] = static_cast<float>((*each.color)[i]) / 255.0F;
    }
    palette.push_back({each.name, color, !each.name.empty()});
  }
  if (palette.empty()) palette.push_back({"", kPlainColor, false});
  return palette;
}

std::vector<std::uint32_t> entries_of(const TriangleMesh& mesh, const Palette& palette) {
  std::unordered_map<std::string_view, std::uint32_t> place;
  for (std::uint32_t k = 0; k < palette.size(); ++k) place.try_emplace(palette[k].name, k);
  std::vector<std::uint32_t> entries;
  for (const MeshElement& each : mesh.elements) {
    const auto found = place.find(each.name);
    entries.push_back(found == place.end() ? 0 : found->second);
  }
  if (entries.empty()) entries.push_back(0);
  return entries;
}

std::vector<std::uint32_t> entries_of(const CompoundSurface& surface, const Palette& palette) {
  std::unordered_map<std::string_view, std::uint32_t> place;
  for (std::uint32_t k = 0; k < palette.size(); ++k) place.try_emplace(palette[k].name, k);
  std::vector<std::uint32_t> entries(static_cast<std::size_t>(surface.row_count()) * 16, 0);
  const std::vector<Solid>& solids = surface.program().solids;
  for (int row = 0; row < surface.row_count(); ++row) {
    const int of = surface.surface_of_row(row);
    if (of == 0) continue;
    for (const std::uint8_t face : face_numbers(solids[static_cast<std::size_t>(of - 1)].body)) {
      const Label label = make_label(row, face);
      const auto found = place.find(surface.element_name(label));
      if (found != place.end()) entries[label] = found->second;
    }
  }
  return entries;
}

Rgb scale_color(Coloring coloring, double t) {
  switch (coloring) {
    case Coloring::kSlope:
      return on_scale(kSlopeScale, t);
    case Coloring::kDeviation:
      return on_scale(kDeviationScale, t);
    case Coloring::kElement:
    case Coloring::kHeight:
      break;
  }
  return on_scale(kHeightScale, t);
}

Rgb Paint::color(std::uint32_t entry, const Vec3& point, const Vec3& normal) const {
  if ((*palette)[entry].block) return (*palette)[entry].color;
  const double span = high > low ? high - low : 1;
  switch (coloring) {
    case Coloring::kElement:
      break;
    case Coloring::kHeight:
      return scale_color(coloring, (point.z() - low) / span);
    case Coloring::kSlope: {
      const double slope = std::acos(std::min(1.0, std::abs(normal.z()))) * 180 / std::numbers::pi;
      return scale_color(coloring, (slope - low) / span);
    }
    case Coloring::kDeviation: {
      constexpr double kUpright = 1e-3;
      if (std::abs(normal.z()) < kUpright) return kUnknownColor;
      const std::optional<CcDatum> datum = surface->at(point.x(), point.y());
      if (!datum) return kUnknownColor;
      return scale_color(coloring, ((point.z() - datum->z) * datum->n.z() - low) / span);
    }
  }
  return (*palette)[entry].color;
}

float light_on(const Vec3& normal) {
  // A key light over the left shoulder, the headlight, and what comes from everywhere.
  static const Vec3 kKey = Vec3(-0.42, 0.58, 0.70).normalized();
  const double side = normal.z() < 0 ? -1 : 1;
  const double key = std::max(0.0, side * normal.dot(kKey)), head = side * normal.z();
  return static_cast<float>(0.36 + 0.20 * head + 0.50 * key);
}

}  // namespace diesink
