// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/chart.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/tessellate/deviation.h"
#include "tests/support/face_points.h"

namespace diesink::test {
namespace {

constexpr double kPi = std::numbers::pi;

// One of each quadric at a point, twice: upright and leaning; added and then cut.
std::string bodies(const std::string& at, double a, double b, double c) {
  const std::string sa = std::to_string(a), sb = std::to_string(b), sc = std::to_string(c);
  std::string text = "SOLID-DEF\n", terms;
  for (const std::string turn : {"0", "1"}) {
    const std::string pose = "\nP1," + at + "\nNOR," + turn + ",0.4,1\n";
    const std::string lean = turn == "0" ? "\nP1," + at + "\nNOR,0,0,1\n" : pose;
    const std::string axes = "LVE,1,2,0.3\nL-R," + sa + "\nS-R," + sb + "\nLEN," + sc + "\n";
    text += "E" + turn + ",E-CONE,2" + lean + axes;
    text += "F" + turn + ",E-CYLI,2" + pose + axes;
    text += "C" + turn + ",R-CONE,2" + lean + "RAD," + sb + "\nLEN," + sc + "\n";
    text += "K" + turn + ",R-CYLI,2" + pose + "RAD," + sb + "\nLEN," + sc + "\n";
    text += "M" + turn + ",PARAB,2" + (turn == "0" ? "\nP1," + at + "\nNOR,0,0,-1\n" : pose) +
            "FOC," + std::to_string(b * b / (4 * c)) + "\nLEN," + sc + "\n";
    text += "L" + turn + ",ELLIP,1\nP1," + at + "\nV1,1," + turn + ",0.2\nV2," + turn +
            ",0.3,1\nA," + sa + "\nB," + sb + "\nC," + sc + "\n";
    for (const char* id : {"E", "F", "C", "K", "M", "L"}) terms += "+" + (id + turn);
  }
  std::string cuts = terms;
  for (char& c1 : cuts) c1 = c1 == '+' ? '-' : c1;
  return text + "BOOLE-DEF\n" + terms.substr(1) + cuts + "\nMACHI-DEF\nX-RNG,0,9\nY-RNG,0,9\n";
}

std::vector<std::string> programs() {
  std::vector<std::string> texts{fixture("allprims.part"), fixture("fig6.part")};
  RandomProgramOptions options;
  options.solids = 23;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    options.base = seed % 2 ? RandomBase::kFerguson : RandomBase::kPlane;
    texts.push_back(random_part_program(seed, options));
  }
  // The same bodies cut instead of added, and bodies far from the origin.
  std::string cut = fixture("allprims.part");
  for (std::size_t at = cut.find("BOOLE-DEF"); at < cut.find("MACHI-DEF"); ++at) {
    if (cut[at] == '+') cut[at] = '-';
  }
  texts.push_back(cut);
  texts.push_back(bodies("1000000,-3000000,500000", 5, 3, 8));
  return texts;
}

bool is_side(const SeenFace& face) {
  return face.body && face.body->has_side() && face.number() == kFaceSide;
}

TEST(FaceChart, ThereAndBackOnEveryFace) {
  int points = 0, faces = 0;
  for (const std::string& text : programs()) {
    const CompoundSurface surface = surface_of(text);
    Random random(21);
    for (const SeenFace& face : seen_faces(surface)) {
      const FaceChart chart(surface.impl(), face.label);
      const std::string what = surface.element_name(face.label);
      ++faces;
      for (int k = 0; k < 60; ++k) {
        Vec3 p, back;
        if (!face.draw(random, p)) continue;
        ++points;
        const Vec2 c = chart.to_chart(p);
        ASSERT_TRUE(c.allFinite()) << what;
        const Vec3 n = chart.normal(p);
        EXPECT_NEAR(n.norm(), 1, 1e-12);
        ASSERT_TRUE(chart.from_chart(c, back)) << what << n.transpose();
        const double allowed = 1e-13 * surface.size();
        ASSERT_LT((back - p).norm(), 10 * allowed) << what;
        // Exactly on the surface, by the definition of the body.
        if (is_side(face)) {
          // About the body's own place: a matrix for program coordinates far from the origin
          // would itself be rounded too coarsely.
          QuadricBody body = std::get<QuadricBody>(face.body->body());
          const Vec3 on = back - body.p;
          body.p.setZero();
          EXPECT_LT((nearest_on(side_matrix(body), on) - on).norm(), 5 * allowed) << what;
        }
        const Vec2 again = chart.to_chart(back);
        EXPECT_LT((again - c).norm(), 1e-12 * surface.size()) << what;
        if (n.z() > 1e-3) {
          EXPECT_LT((n - surface.impl().normal(face.label, p)).norm(), 1e-9) << what;
        }
      }
    }
  }
  EXPECT_GT(faces, 200);
  EXPECT_GT(points, 5000);
}

TEST(FaceChart, KeepsTheTurnOfThePlan) {
  for (const std::string& text : programs()) {
    const CompoundSurface surface = surface_of(text);
    Random random(22);
    for (const SeenFace& face : seen_faces(surface)) {
      const FaceChart chart(surface.impl(), face.label);
      for (int k = 0; k < 20; ++k) {
        Vec3 p;
        if (!face.draw(random, p) || chart.normal(p).z() < 0.05) continue;
        Vec3 x = p + Vec3(1e-5, 0, 0), y = p + Vec3(0, 1e-5, 0);
        if (!face.height(x.x(), x.y(), x.z()) || !face.height(y.x(), y.y(), y.z())) continue;
        const Vec2 c = chart.to_chart(p);
        const Vec2 dx = chart.to_chart(x) - c, dy = chart.to_chart(y) - c;
        EXPECT_GT(dx.x() * dy.y() - dx.y() * dy.x(), 0) << surface.element_name(face.label);
      }
    }
  }
}

// From a drawn point outward in plan until the side ends: the last point, on the silhouette to
// rounding. False where the plane of a cap comes first or there is no silhouette.
bool silhouette_point(Random& random, const SeenFace& face, Vec3& inside, Vec3& rim) {
  if (!face.draw(random, inside)) return false;
  const double turn = random.uniform(0, 2 * kPi);
  const Vec2 way(std::cos(turn), std::sin(turn));
  const PlanBox& box = face.body->plan_box();
  double in = 0, out = 4 * std::hypot(box.x1 - box.x0, box.y1 - box.y0), z = 0;
  if (face.height(inside.x() + out * way.x(), inside.y() + out * way.y(), z)) return false;
  for (int k = 0; k < 100; ++k) {
    const double mid = 0.5 * (in + out);
    (face.height(inside.x() + mid * way.x(), inside.y() + mid * way.y(), z) ? in : out) = mid;
  }
  rim = Vec3(inside.x() + in * way.x(), inside.y() + in * way.y(), 0);
  return face.height(rim.x(), rim.y(), rim.z());
}

TEST(FaceChart, ReachesTheSilhouetteWithoutABreak) {
  int measured = 0;
  double least = 1e9, most = 0;
  for (const std::string& text : programs()) {
    const CompoundSurface surface = surface_of(text);
    Random random(23);
    for (const SeenFace& face : seen_faces(surface)) {
      if (!is_side(face) || face.body->side_rule() != SideRule::kBetween) continue;
      const FaceChart chart(surface.impl(), face.label);
      const double size = surface.size();
      for (int k = 0; k < 20; ++k) {
        Vec3 inside, rim;
        if (!silhouette_point(random, face, inside, rim)) continue;
        if ((rim - inside).norm() > 3 * size) continue;
        EXPECT_LT(std::fabs(chart.normal(rim).z()), 1e-3);
        // Steps towards the rim, even along the quarter turn that the surface makes there.
        const int steps = 400;
        Vec3 last = rim;
        Vec2 last_c = chart.to_chart(rim);
        for (int i = 1; i <= steps; ++i) {
          const double f = 1.0 * i / steps;
          Vec3 p = rim + f * f * (inside - rim);
          if (!face.height(p.x(), p.y(), p.z())) break;
          const Vec2 c = chart.to_chart(p);
          const double moved = (p - last).norm(), drawn = (c - last_c).norm();
          if (moved < 1e-7 * size) continue;  // the height there is known to half the digits
          ++measured;
          least = std::fmin(least, drawn / moved);
          most = std::fmax(most, drawn / moved);
          EXPECT_LT(drawn, 30 * moved) << surface.element_name(face.label);
          EXPECT_GT(drawn, moved / 60) << surface.element_name(face.label);
          last = p;
          last_c = c;
        }
      }
    }
  }
  EXPECT_GT(measured, 10000);
  std::printf("%d steps, chart length / length %.3f .. %.3f\n", measured, least, most);
}

double least_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto at = [](const Vec3& p, const Vec3& q, const Vec3& r) {
    return std::atan2((q - p).cross(r - p).norm(), (q - p).dot(r - p));
  };
  return std::min({at(a, b, c), at(b, c, a), at(c, a, b)}) * 180 / kPi;
}

