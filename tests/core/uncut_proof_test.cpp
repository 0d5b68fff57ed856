// What is not proven to be cut low enough, against ridges whose heights are known and against dense
// points between the moves.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/uncut_proof.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace diesink {
namespace {

constexpr double kSide = 20;

// A square plane that rises by `slope` along y, in two facets.
TriangleMesh plane(double slope) {
  TriangleMesh mesh;
  for (const double y : {0.0, kSide}) {
    for (const double x : {0.0, kSide}) mesh.positions.emplace_back(x, y, slope * y);
  }
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}};
  return mesh;
}

CutterShape cutter(double diameter, double corner) {
  return *CutterShape::make({diameter, corner});
}

struct Look {
  Look(const TriangleMesh& made, const CutterShape& shape, double limit, int threads = 1,
       double end = 18)
      : mesh(made),
        offset(mesh, shape, 0),
        domain(offset, {2, end, 2, end}),
        proof(mesh, offset, shape, domain, limit, threads) {}
  double area() {
    double sum = 0;
    for (const FacetPart& part : proof.unproven(proof.all(), {}).open) sum += part.area();
    return sum;
  }

  TriangleMesh mesh;
  OffsetSurface offset;
  FrameDomain domain;
  UncutProof proof;
};

// Passes along x on level ground, `apart`; the last beyond the domain.
void cut_level(UncutProof& proof, double apart) {
  for (double y = 0; y <= kSide; y += apart) proof.cut({0, y, 0}, {kSide, y, 0});
}

TEST(UncutProof, RidgesOfABallAreSettledUpToTheirHeight) {
  const double r = 3, apart = 1, ridge = r - std::sqrt(r * r - apart * apart / 4);
  Look enough(plane(0), cutter(2 * r, r), ridge * (1 + 1e-6));
  cut_level(enough.proof, apart);
  EXPECT_EQ(enough.area(), 0);
  // Where 95 % may stay, what is higher is a band along each ridge; parts are somewhat wider.
  const double limit = 0.95 * ridge;
  Look less(plane(0), cutter(2 * r, r), limit);
  cut_level(less.proof, apart);
  const double band = apart - 2 * std::sqrt(r * r - (r - limit) * (r - limit));
  const double all = 16 * 16 * band / apart;
  EXPECT_GT(less.area(), all * (1 - 1e-9));
  EXPECT_LT(less.area(), 1.2 * all);
}

TEST(UncutProof, AFlatEndOnASlopeLeavesTriangles) {
  // Its rim cuts steps whose corners lie apart·slope over the plane, straight up.
  const double slope = 0.5, apart = 0.2, height = apart * slope / std::sqrt(1 + slope * slope);
  const CutterShape flat = cutter(6, 0);
  const auto area = [&](double limit) {
    Look look(plane(slope), flat, limit);
    for (double y = -4; y <= kSide + 4; y += apart) {
      const double z = slope * (y + flat.radius());  // its rim lies on the plane
      look.proof.cut({-4, y, z}, {kSide + 4, y, z});
    }
    return look.area();
  };
  EXPECT_EQ(area(height * (1 + 1e-6)), 0);
  EXPECT_GT(area(height * 0.98), 0);
}

TEST(UncutProof, AShortGapInAPassIsFound) {
  // Of a hundredth of a millimetre: no lattice of the radius's size would see it.
  const CutterShape flat = cutter(6, 0);
  Look look(plane(0), flat, 0.02);
  for (const double y : {0.0, 5.99, 11.98, 17.97}) {
    if (y == 11.98) {
      look.proof.cut({-4, y, 0}, {10 - 3 - 0.005, y, 0});
      look.proof.cut({10 + 3 + 0.005, y, 0}, {24, y, 0});
    } else {
      look.proof.cut({-4, y, 0}, {24, y, 0});
    }
  }
  // The ends are round: what stays is a waist.
  const std::vector<FacetPart> open = look.proof.unproven(look.proof.all(), {}).open;
  ASSERT_FALSE(open.empty());
  const bool at_the_waist = std::any_of(open.begin(), open.end(), [](const FacetPart& part) {
    const PlanBox box = part.box();
    return box.x0 <= 10 && box.x1 >= 10 && box.y0 <= 11.98 && box.y1 >= 11.98;
  });
  EXPECT_TRUE(at_the_waist);
}

