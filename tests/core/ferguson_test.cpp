// Ferguson composite surfaces against a plain implementation of the textbook forms, and the
// promises of the headers.
// SPDX-License-Identifier: Apache-2.0
#include "core/base/ferguson.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/plane.h"
#include "tests/support/brute_force.h"

namespace diesink {
namespace {

// A grid of m by n points, 4 apart, moved in plan by at most `warp` and turned by `angle`.
FergusonBase random_grid(int m, int n, double warp, double angle, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto number = [&] { return static_cast<double>(random()) / 4294967296.0 * 2 - 1; };
  FergusonBase base;
  base.columns = m;
  base.rows = n;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < m; ++i) {
      const double x = 4 * i + warp * number(), y = 4 * j + warp * number();
      base.points.emplace_back(x * std::cos(angle) - y * std::sin(angle),
                               x * std::sin(angle) + y * std::cos(angle), 2 * number());
    }
  }
  return base;
}

struct Shape {
  int m, n;
  double warp, angle;
};

class Ferguson : public testing::TestWithParam<Shape> {
 protected:
  void SetUp() override {
    const Shape& s = GetParam();
    base_ = random_grid(s.m, s.n, s.warp, s.angle, 7);
    Result<FergusonSurface> made = FergusonSurface::make(base_);
    ASSERT_TRUE(made) << made.error().message;
    surface_.emplace(std::move(*made));
    for (const Vec3& p : base_.points) size_ = std::max(size_, p.cwiseAbs().maxCoeff());
  }
  double random() { return static_cast<double>(random_()) / 4294967296.0; }

  std::mt19937 random_{3};
  FergusonBase base_;
  std::optional<FergusonSurface> surface_;
  double size_ = 0;
};

TEST_P(Ferguson, MeetsThePlainSurface) {
  const test::PlainFerguson plain(base_);
  FergusonHint hint;
  for (int k = 0; k < 2000; ++k) {
    const double u = random() * (base_.columns - 1), v = random() * (base_.rows - 1);
    const Vec3 p = plain.point(u, v);
    BaseHit hit;
    ASSERT_TRUE(surface_->at(p.x(), p.y(), hit, hint));
    EXPECT_NEAR(hit.z, p.z(), 4e-13 * size_);
    EXPECT_NEAR(hint.u, u, 1e-11);
    EXPECT_NEAR(hint.v, v, 1e-11);
    const FergusonSurface::Point q = surface_->point(u, v);
    EXPECT_LT((q.r - p).norm(), 1e-13 * size_);
  }
}

TEST_P(Ferguson, SlopesAreThoseOfTheHeights) {
  for (int k = 0; k < 500; ++k) {
    const Vec3 p =
        surface_->point(0.1 + random() * (base_.columns - 1.2), 0.1 + random() * (base_.rows - 1.2))
            .r;
    const double h = 1e-5;
    BaseHit mid, left, right, below, above;
    FergusonHint hint;
    ASSERT_TRUE(surface_->at(p.x(), p.y(), mid, hint));
    ASSERT_TRUE(surface_->at(p.x() - h, p.y(), left, hint) &&
                surface_->at(p.x() + h, p.y(), right, hint));
    ASSERT_TRUE(surface_->at(p.x(), p.y() - h, below, hint) &&
                surface_->at(p.x(), p.y() + h, above, hint));
    EXPECT_NEAR(mid.zx, (right.z - left.z) / (2 * h), 1e-7);
    EXPECT_NEAR(mid.zy, (above.z - below.z) / (2 * h), 1e-7);
  }
}

TEST_P(Ferguson, TheHintChangesNoDigit) {
  FergusonHint warm;
  for (int k = 0; k < 2000; ++k) {
    const double u = random() * (base_.columns - 1), v = random() * (base_.rows - 1);
    // Some on the lines between patches, where two could claim the point.
    const Vec3 p =
        surface_->point(k % 3 == 0 ? std::round(u) : u, k % 5 == 0 ? std::round(v) : v).r;
    FergusonHint cold;
    BaseHit a, b;
    ASSERT_TRUE(surface_->at(p.x(), p.y(), a, cold));
    ASSERT_TRUE(surface_->at(p.x(), p.y(), b, warm));
    EXPECT_EQ(a.z, b.z);
    EXPECT_EQ(a.zx, b.zx);
    EXPECT_EQ(a.zy, b.zy);
  }
}

