// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "core/tessellate/deviation.h"
#include "core/tessellate/section_chord.h"
#include "tests/support/face_points.h"

namespace diesink::test {
namespace {

// Newton's method with the shortest step; false where it does not settle.
bool onto(const CurvePair& curve, Vec3& r) {
  for (int k = 0; k < 40; ++k) {
    Eigen::Matrix<double, 2, 3> j;
    Vec3 g;
    const double f0 = curve.f.evaluate(r, g);
    j.row(0) = g;
    const double f1 = curve.g.evaluate(r, g);
    j.row(1) = g;
    const Eigen::Vector2d f(f0, f1);
    if (!f.allFinite()) return false;
    if (f.norm() < 1e-13 * (1 + r.norm())) return true;
    const Eigen::Matrix2d square = j * j.transpose();
    if (square.determinant() < 1e-6) return false;
    r -= j.transpose() * square.inverse() * f;
  }
  return false;
}

// The largest distance from the chord of the curve's points over even steps of it, found one by one
// from the last; negative where that fails.
double sampled(const CurvePair& curve, const Vec3& a, const Vec3& b) {
  const Vec3 e = (b - a).normalized();
  const double length = (b - a).norm();
  constexpr int kSteps = 64;
  Vec3 r = a;
  double most = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double s = length * i / kSteps;
    r += e * (length / kSteps);
    bool settled = false;
    for (int k = 0; k < 20 && !settled; ++k) {
      Mat3 j;
      Vec3 g;
      Vec3 f;
      f.x() = curve.f.evaluate(r, g);
      j.row(0) = g;
      f.y() = curve.g.evaluate(r, g);
      j.row(1) = g;
      f.z() = e.dot(r - a) - s;
      j.row(2) = e;
      if (!f.allFinite() || std::fabs(j.determinant()) < 1e-5) return -1;
      const Vec3 step = j.inverse() * f;
      r -= step;
      settled = step.norm() < 1e-13 * (1 + r.norm());
    }
    if (!settled) return -1;
    most = std::fmax(most, (r - a - e * s).norm());
  }
  return (r - b).norm() < 1e-9 * (1 + b.norm()) ? most : -1;
}

struct Named {
  Implicit f;
  std::string name;
};

std::vector<Named> sheets(const CompoundSurface& surface) {
  std::vector<Named> out;
  for (const SeenFace& face : seen_faces(surface)) {
    const std::string name = surface.element_name(face.label);
    out.push_back({face_implicit(surface.impl(), face.label), name});
    if (face.body && face.body->has_side() && face.number() == kFaceSide) {
      out.push_back({silhouette_implicit(*face.body), name + " silhouette"});
    }
  }
  return out;
}

TEST(ChordDeviation, BoundsWhatSamplingFindsAndHardlyMore) {
  int measured = 0, unproven = 0, base = 0;
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RandomProgramOptions options;
    options.solids = 23;
    options.size = 40;
    options.base = RandomBase::kFerguson;
    const CompoundSurface surface = surface_of(random_part_program(seed, options));
    const std::vector<Named> all = sheets(surface);
    Random random(31 + seed);
    for (int k = 0; k < 4000; ++k) {
      const Named& f = all[static_cast<std::size_t>(random.below(static_cast<int>(all.size())))];
      const Named& g = all[static_cast<std::size_t>(random.below(static_cast<int>(all.size())))];
      if (f.name == g.name) continue;
      const CurvePair curve{f.f, g.f};
      Vec3 a{random.uniform(0, 40), random.uniform(0, 40), random.uniform(-5, 15)};
      if (!onto(curve, a)) continue;
      const Vec3 tangent = curve.f.gradient(a).cross(curve.g.gradient(a));
      if (tangent.norm() < 0.1 || a.norm() > 200) continue;
      Vec3 b = a + tangent.normalized() * std::pow(10, random.uniform(-3, 0.5));
      if (!onto(curve, b)) continue;
      const double truth = sampled(curve, a, b);
      const double bound = chord_deviation(curve, a, b);
      const std::string what = f.name + " x " + g.name;
      if (truth < 0) continue;
      ASSERT_GE(bound, truth - 1e-12) << what << ' ' << (b - a).norm();
      const double length = (b - a).norm();
      ++measured;
      base += f.name == "B" || g.name == "B";
      // A turn of a tenth of a radian: 8 d / L.
      if (truth < 0.1 / 8 * length && truth > 1e-9) {
        if (std::isfinite(bound)) {
          ratios.push_back(bound / truth);
        } else {
          ++unproven;
        }
      }
    }
  }
  EXPECT_GT(measured, 10000);
  EXPECT_GT(base, 300);
  EXPECT_LT(unproven, static_cast<int>(ratios.size()) / 100);
  std::sort(ratios.begin(), ratios.end());
  ASSERT_GT(ratios.size(), 3000u);
  // Loose are those through an inflection or where the surfaces are nearly tangent.
  EXPECT_LT(ratios[ratios.size() / 2], 1.02);
  EXPECT_LT(ratios[ratios.size() * 9 / 10], 1.2);
}

