// The form at the vertices and its gradients there say what it is along the edges:
// (v_i - v_j)'A(v_i - v_j) = (grad F(v_i) - grad F(v_j)) . (v_i - v_j) / 2.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/deviation_filter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/tessellate/deviation_forms.h"

namespace diesink {
namespace {

// What coordinates and forms computed in doubles are off by, relative to the largest coordinate:
// the bound adds 1e-15 for it; here there is room for the difference of two gradients as well.
constexpr double kRounding = 1e-14;
// Both ways of working it out agree to far less than this part.
constexpr double kMargin = 1e-6;
// Squared length of a gradient beside the steepest under which a vertex may be an apex, where the
// bound is another.
constexpr double kApex = 1e-15;

}  // namespace

DeviationFilter::DeviationFilter(const TriangleDeviation& deviation, Label label)
    : face_(deviation.face(label)) {
  is_known_ = face_.kind != Implicit::Kind::kBase;
  if (face_.kind == Implicit::Kind::kQuadric) bend_ = face_.k.cwiseAbs().maxCoeff();
}

void DeviationFilter::clear() {
  vertices_.clear();
  size_ = 0;
  largest_ = off_ = 0;
}

void DeviationFilter::add(const Vec3& p) {
  ++size_;
  if (!is_known_) return;
  largest_ = std::max(largest_, p.cwiseAbs().maxCoeff());
  Vertex vertex;
  vertex.value = face_.form(p, vertex.gradient);
  if (face_.kind == Implicit::Kind::kQuadric) {
    vertices_.push_back(vertex);
  } else {
    off_ = std::max(off_, std::fabs(vertex.value));
  }
}

DeviationFilter::Side DeviationFilter::compare(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                                               std::span<const Vec3> positions,
                                               double limit) const {
  if (!is_known_) return Side::kOpen;
  const double rounding = kRounding * largest_;
  if (face_.kind == Implicit::Kind::kPlane) {
    return off_ + rounding <= limit ? Side::kWithin : Side::kOpen;
  }
  const Vertex &va = vertices_[a], &vb = vertices_[b], &vc = vertices_[c];
  const Vec3 bc = positions[c] - positions[b], ca = positions[a] - positions[c],
             ab = positions[b] - positions[a];
  const EdgeForms q{0.5 * (vc.gradient - vb.gradient).dot(bc),
                    0.5 * (va.gradient - vc.gradient).dot(ca),
                    0.5 * (vb.gradient - va.gradient).dot(ab)};
  const VertexValues values{va.value, vb.value, vc.value};
  const double form = std::max(largest_between(q, {-values[0], -values[1], -values[2]}),
                               largest_between({-q[0], -q[1], -q[2]}, values));
  const double la = va.gradient.squaredNorm(), lb = vb.gradient.squaredNorm(),
               lc = vc.gradient.squaredNorm();
  const double steepest = std::max({la, lb, lc});
  if (!(std::min({la, lb, lc}) > kApex * steepest)) return Side::kOpen;
  // Whichever way one goes from the triangle, the form changes by no more than the steepest
  // gradient and the bend allow: the surface is farther than that.
  const double bent = bend_ * limit * limit;
  const double fewest = form * (1 - kMargin) - rounding - bent;
  if (fewest > 0 && fewest * fewest > limit * limit * steepest) return Side::kBeyond;
  // Along the triangle's normal, not made a unit, it is at most h where the form changes by more
  // than its largest value on the way: h least - h² bend >= form.
  const Vec3 n = ab.cross(-ca);
  const double ga = n.dot(va.gradient), gb = n.dot(vb.gradient), gc = n.dot(vc.gradient);
  const double least = ga + gb + gc < 0 ? -std::max({ga, gb, gc}) : std::min({ga, gb, gc});
  const double h = limit - rounding;
  const double most = form * (1 + kMargin) + rounding + bent;
  return least > 0 && h > 0 && most * most * n.squaredNorm() <= h * h * least * least
             ? Side::kWithin
             : Side::kOpen;
}

}  // namespace diesink
