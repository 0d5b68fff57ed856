// What is proven to be out of a cutter's reach, against fine lattices of cutters and of places.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/reach_proof.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "core/machining/tool_path_plan.h"
#include "core/machining/uncut_proof.h"
#include "core/tessellate/tessellate.h"
#include "tests/support/load_part.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A pocket with upright walls, 20 by 14 and 5 deep, in level ground.
constexpr double kWide = 20, kDeep = 14, kDepth = 5;
const std::string kPocket =
    "SOLID-DEF\nS1,4-PRIS,3\nP1,10,10,-5\nP2,30,24,5\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB-S1\n"
    "MACHI-DEF\nX-RNG,4,36\nY-RNG,4,30\nX-INT,1\nY-INT,1\nTOLER,.02\n";

// Heights of a surface over a lattice that goes a radius beyond the domain on all sides, dilated
// and eroded by the cutter: what it leaves from the lattice's points in the domain. A rim a little
// further out holds for certain what points between the lattice's would, one further in is held by
// no more than those.
class LatticeClosing {
 public:
  LatticeClosing(const CompoundSurface& surface, const CutterShape& cutter, double step,
                 double wider)
      : step_(step), beyond_(static_cast<long>(std::ceil(cutter.radius() / step)) + 1) {
    const Machining& m = surface.program().machining;
    columns_ = std::lround((m.x_range[1] - m.x_range[0]) / step) + 1;
    rows_ = std::lround((m.y_range[1] - m.y_range[0]) / step) + 1;
    width_ = columns_ + 2 * beyond_;
    const long height = rows_ + 2 * beyond_;
    z_.assign(static_cast<std::size_t>(width_ * height), -kInfinity);
    for (long j = 0; j < height; ++j) {
      for (long i = 0; i < width_; ++i) {
        const auto cc = surface.at(m.x_range[0] + static_cast<double>(i - beyond_) * step,
                                   m.y_range[0] + static_cast<double>(j - beyond_) * step);
        if (cc) z_[static_cast<std::size_t>(j * width_ + i)] = cc->z;
      }
    }
    std::vector<double> tips(static_cast<std::size_t>(columns_ * rows_), -kInfinity);
    left_.assign(tips.size(), kInfinity);
    for (long b = -beyond_; b <= beyond_; ++b) {
      for (long a = -beyond_; a <= beyond_; ++a) {
        const double rho = step * std::hypot(a, b);
        if (rho > cutter.radius() + wider) continue;
        const double high = cutter.height(std::min(rho, cutter.radius()));
        for (long j = 0; j < rows_; ++j) {
          const double* z = z_.data() + (j + b + beyond_) * width_ + a + beyond_;
          double* tip = tips.data() + j * columns_;
          for (long i = 0; i < columns_; ++i) tip[i] = std::max(tip[i], z[i] - high);
        }
      }
    }
    for (long b = -beyond_; b <= beyond_; ++b) {
      for (long a = -beyond_; a <= beyond_; ++a) {
        const double rho = step * std::hypot(a, b);
        if (rho > cutter.radius() + wider) continue;
        const double high = cutter.height(std::min(rho, cutter.radius()));
        for (long j = std::max(0L, -b); j < std::min(rows_, rows_ - b); ++j) {
          for (long i = std::max(0L, -a); i < std::min(columns_, columns_ - a); ++i) {
            double& left = left_[static_cast<std::size_t>(j * columns_ + i)];
            left =
                std::min(left, tips[static_cast<std::size_t>((j + b) * columns_ + i + a)] + high);
          }
        }
      }
    }
  }

