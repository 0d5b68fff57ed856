// Text of valid part programs from a seed: every primitive and option in random poses, every kind
// of base. The same seed gives the same text on every machine and compiler.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "core/vec.h"

namespace diesink::test {

// SplitMix64: small, and the same everywhere (the standard distributions are not). Where several
// numbers are drawn for one vector it is written with braces: their order of evaluation is the
// written one.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 0x1234567u) {}

  std::uint64_t bits() {
    state_ += 0x9E3779B97F4A7C15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  // Uniform in [lo, hi).
  double uniform(double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(bits() >> 11) * 0x1p-53);
  }
  // Uniform in 0 .. count-1.
  int below(int count) { return static_cast<int>(bits() % static_cast<std::uint64_t>(count)); }
  bool chance(double probability) { return uniform(0, 1) < probability; }
  Vec3 direction() {
    while (true) {
      const Vec3 v{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      const double length = v.norm();
      if (length > 0.1 && length < 1) return v / length;
    }
  }

 private:
  std::uint64_t state_;
};

enum class RandomBase : std::uint8_t { kAny, kNone, kPlane, kFerguson };

struct RandomProgramOptions {
  int solids = 8;  // successive solids walk through all types and options
  RandomBase base = RandomBase::kAny;
  double size = 100;  // side of the square plan, which begins at the origin
  double body = 10;   // typical half width of a solid
  bool groups = true;
  bool aligned = true;  // one pose in four is along the axes: vertical walls, level tops
  double interval = 0;  // X-INT and Y-INT; 0 = size / 40
};

namespace random_program_detail {

inline constexpr int kVariants = 23;  // type and option pairs

// Shortest text that reads back the same double, in one of the spellings the language knows.
inline std::string number(Random& random, double value) {
  if (value == 0) value = 0;  // no negative zero
  char buffer[40];
  const std::to_chars_result end = std::to_chars(buffer, buffer + sizeof buffer, value);
  std::string text(buffer, end.ptr);
  if (text[0] != '-' && random.chance(0.1)) text.insert(text.begin(), '+');
  if (random.chance(0.3)) {
    const std::size_t exponent = text.find('e');
    if (exponent != std::string::npos) text[exponent] = random.chance(0.5) ? 'D' : 'E';
  }
  return text;
}

class Writer {
 public:
  Writer(Random& random, const RandomProgramOptions& options)
      : random_(random), options_(options) {}

  void line(std::string text) { text_ += text + '\n'; }
  void scalar(std::string_view keyword, double value) {
    line(std::string(keyword) + ',' + number(random_, value));
  }
  void vector(std::string_view keyword, const Vec3& v) {
    std::string text(keyword);
    for (int k = 0; k < 3; ++k) text += ',' + number(random_, v[k]);
    line(text);
  }
  void points(const std::vector<Vec3>& points) {
    for (std::size_t i = 0; i < points.size(); ++i) vector("P" + std::to_string(i + 1), points[i]);
  }
  std::string& text() { return text_; }

  // One solid of the given type and option, somewhere over the plan.
  void solid(const std::string& id, int variant);

 private:
  double length() { return options_.body * random_.uniform(0.4, 1.2); }
  double signed_length() { return random_.chance(0.5) ? length() : -length(); }
  // A rotation; one in four turns the axes into each other exactly.
  Mat3 pose() {
    if (options_.aligned && random_.chance(0.25)) {
      const int k = random_.below(3);
      Mat3 m = Mat3::Zero();
      m(0, k) = random_.chance(0.5) ? 1 : -1;
      m(1, (k + 1) % 3) = random_.chance(0.5) ? 1 : -1;
      m(2, (k + 2) % 3) = 1;
      return m;
    }
    const Vec3 a = random_.direction();
    Vec3 b = random_.direction();
    b = (b - b.dot(a) * a).eval();
    if (b.norm() < 0.05) return pose();
    b.normalize();
    Mat3 m;
    m.col(0) = a;
    m.col(1) = b;
    m.col(2) = a.cross(b);
    return m;
  }
  Vec3 place() {
    const double size = options_.size;
    return {random_.uniform(0, size), random_.uniform(0, size),
            random_.uniform(-0.6, 0.8) * options_.body};
  }
  // Corners of a convex polygon on an ellipse in the local plane z = 0, either way round.
  std::vector<Vec3> ring(int corners) {
    const double a = length(), b = length();
    const double way = random_.chance(0.5) ? 1 : -1, start = random_.uniform(0, 6);
    std::vector<Vec3> loop;
    for (int k = 0; k < corners; ++k) {
      const double angle =
          way * (start + (k + random_.uniform(-0.3, 0.3)) * 2 * std::numbers::pi / corners);
      loop.emplace_back(a * std::cos(angle), b * std::sin(angle), 0);
    }
    return loop;
  }
  // Appends the ring again, moved along or shrunk towards a point over it: the sides stay planar.
  void add_far_ring(std::vector<Vec3>& ring) {
    const std::size_t corners = ring.size();
    const Vec3 apex{random_.uniform(-0.5, 0.5) * options_.body,
                    random_.uniform(-0.5, 0.5) * options_.body, 1.6 * signed_length()};
    const bool shrink = random_.chance(0.6);
    const double share = random_.uniform(0.2, 0.8);
    for (std::size_t k = 0; k < corners; ++k) {
      const Vec3 corner = ring[k];
      ring.push_back(shrink ? Vec3(corner + share * (apex - corner)) : Vec3(corner + apex));
    }
  }
  void place_all(std::vector<Vec3>& points) {
    const Mat3 rotation = pose();
    const Vec3 at = place();
    for (Vec3& p : points) p = (rotation * p + at).eval();
  }

