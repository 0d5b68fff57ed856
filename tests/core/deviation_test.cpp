// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/deviation.h"

#include <gtest/gtest.h>

#include <thread>

#include "core/tessellate/deviation_filter.h"
#include "core/tessellate/deviation_forms.h"
#include "tests/support/face_points.h"

namespace diesink::test {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

// Distance of the flat triangle's points to the face, the largest found on a lattice.
double sampled(const SeenFace& face, const Vec3& a, const Vec3& b, const Vec3& c, int steps) {
  const QuadricBody* quadric = face.body ? std::get_if<QuadricBody>(&face.body->body()) : nullptr;
  const Eigen::Matrix4d form = quadric ? side_matrix(*quadric) : Eigen::Matrix4d();
  double most = 0;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; i + j <= steps; ++j) {
      const Vec3 p = a + (b - a) * i / steps + (c - a) * j / steps;
      double distance = 0;
      if (quadric && face.number() == kFaceSide) {
        distance = (nearest_on(form, p) - p).norm();
      } else if (!face.body) {
        // Gauss-Newton on the foot's plan position.
        Vec3 foot = p;
        for (int k = 0; k < 20; ++k) {
          BaseHit hit;
          if (!face.surface->base_at(foot.x(), foot.y(), hit)) return -1;
          foot.z() = hit.z;
          const Vec3 n = Vec3(-hit.zx, -hit.zy, 1).normalized();
          foot = p - n * (p - foot).dot(n);
        }
        BaseHit hit;
        if (!face.surface->base_at(foot.x(), foot.y(), hit)) return -1;
        distance = (Vec3(foot.x(), foot.y(), hit.z) - p).norm();
      }
      most = std::fmax(most, distance);
    }
  }
  return most;
}

// Three points of a face about a drawn one, within `size`; false where the draw left the face.
bool draw_triangle(Random& random, const SeenFace& face, double size, Vec3 (&v)[3]) {
  Vec3 p;
  if (!face.draw(random, p)) return false;
  const Vec3 n = face.surface->normal(face.label, p);
  if (n.z() < 0.2) return false;  // a step in plan would be a long one on the face
  for (Vec3& corner : v) {
    corner.head<2>() = p.head<2>() + size * Vec2(random.uniform(-1, 1), random.uniform(-1, 1));
    if (!face.height(corner.x(), corner.y(), corner.z())) return false;
    if ((corner - p).norm() > 4 * size) return false;
  }
  const double area = (v[1] - v[0]).cross(v[2] - v[0]).norm();
  return area > 0.15 * std::max({(v[1] - v[0]).squaredNorm(), (v[2] - v[0]).squaredNorm(),
                                 (v[2] - v[1]).squaredNorm()});
}

// Moves some corners off a quadric, up and down, by up to twice what the triangle is beneath it.
void stand_off(Random& random, const SeenFace& face, double gap, Vec3 (&v)[3]) {
  if (!face.body || face.number() != kFaceSide) return;
  for (Vec3& corner : v) {
    if (random.uniform(0, 1) < 0.3) continue;
    corner.z() += 2 * gap * random.uniform(-1, 1) / face.surface->normal(face.label, corner).z();
  }
}

std::vector<std::string> programs() {
  std::vector<std::string> texts{fixture("allprims.part"), fixture("fig6.part")};
  RandomProgramOptions options;
  options.solids = 23;
  options.base = RandomBase::kFerguson;
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    texts.push_back(random_part_program(seed, options));
  return texts;
}

TEST(LargestBetween, IsTheLargestOfALattice) {
  Random random(5);
  constexpr int kSteps = 100;
  int inside = 0;
  for (int k = 0; k < 2000; ++k) {
    EdgeForms q;
    VertexValues p;
    for (double& form : q) form = random.uniform(k % 3 == 0 ? 0 : -1, 1);
    for (double& value : p) value = k % 5 == 0 ? 0 : random.uniform(-0.3, 0.3);
    double truth = -1;
    bool is_inside = false;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const double a = i / double{kSteps}, b = j / double{kSteps}, c = 1 - a - b;
        const double value =
            b * c * q[0] + c * a * q[1] + a * b * q[2] + a * p[0] + b * p[1] + c * p[2];
        if (value <= truth) continue;
        truth = value;
        is_inside = i > 0 && j > 0 && i + j < kSteps;
      }
    }
    inside += is_inside ? 1 : 0;
    const double most = largest_between(q, p);
    ASSERT_GE(most, truth - 1e-15);
    ASSERT_LE(most, truth + 1e-4);  // of the lattice
  }
  EXPECT_GT(inside, 200);
}

