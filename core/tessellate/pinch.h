// Where more than two walls stand on one upright line, and where parts of a mesh hang together by
// one vertex only. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "core/mesh.h"
#include "core/tessellate/arrangement.h"

namespace diesink {

// One end of an arc at a node.
struct ArcEnd {
  std::uint32_t arc = 0;
  bool last = false;
  friend bool operator==(const ArcEnd&, const ArcEnd&) = default;
};

// The walls round the nodes at which four or more arcs end. Over any interval of height the
// material round such a node falls into wedges; each wedge has two walls, which belong together.
class PinchedNodes {
 public:
  explicit PinchedNodes(const Arrangement& arrangement);

  [[nodiscard]] bool has(std::uint32_t node) const { return around_.contains(node); }

  // Of the wall at `end` over an interval of height with the upper end `top`: number of its wedge
  // among `wedges` there. `height` gives a label's height at the node, that of no label included.
  struct Wedge {
    int number = 0, wedges = 1;
  };
  [[nodiscard]] Wedge wedge_of(std::uint32_t node, const ArcEnd& end, double top,
                               const std::function<double(Label)>& height) const;

 private:
  struct Spoke {
    ArcEnd end;
    int sectors[2] = {-1, -1};  // on either side; -1 is beyond the domain
  };
  struct Around {
    std::vector<Spoke> spokes;
    std::vector<Label> sectors;
  };
  std::unordered_map<std::uint32_t, Around> around_;
};

// Gives every fan of triangles round one of `vertices` a vertex of its own, at the same place.
// Needs: no edge in more than two triangles.
void split_fans(TriangleMesh& mesh, const std::vector<std::uint32_t>& vertices);

}  // namespace diesink
