// The table of solids and the bodies it makes.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <map>
#include <set>

#include "core/solids/frame.h"
#include "core/solids/kinds.h"
#include "core/solids/polyhedron.h"
#include "tests/support/load_part.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

// The body of a type and option from its values; lengths in x.
Result<Body> make(std::string_view type, int option, const std::vector<Vec3>& values) {
  const SolidKind* kind = find_solid_kind(type);
  EXPECT_NE(kind, nullptr) << type;
  std::vector<FieldValue> fields;
  for (const Vec3& value : values) fields.push_back({value, {}});
  const SolidOption& chosen = kind->options[static_cast<std::size_t>(option - 1)];
  EXPECT_EQ(chosen.fields.size(), fields.size());
  return chosen.make(fields);
}

Polyhedron polyhedron(std::string_view type, int option, const std::vector<Vec3>& values) {
  const Result<Body> body = make(type, option, values);
  EXPECT_TRUE(body.has_value()) << (body ? "" : body.error().message);
  return body ? std::get<Polyhedron>(*body) : Polyhedron{};
}

QuadricBody quadric(std::string_view type, int option, const std::vector<Vec3>& values) {
  const Result<Body> body = make(type, option, values);
  EXPECT_TRUE(body.has_value()) << (body ? "" : body.error().message);
  return body ? std::get<QuadricBody>(*body) : QuadricBody{};
}

Vec3 length(double value) { return {value, 0, 0}; }

const PolyhedronFace& face(const Polyhedron& body, int number) {
  for (const PolyhedronFace& f : body.faces) {
    if (f.number == number) return f;
  }
  ADD_FAILURE() << "no face" << number;
  return body.faces.front();
}

std::vector<int> numbers(const Polyhedron& body) {
  std::vector<int> all;
  for (const PolyhedronFace& f : body.faces) all.push_back(f.number);
  return all;
}

// What geometry.h promises of a polyhedron, checked by other means than those that made it.
void expect_proper(const Polyhedron& body, const std::string& what) {
  ASSERT_GE(body.faces.size(), 4u) << what;
  const std::array<Vec3, 2> box = bounds_of(Body(body));
  const double size = (box[1] - box[0]).norm();
  Vec3 inside = Vec3::Zero();
  for (const Vec3& v : body.vertices) inside += v / static_cast<double>(body.vertices.size());
  std::map<std::pair<int, int>, int> edges;
  double volume = 0;
  for (const PolyhedronFace& f : body.faces) {
    ASSERT_GE(f.loop.size(), 3u) << what;
    EXPECT_NEAR(f.plane.n.norm(), 1, 1e-15) << what;
    EXPECT_LT(f.plane.n.dot(inside) + f.plane.d, -1e-6 * size) << what << ": inward plane";
    Vec3 turn = Vec3::Zero();
    for (std::size_t k = 0; k < f.loop.size(); ++k) {
      const int a = f.loop[k], b = f.loop[(k + 1) % f.loop.size()];
      ++edges[{a, b}];
      const Vec3 ra = body.vertices[f.loop[k]] - inside,
                 rb = body.vertices[f.loop[(k + 1) % f.loop.size()]] - inside;
      turn += ra.cross(rb);
      EXPECT_NEAR(f.plane.n.dot(body.vertices[f.loop[k]]) + f.plane.d, 0, 1e-6 * size) << what;
    }
    EXPECT_GT(turn.dot(f.plane.n), 0) << what << ": clockwise loop";
    volume += -turn.norm() * (f.plane.n.dot(inside) + f.plane.d) / 6;
    for (const Vec3& v : body.vertices) {
      EXPECT_LE(f.plane.n.dot(v) + f.plane.d, 1e-6 * size) << what << ": not convex";
    }
  }
  EXPECT_GT(volume, 0);
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1) << what;
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u) << what << ": open edge";
  }
  EXPECT_EQ(body.vertices.size() + body.faces.size(), edges.size() / 2 + 2) << what << ": Euler";
}