// Values at the vertices that put the largest at a place of choice, inside narrow triangles.
TEST(LargestBetween, KeepsItsDigitsOnSlivers) {
  Random random(6);
  for (int k = 0; k < 20000; ++k) {
    const double width = std::pow(10, -0.1 * (k % 50)), x = random.uniform(0, 1);
    const EdgeForms q{(1 - x) * (1 - x) + width * width, x * x + width * width, 1};
    double a = random.uniform(0.05, 1), b = random.uniform(0.05, 1), c = random.uniform(0.05, 1);
    const double sum = a + b + c;
    a /= sum, b /= sum, c /= sum;
    const VertexValues p{-b * q[2] - c * q[1], -a * q[2] - c * q[0], -a * q[1] - b * q[0]};
    const double truth = -(b * c * q[0] + c * a * q[1] + a * b * q[2]);
    ASSERT_NEAR(largest_between(q, p), truth, 1e-12) << width;  // rounding, of forms up to 1
  }
}

TEST(TriangleDeviation, BoundsWhatSamplingFindsAndHardlyMore) {
  Random random(11);
  int measured = 0, measured_base = 0;
  double loosest = 0, sum = 0, sum_base = 0;
  for (const std::string& text : programs()) {
    const CompoundSurface surface = surface_of(text);
    const TriangleDeviation deviation(surface.impl());
    for (const SeenFace& face : seen_faces(surface)) {
      const PlanBox box = face.body ? face.body->plan_box() : PlanBox{0, 30, 0, 30};
      const double size = std::fmin(box.x1 - box.x0, box.y1 - box.y0);
      for (int k = 0; k < 60; ++k) {
        Vec3 v[3];
        const double scale = size * (k % 3 == 0 ? 0.1 : 0.02);
        if (!draw_triangle(random, face, scale, v)) continue;
        if (k % 2 == 1) stand_off(random, face, deviation(face.label, v[0], v[1], v[2]), v);
        const double truth = sampled(face, v[0], v[1], v[2], 10);
        if (truth < 0) continue;
        const double bound = deviation(face.label, v[0], v[1], v[2]);
        const std::string what = surface.element_name(face.label);
        ASSERT_GE(bound, truth * (1 - 1e-9)) << what;
        if (k % 3 == 0 || truth < 1e-9) continue;
        const double ratio = bound / truth;
        if (face.body) {
          ++measured;
          sum += ratio;
          loosest = std::fmax(loosest, ratio);
        } else {
          ++measured_base;
          sum_base += ratio;
        }
      }
    }
  }
  // The sampling lattice itself misses some of the maximum.
  EXPECT_LT(loosest, 1.12);
  EXPECT_LT(sum / measured, 1.03);
  // Near inflections of the base little is left of its second derivative but what it varies by.
  EXPECT_LT(sum_base / measured_base, 1.6);
  EXPECT_GT(measured, 500);
  EXPECT_GT(measured_base, 100);
}