TEST(FaceChart, SpacingKeepsTheToleranceAndSpendsIt) {
  int measured = 0, thin = 0;
  double over = 0, sum = 0, angle = 90;
  for (const std::string& text : programs()) {
    const CompoundSurface surface = surface_of(text);
    const TriangleDeviation deviation(surface.impl());
    Random random(24);
    for (const SeenFace& face : seen_faces(surface)) {
      const FaceChart chart(surface.impl(), face.label, deviation.base());
      Vec3 p;
      if (!is_side(face)) {
        if (face.body && face.draw(random, p)) {
          EXPECT_EQ(chart.spacing(p, 0.01), HUGE_VAL);
        }
        continue;
      }
      for (int k = 0; k < 20; ++k) {
        if (!face.draw(random, p)) continue;
        if (chart.apex() && (*chart.apex() - p).norm() < 1) continue;
        const double tolerance = 1e-3;
        const double edge = chart.spacing(p, tolerance);
        ASSERT_GT(edge, 0);
        const double turn = random.uniform(0, 2 * kPi), radius = edge / std::sqrt(3.0);
        Vec3 v[3];
        bool there = true;
        for (int i = 0; i < 3; ++i) {
          const double t = turn + 2 * kPi * i / 3;
          there =
              chart.from_chart(chart.to_chart(p) + radius * Vec2(std::cos(t), std::sin(t)), v[i]) &&
              there;
        }
        if (!there) continue;
        const double off = deviation(face.label, v[0], v[1], v[2]);
        ++measured;
        over = std::fmax(over, off / tolerance);
        sum += off / tolerance;
        EXPECT_LT(off, 1.35 * tolerance) << surface.element_name(face.label);
        EXPECT_GT(off, 0.1 * tolerance) << surface.element_name(face.label);
        const double least = least_angle(v[0], v[1], v[2]);
        angle = std::fmin(angle, least);
        thin += least < 18;
      }
    }
  }
  EXPECT_GT(measured, 1000);
  EXPECT_GT(sum / measured, 0.6);
  EXPECT_LT(thin, measured / 50);
  std::printf(
      "%d triangles, deviation / tolerance: mean %.3f most %.3f; least angle %.1f, %d below 18\n",
      measured, sum / measured, over, angle, thin);
}

