// The labelled plan: its books kept (every arc between the regions its labels name), its labels
// those of evaluation, and the regions of spheres counted by main force.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/arrangement.h"

#include <gtest/gtest.h>

#include <map>

#include "core/compound/compound_impl.h"
#include "tests/support/load_part.h"
#include "tests/support/named_cases.h"
#include "tests/support/random_program.h"

namespace diesink::test {
namespace {

Result<Arrangement> arrange_part(const CompoundSurface& surface, double tolerance) {
  const Machining& m = surface.program().machining;
  ArrangementOptions options;
  options.tolerance = tolerance;
  const PlanBox domain{m.x_range[0], m.x_range[1], m.y_range[0], m.y_range[1]};
  Result<Arrangement> made = arrange(surface, domain, options);
  // As tessellate() does.
  while (made && made->disorder > 0 && ++options.variant < 8)
    made = arrange(surface, domain, options);
  return made;
}

// What is wrong with the books; empty where nothing is.
std::string book_faults(const Arrangement& a) {
  std::vector<std::array<int, 2>> uses(a.arcs.size(), {0, 0});
  for (std::size_t r = 0; r < a.regions.size(); ++r) {
    for (const auto& loop : a.regions[r].loops) {
      if (loop.empty()) return "an empty loop";
      for (std::size_t k = 0; k < loop.size(); ++k) {
        const PlanArc& arc = a.arcs[loop[k].arc];
        ++uses[loop[k].arc][loop[k].forward ? 0 : 1];
        if ((loop[k].forward ? arc.left : arc.right) != a.regions[r].label)
          return "a region's label is not that of its side of an arc";
        const PlanArc& next = a.arcs[loop[(k + 1) % loop.size()].arc];
        const std::uint32_t end = loop[k].forward ? arc.nodes.back() : arc.nodes.front();
        const std::uint32_t begin =
            loop[(k + 1) % loop.size()].forward ? next.nodes.front() : next.nodes.back();
        if (end != begin) return "a loop with a gap";
      }
    }
  }
  for (std::size_t k = 0; k < a.arcs.size(); ++k) {
    if (uses[k][0] != 1) return "an arc whose left side belongs to no region, or to several";
    if (uses[k][1] != (a.arcs[k].border ? 0 : 1))
      return "an arc whose right side belongs to no region, or to several";
    if (a.arcs[k].curves.size() + 1 != a.arcs[k].nodes.size()) return "stretches without curves";
    if (!a.arcs[k].border && a.arcs[k].left == a.arcs[k].right)
      return "an arc between the same labels";
    if (a.arcs[k].closed != (a.arcs[k].nodes.front() == a.arcs[k].nodes.back()) && a.arcs[k].closed)
      return "a closed arc that does not end where it begins";
  }
  return "";
}

// The label over a plan point by the arrangement alone: how often each region's loops, as polygons,
// go round it. Empty where the point is within `near` of an arc.
std::optional<Label> label_over(const Arrangement& a, double x, double y, double near) {
  std::optional<Label> found;
  for (const PlanRegion& region : a.regions) {
    int turns = 0;
    for (const auto& loop : region.loops) {
      for (const ArcUse& use : loop) {
        const std::vector<std::uint32_t>& nodes = a.arcs[use.arc].nodes;
        for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
          const PlanNode* p = &a.nodes[nodes[k]];
          const PlanNode* q = &a.nodes[nodes[k + 1]];
          if (!use.forward) std::swap(p, q);
          const Vec2 d(q->x - p->x, q->y - p->y), e(x - p->x, y - p->y);
          const double s = std::clamp(d.dot(e) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
          if ((e - s * d).norm() <= near + 0.05 * d.norm()) return std::nullopt;
          const double side = d.x() * e.y() - d.y() * e.x();
          if (p->y <= y && q->y > y && side > 0) ++turns;
          if (p->y > y && q->y <= y && side < 0) --turns;
        }
      }
    }
    if (turns == 1) {
      if (found) return kNoLabel - 1;  // in two regions: no label at all
      found = region.label;
    } else if (turns != 0) {
      return kNoLabel - 1;
    }
  }
  return found ? found : std::optional<Label>(kNoLabel - 1);
}

void expect_sound(const CompoundSurface& surface, double tolerance, const std::string& what) {
  const Result<Arrangement> made = arrange_part(surface, tolerance);
  ASSERT_TRUE(made) << what;
  EXPECT_EQ(book_faults(*made), "") << what;
  Random random(3);
  const PlanBox& b = made->box;
  int wrong = 0, seen = 0;
  for (int k = 0; k < 400; ++k) {
    const double x = random.uniform(b.x0, b.x1), y = random.uniform(b.y0, b.y1);
    const std::optional<Label> label = label_over(*made, x, y, 2 * tolerance);
    if (!label) continue;
    ++seen;
    const Label truth = surface.impl().evaluate_face(x, y).label;
    if (*label != truth) ++wrong;
  }
  EXPECT_EQ(wrong, 0) << what << " of " << seen;
}

TEST(Arrangement, BooksAndLabelsOfTheFixtures) {
  for (const char* name : {"fig6", "spheres", "inch", "groups", "nobase"}) {
    const CompoundSurface surface = fixture(name);
    expect_sound(surface, surface.program().machining.tolerance, name);
  }
}

TEST(Arrangement, BooksAndLabelsOfTheNamedCases) {
  for (const NamedCase& c : named_cases()) expect_sound(surface_of(c.text), c.tolerance, c.name);
}

// Spheres on a plane, all added. The regions are counted on a lattice by flood filling equal
// labels, where that is fine enough to part them: twice as fine a lattice counts the same.
std::map<Label, int> counted(const CompoundSurface& surface, int side) {
  const Machining& m = surface.program().machining;
  const auto n = static_cast<std::size_t>(side);
  std::vector<Label> label(n * n);
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < n; ++i) {
      const auto at = [&](const std::array<double, 2>& r, std::size_t k) {
        return r[0] + (r[1] - r[0]) * (static_cast<double>(k) + 0.5) / side;
      };
      const std::optional<CcDatum> hit = surface.at(at(m.x_range, i), at(m.y_range, j));
      label[j * n + i] =
          hit ? make_label(hit->row, static_cast<std::uint32_t>(hit->face)) : kNoLabel;
    }
  }
  std::map<Label, int> regions;
  std::vector<char> done(n * n, 0);
  std::vector<std::size_t> stack;
  for (std::size_t start = 0; start < n * n; ++start) {
    if (done[start]) continue;
    ++regions[label[start]];
    stack.assign(1, start);
    done[start] = 1;
    while (!stack.empty()) {
      const std::size_t k = stack.back();
      stack.pop_back();
      const auto go = [&](bool there, std::size_t to) {
        if (!there || done[to] || label[to] != label[k]) return;
        done[to] = 1;
        stack.push_back(to);
      };
      go(k % n > 0, k - 1);
      go(k % n + 1 < n, k + 1);
      go(k >= n, k - n);
      go(k + n < n * n, k + n);
    }
  }
  return regions;
}