// Across the edge of a pancake gradients turn round within its thickness: what the triangle sags by
// on the sphere that the ellipsoid is but for its axes, so many times as long, bounds it all the
// same.
TEST(TriangleDeviation, OfLongEllipsoidsTakesNoNotice) {
  Random random(19);
  for (const Vec3& axes : {Vec3(15, 0.1, 5), Vec3(0.02, 0.03, 9), Vec3(10, 8, 0.05)}) {
    const auto text = [](double value) { return std::to_string(value); };
    const CompoundSurface surface = surface_of(
        "SOLID-DEF\nE,ELLIP,2\nP1,20,20,2\nA," + text(axes.x()) + "\nB," + text(axes.y()) + "\nC," +
        text(axes.z()) + "\nBOOLE-DEF\nE\nMACHI-DEF\nX-RNG,0,40\nY-RNG,0,40\nTOLER,.01\n");
    const TriangleDeviation deviation(surface.impl());
    const SeenFace face = seen_faces(surface).front();
    const auto direction = [&] {
      return Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)).normalized();
    };
    for (int k = 0; k < 400; ++k) {
      const Vec3 about = direction();
      const double size = k % 2 == 0 ? 0.3 : 0.05;
      Vec3 v[3];
      for (Vec3& corner : v) {
        const Vec3 s = (about + size * direction()).normalized();
        corner =
            Vec3(20, 20, 2) + axes.cwiseProduct(s) * (1 + random.uniform(0, 0.1) * size * size);
      }
      const double bound = deviation(face.label, v[0], v[1], v[2]);
      ASSERT_GE(bound, sampled(face, v[0], v[1], v[2], 8) * (1 - 1e-9) - 1e-12);
      // A triangle within a cap of the sphere, and what its corners stand off.
      ASSERT_LE(bound, 1.5 * size * size * axes.maxCoeff());
    }
  }
}

TEST(TriangleDeviation, BaseOfManyPatches) {
  Random random(13);
  RandomProgramOptions options;
  options.solids = 1;
  options.base = RandomBase::kFerguson;
  int affine = 0, warped = 0;
  for (std::uint64_t seed = 0; seed <= 5; ++seed) {
    const CompoundSurface surface =
        surface_of(seed == 0 ? fixture("fig6.part") : random_part_program(seed, options));
    const TriangleDeviation deviation(surface.impl());
    SeenFace base;
    for (const SeenFace& face : seen_faces(surface)) {
      if (!face.body) base = face;
    }
    ASSERT_NE(base.label, kNoLabel);
    const bool is_affine = std::get<FergusonSurface>(surface.impl().base).affine().has_value();
    (is_affine ? affine : warped) += 1;
    for (const double size : {0.05, 0.5, 2.0, 6.0}) {
      double sum = 0, sum_truth = 0;
      for (int k = 0; k < 250; ++k) {
        Vec3 v[3], p;
        if (!base.draw(random, p)) continue;
        const double turn = random.uniform(0, 7);
        bool there = true;
        for (int i = 0; i < 3; ++i) {
          const double t = turn + 2.1 * i + random.uniform(-0.5, 0.5);
          v[i].head<2>() = p.head<2>() + 0.577 * size * Vec2(std::cos(t), std::sin(t));
          there = base.height(v[i].x(), v[i].y(), v[i].z()) && there;
        }
        if (!there) continue;
        const double truth = sampled(base, v[0], v[1], v[2], 8);
        if (truth < 0) continue;
        const double bound = deviation(base.label, v[0], v[1], v[2]);
        ASSERT_GE(bound, truth * (1 - 1e-9) - 1e-13 * surface.size()) << seed << ' ' << size;
        sum += bound;
        sum_truth += truth;
      }
      // Patches of fig6 are 4 wide; those of the others 15 and more.
      if (size <= 0.5) {
        EXPECT_LT(sum, (is_affine ? 1.15 : 1.5) * sum_truth) << seed << ' ' << size;
      } else if (size <= 2) {
        EXPECT_LT(sum, (is_affine ? 1.7 : 2.2) * sum_truth) << seed << ' ' << size;
      }
    }
  }
  EXPECT_GT(affine, 1);
  EXPECT_GT(warped, 0);
}

TEST(TriangleDeviation, BoundsTheSurfaceOverTheTriangleToo) {
  Random random(12);
  int measured = 0;
  const CompoundSurface surface = surface_of(fixture("allprims.part"));
  const TriangleDeviation deviation(surface.impl());
  for (const SeenFace& face : seen_faces(surface)) {
    if (!face.body) continue;
    for (int k = 0; k < 40; ++k) {
      Vec3 v[3];
      if (!draw_triangle(random, face, 0.5, v)) continue;
      const double bound = deviation(face.label, v[0], v[1], v[2]);
      const Vec3 n = (v[1] - v[0]).cross(v[2] - v[0]).normalized();
      for (int i = 0; i < 20; ++i) {
        const double s = random.uniform(0.15, 0.5), t = random.uniform(0.15, 0.35);
        const Vec3 at = v[0] + s * (v[1] - v[0]) + t * (v[2] - v[0]);
        double z = 0;
        if (!face.height(at.x(), at.y(), z)) continue;
        const Vec3 on(at.x(), at.y(), z);
        const double height = n.dot(on - v[0]);
        const Vec3 foot = on - height * n;
        bool inside = true;
        for (int e = 0; e < 3; ++e) {
          inside = inside && n.dot((v[(e + 1) % 3] - v[e]).cross(foot - v[e])) > 0;
        }
        if (!inside) continue;
        ++measured;
        EXPECT_LE(std::fabs(height), bound * (1 + 1e-9)) << surface.element_name(face.label);
      }
    }
  }
  EXPECT_GT(measured, 500);
}