// Straight up or down, to the outside, and by the way told.
TEST(FaceChart, StandsOffToTheOutside) {
  int moved = 0, straight = 0, outward = 0;
  for (const std::string& text : programs()) {
    const CompoundSurface surface = surface_of(text);
    Random random(26);
    for (const SeenFace& face : seen_faces(surface)) {
      const FaceChart chart(surface.impl(), face.label);
      const Implicit form = face_implicit(surface.impl(), face.label);
      if (!chart.bends_every_way()) {
        ++straight;
        continue;
      }
      for (int k = 0; k < 10; ++k) {
        Vec3 p, gradient;
        if (!face.draw(random, p)) continue;
        Vec3 q = p;
        const double off = chart.stand_off(0.9, 1e-3, q);
        ++moved;
        ASSERT_EQ(q.head<2>(), p.head<2>());
        ASSERT_GT(off, 0);
        ASSERT_LE(off, 0.9e-3 * (1 + 1e-14));  // rounding
        // To first order: the way is a thousandth of the radius at most.
        const double value = form.form(q, gradient);
        EXPECT_GT(value, 0);
        EXPECT_NEAR(value / gradient.norm(), off, 0.02 * off + 1e-12);
        outward += q.z() > p.z() ? 1 : 0;
      }
    }
  }
  EXPECT_GT(moved, 100);
  EXPECT_GT(straight, 10);
  EXPECT_GT(outward, 50);          // added bodies
  EXPECT_GT(moved - outward, 50);  // subtracted ones
}