TEST(Arrangement, RegionsOfAddedSpheresAreThoseOfABruteForceCount) {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    std::string solids, expression;
    for (int k = 1; k <= 8; ++k) {
      const std::string id = "S" + std::to_string(k);
      const auto number = [&](double lo, double hi) {
        return std::to_string(random.uniform(lo, hi));
      };
      const std::string x = number(4, 36), y = number(4, 36), z = number(-3, 1);
      solids += sphere(id, x + "," + y + "," + z, number(3.5, 9));
      expression += "+" + id;
    }
    const CompoundSurface surface = surface_of(on_plane(solids, expression));
    const std::map<Label, int> coarse = counted(surface, 350);
    if (coarse != counted(surface, 700)) continue;  // something finer than the lattice
    const Result<Arrangement> made = arrange_part(surface, 0.01);
    ASSERT_TRUE(made);
    std::map<Label, int> regions;
    for (const PlanRegion& r : made->regions) ++regions[r.label];
    EXPECT_EQ(regions, coarse) << seed;
    ++compared;
  }
  EXPECT_GE(compared, 4);
}

// Arcs from one corner to another that coordinates hardly tell from it.
int doubled_corners(const Arrangement& a, double near) {
  int found = 0;
  for (const PlanArc& arc : a.arcs) {
    const PlanNode &p = a.nodes[arc.nodes.front()], &q = a.nodes[arc.nodes.back()];
    if (arc.nodes.front() != arc.nodes.back() && std::hypot(p.x - q.x, p.y - q.y) <= near) ++found;
  }
  return found;
}

// Where the rim of an oblique recess dips below the plate and its silhouette ends, two cells side
// by side may both find the corner: one as the meeting of three faces, one as a least cell.
// Equal cylinders: the crease crosses itself in a point that no two curves tell, in a cell of its
// own wherever the cells lie.
TEST(Arrangement, WhereACreaseCrossesItselfItsCornerIsExact) {
  for (const NamedCase& one : named_cases()) {
    if (one.name != "Steinmetz" && one.name != "SteinmetzPocket") continue;
    for (const double by : {0.0, -32.0, 3.0}) {
      const CompoundSurface surface = surface_of(moved(one.text, by));
      for (int variant = 0; variant < 8; ++variant) {
        ArrangementOptions options;
        options.tolerance = one.tolerance;
        options.variant = variant;
        const Result<Arrangement> made = arrange(surface, {by, 40 + by, by, 40 + by}, options);
        ASSERT_TRUE(made);
        double nearest = 1e300;
        for (const PlanNode& node : made->nodes) {
          const double away = std::hypot(node.x - 20 - by, node.y - 20 - by);
          if (node.corner) nearest = std::min(nearest, away);
        }
        EXPECT_LE(nearest, 1e-12 * surface.size()) << one.name << " variant " << variant;
      }
    }
  }
}

TEST(Arrangement, ACornerThatTwoCellsFindIsOne) {
  for (const char* recess : {"P1,151.7154,2685.6383,-0.5970\nNOR,0.0650,-0.0430,1.0\nLVE,-0.4995,0."
                             "4126,0.1\nL-R,23.9610\nS-R,16.1661\nLEN,23.8427\n",
                             "P1,150.3257,2646.5464,-0.9713\nNOR,-0.0761,0.0708,1.0\nLVE,0.9899,0."
                             "2075,0.1\nL-R,28.1350\nS-R,19.9769\nLEN,20.2395\n"}) {
    const CompoundSurface surface =
        surface_of(on_plane(std::string("S,E-CYLI,2\n") + recess, "-S", "0,4000", "0,4000"));
    const Result<Arrangement> made = arrange_part(surface, 0.05);
    ASSERT_TRUE(made);
    EXPECT_EQ(book_faults(*made), "");
    EXPECT_EQ(doubled_corners(*made, 1e-9 * surface.size()), 0) << recess;
  }
}

}  // namespace
}  // namespace diesink::test