TEST(Kinds, TableIsConsistent) {
  std::set<std::string_view> words;
  for (const SolidKind* kind : solid_kinds()) {
    EXPECT_FALSE(kind->summary.empty());
    EXPECT_EQ(find_solid_kind(kind->keyword), kind);
    EXPECT_TRUE(words.insert(kind->keyword).second);
    for (const std::string_view alias : kind->aliases) {
      EXPECT_EQ(find_solid_kind(alias), kind);
      EXPECT_TRUE(words.insert(alias).second);
    }
    int number = 0;
    for (const SolidOption& option : kind->options) {
      EXPECT_EQ(option.number, ++number);
      EXPECT_FALSE(option.meaning.empty());
      std::set<std::string_view> fields;
      for (const FieldKind& field : option.fields) {
        EXPECT_TRUE(fields.insert(field.keyword).second);
        EXPECT_NE(option.meaning.find(field.keyword.substr(0, 1)), std::string_view::npos);
      }
    }
  }
  EXPECT_EQ(solid_kinds().size(), 11u);
  EXPECT_EQ(words.size(), solid_type_words().size());
  EXPECT_EQ(find_solid_kind("TORUS"), nullptr);
}

TEST(Polyhedra, RandomOnesAreProper) {
  int seen = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const PartProgram program = test::program_of(test::random_part_program(seed));
    for (const Solid& solid : program.solids) {
      const Polyhedron* body = std::get_if<Polyhedron>(&solid.body);
      if (body == nullptr) continue;
      ++seen;
      expect_proper(*body, std::to_string(seed) + ' ' + solid.id + ' ' + std::string(solid.type));
    }
  }
  EXPECT_GT(seen, 800);
}

TEST(Polyhedra, BoxFacesAreExactAndInOrder) {
  // Opposite corners the other way round in y and z.
  const Polyhedron box = polyhedron("4-PRIS", 3, {{0.1, 0.7, 0.9}, {0.3, 0.2, -1.1}});
  expect_proper(box, "box");
  const Vec3 normals[] = {{0, 0, 1}, {0, 0, -1}, {0, 1, 0}, {1, 0, 0}, {0, -1, 0}, {-1, 0, 0}};
  const double offsets[] = {-0.9, -1.1, -0.7, -0.3, 0.2, 0.1};
  for (int k = 0; k < 6; ++k) {
    EXPECT_EQ(face(box, k + 1).plane.n, normals[k]) << k;
    EXPECT_EQ(face(box, k + 1).plane.d, offsets[k]) << k;
    for (int i = 0; i < 3; ++i)
      EXPECT_FALSE(std::signbit(face(box, k + 1).plane.n[i]) && face(box, k + 1).plane.n[i] == 0);
  }
}

TEST(Polyhedra, WallsAreExactlyVerticalAndTopsLevel) {
  // A prism on a slanted square of decimals that binary cannot hold.
  const Polyhedron prism = polyhedron(
      "4-PRIS", 2,
      {{0.1, 0.2, 0.3}, {1.3, 0.5, 0.3}, {1.0, 1.7, 0.3}, {-0.2, 1.4, 0.3}, length(0.7)});
  EXPECT_EQ(face(prism, 1).plane.n, Vec3(0, 0, -1));
  EXPECT_EQ(face(prism, 2).plane.n, Vec3(0, 0, 1));
  EXPECT_EQ(face(prism, 2).plane.d, -(0.3 + 0.7));
  for (int k = 3; k <= 6; ++k) EXPECT_EQ(face(prism, k).plane.n.z(), 0) << k;
  // A wall whose four corners all differ in plan but lie on one line: z must vanish all the same.
  const Polyhedron wedge = polyhedron(
      "3-PRIS", 1,
      {{0.1, 0.1, 0}, {1.3, 0.7, 0}, {0.5, 2.1, 0}, {0.3, 0.2, 1}, {0.9, 0.5, 1}, {0.5, 1.2, 1}});
  EXPECT_EQ(face(wedge, 3).plane.n.z(), 0);
  EXPECT_NE(face(wedge, 4).plane.n.z(), 0);
}

