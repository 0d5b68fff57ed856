// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/mesh_report.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <unordered_map>
#include <vector>

namespace diesink {
namespace {

// Every edge in two triangles.
bool is_watertight(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return false;
  // The edges by their lower vertex: where those of each begin, then their other ends.
  std::vector<std::uint32_t> begin(mesh.positions.size() + 1, 0);
  const auto each_edge = [&](const auto& take) {
    for (const auto& t : mesh.triangles) {
      take(std::min(t[0], t[1]), std::max(t[0], t[1]));
      take(std::min(t[1], t[2]), std::max(t[1], t[2]));
      take(std::min(t[2], t[0]), std::max(t[2], t[0]));
    }
  };
  each_edge([&](std::uint32_t low, std::uint32_t) { ++begin[low]; });
  std::uint32_t sum = 0;
  for (std::uint32_t& first : begin) {
    sum += first;
    first = sum;
  }
  std::vector<std::uint32_t> other(sum);
  each_edge([&](std::uint32_t low, std::uint32_t high) { other[--begin[low]] = high; });
  for (std::size_t v = 0; v + 1 < begin.size(); ++v) {
    std::uint32_t* const first = other.data() + begin[v];
    const std::size_t count = begin[v + 1] - begin[v];
    if (count % 2 != 0) return false;
    std::sort(first, first + count);
    for (std::size_t k = 0; k < count; k += 2) {
      if (first[k] != first[k + 1] || (k + 2 < count && first[k + 1] == first[k + 2])) return false;
    }
  }
  return true;
}

}  // namespace

void fill_report(const CompoundSurface& surface, const Tessellation& tessellation, double floor,
                 TessellationReport& report) {
  const TriangleMesh& mesh = tessellation.mesh;
  report.elements.assign(mesh.elements.size(), {});
  // Of each solid: its type, and whether a row subtracts it.
  struct Kind {
    std::string type;
    int sign = 1;
  };
  std::unordered_map<std::string, Kind> kinds;
  for (const Solid& s : surface.program().solids) kinds[s.id].type = s.type;
  kinds["B"].type = "B";
  for (int row = 0; row < surface.row_count(); ++row) {
    const int k = surface.surface_of_row(row);
    const std::string id =
        k == 0 ? "B" : surface.program().solids[static_cast<std::size_t>(k - 1)].id;
    if (surface.sign_of_row(row) == Sign::kMinus) kinds[id].sign = -1;
  }
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    ElementReport& r = report.elements[e];
    r.name = mesh.elements[e].name;
    r.solid = mesh.elements[e].solid;
    const auto kind = kinds.find(r.solid);
    if (kind == kinds.end()) continue;  // skirts, the floor
    r.type = kind->second.type;
    r.sign = kind->second.sign;
  }
  report.area = report.volume = 0;
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  std::vector<char> is_floor(report.elements.size());
  for (std::size_t e = 0; e < is_floor.size(); ++e)
    is_floor[e] = report.elements[e].name == "floor";
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 &a = mesh.positions[mesh.triangles[t][0]], &b = mesh.positions[mesh.triangles[t][1]],
               &c = mesh.positions[mesh.triangles[t][2]];
    const Vec3 n = (b - a).cross(c - a);
    const double area = 0.5 * n.norm();
    const std::uint32_t e = mesh.triangle_element[t];
    ++report.elements[e].triangles;
    report.elements[e].area += area;
    report.area += area;
    if (!is_floor[e]) report.volume += 0.5 * n.z() * ((a.z() + b.z() + c.z()) / 3 - floor);
    low = low.cwiseMin(a).cwiseMin(b).cwiseMin(c);
    high = high.cwiseMax(a).cwiseMax(b).cwiseMax(c);
  }
  report.bounds = {low, high};
  report.watertight = is_watertight(mesh);
}

void add_doubts(const CompoundSurface& surface, const Arrangement& arrangement,
                const ArcSamples& samples, const std::vector<RegionMesh>& regions, double deviation,
                TessellationReport& report) {
  const auto doubt_at = [&](double x, double y, const char* what, double area) {
    if (!(area > 0)) return;
    const LineState there = surface.impl().evaluate(x, y);
    const bool hole = there.label == kNoLabel;
    report.add_doubt({x, y, hole ? 0 : there.z}, hole ? "" : surface.element_name(there.label),
                     what, area);
  };
  doubt_at(arrangement.uncertified_place.x(), arrangement.uncertified_place.y(),
           "what meets there cannot be told apart at the least distance",
           arrangement.uncertified_area);
  for (const RegionMesh& r : regions) {
    report.add_doubt(r.unproven_place, surface.element_name(r.label),
                     "the deviation could not be bounded", r.unproven_area);
  }
  if (samples.unproven_point == ArcSamples::kNone) return;
  const ArcPoint& p = samples.points[samples.unproven_point];
  doubt_at(p.x, p.y, "the deviation of a border could not be bounded",
           samples.unproven_length * 2 * deviation);
}

}  // namespace diesink
