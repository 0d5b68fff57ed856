// Which side of a limit a triangle's bound is on, told from what is kept with its vertices.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/tessellate/deviation.h"

namespace diesink {

// The vertices of one face's triangulation. Refinement asks of every triangle it makes whether its
// bound is within the tolerance, some ten times for one that stays; the bound itself is only
// needed where the answer is not plain.
// Units:  mm.
// One object is used by one thread at a time.
class DeviationFilter {
 public:
  enum class Side : std::uint8_t {
    kWithin,  // TriangleDeviation's bound is at most the limit
    kBeyond,  // it is greater
    kOpen,    // not told; always so on a base with curvature
  };

  // Needs: `deviation` outlives this.
  DeviationFilter(const TriangleDeviation& deviation, Label label);

  // Vertices in the order of their indices.
  // Needs: p on the face to rounding, or beside a quadric.
  void add(const Vec3& p);
  [[nodiscard]] std::size_t size() const { return size_; }
  void clear();

  // Needs:  indices of vertices added, `positions` theirs; limit > 0.
  // Bound:  open only within about a millionth of the limit, and where the gradient's length
  //         varies over the triangle, by that part.
  [[nodiscard]] Side compare(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                             std::span<const Vec3> positions, double limit) const;

 private:
  // Of the quadric's form.
  struct Vertex {
    Vec3 gradient;
    double value;  // of the form: what rounding leaves, or what the vertex is off
  };

  Implicit face_;
  bool is_known_ = false;  // a plane or quadric
  double bend_ = 0;        // quadric: no direction has a larger second derivative, half of it
  std::vector<Vertex> vertices_;  // quadric
  std::size_t size_ = 0;
  double largest_ = 0;  // coordinate
  double off_ = 0;      // plane: no vertex is farther from it
};

}  // namespace diesink
