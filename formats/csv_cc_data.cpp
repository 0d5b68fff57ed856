// SPDX-License-Identifier: Apache-2.0
#include "formats/csv_cc_data.h"

#include <string>

#include "core/parallel.h"
#include "formats/json_writer.h"

namespace diesink {
namespace {

constexpr std::string_view kFields[] = {"x", "y", "z", "nx", "ny", "nz", "surface", "row", "face"};

ByteWriter& operator<<(ByteWriter& out, int number) {
  return out << static_cast<std::uint64_t>(number);
}

void csv_point(ByteWriter& out, double x, double y, const std::optional<CcDatum>& datum) {
  out << x << ',' << y << ',';
  if (!datum) {
    out << ",,,,,,";
    return;
  }
  const CcDatum& d = *datum;
  out << d.z << ',' << d.n.x() << ',' << d.n.y() << ',' << d.n.z() << ',';
  out << d.surface << ',';
  out << d.row << ',';
  out << d.face;
}

void json_point(ByteWriter& out, double x, double y, const std::optional<CcDatum>& datum) {
  out << "{\"x\":" << x << ",\"y\":" << y;
  if (!datum) {
    for (std::size_t k = 2; k < std::size(kFields); ++k) out << ",\"" << kFields[k] << "\":null";
    out << '}';
    return;
  }
  const CcDatum& d = *datum;
  out << ",\"z\":" << d.z << ",\"nx\":" << d.n.x() << ",\"ny\":" << d.n.y()
      << ",\"nz\":" << d.n.z();
  out << ",\"surface\":" << d.surface;
  out << ",\"row\":" << d.row;
  out << ",\"face\":" << d.face;
  out << '}';
}

// `{"unit":"mm","names":["B","S2",...]` without the closing brace.
std::string json_head(const CompoundSurface& surface) {
  JsonWriter head;
  head.begin_object()
      .field("unit", name_of(surface.program().unit))
      .key("names")
      .begin_array()
      .value("B");
  for (const Solid& solid : surface.program().solids) head.value(std::string_view(solid.id));
  head.end_array().end_object();
  std::string text = head.text();
  text.pop_back();
  return text;
}

// Calls put(x, y, datum) for every point of the grid.
template <class Put>
void each_point(const CompoundSurface& surface, const GridArray& grid, const Put& put) {
  std::size_t at = 0;
  for (const double y : grid.y()) {
    for (const double x : grid.x()) put(x, y, grid.at(surface, at++));
    tell_progress(static_cast<double>(at) / static_cast<double>(grid.size()));
  }
}

void json_lines(ByteWriter& out, std::string_view name, const std::vector<double>& lines) {
  out << ",\"" << name << "\":[";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i > 0) out << ',';
    out << lines[i];
  }
  out << ']';
}

void csv_header(ByteWriter& out, std::string_view suffix) {
  for (const std::string_view field : kFields) {
    if (field != kFields[0]) out << ',';
    out << field << suffix;
  }
}

}  // namespace

Status write_cc_csv(const CompoundSurface& surface, const GridArray& grid, ByteSink& sink) {
  ByteWriter out(sink);
  csv_header(out, "");
  out << '\n';
  each_point(surface, grid, [&](double x, double y, const std::optional<CcDatum>& datum) {
    csv_point(out, x, y, datum);
    out << '\n';
  });
  return out.finish();
}

Status write_cc_csv(std::span<const CcPoint> points, ByteSink& sink) {
  ByteWriter out(sink);
  csv_header(out, "");
  out << '\n';
  for (const CcPoint& p : points) {
    csv_point(out, p.x, p.y, p.datum);
    out << '\n';
  }
  return out.finish();
}

Status write_cc_json(const CompoundSurface& surface, const GridArray& grid, ByteSink& sink) {
  ByteWriter out(sink);
  out << json_head(surface);
  json_lines(out, "x", grid.x());
  json_lines(out, "y", grid.y());
  out << ",\"points\":[";
  bool first = true;
  each_point(surface, grid, [&](double x, double y, const std::optional<CcDatum>& datum) {
    out << (first ? "\n" : ",\n");
    first = false;
    json_point(out, x, y, datum);
  });
  out << "\n]}\n";
  return out.finish();
}

Status write_cc_json(const CompoundSurface& surface, std::span<const CcPoint> points,
                     ByteSink& sink) {
  ByteWriter out(sink);
  out << json_head(surface) << ",\"points\":[";
  bool first = true;
  for (const CcPoint& p : points) {
    out << (first ? "\n" : ",\n");
    first = false;
    json_point(out, p.x, p.y, p.datum);
  }
  out << "\n]}\n";
  return out.finish();
}

Status write_edges_csv(std::span<const EdgePair> edges, ByteSink& sink) {
  ByteWriter out(sink);
  out << "kind,";
  csv_header(out, "");
  out << ',';
  csv_header(out, "2");
  out << '\n';
  for (const EdgePair& e : edges) {
    out << name_of(e.kind) << ',';
    csv_point(out, e.first.x, e.first.y, e.first.datum);
    out << ',';
    csv_point(out, e.second.x, e.second.y, e.second.datum);
    out << '\n';
  }
  return out.finish();
}

Status write_edges_json(const CompoundSurface& surface, std::span<const EdgePair> edges,
                        ByteSink& sink) {
  ByteWriter out(sink);
  out << json_head(surface) << ",\"edges\":[";
  bool first = true;
  for (const EdgePair& e : edges) {
    out << (first ? "\n" : ",\n");
    first = false;
    out << "{\"kind\":\"" << name_of(e.kind) << "\",\"first\":";
    json_point(out, e.first.x, e.first.y, e.first.datum);
    out << ",\"second\":";
    json_point(out, e.second.x, e.second.y, e.second.datum);
    out << '}';
  }
  out << "\n]}\n";
  return out.finish();
}

}  // namespace diesink
