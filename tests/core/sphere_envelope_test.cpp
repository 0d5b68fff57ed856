// Meshes of spheres, all added, against their envelope counted by other means: faces, creases,
// jumps, edges, corners, lengths, places and areas.
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/sphere_envelope.h"

#include <gtest/gtest.h>

#include "tests/support/envelope_checks.h"
#include "tests/support/load_part.h"
#include "tests/support/mesh_deviation.h"
#include "tests/support/power_cells.h"

namespace diesink::test {
namespace {

// Centres and radii are whole eighths, so that the program's text says them exactly.
SphereScene draw_scene(Random& random, int spheres, bool plane) {
  SphereScene scene;
  scene.plane = plane;
  const int largest = spheres > 8 ? 40 : 72;
  const auto eighths = [&](int low, int high) {
    return 0.125 * (low + random.below(high - low + 1));
  };
  for (int k = 0; k < spheres; ++k) {
    SceneSphere s;
    s.centre.x() = eighths(0, 320);
    s.centre.y() = eighths(0, 320);
    s.centre.z() = eighths(-48, 40);
    s.radius = eighths(12, largest);
    scene.spheres.push_back(s);
  }
  return scene;
}

std::string faults_of_scene(const SphereScene& scene, const Envelope& exact, double tolerance) {
  const CompoundSurface surface = surface_of(scene_text(scene));
  TessellationOptions options;
  options.tolerance = tolerance;
  options.threads = 1;
  const Result<Tessellation> made = tessellate(surface, options);
  if (!made) return to_text(made.error());
  Faults faults;
  check_against_envelope(exact, *made, surface.size(), faults);
  return faults.text();
}

TEST(SphereEnvelope, MeshesHaveTheCountedFacesCurvesAndCorners) {
  int compared = 0, refused = 0;
  std::size_t corners = 0, creases = 0, jumps = 0, edges = 0, closed = 0, split = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Random random(1000003 * seed);
    const int spheres = seed % 10 == 0 ? 14 : 1 + static_cast<int>(seed % 7);
    const SphereScene scene = draw_scene(random, spheres, seed % 3 != 0);
    const std::optional<Envelope> exact = count_envelope(scene);
    if (!exact) {
      ++refused;
      continue;
    }
    if (exact->arcs.empty() && !scene.plane) continue;  // all of it beyond the domain
    EXPECT_EQ(faults_of_scene(scene, *exact, 0.05), "") << "seed " << seed << '\n'
                                                        << scene_text(scene);
    ++compared;
    corners += exact->vertices.size();
    for (const EnvelopeArc& arc : exact->arcs) {
      ++(arc.kind == CurveKind::kCrease ? creases : arc.kind == CurveKind::kJump ? jumps : edges);
      closed += arc.from < 0 ? 1 : 0;
    }
    for (const auto& [label, count] : exact->faces) split += count > 1 ? 1 : 0;
  }
  std::printf(
      "%d scenes, %d refused; %zu corners, %zu creases, %zu jumps, %zu edges, %zu closed, %zu "
      "parted\n",
      compared, refused, corners, creases, jumps, edges, closed, split);
  EXPECT_GE(compared, 300);
  EXPECT_GE(std::min({corners, creases, jumps, edges, closed}), 300u);
  EXPECT_GE(split, 30u);  // an element in several pieces
}

// Spheres with centres at one height over the plane z = 0 (or nothing), on whole numbers.
struct LevelScene {
  struct Ball {
    int x, y, r;
  };
  std::vector<Ball> balls;
  int height = 0;
  bool plane = true;
};

constexpr int kSide = 24;

std::string text_of(const LevelScene& scene) {
  SphereScene spheres;
  spheres.plane = scene.plane;
  spheres.side = kSide;
  for (const LevelScene::Ball& b : scene.balls)
    spheres.spheres.push_back({Vec3(b.x, b.y, scene.height), static_cast<double>(b.r)});
  return scene_text(spheres);
}

// What was among the scenes, and what may be amiss where spheres only touch: a crease of a hair's
// length in place of a point, or an area told as not certified.
struct LevelTally {
  int creases = 0, hidden = 0, pieces = 0, hairs = 0, uncertified = 0;
};

// Faces, areas, creases and their ends, rims; of a scene in the middle of the domain.
std::string faults_of_level_scene(const LevelScene& scene, double tolerance, LevelTally& tally) {
  const CompoundSurface surface = surface_of(text_of(scene));
  TessellationOptions options;
  options.tolerance = tolerance;
  options.threads = 1;
  const Result<Tessellation> made = tessellate(surface, options);
  if (!made) return to_text(made.error());
  // Spheres whose middle is under the plane show what is above it.
  const int under = scene.plane && scene.height < 0 ? scene.height * scene.height : 0;
  std::vector<PowerCells::Disc> discs;
  std::vector<int> number;  // of a disc's sphere
  for (std::size_t k = 0; k < scene.balls.size(); ++k) {
    const LevelScene::Ball& b = scene.balls[k];
    if (b.r * b.r <= under) continue;
    discs.push_back({b.x, b.y, b.r * b.r - under});
    number.push_back(static_cast<int>(k) + 1);
  }
  const PowerCells exact(discs);
  Faults faults;
  check_topology(made->mesh, false, faults);
  std::map<std::string, int> pieces = pieces_of(made->mesh);
  std::map<std::string, double> areas = plan_areas(made->mesh);
  std::map<std::string, std::vector<double>> creases;
  std::map<std::string, double> rims;
  const CurveKind rim_kind = !scene.plane       ? CurveKind::kEdge
                             : scene.height > 0 ? CurveKind::kJump
                                                : CurveKind::kCrease;
  const std::string outside = scene.plane ? "B" : "";
  for (const CurveReport& c : made->report.curves) {
    if (c.between[0] == outside || c.between[1] == outside) {
      rims[c.between[c.between[0] == outside ? 1 : 0]] += c.length;
      if (c.kind != rim_kind) faults.add("the kind of a rim");
    } else if (c.length < 5e-6 * kSide) {
      ++tally.hairs;
    } else {
      creases[sorted_pair(c.between)].push_back(c.length);
      if (c.kind != CurveKind::kCrease) faults.add("the kind of a crease");
    }
  }
  double rest = kSide * kSide;
  for (std::size_t k = 0; k < discs.size(); ++k) {
    const std::string name = scene_element(number[k]);
    const int count = exact.seen(static_cast<int>(k)) ? 1 : 0;
    if (pieces[name] != count) faults.add("pieces of " + name, pieces[name], count);
    if (count == 0) {
      ++tally.hidden;
      continue;
    }
    double area = 0;
    const double radius = std::sqrt(discs[k].square),
                 rim = exact.rim_angle(static_cast<int>(k), &area) * radius;
    rest -= area;
    // What is less than a tolerance wide may go over to the neighbour.
    if (!(std::fabs(areas[name] - area) <= tolerance * 2 * std::numbers::pi * radius))
      faults.add("plan area of " + name, areas[name], area);
    if (!(rims[name] <= rim + 1e-9 * kSide && rims[name] >= rim * (1 - tolerance / radius)))
      faults.add("rim of " + name, rims[name], rim);
  }
  if (scene.plane) {
    if (pieces["B"] != exact.outside_pieces())
      faults.add("pieces of the plane", pieces["B"], exact.outside_pieces());
    if (!(std::fabs(areas["B"] - rest) <= tolerance * 200))
      faults.add("plan area of the plane", areas["B"], rest);
  }
  std::vector<Vec2> ends;
  for (const MeshCurve& c : made->mesh.curves) {
    if (c.closed) continue;
    ends.emplace_back(made->mesh.positions[c.vertices.front()].head<2>());
    ends.emplace_back(made->mesh.positions[c.vertices.back()].head<2>());
  }
  std::size_t told = 0;
  for (const auto& [pair, lengths] : creases) told += lengths.size();
  if (told != exact.creases().size())
    faults.add("creases", static_cast<double>(told), static_cast<double>(exact.creases().size()));
  for (const PowerCells::Crease& c : exact.creases()) {
    const auto one = static_cast<std::size_t>(c.one);
    const std::string pair = sorted_pair(
        {scene_element(number[one]), scene_element(number[static_cast<std::size_t>(c.other)])});
    // An upright circle about the foot of the centre on the crease.
    const LevelScene::Ball& b = scene.balls[static_cast<std::size_t>(number[one] - 1)];
    const Vec2 way = (c.to - c.from).normalized(), from = c.from - Vec2(b.x, b.y);
    const double s0 = from.dot(way), s1 = s0 + (c.to - c.from).norm(),
                 radius = std::sqrt(b.r * b.r - (from - s0 * way).squaredNorm());
    const double length =
        radius * (std::asin(std::min(s1 / radius, 1.0)) - std::asin(std::max(s0 / radius, -1.0)));
    const std::vector<double>& found = creases[pair];
    if (found.size() != 1) {
      faults.add("creases " + pair, static_cast<double>(found.size()), 1);
    } else if (found[0] > length + 1e-9 * kSide || found[0] < length * (1 - tolerance / radius)) {
      faults.add("length of " + pair, found[0], length);
    }
    for (const Vec2& p : {c.from, c.to}) {
      double least = HUGE_VAL;
      for (const Vec2& q : ends) least = std::min(least, (p - q).norm());
      if (!(least <= 1e-9 * kSide))
        faults.add("an end of " + pair + " off by", least, 1e-9 * kSide);
    }
  }
  tally.creases += static_cast<int>(exact.creases().size());
  tally.pieces += scene.plane ? exact.outside_pieces() - 1 : 0;
  tally.uncertified += made->report.uncertified_area > 0 ? 1 : 0;
  return faults.text();
}

TEST(SphereEnvelope, LevelSpheresOnWholeNumbersAreCountedWithoutRounding) {
  LevelTally tally;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Random random(1000003 * seed);
    LevelScene scene;
    scene.plane = seed % 4 != 0;
    scene.height = scene.plane ? static_cast<int>(seed % 3) - 1 : 0;
    const int count = 2 + random.below(6);
    for (int k = 0; k < count; ++k)
      scene.balls.push_back({8 + random.below(9), 8 + random.below(9), 1 + random.below(5)});
    EXPECT_EQ(faults_of_level_scene(scene, 0.02, tally), "") << "seed " << seed << '\n'
                                                             << text_of(scene);
  }
  std::printf("%d creases, %d hidden, %d more pieces of the plane, %d hairs, %d uncertified\n",
              tally.creases, tally.hidden, tally.pieces, tally.hairs, tally.uncertified);
  EXPECT_GE(tally.creases, 200);
  EXPECT_GE(tally.hidden, 50);
  EXPECT_GE(tally.pieces, 3);
  EXPECT_EQ(tally.hairs, 0);
  EXPECT_LE(tally.uncertified, 3);
}

