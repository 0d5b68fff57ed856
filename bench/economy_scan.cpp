// How many triangles a scan takes at one true deviation: diesink, and OpenMesh's decimater by
// quadrics down to the fewest triangles that are off as little. Both are measured the same way:
// vertical distances at the vertices of either mesh and at points all over the triangles of both.
// (The decimater has no bound to hold it to: the number it is asked for is found by halving.)
// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "bench/economy.h"
#include "bench/economy_openmesh.h"
#include "core/base/scanned.h"
#include "core/compound/compound_surface.h"
#include "core/tessellate/tessellate.h"
#include "tests/support/height_mesh.h"

namespace diesink::bench {
namespace {

constexpr double kSize = 100;
constexpr std::uint32_t kPoints = 201;  // each way: 80000 triangles

TriangleMesh relief() {
  return test::height_mesh(0, kSize, kPoints, 0, kSize, kPoints, [](double x, double y) {
    return 8 * std::sin(x / 23) * std::cos(y / 31) + 0.1 * std::sin(3 * x + 2 * y);
  });
}

ScannedSurface surface_of(const TriangleMesh& mesh) {
  Result<ScannedSurface> made = ScannedSurface::make(mesh, {});
  if (!made) std::exit(2);
  return std::move(*made);
}

// Points of `mesh` over `other`.
double one_way(const TriangleMesh& mesh, const ScannedSurface& other) {
  constexpr int kParts = 6;
  double most = 0;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i <= kParts; ++i) {
      for (int j = 0; i + j <= kParts; ++j) {
        const Vec3 p = (i * mesh.positions[t[0]] + j * mesh.positions[t[1]] +
                        (kParts - i - j) * mesh.positions[t[2]]) /
                       kParts;
        BaseHit hit;
        if (other.at(p.x(), p.y(), hit)) most = std::fmax(most, std::fabs(hit.z - p.z()));
      }
    }
  }
  return most;
}

double deviation(const TriangleMesh& scan, const ScannedSurface& of_scan,
                 const TriangleMesh& made) {
  return std::fmax(one_way(made, of_scan), one_way(scan, surface_of(made)));
}

void tell(const char* what, std::size_t triangles, double seconds, double off) {
  std::printf("  %-44s %9zu %8.3f s  true deviation %.5f\n", what, triangles, seconds, off);
}

TriangleMesh decimate(const TriangleMesh& scan, std::size_t vertices, double& seconds) {
  Mesh mesh;
  std::vector<Mesh::VertexHandle> handle;
  for (const Vec3& p : scan.positions) handle.push_back(mesh.add_vertex({p.x(), p.y(), p.z()}));
  for (const auto& t : scan.triangles) mesh.add_face(handle[t[0]], handle[t[1]], handle[t[2]]);
  mesh.request_face_normals();
  mesh.request_vertex_status();
  mesh.request_edge_status();
  mesh.request_face_status();
  mesh.update_face_normals();
  const double start = now();
  // It knows no corners of a border.
  for (const double x : {0.0, kSize}) {
    for (const double y : {0.0, kSize}) {
      for (const auto v : mesh.vertices()) {
        if (mesh.point(v)[0] == x && mesh.point(v)[1] == y) mesh.status(v).set_locked(true);
      }
    }
  }
  OpenMesh::Decimater::DecimaterT<Mesh> decimater(mesh);
  OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
  OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle flipping;
  decimater.add(quadric);
  decimater.add(flipping);
  decimater.module(quadric).unset_max_err();
  decimater.module(flipping).set_max_normal_deviation(60);
  decimater.initialize();
  decimater.decimate_to(vertices);
  seconds = now() - start;
  TriangleMesh out;
  out.positions = scan.positions;
  out.triangles = triangles_left(mesh);
  return out;
}

}  // namespace

void compare_scan(double tolerance) {
  const TriangleMesh scan = relief();
  const ScannedSurface of_scan = surface_of(scan);
  std::printf("a scan of %zu triangles, tolerance %g\n", scan.triangles.size(), tolerance);
  PartProgram program;
  program.base = MeshBase{};
  program.machining.x_range = program.machining.y_range = {0, kSize};
  program.machining.tolerance = tolerance;
  program.boole.emplace_back();
  double start = now();
  Result<CompoundSurface> surface = CompoundSurface::make(program, scan);
  TessellationOptions options;
  options.tolerance = tolerance;
  options.threads = 1;
  Result<Tessellation> made =
      surface ? tessellate(*surface, options) : Result<Tessellation>(surface.error());
  double seconds = now() - start;
  if (!made) {
    std::fprintf(stderr, "%s\n", to_text(made.error()).c_str());
    std::exit(2);
  }
  const double own = deviation(scan, of_scan, made->mesh);
  tell("diesink, proved", made->mesh.triangles.size(), seconds, own);
  std::size_t low = 4, high = scan.positions.size();  // too few, enough
  TriangleMesh fewest = scan;
  double off = 0;
  while (high - low > high / 100 + 1) {
    const std::size_t middle = (low + high) / 2;
    double once = 0;
    TriangleMesh thinned = decimate(scan, middle, once);
    const double is = deviation(scan, of_scan, thinned);
    if (is > own) {
      low = middle;
      continue;
    }
    high = middle;
    fewest = std::move(thinned);
    off = is;
    seconds = once;
  }
  tell("OpenMesh, quadrics, as little off", fewest.triangles.size(), seconds, off);
}

}  // namespace diesink::bench