  Random& random_;
  const RandomProgramOptions& options_;
  std::string text_;
};

inline void Writer::solid(const std::string& id, int variant) {
  const auto header = [&](std::string_view type, int option) {
    line(id + ',' + std::string(type) +
         (option == 1 && random_.chance(0.3) ? std::string() : ',' + std::to_string(option)));
  };
  const Vec3 at = place();
  const Mat3 frame = pose();
  const Vec3 axis = frame.col(2), side = frame.col(0) + random_.uniform(-0.5, 0.5) * axis;
  const double stretch = random_.uniform(0.2, 5);
  std::vector<Vec3> p;
  switch (variant) {
    case 0:
    case 8: {
      const bool pyramid = variant == 8;
      header(pyramid ? "PYRAM" : "TETRA", 1);
      p = ring(pyramid ? 4 : 3);
      p.push_back(Vec3{random_.uniform(-1, 1) * options_.body,
                       random_.uniform(-1, 1) * options_.body, signed_length()});
      place_all(p);
      return points(p);
    }
    case 1:
    case 3:
    case 5:
    case 7: {
      const bool quad = variant >= 5;
      header(variant == 1   ? "TETRA"
             : variant == 3 ? "3-PRIS"
             : variant == 5 ? "PYRAM"
                            : "4-PRIS",
             2);
      p = ring(quad ? 4 : 3);
      place_all(p);
      scalar("HEI", signed_length());
      return points(p);
    }
    case 2:
    case 4: {
      header(variant == 2 ? "TPRIS" : "4-PRIS", 1);
      p = ring(variant == 2 ? 3 : 4);
      add_far_ring(p);
      place_all(p);
      return points(p);
    }
    case 6: {  // a roof: the far ring collapses to its ridge, two sides to triangles
      header("RPRIS", 1);
      const double a = length(), b = length(), h = signed_length(),
                   ridge = a * random_.uniform(0.2, 1);
      p = {{-a, -b, 0},    {a, -b, 0},    {a, b, 0},     {-a, b, 0},
           {-ridge, 0, h}, {ridge, 0, h}, {ridge, 0, h}, {-ridge, 0, h}};
      place_all(p);
      // Coinciding corners must coincide to the bit.
      p[6] = p[5];
      p[7] = p[4];
      return points(p);
    }
    case 9:
      header("4-PRIS", 3);
      vector("P1", at);
      return vector("P2", at + Vec3{signed_length(), signed_length(), signed_length()});
    case 10:
    case 12:
      header(variant == 10 ? "R-CONE" : "R-CYLI", 1);
      vector("P1", at);
      vector("P2", at + 1.5 * length() * axis);
      return scalar("RAD", length());
    case 11:
    case 13:
      header(variant == 11 ? "RCONE" : "RCYL", 2);
      scalar("LEN", 1.5 * length());
      vector("NOR", stretch * axis);
      vector("P1", at);
      return scalar("RAD", length());
    case 14:
    case 16:
      header(variant == 14 ? "E-CONE" : "E-CYLI", 1);
      vector("P1", at);
      vector("P2", at + 1.5 * length() * axis);
      vector("LVE", side);
      scalar("L-R", length());
      return scalar("S-R", 0.4 * length());
    case 15:
    case 17:
      header(variant == 15 ? "ECONE" : "ECYLI", 2);
      vector("P1", at);
      vector("NOR", stretch * axis);
      vector("LVE", side);
      scalar("L-R", length());
      scalar("S-R", 0.4 * length());
      return scalar("LEN", 1.5 * length());
    case 18:
      header("SPHER", 1);
      vector("P1", at);
      return scalar("RAD", length());
    case 19:
      header("sphere", 2);
      vector("P1", at);
      return vector("P2", at + length() * axis);
    case 20: {
      const bool turned = random_.chance(0.6);
      header("ELLIP", turned ? 1 : 2);
      vector("P1", at);
      if (turned) {
        vector("V1", side);
        vector("V2", stretch * axis);
      }
      scalar("A", length());
      scalar("B", length());
      return scalar("C", length());
    }
    case 21:
      header("PARAB", 1);
      vector("P1", at);
      vector("P2", at + 1.5 * length() * axis);
      return scalar("RAD", length());
    default:
      header("PARAB", 2);
      vector("P1", at);
      vector("NOR", stretch * axis);
      scalar("FOC", 0.2 * length());
      return scalar("LEN", 1.5 * length());
  }
}

}  // namespace random_program_detail

// A valid part program. Solids of successive numbers (and seeds) walk through all types and
// options; poses are random. A Ferguson base is one in three affine in plan, else warped, never
// folded; it covers about the whole plan.
inline std::string random_part_program(std::uint64_t seed,
                                       const RandomProgramOptions& options = {}) {
  using random_program_detail::kVariants;
  Random random(seed);
  random_program_detail::Writer out(random, options);
  const double size = options.size;

  out.line("$$ random part program " + std::to_string(seed));
  out.line("SOLID-DEF");
  const int first =
      static_cast<int>((seed * static_cast<std::uint64_t>(options.solids)) % kVariants);
  for (int k = 0; k < options.solids; ++k) {
    out.solid("S" + std::to_string(k + 1), (first + k) % kVariants);
  }

  RandomBase base = options.base;
  if (base == RandomBase::kAny) {
    constexpr RandomBase kBases[] = {RandomBase::kPlane, RandomBase::kFerguson, RandomBase::kNone};
    base = kBases[seed % 3];
  }
  if (base == RandomBase::kPlane) {
    out.line("BSURF-DEF");
    if (random.chance(0.3)) {
      out.scalar("PLANE", random.uniform(-0.3, 0.3) * options.body);
    } else {
      out.line("PLANE");
      out.vector("P1", {0.5 * size, 0.5 * size, random.uniform(-0.3, 0.3) * options.body});
      out.vector("NOR", {random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2),
                         random.chance(0.5) ? 1.0 : -2.0});
    }
  } else if (base == RandomBase::kFerguson) {
    const int m = 2 + random.below(6), n = 2 + random.below(6);
    out.line("BSURF-DEF");
    out.line((random.chance(0.5) ? "FERGU," : "") + std::to_string(m) + ',' + std::to_string(n));
    const int plan = random.below(3);  // 0 along the axes, 1 mirrored and turned, 2 warped
    const double turn = plan == 1 ? random.uniform(0, 6) : 0;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < m; ++i) {
        double u = static_cast<double>(i) / (m - 1) - 0.5,
               v = static_cast<double>(j) / (n - 1) - 0.5;
        if (plan == 2) {
          u += random.uniform(-0.08, 0.08) / (m - 1);
          v += random.uniform(-0.08, 0.08) / (n - 1);
        }
        double x = u, y = v;
        if (plan == 1) {
          x = 1.2 * (-u * std::cos(turn) - v * std::sin(turn));
          y = 1.2 * (-u * std::sin(turn) + v * std::cos(turn));
        }
        const Vec3 p(size * (x + 0.5), size * (y + 0.5), random.uniform(-0.5, 0.5) * options.body);
        std::string row = random_program_detail::number(random, p[0]);
        for (int k = 1; k < 3; ++k) row += ',' + random_program_detail::number(random, p[k]);
        out.line(row);
      }
    }
  } else if (random.chance(0.5)) {
    out.line("BSURF-DEF");
    out.line("NONE");
  }

  out.line("BOOLE-DEF");
  std::string expression = base == RandomBase::kNone ? "" : "B";
  int open = 0;
  bool first_of_group = expression.empty();
  for (int k = 0; k < options.solids; ++k) {
    const bool begin = options.groups && open < 3 && k + 1 < options.solids && random.chance(0.15);
    if (begin) {
      expression += expression.empty() || expression.back() == '(' ? "(" : "+(";
      ++open;
      first_of_group = true;
    }
    const bool add = first_of_group || random.chance(0.65);
    if (!first_of_group) expression += add ? '+' : '-';
    expression += 'S' + std::to_string(k + 1);
    first_of_group = false;
    if (open > 0 && random.chance(0.35)) {
      expression += ')';
      --open;
    }
    if (k % 6 == 5) expression += '\n';
  }
  expression.append(static_cast<std::size_t>(open), ')');
  out.line(expression);

  out.line("MACHI-DEF");
  const double interval = options.interval > 0 ? options.interval : size / 40;
  const auto range = [&](std::string_view keyword) {
    out.line(std::string(keyword) + ",0," + random_program_detail::number(random, size));
  };
  range("X-RNG");
  range("Y-RNG");
  out.scalar("X-INT", interval);
  out.scalar("Y-INT", interval);
  out.scalar("TOLER", 1e-4 * size);
  return out.text();
}

}  // namespace diesink::test
