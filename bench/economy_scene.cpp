// Scenes, and how far meshes of them are off.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <utility>

#include "bench/economy.h"

namespace diesink::bench {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string part_text(const Scene& scene) {
  std::string text = "SOLID-DEF\n", terms = "B";
  char line[200];
  int k = 0;
  for (const Body& b : scene.bodies) {
    const std::string id = "S" + std::to_string(++k);
    const auto point = [&](int n, double x, double y, double z) {
      std::snprintf(line, sizeof line, "P%d,%.17g,%.17g,%.17g\n", n, x, y, z);
      text += line;
    };
    const auto value = [&](const char* word, double v) {
      std::snprintf(line, sizeof line, "%s,%.17g\n", word, v);
      text += line;
    };
    switch (b.kind) {
      case Body::Kind::kSphere:
        text += id + ",SPHER,1\n";
        point(1, b.p.x(), b.p.y(), b.p.z());
        value("RAD", b.radius);
        break;
      case Body::Kind::kCylinder:
      case Body::Kind::kCone:
        text += id + (b.kind == Body::Kind::kCone ? ",R-CONE,1\n" : ",R-CYLI,1\n");
        point(1, b.p.x(), b.p.y(), b.p.z());
        point(2, b.q.x(), b.q.y(), b.q.z());
        value("RAD", b.radius);
        break;
      case Body::Kind::kBox:
        text += id + ",4-PRIS,1\n";
        for (int level = 0; level < 2; ++level) {
          const double z = level == 0 ? b.q.z() : b.p.z();
          point(4 * level + 1, b.p.x(), b.p.y(), z);
          point(4 * level + 2, b.q.x(), b.p.y(), z);
          point(4 * level + 3, b.q.x(), b.q.y(), z);
          point(4 * level + 4, b.p.x(), b.q.y(), z);
        }
        break;
    }
    terms += (b.sign > 0 ? "+" : "-") + id;
    if (k % 8 == 0) terms += "\n";
  }
  std::snprintf(line, sizeof line, "MACHI-DEF\nX-RNG,0,%g\nY-RNG,0,%g\nTOLER,.02\n", scene.size,
                scene.size);
  return text + "BSURF-DEF\nPLANE,0\nBOOLE-DEF\n" + terms + "\n" + line;
}

Scene pockets(const char* part) {
  Scene scene{"50 pockets and 50 bosses", 200, {}};
  std::ifstream file(part);
  std::map<std::string, std::array<double, 3>> data;
  const auto finish = [&](const std::string& type) {
    if (type.empty()) return;
    const auto vec = [&](const char* word) {
      return Vec3(data[word][0], data[word][1], data[word][2]);
    };
    Body b{Body::Kind::kSphere, -1, vec("P1"), vec("P2"), data["RAD"][0]};
    if (type != "SPHER") {
      b.sign = 1;
      b.kind = type == "R-CONE" ? Body::Kind::kCone : Body::Kind::kCylinder;
      if (type == "R-CYLI") b.q = b.p + Vec3(0, 0, data["LEN"][0]);
    }
    scene.bodies.push_back(b);
  };
  std::string line, type;
  while (std::getline(file, line) && line != "BSURF-DEF") {
    std::vector<std::string> words;
    for (std::size_t at = 0; at <= line.size();) {
      const std::size_t comma = std::min(line.find(',', at), line.size());
      words.push_back(line.substr(at, comma - at));
      at = comma + 1;
    }
    if (words.size() == 3 && !words[1].empty() && std::isalpha(words[1][0])) {
      finish(type);
      type = words[1];
    } else if (words.size() > 1) {
      for (std::size_t k = 1; k < words.size() && k < 4; ++k)
        data[words[0]][k - 1] = std::strtod(words[k].c_str(), nullptr);
    }
  }
  finish(type);
  return scene;
}

Scene like_fig6() {
  using K = Body::Kind;
  return {"as Fig. 6, on a plane",
          40,
          {{K::kCylinder, 1, {20, 20, -1}, {20, 20, 5}, 15},
           {K::kSphere, 1, {20, 20, 0}, {0, 0, 0}, 12},
           {K::kBox, 1, {15, 2, -1}, {25, 13, 7}, 0},
           {K::kBox, -1, {15, 28, 1}, {25, 35.5, 9}, 0},
           {K::kCone, 1, {20, 20, 8}, {20, 20, 16}, 7}}};
}

std::vector<Carrier> carriers_of(const Scene& scene) {
  std::vector<Carrier> all;
  const Vec3 margin = Vec3::Constant(0.5);
  const auto plane = [&](const Vec3& at, const Vec3& n, const Eigen::AlignedBox3d& box) {
    all.push_back({Carrier::Kind::kPlane, at, n, 0, 0, 1, box});
  };
  plane(Vec3::Zero(), Vec3::UnitZ(), {Vec3(-1, -1, -1), Vec3(scene.size + 1, scene.size + 1, 1)});
  for (const Body& b : scene.bodies) {
    Eigen::AlignedBox3d box(b.p);
    if (b.kind != Body::Kind::kSphere) box.extend(b.q);
    if (b.kind != Body::Kind::kBox) {
      box.min() -= Vec3::Constant(b.radius);
      box.max() += Vec3::Constant(b.radius);
    }
    box.min() -= margin;
    box.max() += margin;
    const Vec3 axis =
        b.kind == Body::Kind::kSphere ? Vec3(0, 0, 1) : Vec3((b.p - b.q).normalized());
    switch (b.kind) {
      case Body::Kind::kSphere:
        all.push_back({Carrier::Kind::kSphere, b.p, axis, b.radius, 0, 1, box});
        break;
      case Body::Kind::kCylinder:
        all.push_back({Carrier::Kind::kCylinder, b.p, axis, b.radius, 0, 1, box});
        plane(b.q, axis, box);
        break;
      case Body::Kind::kCone: {
        const double slant = std::hypot(b.radius, (b.p - b.q).norm());
        all.push_back({Carrier::Kind::kCone, b.q, axis, 0, b.radius / slant,
                       (b.p - b.q).norm() / slant, box});
        break;
      }
      case Body::Kind::kBox:
        for (int k = 0; k < 3; ++k) {
          plane(b.p, Vec3::Unit(k), box);
          plane(b.q, Vec3::Unit(k), box);
        }
        break;
    }
  }
  return all;
}

double triangle_error(const Carrier& on, const Vec3& a, const Vec3& b, const Vec3& c) {
  constexpr int kParts = 6;
  double most = 0;
  for (int i = 0; i <= kParts; ++i) {
    for (int j = 0; i + j <= kParts; ++j) {
      const Vec3 p = (i * a + j * b + (kParts - i - j) * c) / kParts;
      most = std::fmax(most, std::fabs(on.distance(p)));
    }
  }
  return most;
}

double chord_error(const Carrier& f, const Carrier& g, const Vec3& a, const Vec3& b) {
  const Vec3 m = 0.5 * (a + b);
  const double cosine = f.normal(m).dot(g.normal(m));
  const double square = 1 - cosine * cosine;
  if (square < 0.01) return 0;
  const double df = f.distance(m), dg = g.distance(m);
  return std::sqrt((df * df + dg * dg - 2 * df * dg * cosine) / square);
}

Figures measure(const Scene& scene, const Soup& soup, double near) {
  const Surfaces surfaces(scene, near);
  std::vector<std::vector<std::uint32_t>> of(soup.points.size());
  for (std::size_t v = 0; v < soup.points.size(); ++v) surfaces.at(soup.points[v], of[v]);
  Figures out;
  std::vector<double> least;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> side;
  for (const auto& t : soup.triangles) {
    const Vec3 &a = soup.points[t[0]], &b = soup.points[t[1]], &c = soup.points[t[2]];
    double best = 1e300;
    std::uint32_t on = 0;
    for (const std::uint32_t k : of[t[0]]) {
      if (std::count(of[t[1]].begin(), of[t[1]].end(), k) == 0 ||
          std::count(of[t[2]].begin(), of[t[2]].end(), k) == 0)
        continue;
      const double e = triangle_error(surfaces[k], a, b, c);
      if (e < best) best = e, on = k;
    }
    if (best == 1e300) {
      ++out.stray;
      continue;
    }
    out.deviation = std::fmax(out.deviation, best);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t p = t[k], q = t[(k + 1) % 3];
      const auto [it, fresh] = side.try_emplace({std::min(p, q), std::max(p, q)}, on);
      if (!fresh && it->second != on) {
        out.deviation = std::fmax(out.deviation, chord_error(surfaces[on], surfaces[it->second],
                                                             soup.points[p], soup.points[q]));
      }
    }
    const std::array<double, 3> l{(b - c).norm(), (c - a).norm(), (a - b).norm()};
    const double sine =
        (b - a).cross(c - a).norm() * std::min({l[0], l[1], l[2]}) / (l[0] * l[1] * l[2]);
    least.push_back(std::asin(std::clamp(sine, 0.0, 1.0)) * 180 / std::numbers::pi);
  }
  std::sort(least.begin(), least.end());
  const double at[] = {0.01, 0.05, 0.5};
  for (std::size_t k = 0; k < 3 && !least.empty(); ++k) {
    out.angles[k] = least[static_cast<std::size_t>(at[k] * static_cast<double>(least.size() - 1))];
  }
  return out;
}

void print(const char* what, std::size_t triangles, double seconds, const Figures& f) {
  std::printf("  %-44s %9zu %8.3f s  true deviation %.5f  least angles %5.1f %5.1f %5.1f", what,
              triangles, seconds, f.deviation, f.angles[0], f.angles[1], f.angles[2]);
  if (f.stray > 0) std::printf("  (%zu triangles on no surface)", f.stray);
  std::printf("\n");
}

}  // namespace diesink::bench
