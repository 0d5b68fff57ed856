// Joining surface elements into coarser groups.
// SPDX-License-Identifier: Apache-2.0
#include "convert/mesh_groups.h"

#include <algorithm>
#include <vector>

namespace diesink {

void group_triangles(TriangleMesh& mesh, MeshGroups groups) {
  if (groups == MeshGroups::kElement) return;
  std::vector<MeshElement> joined;
  std::vector<std::uint32_t> group_of;
  for (const MeshElement& element : mesh.elements) {
    const std::string& name = groups == MeshGroups::kSolid ? element.solid : mesh.name;
    const auto same = std::find_if(joined.begin(), joined.end(),
                                   [&](const MeshElement& each) { return each.name == name; });
    group_of.push_back(static_cast<std::uint32_t>(same - joined.begin()));
    if (same == joined.end()) joined.push_back({name, name, element.color});
  }
  for (std::uint32_t& element : mesh.triangle_element) element = group_of[element];
  for (MeshCurve& curve : mesh.curves) {
    for (std::uint32_t& element : curve.between) {
      if (element != MeshCurve::kNoElement) element = group_of[element];
    }
  }
  mesh.elements = std::move(joined);
}

}  // namespace diesink
