// A tessellation of a scene of spheres against the counted envelope of sphere_envelope.h, in words.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "core/tessellate/tessellate.h"
#include "tests/support/element_pieces.h"
#include "tests/support/mesh_checks.h"
#include "tests/support/sphere_envelope.h"

namespace diesink::test {

inline std::string scene_element(int k) {
  return k < 0 ? "" : k == 0 ? "B" : "S" + std::to_string(k) + ".surface";
}

inline std::string scene_number(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", v);
  return text;
}

inline std::string scene_text(const SphereScene& scene, const std::string& interval = "") {
  std::string solids, expression = scene.plane ? "B" : "";
  for (std::size_t k = 0; k < scene.spheres.size(); ++k) {
    const SceneSphere& s = scene.spheres[k];
    const std::string id = "S" + std::to_string(k + 1);
    solids += id + ",SPHER,1\nP1," + scene_number(s.centre.x()) + ',' + scene_number(s.centre.y()) +
              ',' + scene_number(s.centre.z()) + "\nRAD," + scene_number(s.radius) + '\n';
    expression += (expression.empty() ? "" : "+") + id;
  }
  const std::string range = ",0," + scene_number(scene.side) + '\n';
  return "SOLID-DEF\n" + solids + (scene.plane ? "BSURF-DEF\nPLANE,0\n" : "") + "BOOLE-DEF\n" +
         expression + "\nMACHI-DEF\nX-RNG" + range + "Y-RNG" + range +
         (interval.empty() ? "" : "X-INT," + interval + "\nY-INT," + interval + '\n') +
         "TOLER,.01\n";
}

inline std::string sorted_pair(const std::array<std::string, 2>& between) {
  return std::min(between[0], between[1]) + '|' + std::max(between[0], between[1]);
}

// Faces, plan areas, curves with their lengths, corner vertices with their places.
inline void check_against_envelope(const Envelope& exact, const Tessellation& made, double size,
                                   Faults& faults) {
  const TriangleMesh& mesh = made.mesh;
  const double t = made.report.tolerance;
  const std::map<std::string, int> pieces = pieces_of(mesh);
  std::map<std::string, double> areas = plan_areas(mesh);
  std::map<std::string, int> expected;
  for (const auto& [label, count] : exact.faces) {
    if (label < 0) continue;
    const std::string name = scene_element(label);
    expected[name] = count;
    // Chords are off their arcs by the tolerance at most, two thirds of it in the mean.
    const double area = exact.area.at(label), slack = t * exact.perimeter.at(label) + 1e-9 * area;
    if (!(std::fabs(areas[name] - area) <= slack)) {
      faults.add("plan area of " + name, areas[name], area);
    }
  }
  for (const auto& [name, count] : expected) {
    const auto it = pieces.find(name);
    if (it == pieces.end() || it->second != count)
      faults.add("pieces of " + name, it == pieces.end() ? 0 : it->second, count);
  }
  for (const auto& [name, count] : pieces) {
    if (role_of(name) == ElementRole::kFace && !expected.contains(name))
      faults.add("an element that is not seen: " + name);
  }
  // Curves by kind, elements and whether they are closed; lengths in order.
  using Key = std::tuple<CurveKind, std::string, bool>;
  std::map<Key, std::vector<std::array<double, 2>>> curves;  // length, and what it may be short by
  for (const EnvelopeArc& arc : exact.arcs) {
    // A chord of sag t on a circle of radius R is short by t / 3 R of its arc. A wall's foot is no
    // circle: it may turn up to a rim within one chord.
    const double shorter = arc.kind == CurveKind::kJump ? 0.05 * arc.length + 2 * t
                                                        : 0.4 * t / arc.radius * arc.length;
    curves[{arc.kind, sorted_pair({scene_element(arc.left), scene_element(arc.right)}),
            arc.from < 0}]
        .push_back({arc.length, shorter + 1e-9 * size});
  }
  std::map<Key, std::vector<double>> told;
  for (const CurveReport& c : made.report.curves)
    told[{c.kind, sorted_pair(c.between), c.closed}].push_back(c.length);
  const auto name = [](const Key& key) {
    const char* kinds[] = {"crease ", "edge ", "jump ", "other "};
    return kinds[static_cast<int>(std::get<0>(key))] + std::get<1>(key) +
           (std::get<2>(key) ? " closed" : "");
  };
  for (auto& [key, lengths] : curves) {
    std::vector<double>& found = told[key];
    if (found.size() != lengths.size()) {
      faults.add("curves " + name(key), static_cast<double>(found.size()),
                 static_cast<double>(lengths.size()));
      continue;
    }
    std::sort(lengths.begin(), lengths.end());
    std::sort(found.begin(), found.end());
    for (std::size_t k = 0; k < found.size(); ++k) {
      if (found[k] > lengths[k][0] + 1e-9 * size || found[k] < lengths[k][0] - lengths[k][1])
        faults.add("length of " + name(key), found[k], lengths[k][0]);
    }
  }
  for (const auto& [key, lengths] : told) {
    if (!lengths.empty() && !curves.contains(key))
      faults.add("a curve that is not there: " + name(key));
  }
  // Ends of curves, each height once.
  std::vector<Vec3> places, ends;
  for (const EnvelopeVertex& v : exact.vertices) {
    for (const double z : v.heights) places.emplace_back(v.at.x(), v.at.y(), z);
  }
  for (const MeshCurve& c : mesh.curves) {
    if (c.closed) continue;
    ends.push_back(mesh.positions[c.vertices.front()]);
    ends.push_back(mesh.positions[c.vertices.back()]);
  }
  const auto unmatched = [&](const std::vector<Vec3>& of, const std::vector<Vec3>& in) {
    Tally alone;
    for (const Vec3& p : of) {
      const bool met = std::any_of(in.begin(), in.end(),
                                   [&](const Vec3& q) { return (p - q).norm() <= 1e-9 * size; });
      if (!met) alone(p);
    }
    return alone;
  };
  const Tally lost = unmatched(places, ends), more = unmatched(ends, places);
  faults.add("corners without a vertex", lost.count, lost.first);
  faults.add("ends of curves that are no corners", more.count, more.first);
  if (made.report.corner_vertices != places.size())
    faults.add("corner_vertices", static_cast<double>(made.report.corner_vertices),
               static_cast<double>(places.size()));
}

}  // namespace diesink::test