  // The plan area over which the surface comes nowhere within `distance` of what is left.
  [[nodiscard]] double area(double distance) const {
    const long near = static_cast<long>(distance / step_) + 1;
    double count = 0;
    for (long j = 0; j < rows_; ++j) {
      for (long i = 0; i < columns_; ++i) {
        const double left = left_[static_cast<std::size_t>(j * columns_ + i)];
        const double* z = z_.data() + (j + beyond_) * width_ + i + beyond_;
        if (!(*z > -kInfinity) || left - *z <= distance) continue;
        bool out = true;
        for (long b = -near; b <= near && out; ++b) {
          for (long a = -near; a <= near && out; ++a) {
            const double down = std::max(0.0, left - z[b * width_ + a]);
            out = step_ * step_ * static_cast<double>(a * a + b * b) + down * down >
                  distance * distance;
          }
        }
        if (!out) continue;
        count += (i == 0 || i + 1 == columns_ ? 0.5 : 1) * (j == 0 || j + 1 == rows_ ? 0.5 : 1);
      }
    }
    return count * step_ * step_;
  }

 private:
  double step_;
  long beyond_, columns_ = 0, rows_ = 0, width_ = 0;
  std::vector<double> z_, left_;
};

struct Planned {
  PathReport report;
  double limit = 0;
};

Planned planned(const CompoundSurface& surface, const Cutter& cutter, double cusp, double outtol) {
  PathOptions options;
  options.cutter = cutter;
  options.cusp = cusp;
  options.intol = options.outtol = outtol;
  options.threads = 2;
  const Result<PlannedPath> path = plan_path(surface, options);
  EXPECT_TRUE(path);
  return {path ? path->report : PathReport{}, outtol + cusp};
}

// What a path has to leave uncut lies between what it may not leave by its limit and what the
// cutter leaves more than that it is told from at; both close in on the same as the limit falls.
TEST(OutOfReach, Fig6BetweenWhatALatticeTells) {
  const CompoundSurface surface = test::fixture("fig6");
  constexpr double kStep = 0.1;
  for (const Cutter& cutter : {Cutter{6, 3}, Cutter{6, 0}, Cutter{6, 1}}) {
    const CutterShape shape = *CutterShape::make(cutter);
    const LatticeClosing less(surface, shape, kStep, -kStep), more(surface, shape, kStep, kStep);
    for (const double cusp : {0.1, 0.03}) {
      const Planned path = planned(surface, cutter, cusp, 0.02);
      EXPECT_GE(path.report.unreachable_area, less.area(path.limit)) << cutter.corner_radius;
      EXPECT_LE(path.report.unreachable_area, more.area(std::min(0.02, 0.4 * path.limit)))
          << cutter.corner_radius;
      EXPECT_LE(path.report.left_area + path.report.unsettled_area, 1e-3);
      // Next to all of it is proven, and what is proven is out of reach.
      EXPECT_LE(path.report.unproven_area, 0.02 * path.report.unreachable_area);
    }
  }
}

// Over a floor between upright walls the cutter's axis stays a radius from them: where the nearest
// such place is so far, what stands is its profile there, or a wall is nearer.
double pocket_area(const CutterShape& cutter, double limit) {
  constexpr double kStep = 0.005;
  const double R = cutter.radius();
  double corner = 0;
  for (double y = kStep / 2; y < R; y += kStep) {
    for (double x = kStep / 2; x < R; x += kStep) {
      const double off = std::hypot(R - x, R - y);
      const double stands = off > R ? kDepth : cutter.height(off);
      if (std::min({stands, x, y}) > limit) corner += kStep * kStep;
    }
  }
  double across = 0;
  for (double x = kStep / 2; x < R; x += kStep) {
    if (std::min(cutter.height(R - x), x) > limit) across += kStep;
  }
  return 4 * corner + across * 2 * (kWide - 2 * R + kDeep - 2 * R);
}

TEST(OutOfReach, APocketsCornersAndFeetAreWhatTheyAre) {
  const CompoundSurface surface = test::surface_of(kPocket);
  for (const Cutter& cutter : {Cutter{6, 3}, Cutter{6, 0}, Cutter{6, 1}}) {
    const CutterShape shape = *CutterShape::make(cutter);
    double before = kInfinity;
    for (const double cusp : {0.1, 0.02}) {
      const Planned path = planned(surface, cutter, cusp, 0.01);
      const double least = pocket_area(shape, path.limit), most = pocket_area(shape, 0.004);
      EXPECT_GE(path.report.unreachable_area, 0.999 * least) << cutter.corner_radius;
      EXPECT_LE(path.report.unreachable_area, 1.001 * most) << cutter.corner_radius;
      EXPECT_LE(path.report.left_area + path.report.unsettled_area, 1e-3);
      // A flat end reaches all of the floor up to the arcs in the corners, and a path all but so
      // much.
      const double arcs = 2 * std::numbers::pi * shape.radius();
      EXPECT_LE(path.report.unproven_area, 0.02 * path.report.unreachable_area + 0.03 * arcs);
      EXPECT_LE(most - least, before);
      before = most - least;
    }
  }
}

