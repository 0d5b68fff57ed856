// OpenCASCADE's booleans and mesher.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <map>

#include "bench/economy.h"

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>

namespace diesink::bench {
namespace {

TopoDS_Shape shape_of(const Body& b) {
  const gp_Pnt p(b.p.x(), b.p.y(), b.p.z());
  const Vec3 d = b.q - b.p;
  switch (b.kind) {
    case Body::Kind::kSphere:
      return BRepPrimAPI_MakeSphere(p, b.radius).Shape();
    case Body::Kind::kBox:
      return BRepPrimAPI_MakeBox(p, gp_Pnt(b.q.x(), b.q.y(), b.q.z())).Shape();
    case Body::Kind::kCylinder:
      return BRepPrimAPI_MakeCylinder(gp_Ax2(p, gp_Dir(d.x(), d.y(), d.z())), b.radius, d.norm())
          .Shape();
    case Body::Kind::kCone:
      return BRepPrimAPI_MakeCone(gp_Ax2(p, gp_Dir(d.x(), d.y(), d.z())), b.radius, 0, d.norm())
          .Shape();
  }
  return {};
}

// A run of bodies of one sign at a time.
TopoDS_Shape solid_of(const Scene& scene) {
  constexpr double kDepth = 20;
  TopoDS_Shape shape =
      BRepPrimAPI_MakeBox(gp_Pnt(0, 0, -kDepth), gp_Pnt(scene.size, scene.size, 0)).Shape();
  for (const Body& b : scene.bodies) {
    shape = b.sign > 0 ? BRepAlgoAPI_Fuse(shape, shape_of(b)).Shape()
                       : BRepAlgoAPI_Cut(shape, shape_of(b)).Shape();
  }
  return shape;
}

// The faces seen from above and the walls between them; the block's own sides and floor left out.
Soup meshed(const Scene& scene, TopoDS_Shape& shape, double deflection, double& seconds) {
  BRepTools::Clean(shape);
  const double start = now();
  BRepMesh_IncrementalMesh mesher(shape, deflection, false, 0.5, true);
  seconds = now() - start;
  Soup soup;
  std::map<std::array<long long, 3>, std::uint32_t> number;  // joins the faces' own nodes
  for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next()) {
    const TopoDS_Face& face = TopoDS::Face(faces.Current());
    TopLoc_Location place;
    const Handle(Poly_Triangulation) made = BRep_Tool::Triangulation(face, place);
    if (made.IsNull()) continue;
    std::vector<std::uint32_t> of;
    for (int k = 1; k <= made->NbNodes(); ++k) {
      const gp_Pnt p = made->Node(k).Transformed(place.Transformation());
      const auto cell = [](double v) { return std::llround(v * 1e6); };
      const auto [it, fresh] = number.try_emplace({cell(p.X()), cell(p.Y()), cell(p.Z())},
                                                  static_cast<std::uint32_t>(soup.points.size()));
      if (fresh) soup.points.emplace_back(p.X(), p.Y(), p.Z());
      of.push_back(it->second);
    }
    for (int k = 1; k <= made->NbTriangles(); ++k) {
      int a = 0, b = 0, c = 0;
      made->Triangle(k).Get(a, b, c);
      const std::array<std::uint32_t, 3> t{of[static_cast<std::size_t>(a - 1)],
                                           of[static_cast<std::size_t>(b - 1)],
                                           of[static_cast<std::size_t>(c - 1)]};
      const auto all = [&](auto what) {
        return what(soup.points[t[0]]) && what(soup.points[t[1]]) && what(soup.points[t[2]]);
      };
      bool outside = all([](const Vec3& p) { return p.z() < -19.9; });
      for (int axis = 0; axis < 2; ++axis) {
        for (const double at : {0.0, scene.size})
          outside = outside || all([&](const Vec3& p) { return std::fabs(p[axis] - at) < 1e-6; });
      }
      if (!outside) soup.triangles.push_back(t);
    }
  }
  return soup;
}
}  // namespace

void compare_occt(const Scene& scene, double tolerance, double deviation) {
  double seconds = 0;
  const double start = now();
  TopoDS_Shape shape = solid_of(scene);
  std::printf("  OpenCASCADE, booleans alone: %.3f s\n", now() - start);
  Soup theirs = meshed(scene, shape, tolerance, seconds);
  Figures figures = measure(scene, theirs, 1e-5);
  print("OpenCASCADE, deflection = tolerance", theirs.triangles.size(), seconds, figures);
  // The deflection at which it deviates as far as ours.
  double lo = 0.1 * tolerance, hi = tolerance;
  for (int k = 0; k < 8; ++k) {
    const double mid = std::sqrt(lo * hi);
    theirs = meshed(scene, shape, mid, seconds);
    figures = measure(scene, theirs, 1e-5);
    (figures.deviation > deviation ? hi : lo) = mid;
  }
  theirs = meshed(scene, shape, lo, seconds);
  char what[100];
  std::snprintf(what, sizeof what, "OpenCASCADE, deflection %.5f", lo);
  print(what, theirs.triangles.size(), seconds, measure(scene, theirs, 1e-5));
}

}  // namespace diesink::bench
