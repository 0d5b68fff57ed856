// One part tessellated and held against everything that has to be true of the result.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <string>

#include "tests/support/mesh_deviation.h"

namespace diesink::test {

struct ProofOptions {
  TessellationOptions tessellation;
  int samples = 2000;
  std::uint64_t seed = 1;
  bool may_be_empty = false;  // a part whose domain meets no surface is no fault
};

// What a proof has measured beside the faults it tells.
struct ProofFigures {
  double residual = 0;     // largest distance of a curve's vertex to its faces, of the size
  double uncertified = 0;  // plan area told as such
};

// Whether the surface is surely there all over its domain.
inline bool is_everywhere(const CompoundSurface& surface) {
  const PartProgram& program = surface.program();
  return std::holds_alternative<PlaneBase>(program.base) &&
         program.boole.front().kind == BooleanStep::Kind::kTerm &&
         program.boole.front().surface == 0;
}

inline bool same_bytes(const TriangleMesh& a, const TriangleMesh& b) {
  const auto same = [](const auto& u, const auto& v) {
    return u.size() == v.size() &&
           (u.empty() || std::memcmp(u.data(), v.data(), u.size() * sizeof(u[0])) == 0);
  };
  if (!same(a.positions, b.positions) || !same(a.triangles, b.triangles) ||
      !same(a.triangle_element, b.triangle_element) || !same(a.normals, b.normals) ||
      !same(a.corner_normals, b.corner_normals) || a.curves.size() != b.curves.size() ||
      a.elements.size() != b.elements.size())
    return false;
  for (std::size_t k = 0; k < a.curves.size(); ++k) {
    if (a.curves[k].vertices != b.curves[k].vertices || a.curves[k].kind != b.curves[k].kind ||
        a.curves[k].between != b.curves[k].between || a.curves[k].closed != b.curves[k].closed)
      return false;
  }
  for (std::size_t k = 0; k < a.elements.size(); ++k) {
    if (a.elements[k].name != b.elements[k].name) return false;
  }
  return true;
}

// The faults of a mesh that is there; `made` as tessellate() gave it for these options.
inline std::string faults_of(const CompoundSurface& surface, const ProofOptions& options,
                             const Tessellation& made, ProofFigures* figures = nullptr) {
  Faults faults;
  if (figures != nullptr) figures->uncertified = made.report.uncertified_area;
  check_mesh(surface, options.tessellation, made, !is_everywhere(surface), faults);
  if (made.mesh.triangles.empty()) return faults.text();
  // The grid scheme promises its own nodes, the adaptive one the tolerance (or says how much of the
  // plan it could not certify, and then by how far).
  if (options.tessellation.scheme == MeshScheme::kAdaptive) {
    const double t = std::max(made.report.tolerance, made.report.certified_deviation);
    check_deviation(surface, made, t, options.samples, options.seed, faults);
  }
  double residual = 0;
  if (options.tessellation.scheme == MeshScheme::kAdaptive || options.tessellation.creases)
    residual = check_curves(surface, made, faults);
  if (figures != nullptr) figures->residual = residual / surface.size();
  return faults.text();
}

// Tessellates and tells the faults, one a line; empty where there is none.
inline std::string prove(const CompoundSurface& surface, const ProofOptions& options,
                         ProofFigures* figures = nullptr) {
  const Result<Tessellation> made = tessellate(surface, options.tessellation);
  if (!made) {
    const bool empty = to_text(made.error()).find("no vertical line") != std::string::npos;
    return empty && options.may_be_empty ? "" : "refused: " + to_text(made.error()) + '\n';
  }
  return faults_of(surface, options, *made, figures);
}

}  // namespace diesink::test
