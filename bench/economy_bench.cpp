// How many triangles a tolerance takes: diesink beside OpenCASCADE's mesher and beside OpenMesh's
// decimater started from a mesh ten times finer, all at one true deviation, which is measured the
// same way for all three: the distance of points of every triangle from the plane, sphere, cylinder
// or cone that it stands for, and that of crease edges from the curve in which two of those meet.
// Then a scan, thinned out by diesink and by OpenMesh's decimater (economy_scan.cpp).
// usage: economy_bench [TOLERANCE [PART]]
//        TOLERANCE   of the pockets (0.01); the other scene takes twice it
//        PART        other pockets, of make_parts.py
// Sources: none of its own.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <utility>

#include "bench/economy.h"
#include "core/compound/compound_surface.h"
#include "core/part_program/part_program.h"
#include "core/tessellate/tessellate.h"

namespace diesink::bench {

Soup ours(const Scene& scene, double tolerance, double& seconds) {
  Diagnostics diagnostics;
  const std::optional<PartProgram> program =
      parse_part_program(part_text(scene), scene.name, diagnostics);
  if (!program) {
    for (const Diagnostic& d : diagnostics.all()) std::fprintf(stderr, "%s\n", to_text(d).c_str());
    std::exit(2);
  }
  const double start = now();
  Result<CompoundSurface> surface = CompoundSurface::make(*program);
  TessellationOptions options;
  options.tolerance = tolerance;
  Result<Tessellation> made =
      surface ? tessellate(*surface, options) : Result<Tessellation>(surface.error());
  seconds = now() - start;
  if (!made) {
    std::fprintf(stderr, "%s\n", to_text(made.error()).c_str());
    std::exit(2);
  }
  return {std::move(made->mesh.positions), std::move(made->mesh.triangles)};
}

namespace {

void compare(const Scene& scene, double tolerance) {
  std::printf("%s, tolerance %g\n", scene.name.c_str(), tolerance);
  double seconds = 1e300;
  Soup soup;
  for (int run = 0; run < 3; ++run) {
    double once = 0;
    soup = ours(scene, tolerance, once);
    seconds = std::fmin(seconds, once);
  }
  const Figures own = measure(scene, soup, tolerance);
  print("diesink, from bodies to mesh", soup.triangles.size(), seconds, own);
#ifdef DIESINK_BENCH_OPENMESH
  const Soup coarse = decimated(scene, own.deviation, seconds);
  print("OpenMesh, from a mesh at a tenth", coarse.triangles.size(), seconds,
        measure(scene, coarse, tolerance));
#endif
#ifdef DIESINK_BENCH_OCCT
  compare_occt(scene, tolerance, own.deviation);
#endif
}

}  // namespace
}  // namespace diesink::bench

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const double tolerance = argc > 1 ? std::strtod(argv[1], nullptr) : 0.01;
  if (argc > 3 || !(tolerance > 0)) {
    std::fprintf(stderr, "usage: economy_bench [TOLERANCE [PART]]\n");
    return 1;
  }
  const char* part = argc > 2 ? argv[2] : DIESINK_FIXTURE_PARTS "/pockets.part";
  const diesink::bench::Scene plate = diesink::bench::pockets(part);
  if (plate.bodies.empty()) {
    std::fprintf(stderr, "economy_bench: no pockets in '%s'\n", part);
    return 1;
  }
  diesink::bench::compare(plate, tolerance);
  diesink::bench::compare(diesink::bench::like_fig6(), 2 * tolerance);
#ifdef DIESINK_BENCH_OPENMESH
  diesink::bench::compare_scan(0.5 * tolerance);
  diesink::bench::compare_scan(2 * tolerance);
#endif
  return 0;
}
