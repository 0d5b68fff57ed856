// How many triangles a tolerance takes: diesink beside OpenCASCADE's mesher and beside OpenMesh's
// decimater started from a mesh ten times finer, all at one true deviation, which is measured the
// same way for all three: the distance of points of every triangle from the plane, sphere, cylinder
// or cone that it stands for, and that of crease edges from the curve in which two of those meet.
// usage: economy_bench [TOLERANCE]      of the pockets; the other scene takes twice it
// Sources: none of its own.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numbers>
#include <string>
#include <unordered_map>
#include <vector>

#include <Eigen/Geometry>

#include "bench/bench_parts.h"
#include "core/tessellate/tessellate.h"

#ifdef DIESINK_BENCH_OPENMESH
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#endif
#ifdef DIESINK_BENCH_OCCT
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
#endif

namespace diesink::bench {
namespace {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// ---- scenes ----

struct Body {
  enum class Kind { kSphere, kCylinder, kCone, kBox } kind;
  int sign;
  Vec3 p, q;  // centre; ends of the axis, a cone's apex last; corners of a box
  double radius;
};

struct Scene {
  std::string name;
  double size = 0;  // of the plate, from 0
  std::vector<Body> bodies;
};

std::string part_text(const Scene& scene) {
  std::string text = "SOLID-DEF\n", terms = "B";
  char line[200];
  int k = 0;
  for (const Body& b : scene.bodies) {
    const std::string id = "S" + std::to_string(++k);
    const auto point = [&](int n, double x, double y, double z) {
      std::snprintf(line, sizeof line, "P%d,%.17g,%.17g,%.17g\n", n, x, y, z);
      text += line;
    };
    const auto value = [&](const char* word, double v) {
      std::snprintf(line, sizeof line, "%s,%.17g\n", word, v);
      text += line;
    };
    switch (b.kind) {
      case Body::Kind::kSphere:
        text += id + ",SPHER,1\n";
        point(1, b.p.x(), b.p.y(), b.p.z());
        value("RAD", b.radius);
        break;
      case Body::Kind::kCylinder:
      case Body::Kind::kCone:
        text += id + (b.kind == Body::Kind::kCone ? ",R-CONE,1\n" : ",R-CYLI,1\n");
        point(1, b.p.x(), b.p.y(), b.p.z());
        point(2, b.q.x(), b.q.y(), b.q.z());
        value("RAD", b.radius);
        break;
      case Body::Kind::kBox:
        text += id + ",4-PRIS,1\n";
        for (int level = 0; level < 2; ++level) {
          const double z = level == 0 ? b.q.z() : b.p.z();
          point(4 * level + 1, b.p.x(), b.p.y(), z);
          point(4 * level + 2, b.q.x(), b.p.y(), z);
          point(4 * level + 3, b.q.x(), b.q.y(), z);
          point(4 * level + 4, b.p.x(), b.q.y(), z);
        }
        break;
    }
    terms += (b.sign > 0 ? "+" : "-") + id;
    if (k % 8 == 0) terms += "\n";
  }
  std::snprintf(line, sizeof line, "MACHI-DEF\nX-RNG,0,%g\nY-RNG,0,%g\nTOLER,.02\n", scene.size,
                scene.size);
  return text + "BSURF-DEF\nPLANE,0\nBOOLE-DEF\n" + terms + "\n" + line;
}

// The bodies of fixtures/parts/pockets.part.
Scene pockets() {
  Scene scene{"50 pockets and 50 bosses", 200, {}};
  std::ifstream file(DIESINK_FIXTURE_PARTS "/pockets.part");
  std::map<std::string, std::array<double, 3>> data;
  const auto finish = [&](const std::string& type) {
    if (type.empty()) return;
    const auto vec = [&](const char* word) {
      return Vec3(data[word][0], data[word][1], data[word][2]);
    };
    Body b{Body::Kind::kSphere, -1, vec("P1"), vec("P2"), data["RAD"][0]};
    if (type != "SPHER") {
      b.sign = 1;
      b.kind = type == "R-CONE" ? Body::Kind::kCone : Body::Kind::kCylinder;
      if (type == "R-CYLI") b.q = b.p + Vec3(0, 0, data["LEN"][0]);
    }
    scene.bodies.push_back(b);
  };
  std::string line, type;
  while (std::getline(file, line) && line != "BSURF-DEF") {
    std::vector<std::string> words;
    for (std::size_t at = 0; at <= line.size();) {
      const std::size_t comma = std::min(line.find(',', at), line.size());
      words.push_back(line.substr(at, comma - at));
      at = comma + 1;
    }
    if (words.size() == 3 && !words[1].empty() && std::isalpha(words[1][0])) {
      finish(type);
      type = words[1];
    } else if (words.size() > 1) {
      for (std::size_t k = 1; k < words.size() && k < 4; ++k)
        data[words[0]][k - 1] = std::strtod(words[k].c_str(), nullptr);
    }
  }
  finish(type);
  return scene;
}

// Fig. 6 of the paper with a level base and upright cone.
Scene like_fig6() {
  using K = Body::Kind;
  return {"as Fig. 6, on a plane",
          40,
          {{K::kCylinder, 1, {20, 20, -1}, {20, 20, 5}, 15},
           {K::kSphere, 1, {20, 20, 0}, {0, 0, 0}, 12},
           {K::kBox, 1, {15, 2, -1}, {25, 13, 7}, 0},
           {K::kBox, -1, {15, 28, 1}, {25, 35.5, 9}, 0},
           {K::kCone, 1, {20, 20, 8}, {20, 20, 16}, 7}}};
}

// ---- true deviation ----

// A whole plane, sphere, cylinder or cone.
struct Carrier {
  enum class Kind { kPlane, kSphere, kCylinder, kCone } kind;
  Vec3 c, axis;                             // point or centre or apex; unit normal or axis
  double radius = 0, sine = 0, cosine = 1;  // cone: of half its opening
  Eigen::AlignedBox3d box;                  // where it can matter

