// The curves of meshes against the equations of the language's definitions, written here anew: of
// every kind of solid with the plane, with a Ferguson base and with one another.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <set>

#include "tests/support/brute_force.h"
#include "tests/support/load_part.h"
#include "tests/support/mesh_deviation.h"

namespace diesink::test {
namespace {

// F = 0 on the face, |grad F| = 1 about there: F is a distance to first order. From the data
// statements alone.
using Face = std::function<double(const Vec3&)>;

struct Shape {
  std::string kind;
  std::string text;  // without the ID
  std::map<std::string, Face> faces;
};

std::string statement(const std::string& keyword, const Vec3& v) {
  char text[120];
  std::snprintf(text, sizeof text, "%s,%.17g,%.17g,%.17g\n", keyword.c_str(), v.x(), v.y(), v.z());
  return text;
}
std::string statement(const std::string& keyword, double v) {
  char text[60];
  std::snprintf(text, sizeof text, "%s,%.17g\n", keyword.c_str(), v);
  return text;
}

Face plane_face(const Vec3& on, const Vec3& normal) {
  const Vec3 n = normal.normalized();
  return [=](const Vec3& r) { return n.dot(r - on); };
}

// F over the length of its gradient, by central differences: independent of how F is scaled.
Face scaled(const Face& f, double size) {
  return [=](const Vec3& r) {
    Vec3 g;
    const double h = 1e-5 * size;
    for (int k = 0; k < 3; ++k) {
      Vec3 e = Vec3::Zero();
      e[k] = h;
      g[k] = (f(r + e) - f(r - e)) / (2 * h);
    }
    return f(r) / std::max(g.norm(), 1e-300);
  };
}

// The frame of a body with the axis a: v is the part of the given direction across it.
struct Axes {
  Vec3 u, v, a;
};
Axes axes_of(const Vec3& axis, const Vec3& along) {
  Axes x;
  x.a = axis.normalized();
  x.u = (along - along.dot(x.a) * x.a).normalized();
  x.v = x.a.cross(x.u);
  return x;
}

// Convex polyhedra: rings of corners, faces in the order of the language.
Shape polyhedron(const std::string& kind, const std::string& header, const std::vector<Vec3>& p,
                 const std::vector<std::vector<int>>& faces, const std::string& tail = "") {
  Shape s;
  s.kind = kind;
  s.text = header + '\n';
  for (std::size_t k = 0; k < p.size(); ++k) s.text += statement("P" + std::to_string(k + 1), p[k]);
  s.text += tail;
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const auto at = [&](std::size_t i) { return p[static_cast<std::size_t>(faces[k][i])]; };
    s.faces["face" + std::to_string(k + 1)] =
        plane_face(at(0), (at(1) - at(0)).cross(at(2) - at(0)));
  }
  return s;
}

// One of each kind about `at`, of half width r, with an axis that leans.
Shape make_shape(int which, const Vec3& at, double r, Random& random) {
  const Vec3 lean = (Vec3(0, 0, 1) + 0.7 * random.direction()).normalized();
  const double length = 1.6 * r;
  const Vec3 p1 = at - 0.5 * length * lean, p2 = at + 0.5 * length * lean;
  const Vec3 along = random.direction() + 0.3 * lean;
  const Axes x = axes_of(lean, along);
  const auto corner = [&](double u, double v, double w) {
    return Vec3(at + r * (u * x.u + v * x.v + w * x.a));
  };
  Shape s;
  const auto caps = [&](bool top) {
    s.faces["bottom"] = plane_face(p1, lean);
    if (top) s.faces["top"] = plane_face(p2, lean);
  };
  switch (which) {
    case 0:
      return polyhedron(
          "TETRA", "TETRA,1",
          {corner(-1, -.7, -.6), corner(1, -.6, -.7), corner(0, 1, -.5), corner(.1, 0, 1.1)},
          {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
    case 1:
      return polyhedron("3-PRIS", "3-PRIS,1",
                        {corner(-1, -.8, -.8), corner(1, -.8, -.8), corner(0, 1, -.8),
                         corner(-1, -.8, .8), corner(1, -.8, .8), corner(0, 1, .8)},
                        {{0, 1, 2}, {3, 4, 5}, {0, 1, 4}, {1, 2, 5}, {2, 0, 3}});
    case 2:
      return polyhedron("PYRAM", "PYRAM,1",
                        {corner(-1, -1, -.6), corner(1, -1, -.6), corner(1, 1, -.6),
                         corner(-1, 1, -.6), corner(.2, -.1, 1.2)},
                        {{0, 1, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
    case 3: {
      std::vector<Vec3> p;
      for (const double w : {-.7, .7}) {
        const double k = w < 0 ? 1 : 0.6;  // a truncated pyramid
        p.push_back(corner(-k, -k, w));
        p.push_back(corner(k, -k, w));
        p.push_back(corner(k, k, w));
        p.push_back(corner(-k, k, w));
      }
      return polyhedron("4-PRIS", "4-PRIS,1", p,
                        {{0, 1, 2}, {4, 5, 6}, {0, 1, 5}, {1, 2, 6}, {2, 3, 7}, {3, 0, 4}});
    }
    case 4:
      s.kind = "R-CONE";
      s.text = "R-CONE,1\n" + statement("P1", p1) + statement("P2", p2) + statement("RAD", r);
      // (distance from the axis) = r (1 - w / length)
      s.faces["side"] = scaled(
          [=](const Vec3& q) {
            const double w = lean.dot(q - p1);
            return (q - p1 - w * lean).norm() - r * (1 - w / length);
          },
          r);
      caps(false);
      return s;
    case 5:
      s.kind = "R-CYLI";
      s.text = "R-CYLI,2\n" + statement("P1", p1) + statement("NOR", Vec3(2.5 * lean)) +
               statement("RAD", r) + statement("LEN", length);
      s.faces["side"] = [=](const Vec3& q) { return lean.cross(q - p1).norm() - r; };
      caps(true);
      return s;
    case 6:
    case 7: {
      const bool is_cone = which == 6;
      const double b = 0.6 * r;
      s.kind = is_cone ? "E-CONE" : "E-CYLI";
      s.text = s.kind + ",1\n" + statement("P1", p1) + statement("P2", p2) +
               statement("LVE", along) + statement("L-R", r) + statement("S-R", b);
      s.faces["side"] = scaled(
          [=](const Vec3& q) {
            const double u = x.u.dot(q - p1) / r, v = x.v.dot(q - p1) / b,
                         w = is_cone ? 1 - x.a.dot(q - p1) / length : 1;
            return r * (std::hypot(u, v) - w);
          },
          r);
      caps(!is_cone);
      return s;
    }
    case 8:
      s.kind = "SPHER";
      s.text = "SPHER,1\n" + statement("P1", at) + statement("RAD", r);
      s.faces["surface"] = [=](const Vec3& q) { return (q - at).norm() - r; };
      return s;
    case 9: {
      // V1 the direction of the local y axis, V2 of the local z axis.
      const double a = 0.7 * r, b = r, c = 0.8 * r;
      const Vec3 z = lean, y = x.u, ex = y.cross(z);
      s.kind = "ELLIP";
      s.text = "ELLIP,1\n" + statement("P1", at) + statement("V1", Vec3(1.7 * y)) +
               statement("V2", z) + statement("A", a) + statement("B", b) + statement("C", c);
      s.faces["surface"] = scaled(
          [=](const Vec3& q) {
            const Vec3 d = q - at;
            return r * (Vec3(ex.dot(d) / a, y.dot(d) / b, z.dot(d) / c).norm() - 1);
          },
          r);
      return s;
    }
    default: {
      const double focal = 0.3 * r;
      s.kind = "PARAB";
      s.text = "PARAB,2\n" + statement("P1", p2) + statement("NOR", Vec3(-lean)) +
               statement("FOC", focal) + statement("LEN", length);
      s.faces["side"] = scaled(
          [=](const Vec3& q) {
            const double w = -lean.dot(q - p2);
            return ((q - p2 + w * lean).squaredNorm() - 4 * focal * w) / r;
          },
          r);
      s.faces["top"] = plane_face(p1, lean);
      return s;
    }
  }
}
constexpr int kShapes = 11;

struct Scene {
  std::string text;
  std::map<std::string, Face> faces;  // by element
};

struct CurveTally {
  double worst = 0;  // residual of the size
  std::size_t points = 0, creases = 0, closed = 0;
  std::set<std::string> pairs;
};

// What is wrong with the curves of a mesh of a scene.
std::string faults_of_curves(const Scene& scene, double tolerance, CurveTally& tally) {
  const CompoundSurface surface = surface_of(scene.text);
  TessellationOptions options;
  options.tolerance = tolerance;
  options.threads = 1;
  const Result<Tessellation> made = tessellate(surface, options);
  if (!made) return to_text(made.error());
  const TriangleMesh& mesh = made->mesh;
  Faults faults;
  const double size = surface.size();
  Tally off, sagging;
  std::size_t told = 0;
  for (const MeshCurve& curve : mesh.curves) {
    if (curve.kind == CurveKind::kCrease) {
      // Its entry of the report: creases stand in both in one order.
      while (made->report.curves[told].kind != CurveKind::kCrease) ++told;
      const CurveReport& report = made->report.curves[told++];
      double length = 0;
      const std::size_t n = curve.vertices.size();
      for (std::size_t k = 0; k + (curve.closed ? 0 : 1) < n; ++k) {
        length += (mesh.positions[curve.vertices[k]] - mesh.positions[curve.vertices[(k + 1) % n]])
                      .norm();
      }
      if (std::fabs(length - report.length) > 1e-12 * size)
        faults.add("length", report.length, length);
      if (curve.closed != report.closed) faults.add("closed is told wrongly");
      if (!curve.closed && curve.vertices.front() == curve.vertices.back())
        faults.add("an open curve that is closed");
    }
    if (curve.kind != CurveKind::kCrease) continue;
    std::array<const Face*, 2> both{};
    for (std::size_t side = 0; side < 2; ++side) {
      const auto it = scene.faces.find(mesh.elements[curve.between[side]].name);
      if (it == scene.faces.end()) {
        faults.add("no such face: " + mesh.elements[curve.between[side]].name);
        return faults.text();
      }
      both[side] = &it->second;
    }
    ++tally.creases;
    tally.closed += curve.closed ? 1 : 0;
    const std::size_t n = curve.vertices.size();
    double chords = 0, fine = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3& p = mesh.positions[curve.vertices[k]];
      for (const Face* face : both) {
        const double residual = std::fabs((*face)(p)) / size;
        tally.worst = std::max(tally.worst, residual);
        ++tally.points;
        if (!(residual <= 1e-9)) off(p);
      }
      if (k + 1 == n && !curve.closed) break;
      // Points of the true curve beside the chord: Newton's method across it.
      const Vec3& q = mesh.positions[curve.vertices[(k + 1) % n]];
      constexpr int kParts = 16;
      Vec3 last = p;
      const Vec3 e = (q - p).normalized();
      chords += (q - p).norm();
      for (int i = 1; i <= kParts; ++i) {
        Vec3 r = p + (q - p) * i / kParts;
        const Vec3 start = r;
        for (int step = 0; step < 12; ++step) {
          // Gradients by differences; moves in the plane across the chord.
          Eigen::Matrix3d m;
          Vec3 f;
          for (int row = 0; row < 2; ++row) {
            const Face& face = *both[static_cast<std::size_t>(row)];
            f[row] = face(r);
            const double h = 1e-6 * size;
            for (int c = 0; c < 3; ++c) {
              Vec3 d = Vec3::Zero();
              d[c] = h;
              m(row, c) = (face(r + d) - face(r - d)) / (2 * h);
            }
          }
          m.row(2) = e.transpose();
          f[2] = e.dot(r - start);
          const Vec3 move = m.fullPivLu().solve(f);
          if (!(move.norm() < 10 * tolerance)) break;  // all but tangent: not to be judged here
          r -= move;
          if (move.norm() < 1e-13 * size) break;
        }
        if ((r - start).norm() > tolerance * (1 + 1e-6)) sagging(start);
        fine += (r - last).norm();
        last = r;
      }
    }
    // Chords of sag s and turn d are short by no more than 2 s d / 3 each; d is below one.
    if (fine < chords - 1e-9 * size || fine > chords * 1.2)
      faults.add("length of a crease against its curve", chords, fine);
  }
  faults.add("points of creases off their faces", off.count, off.first);
  faults.add("chords farther from the curve than the tolerance", sagging.count, sagging.first);
  for (const CurveReport& c : made->report.curves) {
    if (c.kind == CurveKind::kCrease) tally.pairs.insert(c.between[0] + '|' + c.between[1]);
  }
  return faults.text();
}

void add(Scene& scene, const std::string& id, const Shape& shape) {
  scene.text += id + ',' + shape.text;
  for (const auto& [name, face] : shape.faces) scene.faces[id + '.' + name] = face;
}

std::string finish(const std::string& solids, const std::string& base,
                   const std::string& expression) {
  return "SOLID-DEF\n" + solids + "BSURF-DEF\n" + base + "BOOLE-DEF\n" + expression +
         "\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.02\n";
}

TEST(Curves, OfEveryKindWithThePlaneAndAFergusonBaseLieOnBoth) {
  CurveTally tally;
  for (int which = 0; which < kShapes; ++which) {
    for (const bool ferguson : {false, true}) {
      for (const bool subtracted : {false, true}) {
        Random random(90001 *
                      static_cast<std::uint64_t>(4 * which + 2 * ferguson + subtracted + 1));
        Scene scene;
        std::string base = "PLANE\nP1,20,20,0.5\nNOR,-0.1,0.2,1\n";
        scene.faces["B"] = plane_face(Vec3(20, 20, 0.5), Vec3(-0.1, 0.2, 1));
        if (ferguson) {
          FergusonBase grid;
          grid.columns = 4;
          grid.rows = 3;
          base = "FERGU,4,3\n";
          for (int j = 0; j < 3; ++j) {
            for (int i = 0; i < 4; ++i) {
              const Vec3 p{i * 44.0 / 3 - 2 + random.uniform(-1, 1) * (i % 3 != 0),
                           j * 22.0 - 2 + random.uniform(-1, 1) * (j == 1),
                           random.uniform(-1.5, 1.5)};
              grid.points.push_back(p);
              base += statement("P", p).substr(2);
            }
          }
          const auto plain = std::make_shared<PlainFerguson>(grid);
          scene.faces["B"] = [plain](const Vec3& r) {
            const std::optional<Vec2> uv = plain->invert(r.x(), r.y());
            return uv ? (r.z() - plain->point(uv->x(), uv->y()).z()) : 1e9;
          };
        }
        const Shape shape = make_shape(which, Vec3(20.3, 19.6, subtracted ? 2 : -1), 8, random);
        add(scene, "S", shape);
        scene.text = finish(scene.text, base, subtracted ? "B-S" : "B+S");
        EXPECT_EQ(faults_of_curves(scene, ferguson ? 0.1 : 0.02, tally), "")
            << shape.kind << ' ' << ferguson << subtracted << '\n'
            << scene.text;
      }
    }
  }
  std::printf(
      "%zu points of %zu creases (%zu closed), %zu pairs, off by %.2g of the size at most\n",
      tally.points, tally.creases, tally.closed, tally.pairs.size(), tally.worst);
  EXPECT_GE(tally.creases, 80u);
  EXPECT_GE(tally.closed, 5u);
  EXPECT_LE(tally.worst, 1e-11);
}

TEST(Curves, OfEveryTwoKindsLieOnBoth) {
  CurveTally tally;
  std::set<std::string> met;
  for (int one = 0; one < kShapes; ++one) {
    for (int other = 0; other <= one; ++other) {
      Random random(70003 * static_cast<std::uint64_t>(kShapes * one + other + 1));
      Scene scene;
      scene.faces["B"] = plane_face(Vec3::Zero(), Vec3(0, 0, 1));
      const Shape s = make_shape(one, Vec3(16, 20, 1), 8, random),
                  t = make_shape(other, Vec3(23, 21, 0), 8.5, random);
      add(scene, "S", s);
      add(scene, "T", t);
      const bool subtracted = (one + other) % 3 == 2;
      scene.text = finish(scene.text, "PLANE,0\n", subtracted ? "B+S-T" : "B+S+T");
      tally.pairs.clear();
      EXPECT_EQ(faults_of_curves(scene, 0.02, tally), "") << s.kind << ' ' << t.kind << '\n'
                                                          << scene.text;
      bool together = false;
      for (const std::string& pair : tally.pairs)
        together = together || (pair.find("S.") != pair.npos && pair.find("T.") != pair.npos);
      if (together) met.insert(s.kind + ' ' + t.kind);
    }
  }
  std::printf(
      "%zu points of %zu creases (%zu closed), %zu of %d pairs of kinds, off by %.2g of the size "
      "at most\n",
      tally.points, tally.creases, tally.closed, met.size(), kShapes * (kShapes + 1) / 2,
      tally.worst);
  EXPECT_GE(met.size(), 50u);
  EXPECT_LE(tally.worst, 1e-11);
}

}  // namespace
}  // namespace diesink::test