std::string one(const std::string& solids, const std::string& boole) {
  return "SOLID-DEF\n" + solids + "BOOLE-DEF\n" + boole + "\nMACHI-DEF\nX-RNG,0,9\nY-RNG,0,9\n";
}

TEST(ChordDeviation, RimOfACylinderFarFromTheOrigin) {
  const CompoundSurface surface =
      surface_of(one("K1,R-CYLI,1\nP1,1000000,-2000000,0\nP2,1000000,-2000000,8\nRAD,5\n", "K1"));
  const CurvePair rim{face_implicit(surface.impl(), make_label(0, kFaceSide)),
                      face_implicit(surface.impl(), make_label(0, kFaceTop))};
  for (const double turn : {0.01, 0.1, 0.5}) {
    const Vec3 c(1e6, -2e6, 8);
    const Vec3 a = c + Vec3(5, 0, 0), b = c + Vec3(5 * std::cos(turn), 5 * std::sin(turn), 0);
    const double sag = 5 * (1 - std::cos(turn / 2));
    const double bound = chord_deviation(rim, a, b);
    EXPECT_GE(bound, sag);
    EXPECT_LE(bound, (1 + turn * turn) * sag + 2e-8);
  }
}

// Plane sections of convex bodies: never less than the farthest point of the arc, and not much
// more; a plane that cuts next to nothing off a long cylinder gives an ellipse with sharp ends.
TEST(SectionChord, BoundsTheArcHoweverSharp) {
  Random random(9);
  int measured = 0;
  double loosest = 0;
  for (int k = 0; k < 4000; ++k) {
    // The cylinder of radius R about z, and a plane at a distance from its axis of all but R whose
    // normal leans by a hair: an ellipse of half axes a across and a long b along.
    const double R = 2.5, depth = std::pow(10, random.uniform(-9, -0.5)),
                 lean = std::pow(10, random.uniform(-4, -0.3));
    CurvePair curve;
    curve.f.kind = Implicit::Kind::kQuadric;
    curve.f.k = Vec3(1 / (R * R), 1 / (R * R), 0);
    curve.f.m = -1;
    curve.g.n = Vec3(std::cos(lean), 0, std::sin(lean));
    curve.g.c = Vec3(R - depth, 0, 0);
    // x = R cos t, y = R sin t, z from the plane: its tip is where x = R.
    const auto at = [&](double t) {
      const double x = R * std::cos(t);
      return Vec3(x, R * std::sin(t), (R - depth - x) / std::tan(lean));
    };
    const double half = std::sqrt(2 * depth / R);
    const double t0 = half * random.uniform(-2, 2),
                 t1 = t0 + half * std::pow(10, random.uniform(-3, 0.3));
    const Vec3 a = at(t0), b = at(t1);
    const double bound = section_chord_deviation(curve, a, b);
    if (!(bound < 1e300)) continue;
    const Vec3 e = (b - a).normalized();
    double most = 0, past = 0;
    for (int i = 0; i <= 200; ++i) {
      const Vec3 r = at(t0 + (t1 - t0) * i / 200) - a;
      most = std::fmax(most, (r - e * e.dot(r)).norm());
      past = std::fmax(past, std::fmax(-e.dot(r), e.dot(r) - (b - a).norm()));
    }
    ASSERT_LE(past, 1e-12);
    ASSERT_GE(bound, most);
    ++measured;
    if (most > 0.02 * (b - a).norm()) loosest = std::fmax(loosest, bound / most);
  }
  std::printf("%d arcs, bound at most %.2f times the sag\n", measured, loosest);
  EXPECT_GT(measured, 1500);
  EXPECT_LT(loosest, 3);
}