TEST(TriangleDeviation, SphereIsExact) {
  const CompoundSurface surface = surface_of(
      "SOLID-DEF\nS1,SPHER,1\nP1,3,4,5\nRAD,10\nBOOLE-DEF\nS1\nMACHI-DEF\nX-RNG,0,9\nY-RNG,0,9\n");
  const TriangleDeviation deviation(surface.impl());
  for (const double rho : {0.01, 0.5, 3.0, 8.0}) {  // equilateral, about the vertical
    Vec3 v[3];
    for (int k = 0; k < 3; ++k) {
      v[k] = Vec3(3 + rho * std::cos(2.1 + 2 * M_PI * k / 3),
                  4 + rho * std::sin(2.1 + 2 * M_PI * k / 3), 5 + std::sqrt(100 - rho * rho));
    }
    const double sag = rho * rho / (10 + std::sqrt(100 - rho * rho));
    EXPECT_NEAR(deviation(make_label(0, kFaceSide), v[0], v[1], v[2]), sag, 1e-12 + 1e-9 * sag);
  }
}

TEST(TriangleDeviation, FromTheApexOfACone) {
  const CompoundSurface surface = surface_of(
      "SOLID-DEF\nC1,R-CONE,1\nP1,0,0,0\nP2,0,0,12\nRAD,5\nBOOLE-DEF\nC1\nMACHI-DEF\nX-RNG,0,9\n"
      "Y-RNG,0,9\n");
  const TriangleDeviation deviation(surface.impl());
  const Eigen::Matrix4d form = side_matrix(std::get<QuadricBody>(surface.impl().bodies[0].body()));
  for (const double turn : {0.02, 0.2, 0.7}) {
    const Vec3 a(0, 0, 12), b(5, 0, 0), c(5 * std::cos(turn), 5 * std::sin(turn), 0);
    const double bound = deviation(make_label(0, kFaceSide), a, b, c);
    const Vec3 middle = 0.5 * (b + c);
    const double truth = (nearest_on(form, middle) - middle).norm();
    EXPECT_GE(bound, truth * (1 - 1e-9));
    EXPECT_LE(bound, 1.06 * truth);
  }
}

// Coarse, fine, narrow and flat triangles, and limits far from the bound, near it and next to it.
TEST(DeviationFilter, TellsOnlyWhatTheBoundSays) {
  Random random(17);
  int told = 0, open = 0, within = 0, beyond = 0;
  for (const std::string& text : programs()) {
    const CompoundSurface surface = surface_of(text);
    const TriangleDeviation deviation(surface.impl());
    for (const SeenFace& face : seen_faces(surface)) {
      if (!face.body) continue;
      const PlanBox box = face.body->plan_box();
      const double size = std::fmin(box.x1 - box.x0, box.y1 - box.y0);
      for (int k = 0; k < 80; ++k) {
        constexpr double kScales[] = {0.5, 0.1, 0.02, 1e-3};
        Vec3 v[3];
        if (!draw_triangle(random, face, size * kScales[k % 4], v)) continue;
        if (k % 5 == 0) {  // narrow, and with no width at all
          v[2].head<2>() = 0.5 * (v[0] + v[1]).head<2>() +
                           1e-3 * (k % 10 == 0 ? 0 : 1) * (v[2] - v[0]).head<2>();
          if (!face.height(v[2].x(), v[2].y(), v[2].z())) continue;
        }
        if (k % 8 >= 6) stand_off(random, face, deviation(face.label, v[0], v[1], v[2]), v);
        const Vec3 positions[] = {v[0], v[1], v[2]};
        DeviationFilter filter(deviation, face.label);
        for (const Vec3& p : positions) filter.add(p);
        const double bound = deviation(face.label, v[0], v[1], v[2]);
        for (const double part : {0.1, 0.9, 1 - 1e-5, 1.0, 1 + 1e-5, 1.1, 10.0}) {
          const double limit = part * std::fmin(bound, 1e6);
          const DeviationFilter::Side side = filter.compare(0, 1, 2, positions, limit);
          if (side == DeviationFilter::Side::kWithin) {
            ++within;
            ASSERT_LE(bound, limit) << surface.element_name(face.label) << " " << part;
          } else if (side == DeviationFilter::Side::kBeyond) {
            ++beyond;
            ASSERT_GT(bound, limit) << surface.element_name(face.label) << " " << part;
          }
          const bool clear = part < 0.95 || part > 1.05;
          if (!clear || k % 4 == 0 || k % 5 == 0 || bound < 1e-9) continue;
          ++(side == DeviationFilter::Side::kOpen ? open : told);
        }
      }
    }
  }
  EXPECT_GT(within, 1000);
  EXPECT_GT(beyond, 1000);
  EXPECT_LT(open, told / 10);
}