// Long, flat and sharp bodies: the charts stay one to one and the spacing sensible, only the shape
// of triangles suffers.
TEST(FaceChart, UnusualProportions) {
  const double sizes[][3] = {{5, 5, 100}, {50, 1, 8}, {50, 40, 0.5}, {0.2, 0.1, 30}, {3, 0.1, 3}};
  int measured = 0, seen = 0;
  for (const double(&abc)[3] : sizes) {
    const CompoundSurface surface = surface_of(bodies("0,0,0", abc[0], abc[1], abc[2]));
    const TriangleDeviation deviation(surface.impl());
    Random random(25);
    for (const SeenFace& face : seen_faces(surface)) {
      if (!is_side(face)) continue;
      const FaceChart chart(surface.impl(), face.label, deviation.base());
      const std::string what = surface.element_name(face.label);
      for (int k = 0; k < 40; ++k) {
        Vec3 p, back;
        if (!face.draw(random, p)) continue;
        ++seen;
        const Vec2 c = chart.to_chart(p);
        ASSERT_TRUE(chart.from_chart(c, back)) << what;
        EXPECT_LT((back - p).norm(), 1e-11 * surface.size()) << what;
        const double edge = chart.spacing(p, 1e-3);
        ASSERT_GT(edge, 0);
        // Triangles over an apex are another matter: it is to be one of their vertices.
        if (chart.apex() && c.norm() < edge) continue;
        Vec3 v[3];
        bool there = true;
        for (int i = 0; i < 3; ++i) {
          const double t = 0.1 * k + 2 * kPi * i / 3;
          there =
              chart.from_chart(c + edge / std::sqrt(3.0) * Vec2(std::cos(t), std::sin(t)), v[i]) &&
              there;
        }
        if (!there) continue;
        ++measured;
        const double off = deviation(face.label, v[0], v[1], v[2]);
        EXPECT_LT(off, 3e-3) << what;
      }
    }
  }
  EXPECT_GT(seen, 1000);
  EXPECT_GT(measured, 500);
}

TEST(TurnTable, ArcLengthOfAnEllipse) {
  for (const double ratio : {1.0, 1.5, 5.0, 40.0}) {
    const TurnTable table = TurnTable::ellipse(ratio, 1, 0.3);
    double length = 0;
    const int steps = 200000;
    for (int k = 0; k < steps; ++k) {  // of a turn of 2
      const double t = 0.3 + 2.0 * (k + 0.5) / steps;
      length += std::hypot(ratio * std::sin(t), std::cos(t)) * 2.0 / steps;
    }
    EXPECT_NEAR(table.at(2.0), length, 2e-5 * ratio) << ratio;
    double last = table.at(-kPi);
    EXPECT_EQ(last, table.first());
    for (int k = 1; k <= 5000; ++k) {
      const double turn = -kPi + 2 * kPi * k / 5000;
      const double s = table.at(turn);
      EXPECT_GT(s, last);
      EXPECT_NEAR(table.inverse(s), turn, 1e-13 * ratio);
      last = s;
    }
  }
}

TEST(FaceChart, LevelPlanesKeepTheirCoordinates) {
  const CompoundSurface surface = surface_of(
      "SOLID-DEF\nQ1,4-PRIS,3\nP1,0.1,0.2,0.3\nP2,7.7,9.9,3.3\nBOOLE-DEF\nQ1\n"
      "MACHI-DEF\nX-RNG,0,9\nY-RNG,0,9\n");
  for (const SeenFace& face : seen_faces(surface)) {
    const FaceChart chart(surface.impl(), face.label);
    const Vec2 a = chart.to_chart(Vec3(1, 2, 3.3)), b = chart.to_chart(Vec3(4, 7, 3.3));
    EXPECT_EQ(b.x() - a.x(), 3);
    EXPECT_EQ(b.y() - a.y(), 5);
    Vec3 p;
    ASSERT_TRUE(chart.from_chart(a, p));
    EXPECT_EQ(p, Vec3(1, 2, 3.3));
  }
}

}  // namespace
}  // namespace diesink::test