TEST_P(Ferguson, RowsGiveTheDigitsOfPoints) {
  const PlanBox box = surface_->plan_box();
  for (int k = 0; k < 60; ++k) {
    // Rows through the grid's own points as well as between them, past both ends.
    const double y = k < 20 ? base_.points[random_() % base_.points.size()].y()
                            : box.y0 - 1 + random() * (box.y1 - box.y0 + 2);
    std::vector<double> xs;
    const int count = k % 4 == 0 ? 1000 : 1 + static_cast<int>(random() * 60);
    for (int i = 0; i < count; ++i)
      xs.push_back(box.x0 - 1 + (box.x1 - box.x0 + 2) * (i + 0.5 * random()) / count);
    if (k % 7 == 0) xs = {xs.front()};
    std::vector<double> z(xs.size()), zx(xs.size()), zy(xs.size());
    surface_->row(y, xs, z.data(), zx.data(), zy.data());
    for (std::size_t i = 0; i < xs.size(); ++i) {
      FergusonHint hint;
      BaseHit hit;
      if (!surface_->at(xs[i], y, hit, hint)) {
        EXPECT_TRUE(std::isnan(z[i]));
        continue;
      }
      EXPECT_EQ(z[i], hit.z) << xs[i] << ',' << y;
      EXPECT_EQ(zx[i], hit.zx);
      EXPECT_EQ(zy[i], hit.zy);
    }
  }
}

TEST_P(Ferguson, ItsBorderBelongsToIt) {
  Vec2 area = Vec2::Zero();
  for (int side = 0; side < 4; ++side) {
    const double length = surface_->border_length(side);
    const FergusonSurface::BorderPoint end = surface_->border(side, length);
    const FergusonSurface::BorderPoint start = surface_->border((side + 1) % 4, 0);
    EXPECT_EQ(end.at, start.at);
    for (int k = 0; k <= 200; ++k) {
      const double w = length * k / 200;
      const FergusonSurface::BorderPoint b = surface_->border(side, w);
      BaseHit hit;
      FergusonHint hint;
      EXPECT_TRUE(surface_->at(b.at.x(), b.at.y(), hit, hint)) << side << ' ' << w;
      const Vec2 left = Vec2(-b.along.y(), b.along.x()).normalized();
      if (k > 0 && k < 200) {
        EXPECT_TRUE(
            surface_->at(b.at.x() + 1e-3 * left.x(), b.at.y() + 1e-3 * left.y(), hit, hint));
        EXPECT_FALSE(
            surface_->at(b.at.x() - 1e-3 * left.x(), b.at.y() - 1e-3 * left.y(), hit, hint));
        EXPECT_FALSE(
            surface_->at(b.at.x() - 1e-9 * left.x(), b.at.y() - 1e-9 * left.y(), hit, hint));
        const double d = 1e-6;
        EXPECT_LT(((surface_->border(side, w + d).at - surface_->border(side, w - d).at) / (2 * d) -
                   b.along)
                      .norm(),
                  1e-5);
      }
      area += b.at;
    }
  }
}

