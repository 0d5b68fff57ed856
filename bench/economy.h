// What economy_bench compares: scenes of bodies whose surfaces are known exactly, meshes of them,
// and how far those are off. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/vec.h"

namespace diesink::bench {

double now();  // seconds

struct Body {
  enum class Kind { kSphere, kCylinder, kCone, kBox } kind;
  int sign;
  Vec3 p, q;  // centre; ends of the axis, a cone's apex last; corners of a box
  double radius;
};

struct Scene {
  std::string name;
  double size = 0;  // of the plate, from 0
  std::vector<Body> bodies;
};

std::string part_text(const Scene& scene);
Scene pockets(const char* part);  // the bodies of a plate of make_parts.py; none: not such a file
Scene like_fig6();                // Fig. 6 of the paper with a level base and upright cone

// A whole plane, sphere, cylinder or cone.
struct Carrier {
  enum class Kind { kPlane, kSphere, kCylinder, kCone } kind;
  Vec3 c, axis;                             // point or centre or apex; unit normal or axis
  double radius = 0, sine = 0, cosine = 1;  // cone: of half its opening
  Eigen::AlignedBox3d box;                  // where it can matter

  [[nodiscard]] double distance(const Vec3& p) const {  // signed
    const Vec3 r = p - c;
    switch (kind) {
      case Kind::kPlane:
        return r.dot(axis);
      case Kind::kSphere:
        return r.norm() - radius;
      case Kind::kCylinder:
        return (r - axis * r.dot(axis)).norm() - radius;
      case Kind::kCone: {
        const double along = r.dot(axis), across = (r - axis * along).norm();
        return across * cosine - along * sine;
      }
    }
    return 0;
  }
  [[nodiscard]] Vec3 normal(const Vec3& p) const {
    const double h = 1e-6;
    Vec3 n;
    for (int k = 0; k < 3; ++k)
      n[k] = distance(p + h * Vec3::Unit(k)) - distance(p - h * Vec3::Unit(k));
    return n.normalized();
  }
};

std::vector<Carrier> carriers_of(const Scene& scene);

struct Soup {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// The largest distance of points all over the triangle.
double triangle_error(const Carrier& on, const Vec3& a, const Vec3& b, const Vec3& c);
// Of the middle of a chord from the curve in which two surfaces meet, to first order.
double chord_error(const Carrier& f, const Carrier& g, const Vec3& a, const Vec3& b);

// Finds the surfaces that points lie on; `near` far off.
class Surfaces {
 public:
  Surfaces(const Scene& scene, double near) : all_(carriers_of(scene)), near_(near) {}
  void at(const Vec3& p, std::vector<std::uint32_t>& out) const {
    out.clear();
    for (std::uint32_t k = 0; k < all_.size(); ++k) {
      if (all_[k].box.contains(p) && std::fabs(all_[k].distance(p)) <= near_) out.push_back(k);
    }
  }
  [[nodiscard]] const Carrier& operator[](std::uint32_t k) const { return all_[k]; }

 private:
  std::vector<Carrier> all_;
  double near_;
};

struct Figures {
  double deviation = 0;
  std::array<double, 3> angles{};  // quantiles 0.01, 0.05, 0.5 of the least angle, degrees
  std::size_t stray = 0;           // triangles on none of the surfaces
};

// `near`: how far off its surface a vertex may be.
Figures measure(const Scene& scene, const Soup& soup, double near);
void print(const char* what, std::size_t triangles, double seconds, const Figures& f);

// Each with the seconds it took.
Soup ours(const Scene& scene, double tolerance, double& seconds);
// OpenMesh's decimater, from our mesh at a tenth of the tolerance.
Soup decimated(const Scene& scene, double tolerance, double& seconds);
// OpenCASCADE: its booleans once, then its mesher at the tolerance, and at the deflection at which
// it is off by `deviation`.
void compare_occt(const Scene& scene, double tolerance, double deviation);
// A scan alone, thinned out within a tolerance: diesink beside OpenMesh's decimater.
void compare_scan(double tolerance);

}  // namespace diesink::bench