// The parts themselves, without any path.
TEST(OutOfReach, NoCutterComesLowOverWhatIsProvenToBe) {
  const CompoundSurface surface = test::fixture("fig6");
  TessellationOptions fine;
  fine.tolerance = 0.01;
  const Result<Tessellation> mesh = tessellate(surface, fine);
  ASSERT_TRUE(mesh);
  const double deviation = mesh->report.deviation_where_certified();
  constexpr double kOut = 0.05;
  test::Random random(7);
  for (const Cutter& cutter : {Cutter{6, 3}, Cutter{6, 0}, Cutter{6, 1}}) {
    const CutterShape shape = *CutterShape::make(cutter);
    const OffsetSurface offset(mesh->mesh, shape, 0);
    const PointDrop drop(offset);
    const FrameDomain domain(offset, {1, 39, 1, 39});
    UncutProof proof(mesh->mesh, offset, shape, domain, 0.1, 1);
    const ReachProof reach(surface, offset, drop, shape, domain, deviation);
    ReachProof::Search search(reach);
    proof.tell_reach(reach, kOut + deviation);
    std::size_t out = 0, in = 0;
    double closest = kInfinity;
    for (int round = 0; round < 1500; ++round) {
      FacetPart part =
          proof.all()[static_cast<std::size_t>(random.below(static_cast<int>(proof.all().size())))];
      while (std::max(part.box().x1 - part.box().x0, part.box().y1 - part.box().y0) > 0.4) {
        part = halves(part)[static_cast<std::size_t>(random.below(2))];
        if (part.size < 3) break;
      }
      if (part.size < 3) continue;
      ReachProof::Question question;
      question.lift = proof.lift(part, kOut + deviation);
      question.low = (kOut + deviation) / proof.normal(part).z();
      question.most_boxes = 1024;
      ReachProof::Search::Rest all = search.all(part);
      const ReachProof::Answer answer = search.ask(part, question, all);
      const Vec3 p = part.middle();
      if (answer.reach == ReachProof::Reach::kIn) {
        ++in;
        EXPECT_GE(answer.tip.z(), drop.at(answer.tip.x(), answer.tip.y()) - 1e-9);
        continue;
      }
      if (answer.reach != ReachProof::Reach::kOut) continue;
      ++out;
      // The lowest that is found all round, and then around that.
      double least = kInfinity;
      Vec2 best = p.head<2>();
      for (int k = 0; k < 3000; ++k) {
        const double wide = k < 1500 ? 3 : 3 * std::pow(0.995, k - 1500);
        const double turn = random.uniform(0, 6.2831853), far = wide * random.uniform(0, 1);
        const Vec2 from = k < 1500 ? Vec2(p.head<2>()) : best;
        const Vec2 c = from + far * Vec2(std::cos(turn), std::sin(turn));
        const double rho = (c - p.head<2>()).norm();
        if (rho > 3 || c.x() < 1 || c.x() > 39 || c.y() < 1 || c.y() > 39) continue;
        const double stays = drop.at(c.x(), c.y()) + shape.height(rho) - p.z();
        if (!(stays < least)) continue;
        least = stays;
        best = c;
      }
      ASSERT_GT(least, kOut / proof.normal(part).z()) << p.transpose();
      closest = std::min(closest, least * proof.normal(part).z());
    }
    EXPECT_GT(out, 20U);
    EXPECT_LT(closest, 2 * kOut);  // some are told by little
    EXPECT_GT(in, 20U);
  }
}

}  // namespace
}  // namespace diesink