  [[nodiscard]] double distance(const Vec3& p) const {  // signed
    const Vec3 r = p - c;
    switch (kind) {
      case Kind::kPlane:
        return r.dot(axis);
      case Kind::kSphere:
        return r.norm() - radius;
      case Kind::kCylinder:
        return (r - axis * r.dot(axis)).norm() - radius;
      case Kind::kCone: {
        const double along = r.dot(axis), across = (r - axis * along).norm();
        return across * cosine - along * sine;
      }
    }
    return 0;
  }
  [[nodiscard]] Vec3 normal(const Vec3& p) const {
    const double h = 1e-6;
    Vec3 n;
    for (int k = 0; k < 3; ++k)
      n[k] = distance(p + h * Vec3::Unit(k)) - distance(p - h * Vec3::Unit(k));
    return n.normalized();
  }
};

[[nodiscard]] std::vector<Carrier> carriers_of(const Scene& scene) {
  std::vector<Carrier> all;
  const Vec3 margin = Vec3::Constant(0.5);
  const auto plane = [&](const Vec3& at, const Vec3& n, const Eigen::AlignedBox3d& box) {
    all.push_back({Carrier::Kind::kPlane, at, n, 0, 0, 1, box});
  };
  plane(Vec3::Zero(), Vec3::UnitZ(), {Vec3(-1, -1, -1), Vec3(scene.size + 1, scene.size + 1, 1)});
  for (const Body& b : scene.bodies) {
    Eigen::AlignedBox3d box(b.p);
    if (b.kind != Body::Kind::kSphere) box.extend(b.q);
    if (b.kind != Body::Kind::kBox) {
      box.min() -= Vec3::Constant(b.radius);
      box.max() += Vec3::Constant(b.radius);
    }
    box.min() -= margin;
    box.max() += margin;
    const Vec3 axis =
        b.kind == Body::Kind::kSphere ? Vec3(0, 0, 1) : Vec3((b.p - b.q).normalized());
    switch (b.kind) {
      case Body::Kind::kSphere:
        all.push_back({Carrier::Kind::kSphere, b.p, axis, b.radius, 0, 1, box});
        break;
      case Body::Kind::kCylinder:
        all.push_back({Carrier::Kind::kCylinder, b.p, axis, b.radius, 0, 1, box});
        plane(b.q, axis, box);
        break;
      case Body::Kind::kCone: {
        const double slant = std::hypot(b.radius, (b.p - b.q).norm());
        all.push_back({Carrier::Kind::kCone, b.q, axis, 0, b.radius / slant,
                       (b.p - b.q).norm() / slant, box});
        break;
      }
      case Body::Kind::kBox:
        for (int k = 0; k < 3; ++k) {
          plane(b.p, Vec3::Unit(k), box);
          plane(b.q, Vec3::Unit(k), box);
        }
        break;
    }
  }
  return all;
}

struct Soup {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

double triangle_error(const Carrier& on, const Vec3& a, const Vec3& b, const Vec3& c) {
  constexpr int kParts = 6;
  double most = 0;
  for (int i = 0; i <= kParts; ++i) {
    for (int j = 0; i + j <= kParts; ++j) {
      const Vec3 p = (i * a + j * b + (kParts - i - j) * c) / kParts;
      most = std::fmax(most, std::fabs(on.distance(p)));
    }
  }
  return most;
}

// Of the middle of a chord from the curve in which two surfaces meet, to first order.
double chord_error(const Carrier& f, const Carrier& g, const Vec3& a, const Vec3& b) {
  const Vec3 m = 0.5 * (a + b);
  const double cosine = f.normal(m).dot(g.normal(m));
  const double square = 1 - cosine * cosine;
  if (square < 0.01) return 0;
  const double df = f.distance(m), dg = g.distance(m);
  return std::sqrt((df * df + dg * dg - 2 * df * dg * cosine) / square);
}

// Finds the surfaces that points lie on; `near` far off.
class Surfaces {
 public:
  Surfaces(const Scene& scene, double near) : all_(carriers_of(scene)), near_(near) {}
  void at(const Vec3& p, std::vector<std::uint32_t>& out) const {
    out.clear();
    for (std::uint32_t k = 0; k < all_.size(); ++k) {
      if (all_[k].box.contains(p) && std::fabs(all_[k].distance(p)) <= near_) out.push_back(k);
    }
  }
  [[nodiscard]] const Carrier& operator[](std::uint32_t k) const { return all_[k]; }