TEST(Polyhedra, EitherWayRoundIsTheSameBody) {
  const std::vector<Vec3> corners = {{0, 0, 0}, {4, 0, 0}, {4, 3, 0},   {0, 3, 0},
                                     {1, 1, 2}, {3, 1, 2}, {3, 2.5, 2}, {1, 2.5, 2}};
  std::vector<Vec3> other = corners;
  std::swap(other[1], other[3]);
  std::swap(other[5], other[7]);
  std::vector<Vec3> below(corners.begin() + 4, corners.end());
  below.insert(below.end(), corners.begin(), corners.begin() + 4);
  const Polyhedron a = polyhedron("4-PRIS", 1, corners), b = polyhedron("4-PRIS", 1, other),
                   c = polyhedron("4-PRIS", 1, below);
  expect_proper(a, "a");
  expect_proper(b, "b");
  expect_proper(c, "c");
  EXPECT_EQ(face(a, 1).plane.n, face(b, 1).plane.n);
  EXPECT_EQ(face(a, 1).plane.n, face(c, 2).plane.n);
  // face3 stands on P1P2: y = 0 in a, x = 0 in b.
  EXPECT_LT((face(a, 3).plane.n - face(b, 6).plane.n).norm(), 1e-15);
}

TEST(Polyhedra, DegenerateFacesAreLeftOutWithTheirNumbers) {
  // The far ring of a triangular prism in one point: a tetrahedron.
  const Vec3 apex(0.3, 0.3, 2);
  const Polyhedron tip =
      polyhedron("3-PRIS", 1, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, apex, apex, apex});
  expect_proper(tip, "tip");
  EXPECT_EQ(numbers(tip), (std::vector<int>{1, 3, 4, 5}));
  EXPECT_EQ(tip.vertices.size(), 4u);
  // A roof: the far ring is its ridge, two sides are triangles.
  const Polyhedron roof = polyhedron(
      "4-PRIS", 1,
      {{0, 0, 0}, {6, 0, 0}, {6, 4, 0}, {0, 4, 0}, {1, 2, 3}, {5, 2, 3}, {5, 2, 3}, {1, 2, 3}});
  expect_proper(roof, "roof");
  EXPECT_EQ(numbers(roof), (std::vector<int>{1, 3, 4, 5, 6}));
  EXPECT_EQ(face(roof, 3).loop.size(), 4u);
  EXPECT_EQ(face(roof, 4).loop.size(), 3u);
  // A wedge: one side collapses to the edge P1P4 = P1.
  const Polyhedron wedge =
      polyhedron("3-PRIS", 1, {{0, 0, 0}, {4, 0, 0}, {0, 3, 0}, {0, 0, 0}, {4, 0, 2}, {0, 3, 2}});
  expect_proper(wedge, "wedge");
  EXPECT_EQ(face(wedge, 3).loop.size(), 3u);
}

TEST(Polyhedra, CornersThatAllButCoincide) {
  // A doubled end of a roof's ridge: within rounding it is one vertex, off along the ridge a tiny
  // edge, off across it the ridge is no line any more.
  const auto roof = [](const Vec3& off) {
    return make("4-PRIS", 1,
                {{0, 0, 0},
                 {6, 0, 0},
                 {6, 4, 0},
                 {0, 4, 0},
                 {1, 2, 3},
                 {5, 2, 3},
                 Vec3(5, 2, 3) + off,
                 {1, 2, 3}});
  };
  for (const Vec3& direction :
       {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0.6, -0.8)}) {
    const Result<Body> rounded = roof(1e-14 * direction);
    ASSERT_TRUE(rounded);
    EXPECT_EQ(std::get<Polyhedron>(*rounded).vertices.size(), 6u);
    expect_proper(std::get<Polyhedron>(*rounded), "rounded");
  }
  EXPECT_TRUE(roof({1e-8, 0, 0}));
  EXPECT_TRUE(roof({-1e-8, 0, 0}));
  const Result<Body> sliver = roof({0, 1e-8, 0});
  ASSERT_FALSE(sliver);
  EXPECT_NE(sliver.error().message.find("face2 (P5 P8 P7 P6) is only"), std::string::npos)
      << sliver.error().message;
}