TEST(SphereEnvelope, LevelSpheresThatTouchCoincideOrMeetInOnePoint) {
  struct Case {
    const char* what;
    LevelScene scene;
  };
  std::vector<Case> cases;
  for (const int height : {-1, 0, 1}) {
    const auto add = [&](const char* what, const std::vector<LevelScene::Ball>& balls) {
      cases.push_back({what, {balls, height, true}});
      if (height == 0) cases.push_back({what, {balls, height, false}});
    };
    add("two that touch", {{8, 12, 4}, {16, 12, 4}});
    add("one in another that touches it", {{12, 12, 5}, {14, 12, 3}});
    add("equal", {{12, 12, 5}, {12, 12, 5}});
    add("one under another", {{12, 12, 3}, {12, 12, 5}});
    add("one under two", {{12, 12, 2}, {10, 12, 5}, {14, 12, 5}});
    add("three in a line", {{8, 12, 4}, {12, 12, 4}, {16, 12, 4}});
    add("four through one point", {{9, 12, 5}, {15, 12, 5}, {12, 9, 5}, {12, 15, 5}});
    add("four round a hole", {{7, 7, 5}, {15, 7, 5}, {7, 15, 5}, {15, 15, 5}});
    add("four that touch round a hole", {{8, 8, 4}, {16, 8, 4}, {8, 16, 4}, {16, 16, 4}});
    add("four through the middle of a fifth",
        {{12, 12, 5}, {9, 12, 3}, {15, 12, 3}, {12, 9, 3}, {12, 15, 3}});
    add("far apart", {{6, 6, 3}, {18, 18, 3}});
  }
  LevelTally tally;
  for (const Case& c : cases) {
    EXPECT_EQ(faults_of_level_scene(c.scene, 0.02, tally), "")
        << c.what << " at " << c.scene.height << '\n'
        << text_of(c.scene);
  }
  std::printf("%d hairs, %d uncertified\n", tally.hairs, tally.uncertified);
  EXPECT_EQ(tally.hairs, 0);
  EXPECT_EQ(tally.uncertified, 0);
}

}  // namespace
}  // namespace diesink::test