 private:
  std::vector<Carrier> all_;
  double near_;
};

struct Figures {
  double deviation = 0;
  std::array<double, 3> angles{};  // quantiles 0.01, 0.05, 0.5 of the least angle, degrees
  std::size_t stray = 0;           // triangles on none of the surfaces
};

Figures measure(const Scene& scene, const Soup& soup, double near) {
  const Surfaces surfaces(scene, near);
  std::vector<std::vector<std::uint32_t>> of(soup.points.size());
  for (std::size_t v = 0; v < soup.points.size(); ++v) surfaces.at(soup.points[v], of[v]);
  Figures out;
  std::vector<double> least;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> side;
  for (const auto& t : soup.triangles) {
    const Vec3 &a = soup.points[t[0]], &b = soup.points[t[1]], &c = soup.points[t[2]];
    double best = 1e300;
    std::uint32_t on = 0;
    for (const std::uint32_t k : of[t[0]]) {
      if (std::count(of[t[1]].begin(), of[t[1]].end(), k) == 0 ||
          std::count(of[t[2]].begin(), of[t[2]].end(), k) == 0)
        continue;
      const double e = triangle_error(surfaces[k], a, b, c);
      if (e < best) best = e, on = k;
    }
    if (best == 1e300) {
      ++out.stray;
      continue;
    }
    out.deviation = std::fmax(out.deviation, best);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t p = t[k], q = t[(k + 1) % 3];
      const auto [it, fresh] = side.try_emplace({std::min(p, q), std::max(p, q)}, on);
      if (!fresh && it->second != on) {
        out.deviation = std::fmax(out.deviation, chord_error(surfaces[on], surfaces[it->second],
                                                             soup.points[p], soup.points[q]));
      }
    }
    const std::array<double, 3> l{(b - c).norm(), (c - a).norm(), (a - b).norm()};
    const double sine =
        (b - a).cross(c - a).norm() * std::min({l[0], l[1], l[2]}) / (l[0] * l[1] * l[2]);
    least.push_back(std::asin(std::clamp(sine, 0.0, 1.0)) * 180 / std::numbers::pi);
  }
  std::sort(least.begin(), least.end());
  const double at[] = {0.01, 0.05, 0.5};
  for (std::size_t k = 0; k < 3 && !least.empty(); ++k) {
    out.angles[k] = least[static_cast<std::size_t>(at[k] * static_cast<double>(least.size() - 1))];
  }
  return out;
}

void print(const char* what, std::size_t triangles, double seconds, const Figures& f) {
  std::printf("  %-44s %9zu %8.3f s  true deviation %.5f  least angles %5.1f %5.1f %5.1f", what,
              triangles, seconds, f.deviation, f.angles[0], f.angles[1], f.angles[2]);
  if (f.stray > 0) std::printf("  (%zu triangles on no surface)", f.stray);
  std::printf("\n");
}

// ---- the three ----

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

#ifdef DIESINK_BENCH_OPENMESH
struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;

// Refuses a collapse that makes a triangle or crease edge deviate by more than the tolerance.
template <class M>
class KeepsTolerance : public OpenMesh::Decimater::ModBaseT<M> {
 public:
  DECIMATING_MODULE(KeepsTolerance, M, KeepsTolerance);
  explicit KeepsTolerance(M& mesh) : Base(mesh, true) {}
  void set(const Surfaces* surfaces, const std::vector<std::vector<std::uint32_t>>* of,
           double tolerance) {
    surfaces_ = surfaces;
    of_ = of;
    tolerance_ = tolerance;
  }
  float collapse_priority(const CollapseInfo& ci) override {
    const auto index = [](auto handle) { return static_cast<std::uint32_t>(handle.idx()); };
    const auto point = [&](auto handle) {
      const auto& p = Base::mesh().point(handle);
      return Vec3(p[0], p[1], p[2]);
    };
    const std::uint32_t to = index(ci.v1);
    // A crease stays one, a corner stays.
    for (const std::uint32_t k : (*of_)[index(ci.v0)]) {
      if (!has(to, k)) return float(Base::ILLEGAL_COLLAPSE);
    }
    for (auto f = Base::mesh().cvf_iter(ci.v0); f.is_valid(); ++f) {
      if (*f == ci.fl || *f == ci.fr) continue;
      std::array<typename M::VertexHandle, 3> v;
      std::size_t n = 0;
      for (auto fv = Base::mesh().cfv_iter(*f); fv.is_valid(); ++fv)
        v[n++] = *fv == ci.v0 ? ci.v1 : *fv;
      double best = 1e300;
      for (const std::uint32_t k : (*of_)[index(v[0])]) {
        if (has(index(v[1]), k) && has(index(v[2]), k)) {
          best = std::fmin(best,
                           triangle_error((*surfaces_)[k], point(v[0]), point(v[1]), point(v[2])));
        }
      }
      if (best > tolerance_) return float(Base::ILLEGAL_COLLAPSE);
      for (std::size_t e = 0; e < 3; ++e) {
        const auto p = v[e], q = v[(e + 1) % 3];
        if (p != ci.v1 && q != ci.v1) continue;
        std::array<std::uint32_t, 2> both{};
        std::size_t common = 0;
        for (const std::uint32_t k : (*of_)[index(p)]) {
          if (has(index(q), k) && common < 2) both[common++] = k;
        }
        if (common == 2 && (*of_)[index(ci.v0)].size() > 1 &&
            chord_error((*surfaces_)[both[0]], (*surfaces_)[both[1]], point(p), point(q)) >
                tolerance_)
          return float(Base::ILLEGAL_COLLAPSE);
      }
    }
    return float(Base::LEGAL_COLLAPSE);
  }

