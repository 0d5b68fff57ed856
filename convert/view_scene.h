// From files of the command line to what a page of the viewer shows.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "convert/command.h"
#include "convert/input.h"
#include "convert/mesh_input.h"
#include "viewer/scene.h"

namespace diesink {

struct ViewSources {
  std::vector<std::string> files;
  std::optional<double> tolerance;  // of a part's mesh; default its program's
  std::optional<std::array<double, 2>> cutter;
  bool verify = false;  // what the cutter leaves is found as well; needs a part and a path
  MeshInputOptions in;
};

// Reads the files, one part program, one mesh and one tool path at most, told apart by their
// content. A part is shown by its mesh, closed with sides and a floor; with a mesh beside it by
// that mesh, whose deviations from the part's surface are taken. Everything comes into the unit of
// the part, else of the mesh, else of the path.
Loaded<Scene> load_scene(const ViewSources& sources, const CommonOptions& common);

}  // namespace diesink
