// Features far smaller than a grid cell, and down to 1e-4 of the domain, at random places of random
// grounds: each is there with its faces, in one piece and of the right plan area, whatever the
// tolerance and the grid.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/element_pieces.h"
#include "tests/support/load_part.h"
#include "tests/support/mesh_deviation.h"
#include "tests/support/mesh_proof.h"

namespace diesink::test {
namespace {

constexpr double kPi = std::numbers::pi;

std::string words(const std::string& keyword, std::initializer_list<double> values) {
  std::string text = keyword;
  for (const double v : values) {
    char number[40];
    std::snprintf(number, sizeof number, ",%.17g", v);
    text += number;
  }
  return text + '\n';
}

// A face that has to be seen, and over how much of the plan; `most` above `least` where the ground
// is not level under it. The perimeter bounds what chords may cost.
struct Expected {
  std::string element;
  double least = 0, most = 0, perimeter = 0;
};

struct FeatureProgram {
  std::string text;  // without MACHI-DEF
  std::vector<Expected> faces;
  double size = 0;  // of its features
  [[nodiscard]] std::string with(double tolerance, double interval) const {
    return text + "MACHI-DEF\nX-RNG,0,100\nY-RNG,0,100\n" + words("X-INT", {interval}) +
           words("Y-INT", {interval}) + words("TOLER", {tolerance});
  }
};

enum class Ground : std::uint8_t { kLevel, kTilted, kBox, kDome, kFerguson };

FeatureProgram draw(Random& random, Ground ground, double size) {
  FeatureProgram out;
  out.size = size;
  std::string solids, base = "PLANE,0\n", expression = "B";
  // Height of the ground about the middle, from the definition of what is there.
  const auto height = [&](double x, double y) {
    switch (ground) {
      case Ground::kTilted:
        return 0.2 * (x - 50) - 0.1 * (y - 50);
      case Ground::kBox:
        return 6.0;
      case Ground::kDome:
        return -10 + std::sqrt(900 - (x - 50) * (x - 50) - (y - 50) * (y - 50));
      case Ground::kFerguson:  // in x quadratic about, so that it is not known exactly
      case Ground::kLevel:
        break;
    }
    return 0.0;
  };
  if (ground == Ground::kTilted) base = "PLANE\nP1,50,50,0\nNOR,-0.2,0.1,1\n";
  if (ground == Ground::kBox) {
    solids += "G,4-PRIS,3\nP1,20,22,-3\nP2,81,79,6\n";
    expression += "+G";
  }
  if (ground == Ground::kDome) {
    solids += "G,SPHER,1\nP1,50,50,-10\nRAD,30\n";
    expression += "+G";
  }
  if (ground == Ground::kFerguson) {
    base = "FERGU,4,4\n";
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 4; ++i) {
        base += words("P", {100.0 * i / 3, 100.0 * j / 3, random.uniform(-4, 4)}).substr(2);
      }
    }
  }
  const bool level = ground == Ground::kLevel || ground == Ground::kBox;
  // Above the ground for sure, and the greatest slope that it has.
  const double slope = level ? 0 : ground == Ground::kDome ? 1.0 : 0.6;
  std::vector<Vec2> taken;
  const int count = 1 + random.below(4);
  for (int k = 0; k < count; ++k) {
    Vec2 p;
    for (bool free = false; !free;) {
      p = Vec2{random.uniform(33, 67), random.uniform(33, 67)};
      free = true;
      for (const Vec2& q : taken) free = free && (p - q).norm() > 24 * size;
    }
    taken.push_back(p);
    const std::string id = "F" + std::to_string(k + 1);
    const double x = p.x(), y = p.y(), s = size;
    double z = height(x, y);
    // Where the ground is not known, features reach through whatever it can be.
    const double deep = ground == Ground::kFerguson ? 12 : 4 * s + 12 * s * slope;
    const auto column = [&](const std::string& name, double radius, double low, double high) {
      solids += name + ",R-CYLI,1\n" + words("P1", {x, y, low}) + words("P2", {x, y, high}) +
                words("RAD", {radius});
    };
    switch (ground == Ground::kFerguson ? 1 + random.below(3) : random.below(5)) {
      case 0:
      case 4: {  // a boss or a dimple
        const bool boss = random.chance(0.5);
        solids += id + ",SPHER,1\n" + words("P1", {x, y, z}) + words("RAD", {s});
        expression += (boss ? "+" : "-") + id;
        out.faces.push_back(
            {id + ".surface", (level ? 1 : 0.5) * kPi * s * s, kPi * s * s, 2 * kPi * s});
        break;
      }
      case 1:  // a peg
        column(id, s, z - deep, z + deep);
        expression += "+" + id;
        out.faces.push_back({id + ".top", kPi * s * s, kPi * s * s, 2 * kPi * s});
        break;
      case 2: {  // a slot
        const double l = random.uniform(2, 20) * s, w = 0.5 * s;
        solids += id + ",4-PRIS,3\n" + words("P1", {x - w, y - 0.5 * l, z - deep}) +
                  words("P2", {x + w, y + 0.5 * l, z + deep + 20});
        expression += "-" + id;
        // The bottom is the side between the corners that stand out from the plan first.
        out.faces.push_back({id + ".", 2 * w * l, 2 * w * l, 0});
        break;
      }
      default: {  // an island in a pocket
        const std::string peg = "I" + std::to_string(k + 1);
        column(id, 5 * s, z - deep, z + deep + 20);
        column(peg, s, z - deep - 2 * s, z - deep + 2 * s);
        expression += "-" + id + "+" + peg;
        out.faces.push_back({id + ".bottom", 24 * kPi * s * s, 24 * kPi * s * s, 12 * kPi * s});
        out.faces.push_back({peg + ".top", kPi * s * s, kPi * s * s, 2 * kPi * s});
      }
    }
  }
  out.text = "SOLID-DEF\n" + solids + "BSURF-DEF\n" + base + "BOOLE-DEF\n" + expression + '\n';
  return out;
}