TEST(Polyhedra, HeightGoesAlongTheRightHandNormal) {
  const std::vector<Vec3> base = {{0, 0, 1}, {4, 0, 1}, {2, 6, 1}};
  const auto with = [&](double h) {
    std::vector<Vec3> values = base;
    values.push_back(length(h));
    return values;
  };
  const Polyhedron up = polyhedron("TETRA", 2, with(3)), down = polyhedron("TETRA", 2, with(-3));
  EXPECT_EQ(up.vertices.back(), Vec3(2, 2, 4));
  EXPECT_EQ(down.vertices.back(), Vec3(2, 2, -2));
  expect_proper(up, "up");
  expect_proper(down, "down");
  const Polyhedron prism = polyhedron("TPRIS", 2, {base[0], base[2], base[1], length(3)});
  EXPECT_EQ(prism.vertices[3], Vec3(0, 0, -2));
  // The mean of the corners, which for this trapezium is not its centre of area.
  const Polyhedron pyramid =
      polyhedron("PYRAM", 2, {{0, 0, 0}, {8, 0, 0}, {5, 4, 0}, {3, 4, 0}, length(5)});
  EXPECT_EQ(pyramid.vertices.back(), Vec3(4, 2, 5));
}

TEST(Polyhedra, PlanarityAndConvexityHaveTheirLimit) {
  const auto cube = [](double off, bool inward) {
    // Two corners of the top opposite each other are off its plane by `off`, or an edge is pushed
    // in.
    return make("4-PRIS", 1,
                {{0, 0, 0},
                 {1, 0, 0},
                 {1, 1, 0},
                 {0, 1, 0},
                 {0, 0, 1},
                 {1, 0, inward ? 1 : 1 + off},
                 {1, 1, 1},
                 {0, 1, inward ? 1 : 1 + off}});
  };
  EXPECT_TRUE(cube(1e-7, false));
  EXPECT_FALSE(cube(1e-5, false));
  EXPECT_TRUE(cube(0, true));
  // Coplanar neighbours are convex; a dent of a thousandth is not.
  const auto dented = [](double dent) {
    return make("3-PRIS", 1,
                {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 1}, {2, 0, 1}, {0, 2, 1 - dent}});
  };
  EXPECT_TRUE(dented(0.5));
  const Result<Body> arrow =
      make("4-PRIS", 2, {{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {0, 4, 0}, length(1)});
  ASSERT_FALSE(arrow);
  EXPECT_NE(arrow.error().message.find("not convex"), std::string::npos);
  // Every face planar and convex, and yet no convex body: the two rings cross in the line P1P3.
  const Result<Body> crossed = make("4-PRIS", 1,
                                    {{-1, 0, 0},
                                     {0, -1, 0},
                                     {1, 0, 0},
                                     {0, 1, 0},
                                     {-1, 0, 0},
                                     {0, -1, -1},
                                     {1, 0, 0},
                                     {0, 1, 1}});
  ASSERT_FALSE(crossed);
  EXPECT_NE(crossed.error().message.find("not convex: P"), std::string::npos)
      << crossed.error().message;
  const Result<Body> thin =
      make("4-PRIS", 2, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, length(1e-7)});
  ASSERT_FALSE(thin);
  EXPECT_NE(thin.error().message.find("flat"), std::string::npos);
  EXPECT_TRUE(make("4-PRIS", 2, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, length(1e-4)}));
}

// ---- quadrics ----

TEST(Frames, AlongAnAxisAreExact) {
  for (int k = 0; k < 3; ++k) {
    for (const double sign : {1.0, -1.0}) {
      for (const double scale : {1.0, 0.3, 1e-200, 1e200, 3e-320}) {
        const Vec3 axis = unit(sign * scale * Vec3::Unit(k));
        EXPECT_EQ(axis, Vec3(sign * Vec3::Unit(k)));
        const Mat3 frame = frame_about(axis);
        EXPECT_EQ(Vec3(frame.row(2)), axis);
        for (int i = 0; i < 9; ++i) {
          const double entry = frame.data()[i];
          EXPECT_TRUE(entry == 1 || entry == -1 || (entry == 0 && !std::signbit(entry)));
        }
        EXPECT_EQ(frame.determinant(), 1);
      }
    }
  }
}

