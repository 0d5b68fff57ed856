// SPDX-License-Identifier: Apache-2.0
#include "core/mesh_tools/weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/mesh_tools/position_hash.h"
#include "core/mesh_tools/vertex_table.h"

namespace diesink {
namespace {

constexpr std::uint32_t kNobody = 0xFFFFFFFFU;

}  // namespace

WeldMap weld_map(std::span<const Vec3> positions) {
  WeldMap map;
  map.of_vertex.resize(positions.size());
  // By slot, the vertex that came first to its place.
  std::vector<std::uint32_t> slots(std::bit_ceil(positions.size() + 1), kNobody);
  const auto slot_of = [&](const Vec3& p, std::uint64_t hash) {
    std::size_t at = static_cast<std::size_t>(hash) & (slots.size() - 1);
    while (slots[at] != kNobody && positions[slots[at]] != p) at = (at + 1) & (slots.size() - 1);
    return at;
  };
  const auto hash_at = [&](std::size_t v) { return hash_of(positions[v] + Vec3::Zero()); };
  // Many at once, which hides the memory's latency.
  constexpr std::size_t kBatch = 48;
  std::array<std::uint64_t, kBatch> hashes;
  for (std::size_t first = 0; first < positions.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, positions.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      hashes[i] = hash_at(first + i);
      __builtin_prefetch(&slots[static_cast<std::size_t>(hashes[i]) & (slots.size() - 1)]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const auto v = static_cast<std::uint32_t>(first + i);
      std::uint32_t& there = slots[slot_of(positions[v], hashes[i])];
      if (there != kNobody) {
        map.of_vertex[v] = map.of_vertex[there];
        continue;
      }
      there = v;
      map.of_vertex[v] = static_cast<std::uint32_t>(map.kept.size());
      map.kept.push_back(v);
      // At three fifths look-ups still end after two slots, most of them.
      if (5 * map.kept.size() < 3 * slots.size()) continue;
      slots.assign(2 * slots.size(), kNobody);
      for (const std::uint32_t k : map.kept) slots[slot_of(positions[k], hash_at(k))] = k;
    }
  }
  return map;
}

WeldMap weld_map(std::span<const Vec3> positions, double tolerance) {
  // Cells twice the tolerance wide: a ball of the tolerance reaches into two of them along each
  // axis.
  const double width = 2 * tolerance;
  WeldMap map;
  map.of_vertex.resize(positions.size());
  VertexTable cells(positions.size() / 2);
  std::vector<std::uint32_t> first_in_cell;  // kept vertices by cell, chained by next
  std::vector<std::uint32_t> next;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3 scaled = positions[i] / width;
    const Vec3 cell = scaled.array().floor();
    const Vec3 other =
        cell.array() +
        ((scaled - cell).array() < 0.5).select(Vec3::Constant(-1), Vec3::Ones()).array();
    std::uint32_t best = VertexTable::kAbsent;
    double best_distance = tolerance * tolerance;
    for (unsigned side = 0; side < 8; ++side) {
      const Vec3 look((side & 1U) != 0 ? other.x() : cell.x(),
                      (side & 2U) != 0 ? other.y() : cell.y(),
                      (side & 4U) != 0 ? other.z() : cell.z());
      const std::uint32_t found = cells.find(look);
      if (found == VertexTable::kAbsent) continue;
      for (std::uint32_t k = first_in_cell[found]; k != VertexTable::kAbsent; k = next[k]) {
        const double distance = (positions[map.kept[k]] - positions[i]).squaredNorm();
        if (distance < best_distance || (distance == best_distance && k < best)) {
          best = k;
          best_distance = distance;
        }
      }
    }
    if (best == VertexTable::kAbsent) {
      best = static_cast<std::uint32_t>(map.kept.size());
      map.kept.push_back(static_cast<std::uint32_t>(i));
      const std::uint32_t own = cells.add(cell);
      if (own == first_in_cell.size()) first_in_cell.push_back(VertexTable::kAbsent);
      next.push_back(first_in_cell[own]);
      first_in_cell[own] = best;
    }
    map.of_vertex[i] = best;
  }
  return map;
}

void keep_triangles(TriangleMesh& mesh, const std::vector<bool>& keep) {
  std::size_t to = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!keep[t]) continue;
    mesh.triangles[to] = mesh.triangles[t];
    if (!mesh.triangle_element.empty()) mesh.triangle_element[to] = mesh.triangle_element[t];
    if (!mesh.corner_normals.empty()) mesh.corner_normals[to] = mesh.corner_normals[t];
    ++to;
  }
  mesh.triangles.resize(to);
  if (!mesh.triangle_element.empty()) mesh.triangle_element.resize(to);
  if (!mesh.corner_normals.empty()) mesh.corner_normals.resize(to);
}

WeldReport weld(TriangleMesh& mesh, double tolerance) {
  WeldReport report;
  const WeldMap map =
      tolerance > 0 ? weld_map(mesh.positions, tolerance) : weld_map(mesh.positions);
  report.merged_vertices = mesh.positions.size() - map.kept.size();
  for (std::size_t k = 0; k < map.kept.size(); ++k) {
    mesh.positions[k] = mesh.positions[map.kept[k]];
    if (!mesh.vertex_colors.empty()) mesh.vertex_colors[k] = mesh.vertex_colors[map.kept[k]];
  }
  mesh.positions.resize(map.kept.size());
  if (!mesh.vertex_colors.empty()) mesh.vertex_colors.resize(map.kept.size());

  std::vector<bool> keep(mesh.triangles.size(), true);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    std::array<std::uint32_t, 3>& t = mesh.triangles[i];
    for (std::uint32_t& v : t) v = map.of_vertex[v];
    keep[i] = t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    if (!keep[i]) ++report.collapsed_triangles;
  }
  if (tolerance > 0 && report.collapsed_triangles > 0) keep_triangles(mesh, keep);

  for (MeshCurve& curve : mesh.curves) {
    for (std::uint32_t& v : curve.vertices) v = map.of_vertex[v];
    curve.vertices.erase(std::unique(curve.vertices.begin(), curve.vertices.end()),
                         curve.vertices.end());
    while (curve.closed && curve.vertices.size() > 1 &&
           curve.vertices.front() == curve.vertices.back()) {
      curve.vertices.pop_back();
    }
  }
  return report;
}

}  // namespace diesink