// What of the features is not there as it has to be. A tolerance above their size may leave little
// of a circle (a triangle has 0.41 of it), but not nothing.
std::string faults_of_features(const FeatureProgram& program, const Tessellation& made,
                               double tolerance) {
  Faults faults;
  const std::map<std::string, int> pieces = pieces_of(made.mesh);
  const std::map<std::string, double> areas = plan_areas(made.mesh);
  const bool coarse = tolerance > 0.1 * program.size;
  for (const Expected& face : program.faces) {
    std::string name = face.element;
    if (name.ends_with(".")) {  // the one face of a slot that is seen
      const auto it = areas.lower_bound(name + "face");
      if (it != areas.end() && it->first.starts_with(name + "face")) name = it->first;
    }
    const auto piece = pieces.find(name);
    if (piece == pieces.end()) {
      faults.add("lost: " + name);
      continue;
    }
    if (piece->second != 1) faults.add("pieces of " + name, piece->second, 1);
    const double area = areas.at(name);
    const double loss =
        coarse ? (face.perimeter > 0 ? 0.62 * face.most : 0) : tolerance * face.perimeter;
    const double slack = 1e-12 * 100 * program.size;
    // A pocket's floor loses what its island's and gains what its own chords cut off.
    const double gain = tolerance < program.size ? tolerance * face.perimeter : face.most * 0.1;
    if (!(area >= face.least - loss - slack)) faults.add("plan area of " + name, area, face.least);
    if (!(area <= face.most + gain + slack)) faults.add("plan area of " + name, area, face.most);
  }
  return faults.text();
}

TEST(TinyFeatures, AreThereWithTheirFacesAndDoNotDependOnTheGrid) {
  std::size_t faces = 0, uncertified = 0;
  std::map<std::string, int> kinds;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(777767777 * seed);
    const auto ground = static_cast<Ground>(seed % 5);
    const bool curved = ground == Ground::kDome || ground == Ground::kFerguson;
    const bool fine = seed % 2 == 0;
    // (A curved ground at a fortieth of a thousandth would be a million triangles.)
    const double size = 100 * std::pow(10, random.uniform(fine && curved ? -2.4 : -4, -2));
    const FeatureProgram program = draw(random, ground, size);
    TessellationOptions options;
    options.tolerance = fine ? size / 40 : 0.1;
    options.threads = 1;
    const Result<Tessellation> made =
        tessellate(surface_of(program.with(options.tolerance, 1.7)), options);
    const std::string what =
        "seed " + std::to_string(seed) + '\n' + program.with(options.tolerance, 1.7);
    ASSERT_TRUE(made) << what;
    EXPECT_EQ(faults_of_features(program, *made, options.tolerance), "") << what;
    const Result<Tessellation> other =
        tessellate(surface_of(program.with(options.tolerance, 31)), options);
    ASSERT_TRUE(other) << what;
    EXPECT_TRUE(same_bytes(made->mesh, other->mesh)) << what;
    faces += program.faces.size();
    uncertified += made->report.uncertified_area > 0 ? 1 : 0;
    for (const Expected& face : program.faces) ++kinds[face.element.substr(face.element.find('.'))];
  }
  std::printf("%zu faces, %zu programs uncertified:", faces, uncertified);
  for (const auto& [kind, count] : kinds) std::printf(" %s %d", kind.c_str(), count);
  std::printf("\n");
  EXPECT_EQ(kinds.size(), 4u);
  EXPECT_LE(uncertified, 6u);
}

}  // namespace
}  // namespace diesink::test