TEST(SectionChord, IsSilentWhereTheArcTurnsBackOrIsNone) {
  const CurvePair disc = [] {
    CurvePair curve;
    curve.f.kind = Implicit::Kind::kQuadric;
    curve.f.k = Vec3(1, 1, 1);
    curve.f.m = -1;
    curve.g.n = Vec3(0, 0, 1);
    return curve;
  }();
  const auto at = [](double t) { return Vec3(std::cos(t), std::sin(t), 0); };
  EXPECT_LT(section_chord_deviation(disc, at(0), at(1.5)), 1);
  EXPECT_GT(section_chord_deviation(disc, at(0), at(3.2)), 0.95);  // the short way round
  EXPECT_EQ(section_chord_deviation(disc, at(0), Vec3(0.5, 0.5, 0)), HUGE_VAL);  // not on it
  CurvePair strip = disc;  // two lines side by side
  strip.f.k = Vec3(1, 0, 0);
  EXPECT_EQ(section_chord_deviation(strip, Vec3(-1, 0, 0), Vec3(1, 1, 0)), HUGE_VAL);
  CurvePair cone = disc;
  cone.f.k = Vec3(1, 1, -1);
  EXPECT_EQ(section_chord_deviation(cone, at(0), at(1)), HUGE_VAL);
}

TEST(ChordDeviation, RulingsAreStraightDownToTheApex) {
  const CompoundSurface surface = surface_of(one("C1,R-CONE,1\nP1,1,2,0\nP2,1,2,9\nRAD,5\n", "C1"));
  Implicit cut;  // an upright plane through the axis
  cut.c = Vec3(1, 2, 0);
  cut.n = Vec3(0, 1, 0);
  const CurvePair curve{face_implicit(surface.impl(), make_label(0, kFaceSide)), cut};
  EXPECT_LT(chord_deviation(curve, Vec3(1, 2, 9), Vec3(6, 2, 0)), 1e-13);
  // Over the apex from side to side it is no straight line, and no smooth curve either.
  EXPECT_GT(chord_deviation(curve, Vec3(0, 2, 7.2), Vec3(2, 2, 7.2)), 1.0);
}

TEST(ChordDeviation, NothingIsProvenWhereSurfacesTouch) {
  const CompoundSurface surface = surface_of(
      one("K1,R-CYLI,1\nP1,0,0,0\nP2,9,0,0\nRAD,2\nS1,SPHER,1\nP1,4,0,0\nRAD,2\n", "K1+S1"));
  const CurvePair curve{face_implicit(surface.impl(), make_label(0, kFaceSide)),
                        face_implicit(surface.impl(), make_label(1, kFaceSide))};
  EXPECT_EQ(chord_deviation(curve, Vec3(4, 0, 2), Vec3(4, 2 * std::sin(0.1), 2 * std::cos(0.1))),
            HUGE_VAL);
}

// Cylinders side by side touch along the ruling they share; beside it, or across it, nothing is.
TEST(ChordDeviation, ARulingThatTwoCylindersShareIsStraight) {
  const CompoundSurface surface = surface_of(one(
      "K1,R-CYLI,1\nP1,0,0,0\nP2,9,0,0\nRAD,2\nK2,R-CYLI,1\nP1,0,4,0\nP2,9,4,0\nRAD,2\n", "K1+K2"));
  const CurvePair curve{face_implicit(surface.impl(), make_label(0, kFaceSide)),
                        face_implicit(surface.impl(), make_label(1, kFaceSide))};
  EXPECT_LT(chord_deviation(curve, Vec3(1, 2, 0), Vec3(8, 2, 0)), 1e-14);
  EXPECT_GE(chord_deviation(curve, Vec3(1, 2, 0.01), Vec3(8, 2, 0.01)), 0.00999);
  EXPECT_EQ(chord_deviation(curve, Vec3(1, 2, 0), Vec3(1, 2, 0.1)), HUGE_VAL);
}