TEST(UncutProof, NextToAWallTheWallCounts) {
  // A step of 5 at y = 10: beside it the ball's flank stands over the ground, but close to the
  // wall.
  TriangleMesh mesh;
  for (const double y : {0.0, 10.0}) {
    for (const double x : {0.0, kSide}) mesh.positions.emplace_back(x, y, 0);
  }
  for (const double y : {10.0, kSide}) {
    for (const double x : {0.0, kSide}) mesh.positions.emplace_back(x, y, 5);
  }
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}, {4, 5, 7}, {4, 7, 6}};
  const CutterShape flat = cutter(6, 0);
  const auto area = [&](double off) {
    Look look(mesh, flat, 0.02);
    for (double y = 10 - 3 - off; y > -6; y -= 5.9) look.proof.cut({-4, y, 0}, {24, y, 0});
    for (double y = 10; y < 26; y += 5.9) look.proof.cut({-4, y, 5}, {24, y, 5});
    return look.area();
  };
  // A strip of 0.019 stands up against the wall: within the limit of it. One of 0.03 is not.
  EXPECT_EQ(area(0.019), 0);
  EXPECT_NEAR(area(0.03), 16 * 0.01, 16 * 0.002);
}

TEST(UncutProof, WhatIsSettledKeepsTheLimitAtDensePoints) {
  std::mt19937 random(7);
  constexpr double kEnd = 7;
  std::uniform_real_distribution<double> at(0, kEnd + 2), high(0, 0.15);
  for (const CutterShape& shape : {cutter(3, 1.5), cutter(3, 0), cutter(3, 0.5)}) {
    const double slope = 0.3, limit = 0.1;
    Look look(plane(slope), shape, limit, 1, kEnd);
    std::vector<PassedMove> moves;
    const double steep = std::sqrt(1 + slope * slope);
    const auto lowest = [&](double y) {  // of a tip that touches the plane
      return slope * y + shape.corner() * (steep - 1) + slope * shape.flat();
    };
    for (int k = 0; k < 80; ++k) {
      const Vec2 a(at(random), at(random)), b = a + Vec2(high(random) * 20 - 1, high(random) * 20);
      const double lift = high(random);
      const Vec3 from(a.x(), a.y(), lowest(a.y()) + lift), to(b.x(), b.y(), lowest(b.y()) + lift);
      look.proof.cut(from, to);
      moves.emplace_back(from, to);
    }
    const std::vector<FacetPart> open = look.proof.unproven(look.proof.all(), {}).open;
    const auto is_open = [&](const Vec2& p) {
      return std::any_of(open.begin(), open.end(), [&](const FacetPart& part) {
        if ((part.p[0].head<2>() - p).norm() > 1) return false;
        for (std::size_t k = 0; k < part.size; ++k) {
          const Vec2 a = part.p[k].head<2>(), side = part.p[(k + 1) % part.size].head<2>() - a;
          if (side.x() * (p.y() - a.y()) - side.y() * (p.x() - a.x()) < -1e-9) return false;
        }
        return true;
      });
    };
    int settled = 0;
    std::uniform_real_distribution<double> inside(2, kEnd);
    for (int k = 0; k < 3000; ++k) {
      const Vec2 p(inside(random), inside(random));
      double left = std::numeric_limits<double>::infinity();
      for (const PassedMove& move : moves) move.lower(shape, p, left);
      const double stays = (left - slope * p.y()) / steep;
      if (stays <= limit * (1 + 1e-9)) {
        ++settled;
        continue;
      }
      ASSERT_TRUE(is_open(p)) << p.transpose() << ": " << stays;
    }
    EXPECT_GT(settled, 300);
    EXPECT_LT(settled, 2900);
  }
}

TEST(UncutProof, ThreadsMakeNoDifference) {
  const auto look = [](int threads) {
    Look one(plane(0.2), cutter(6, 3), 0.05, threads);
    for (double y = 0; y < kSide; y += 1.3) one.proof.cut({0, y, 0.2 * y}, {kSide, y, 0.2 * y});
    return one.proof.unproven(one.proof.all(), {}).open;
  };
  const std::vector<FacetPart> one = look(1), four = look(4);
  ASSERT_EQ(one.size(), four.size());
  for (std::size_t k = 0; k < one.size(); ++k) {
    ASSERT_EQ(one[k].size, four[k].size);
    for (std::size_t c = 0; c < one[k].size; ++c) EXPECT_EQ(one[k].p[c], four[k].p[c]);
  }
}

}  // namespace
}  // namespace diesink
