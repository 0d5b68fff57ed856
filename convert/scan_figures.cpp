// SPDX-License-Identifier: Apache-2.0
#include "convert/scan_figures.h"

#include "core/compound/compound_impl.h"
#include "formats/text_number.h"

namespace diesink {

std::optional<ScanFigures> scan_figures(const CompoundSurface& surface, int threads) {
  const ScannedSurface* scan = std::get_if<ScannedSurface>(&surface.impl().base);
  if (scan == nullptr) return std::nullopt;
  const Machining& m = surface.program().machining;
  ScanFigures figures;
  figures.cover =
      scan_cover(*scan, {m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]}, threads);
  figures.fill = scan->fill();
  figures.filled = std::get<MeshBase>(surface.program().base).fill_size > 0;
  return figures;
}

void write_scan(JsonWriter& json, const ScanFigures& scan, std::optional<double> crease_offset) {
  json.key("scan")
      .begin_object()
      .field("open_area", scan.cover.open_area)
      .field("holes", scan.cover.open_loops)
      .field("layered_area", scan.cover.layered_area);
  if (crease_offset) json.field("crease_offset", *crease_offset);
  if (scan.filled) {
    json.field("filled_holes", scan.fill.holes).field("filled_area", scan.fill.area);
  }
  json.end_object();
}

std::string scan_text(const ScanFigures& scan) {
  const auto holes = [](std::size_t count) {
    return std::to_string(count) + (count == 1 ? " hole" : " holes");
  };
  std::string text = "open over an area of " + to_text(scan.cover.open_area) + " (" +
                     holes(scan.cover.open_loops) + "), more than one layer over " +
                     to_text(scan.cover.layered_area);
  if (scan.filled) {
    text += "; " + holes(scan.fill.holes) + " filled, an area of " + to_text(scan.fill.area);
  }
  return text;
}

}  // namespace diesink