TEST(TriangleDeviation, PlanesAndHopelessTriangles) {
  const CompoundSurface surface = surface_of(
      "SOLID-DEF\nK1,R-CYLI,1\nP1,0,0,1000000\nP2,3,0,1000012\nRAD,5\nS1,SPHER,1\nP1,0,0,0\nRAD,2\n"
      "BOOLE-DEF\nK1+S1\nMACHI-DEF\nX-RNG,0,9\nY-RNG,0,9\n");
  const TriangleDeviation deviation(surface.impl());
  const SeenFace top{&surface.impl(), make_label(0, kFaceTop), &surface.impl().bodies[0], true};
  Random random(3);
  Vec3 v[3];
  int done = 0;
  for (int k = 0; k < 100; ++k) {
    if (!draw_triangle(random, top, 2, v)) continue;
    ++done;
    EXPECT_LE(deviation(top.label, v[0], v[1], v[2]), 3e-9);
    EXPECT_GT(deviation(top.label, v[0] + Vec3(0, 0, 0.1), v[1], v[2]), 0.09);
  }
  EXPECT_GT(done, 10);
  // A great circle's triangle has no side.
  EXPECT_EQ(deviation(make_label(1, kFaceSide), Vec3(2, 0, 0), Vec3(-1, std::sqrt(3.0), 0),
                      Vec3(-1, -std::sqrt(3.0), 0)),
            kInf);
}

TEST(TriangleDeviation, AnyNumberOfThreadsSeeTheSameBase) {
  const CompoundSurface surface = surface_of(fixture("fig6.part"));
  Label label = kNoLabel;
  for (const SeenFace& face : seen_faces(surface)) {
    if (!face.body) label = face.label;
  }
  ASSERT_NE(label, kNoLabel);
  const Machining& m = surface.program().machining;
  const auto sweep = [&](const TriangleDeviation& deviation, std::vector<double>& out) {
    Random random(8);
    for (int k = 0; k < 3000; ++k) {
      Vec3 v[3];
      const double x = random.uniform(m.x_range[0], m.x_range[1] - 2),
                   y = random.uniform(m.y_range[0], m.y_range[1] - 2);
      bool there = true;
      for (Vec3& p : v) {
        p.head<2>() = Vec2{x + random.uniform(0, 2), y + random.uniform(0, 2)};
        BaseHit hit;
        there = surface.impl().base_at(p.x(), p.y(), hit) && there;
        p.z() = hit.z;
      }
      out.push_back(there ? deviation(label, v[0], v[1], v[2]) : 0);
    }
  };
  std::vector<double> alone;
  sweep(TriangleDeviation(surface.impl()), alone);
  const TriangleDeviation shared(surface.impl());
  std::vector<std::vector<double>> out(4);
  std::vector<std::thread> threads;
  for (std::vector<double>& own : out) threads.emplace_back([&] { sweep(shared, own); });
  for (std::thread& t : threads) t.join();
  for (const std::vector<double>& own : out) EXPECT_EQ(own, alone);
}

}  // namespace
}  // namespace diesink::test