TEST_P(Ferguson, BoundsEncloseAndTighten) {
  const PlanBox all = surface_->plan_box();
  for (const double h : {3.0, 0.3, 0.03, 1e-3, 1e-6, 0.0}) {
    for (int k = 0; k < 60; ++k) {
      const double x = all.x0 - 1 + random() * (all.x1 - all.x0 + 2),
                   y = all.y0 - 1 + random() * (all.y1 - all.y0 + 2);
      const PlanBox box{x, x + h, y, y + h};
      const BaseBounds b = surface_->bounds(box);
      int inside = 0;
      const auto in = [](const Range& r, double v, double slack) {
        return v >= r.lo - slack && v <= r.hi + slack;
      };
      for (int i = 0; i < 8; ++i) {
        for (int j = 0; j < 8; ++j) {
          const double px = x + h * i / 7, py = y + h * j / 7;
          BaseHit hit;
          FergusonHint hint;
          if (!surface_->at(px, py, hit, hint)) continue;
          ++inside;
          EXPECT_TRUE(in(b.z, hit.z, 0)) << b.z.lo << ' ' << hit.z << ' ' << b.z.hi << " h " << h;
          EXPECT_TRUE(in(b.zx, hit.zx, 0))
              << b.zx.lo << ' ' << hit.zx << ' ' << b.zx.hi << " h " << h;
          EXPECT_TRUE(in(b.zy, hit.zy, 1e-11));
          const double d = 1e-4;
          BaseHit next;
          if (h >= 0.03 && i < 7 && j < 7) {
            if (surface_->at(px + d, py, next, hint)) {
              EXPECT_TRUE(in(b.zxx, (next.zx - hit.zx) / d, 1e-7))
                  << b.zxx.lo << ' ' << (next.zx - hit.zx) / d << ' ' << b.zxx.hi;
              EXPECT_TRUE(in(b.zxy, (next.zy - hit.zy) / d, 1e-7));
            }
            if (surface_->at(px, py + d, next, hint)) {
              EXPECT_TRUE(in(b.zyy, (next.zy - hit.zy) / d, 1e-7));
            }
          }
        }
      }
      if (b.coverage == Coverage::kOutside) {
        EXPECT_EQ(inside, 0);
      }
      if (b.coverage == Coverage::kInside) {
        EXPECT_EQ(inside, 64);
      }
      if (inside == 64 && h < 0.1) {
        EXPECT_NE(b.coverage, Coverage::kOutside);
        // Slopes up to about 2 and curvatures up to about 5 in these grids.
        EXPECT_LT(b.zx.hi - b.zx.lo, 60 * h + 1e-9);
        EXPECT_LT(b.zy.hi - b.zy.lo, 60 * h + 1e-9);
        if (b.coverage == Coverage::kInside) {
          BaseHit hit;
          FergusonHint hint;
          ASSERT_TRUE(surface_->at(x + h / 2, y + h / 2, hit, hint));
          const double linear = (std::fabs(hit.zx) + std::fabs(hit.zy)) * h;
          EXPECT_LT(b.z.hi - b.z.lo, linear + 60 * h * h + 1e-10);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Grids, Ferguson,
                         testing::Values(Shape{11, 11, 0, 0}, Shape{2, 2, 0, 0},
                                         Shape{5, 3, 0, 0.3}, Shape{6, 6, 0.5, 0},
                                         Shape{9, 7, 0.9, 0.7}, Shape{2, 2, 0.8, 0},
                                         Shape{3, 2, 1.0, -1.9}, Shape{7, 7, 0.2, 3.0}));

TEST(FergusonMake, KnowsAnAffinePlan) {
  EXPECT_TRUE(FergusonSurface::make(random_grid(11, 11, 0, 0, 1))->affine());
  EXPECT_TRUE(FergusonSurface::make(random_grid(4, 5, 0, 0.4, 1))->affine());
  EXPECT_FALSE(FergusonSurface::make(random_grid(4, 5, 1e-6, 0.4, 1))->affine());
}

TEST(FergusonMake, AcceptsAGridSeenFromBelow) {
  FergusonBase base = random_grid(6, 5, 0.4, 0, 5);
  for (Vec3& p : base.points) p.x() = -p.x();
  const Result<FergusonSurface> made = FergusonSurface::make(base);
  ASSERT_TRUE(made);
  double area = 0;
  for (int side = 0; side < 4; ++side) {
    for (int k = 0; k < 100; ++k) {
      const double w = made->border_length(side) / 100;
      const Vec2 a = made->border(side, k * w).at, b = made->border(side, (k + 1) * w).at;
      area += 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
  }
  EXPECT_GT(area, 0);
  EXPECT_NEAR(area, 20 * 16, 20);
}

TEST(FergusonMake, RefusesAFoldedGrid) {
  FergusonBase swapped = random_grid(5, 5, 0.3, 0.2, 9);
  std::swap(swapped.points[11], swapped.points[12]);
  const Result<FergusonSurface> made = FergusonSurface::make(swapped);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kInput);
  EXPECT_NE(made.error().message.find("folded"), std::string::npos);

  FergusonBase flat = random_grid(4, 4, 0, 0, 9);
  for (Vec3& p : flat.points) p.y() = p.x();
  EXPECT_FALSE(FergusonSurface::make(flat));

  FergusonBase collapsed = random_grid(4, 4, 0, 0, 9);
  for (std::size_t i = 0; i < 4; ++i) collapsed.points[i] = collapsed.points[0];
  EXPECT_FALSE(FergusonSurface::make(collapsed));
}

// A strip wound more than once about the origin, its radius growing by `drift` a radian.
FergusonBase wound_strip(double drift) {
  FergusonBase base;
  base.columns = 26;
  base.rows = 3;
  for (int j = 0; j < base.rows; ++j) {
    for (int i = 0; i < base.columns; ++i) {
      const double angle = 0.31 * i, radius = 8 - j + drift * angle;
      base.points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.1 * i);
    }
  }
  return base;
}

TEST(FergusonMake, RefusesAPlanThatOverlapsItself) {
  EXPECT_TRUE(FergusonSurface::make(wound_strip(0.5)));  // 3.1 a turn, wider than the strip
  const Result<FergusonSurface> made = FergusonSurface::make(wound_strip(0.1));
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("overlaps"), std::string::npos) << made.error().message;
}

// A patch so bent that Newton's method from its middle can leave it: every point of it is found all
// the same.
TEST(FergusonMake, FindsEveryPointOfAStronglyBentPatch) {
  FergusonBase base;
  base.columns = 3;
  base.rows = 2;
  for (const auto& [x, y] :
       {std::pair{-10.0, 0.0}, {0.0, 9.0}, {10.0, 0.0}, {-6.0, -4.0}, {0.0, 2.0}, {6.0, -4.0}}) {
    base.points.emplace_back(x, y, x + y);
  }
  const Result<FergusonSurface> made = FergusonSurface::make(base);
  ASSERT_TRUE(made);
  for (int i = 0; i <= 400; ++i) {
    for (int j = 0; j <= 100; ++j) {
      const Vec3 p = made->point(i / 200.0, j / 100.0).r;
      BaseHit hit;
      FergusonHint hint;
      ASSERT_TRUE(made->at(p.x(), p.y(), hit, hint)) << i << ' ' << j;
      EXPECT_NEAR(hit.z, p.z(), 1e-12 * 10);
    }
  }
}

TEST(Plane, HeightsSlopesAndBounds) {
  const PlaneSurface plane({Vec3(1, 2, 3), Vec3(0.6, 0, 0.8)});
  BaseHit hit;
  ASSERT_TRUE(plane.at(5, -7, hit));
  EXPECT_NEAR(hit.z, 3 - 0.75 * 4, 1e-15);
  EXPECT_NEAR(hit.zx, -0.75, 1e-15);
  EXPECT_EQ(hit.zy, 0);
  const double xs[] = {-1, 5};
  double z[2];
  plane.row(-7, xs, z);
  EXPECT_EQ(z[1], hit.z);
  const BaseBounds b = plane.bounds({0, 4, -1, 1});
  EXPECT_EQ(b.coverage, Coverage::kInside);
  EXPECT_LE(b.z.lo, 0.75);
  EXPECT_GE(b.z.hi, 3.75);
  EXPECT_NEAR(b.z.hi - b.z.lo, 3, 1e-12);
}

}  // namespace
}  // namespace diesink