TEST(Implicit, ValueIsTheDistanceAndItsGradientUnit) {
  Random random(41);
  int measured = 0;
  const CompoundSurface surface = surface_of(fixture("allprims.part"));
  for (const SeenFace& face : seen_faces(surface)) {
    const Implicit f = face_implicit(surface.impl(), face.label);
    for (int k = 0; k < 20; ++k) {
      Vec3 p;
      if (!face.draw(random, p)) continue;
      ++measured;
      Vec3 n;
      EXPECT_NEAR(f.evaluate(p, n), 0, 1e-12);
      EXPECT_NEAR(n.norm(), 1, 1e-14);
      EXPECT_GT(f.value(p + 1e-3 * n), 0);
      EXPECT_NEAR(f.value(p + 1e-3 * n), 1e-3, 2e-6);
      // The form's gradient against differences of the form.
      const Vec3 q = p + 0.3 * random.direction();
      Vec3 gradient, unused;
      f.form(q, gradient);
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 h = 1e-5 * Vec3::Unit(axis);
        EXPECT_NEAR((f.form(q + h, unused) - f.form(q - h, unused)) / 2e-5, gradient[axis], 1e-8);
      }
    }
  }
  EXPECT_GT(measured, 300);
}

TEST(Implicit, SilhouettePlaneHoldsLevelNormals) {
  const CompoundSurface surface = surface_of(fixture("allprims.part"));
  Random random(42);
  for (const BodyLine& body : surface.impl().bodies) {
    if (!body.has_side()) continue;
    const Implicit side = face_implicit(body, kFaceSide), level = silhouette_implicit(body);
    for (int k = 0; k < 20; ++k) {
      const Vec3 p = 10 * random.direction() + level.c;
      Vec3 n, unused;
      side.form(p, n);
      if (level.n.norm() == 0) {
        EXPECT_EQ(level.value(p), n.z() > 0 ? 1 : n.z() < 0 ? -1 : 0);
        continue;
      }
      // The plane is where the gradient is level: both are linear.
      const Vec3 on = p - level.n * level.value(p);
      side.form(on, unused);
      EXPECT_NEAR(unused.z(), 0, 1e-12 * n.norm() + 1e-12);
      EXPECT_EQ(n.z() > 0, level.value(p) > 0);
    }
  }
}

// A sphere and a cylinder that touches it from within: their curve crosses itself in the point of
// contact, where their tangent planes are one. Chords that begin as far from it as they are long
// have a bound, how near to it they may be; the bound is no less than the curve's distance and not
// four times as much.
TEST(ChordDeviation, NearAPointOfContactChordsHaveABoundByTheConeThere) {
  CurvePair viviani;
  viviani.f.kind = viviani.g.kind = Implicit::Kind::kQuadric;
  viviani.f.k = Vec3(0.25, 0.25, 0.25);  // r = 2 about the origin
  viviani.f.m = -1;
  viviani.g.c = Vec3(1, 0, 0);
  viviani.g.k = Vec3(0.5, 0.5, 0);
  viviani.g.m = -0.5;
  const auto at = [](double t) {
    return Vec3(1 + std::cos(t), std::sin(t), 2 * std::sin(0.5 * t));
  };
  for (double t = 0.125; t > 1e-4; t *= 0.5) {
    const Vec3 a = at(t), b = at(2 * t), e = (b - a).normalized();
    double most = 0;
    for (int k = 1; k < 200; ++k) {
      const Vec3 d = at(t * (1 + k / 200.0)) - a;
      most = std::fmax(most, (d - e * e.dot(d)).norm());
    }
    const double bound = chord_deviation(viviani, a, b);
    EXPECT_GE(bound, most) << t;
    EXPECT_LE(bound, 5 * most) << t;
  }
}

}  // namespace
}  // namespace diesink::test