 private:
  [[nodiscard]] bool has(std::uint32_t v, std::uint32_t k) const {
    return std::count((*of_)[v].begin(), (*of_)[v].end(), k) > 0;
  }
  const Surfaces* surfaces_ = nullptr;
  const std::vector<std::vector<std::uint32_t>>* of_ = nullptr;
  double tolerance_ = 0;
};

Soup decimated(const Scene& scene, double tolerance, double& seconds) {
  const Soup fine = ours(scene, 0.1 * tolerance, seconds);
  const double start = now();
  Mesh mesh;
  std::vector<Mesh::VertexHandle> handle;
  const Surfaces surfaces(scene, 0.1 * tolerance);
  std::vector<std::vector<std::uint32_t>> of(fine.points.size());
  for (std::size_t v = 0; v < fine.points.size(); ++v) {
    const Vec3& p = fine.points[v];
    handle.push_back(mesh.add_vertex({p.x(), p.y(), p.z()}));
    surfaces.at(p, of[v]);
  }
  for (const auto& t : fine.triangles) mesh.add_face(handle[t[0]], handle[t[1]], handle[t[2]]);
  mesh.request_face_normals();
  mesh.request_vertex_status();
  mesh.request_edge_status();
  mesh.request_face_status();
  mesh.update_face_normals();
  {
    OpenMesh::Decimater::DecimaterT<Mesh> decimater(mesh);
    OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
    OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle flipping;
    KeepsTolerance<Mesh>::Handle keeps;
    decimater.add(quadric);
    decimater.add(flipping);
    decimater.add(keeps);
    decimater.module(flipping).set_max_normal_deviation(30);
    decimater.module(keeps).set(&surfaces, &of, tolerance);
    decimater.initialize();
    decimater.decimate();
  }
  seconds = now() - start;
  Soup soup{fine.points, {}};
  for (const auto f : mesh.faces()) {
    if (f.deleted()) continue;
    std::array<std::uint32_t, 3> t{};
    std::size_t n = 0;
    for (auto fv = mesh.cfv_iter(f); fv.is_valid(); ++fv)
      t[n++] = static_cast<std::uint32_t>(fv->idx());
    soup.triangles.push_back(t);
  }
  return soup;
}
#endif

#ifdef DIESINK_BENCH_OCCT
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
#endif

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
    (figures.deviation > own.deviation ? hi : lo) = mid;
  }
  theirs = meshed(scene, shape, lo, seconds);
  char what[100];
  std::snprintf(what, sizeof what, "OpenCASCADE, deflection %.5f", lo);
  print(what, theirs.triangles.size(), seconds, measure(scene, theirs, 1e-5));
#endif
}

}  // namespace
}  // namespace diesink::bench

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const double tolerance = argc > 1 ? std::strtod(argv[1], nullptr) : 0.01;
  if (argc > 2 || !(tolerance > 0)) {
    std::fprintf(stderr, "usage: economy_bench [TOLERANCE]\n");
    return 1;
  }
  diesink::bench::compare(diesink::bench::pockets(), tolerance);
  diesink::bench::compare(diesink::bench::like_fig6(), 2 * tolerance);
  return 0;
}