TEST(Frames, AreOrthonormalAndRightHanded) {
  test::Random random(7);
  for (int round = 0; round < 2000; ++round) {
    const Vec3 axis = unit(random.direction() * random.uniform(1e-3, 1e3));
    // Now and then all but parallel to the axis.
    const Vec3 across =
        round % 3 == 0 ? Vec3(axis + 1e-7 * random.direction()) : random.direction();
    const Result<Mat3> given = frame_about(axis, across, "LVE");
    ASSERT_TRUE(given);
    for (const Mat3& frame : {frame_about(axis), *given}) {
      EXPECT_LT((frame * frame.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff(), 1e-15);
      EXPECT_NEAR(frame.determinant(), 1, 1e-15);
      EXPECT_EQ(Vec3(frame.row(2)), axis);
    }
    EXPECT_GT(across.dot(given->row(0)), 0);
    EXPECT_NEAR(across.dot(given->row(1)), 0, 1e-15);
  }
}

TEST(Quadrics, BothOptionsSayTheSame) {
  const Vec3 p(3, -2, 1), axis(1, 2, -2);  // length 3
  for (const std::string_view type : {"R-CONE", "R-CYLI"}) {
    const QuadricBody a = quadric(type, 1, {p, p + axis, length(4)});
    const QuadricBody b = quadric(type, 2, {p, 7 * axis, length(4), length(3)});
    EXPECT_EQ(a.shape, type == "R-CONE" ? QuadricShape::kCone : QuadricShape::kCylinder);
    EXPECT_EQ(b.shape, a.shape);
    EXPECT_EQ(a.p, p);
    EXPECT_LT((a.frame - b.frame).norm(), 1e-15);
    EXPECT_EQ(a.A, 4);
    EXPECT_EQ(a.B, 4);
    EXPECT_EQ(a.C, 3);
    EXPECT_EQ(b.C, 3);
  }
  for (const std::string_view type : {"E-CONE", "E-CYLI"}) {
    const Vec3 lve = Vec3(2, -1, 0) + 5 * axis;  // its part across the axis is (2,-1,0)
    const QuadricBody a = quadric(type, 1, {p, p + axis, lve, length(4), length(2)});
    const QuadricBody b = quadric(type, 2, {p, axis, lve, length(4), length(2), length(3)});
    EXPECT_LT((a.frame - b.frame).norm(), 1e-15);
    EXPECT_LT((Vec3(a.frame.row(0)) - Vec3(2, -1, 0).normalized()).norm(), 1e-14);
    EXPECT_EQ(a.A, 4);
    EXPECT_EQ(a.B, 2);
  }
  const QuadricBody sphere = quadric("SPHER", 2, {p, p + axis});
  EXPECT_EQ(sphere.A, 3);
  EXPECT_EQ(sphere.frame, Mat3(Mat3::Identity()));
  const QuadricBody rim = quadric("PARAB", 1, {p, p + axis, length(6)});
  const QuadricBody focal = quadric("PARAB", 2, {p, axis, length(3), length(3)});
  // On the rim r² = A² w: 36 = A² 3, and A² = 4 FOC.
  EXPECT_NEAR(rim.A, std::sqrt(12.0), 1e-15);
  EXPECT_NEAR(focal.A, rim.A, 1e-15);
  EXPECT_EQ(rim.C, 3);
}

TEST(Quadrics, EllipsoidAxesAreThePapers) {
  const Vec3 v2(0, 3, 4), v1 = Vec3(1, 1, -0.75) * 2 + 3 * v2;  // (1,1,-.75) is across v2
  const QuadricBody e = quadric("ELLIP", 1, {{1, 2, 3}, v1, v2, length(5), length(4), length(3)});
  EXPECT_LT((Vec3(e.frame.row(2)) - Vec3(0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_LT((Vec3(e.frame.row(1)) - Vec3(1, 1, -0.75).normalized()).norm(), 1e-14);
  const Vec3 o = e.frame.row(1), a = e.frame.row(2);
  EXPECT_LT((Vec3(e.frame.row(0)) - o.cross(a)).norm(), 1e-15);
  EXPECT_NEAR(e.frame.determinant(), 1, 1e-15);
  EXPECT_EQ(e.A, 5);
  EXPECT_EQ(e.B, 4);
  EXPECT_EQ(e.C, 3);
  const QuadricBody aligned =
      quadric("ELLIP", 1, {{0, 0, 0}, {0, 2, 0}, {0, 0, 9}, length(5), length(4), length(3)});
  EXPECT_EQ(aligned.frame, Mat3(Mat3::Identity()));
}

}  // namespace
}  // namespace diesink
