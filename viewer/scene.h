// What one page of the viewer shows, and the page.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"
#include "core/tool_path.h"
#include "picture/paint.h"

namespace diesink {

struct SceneElement {
  std::string name, type;  // "S2.side", "R-CYLI"
  int sign = 1;
  Rgb color{};
  bool block = false;                           // a side or the floor under a part
  std::optional<double> certified_deviation{};  // of the part's own mesh
};

// What a cutter has left over the surface, as pixels in plan, row-major from the low corner.
struct CutMap {
  static constexpr float kNothing = -1e30F;  // no surface, or out of the cutter's reach
  static constexpr float kUncut = 1e30F;     // no move comes over it
  std::array<double, 2> corner{0, 0};        // of the first pixel
  std::array<double, 2> pixel{1, 1};         // sides
  std::size_t columns = 0, rows = 0;
  std::vector<float> height;  // along the normal, gouges negative
  double limit = 0, gouge_limit = 0;
};

// Units: `unit` throughout, z up.
// Shape: `mesh` has normals; `elements` has one entry an element of the mesh, or one at all where
//        it has none; `deviations` is empty or has one entry a triangle, NaN where none is known.
struct Scene {
  std::string title, maker;
  LengthUnit unit = LengthUnit::kUnknown;
  TriangleMesh mesh;  // without triangles where there is only a path
  std::vector<SceneElement> elements;
  double tolerance = 0;  // of the mesh from its surface; 0 where it has none
  std::optional<double> certified_deviation;
  std::vector<float> deviations;
  double deviation_scale = 0;  // at the ends of the colours, to begin with
  std::optional<ToolPath> path;
  std::optional<Cutter> cutter;
  std::optional<CutMap> cut;
  std::string_view coloring = "element";  // to begin with: element, deviation or cut
};

// The step of the page's coordinates: a power of ten, at most a hundredth of the tolerance, or
// where there is none a millionth of the extent; never under 1e-8 of the extent.
double scene_quantum(double extent, double tolerance);

// Errors: kUnsupported in a build without the viewer, with how to get it.
Status can_view();

// One HTML page with everything in it.
// Bound:  every coordinate lies within half of scene_quantum() of the scene's, and on it to the
//         bit where it is a multiple.
// Errors: as can_view(); kInput for a scene without a triangle or a
//         move; kLimit for one that is too large for a page.
Result<std::string> viewer_page_of(const Scene& scene);

}  // namespace diesink
