// Tool paths of the command line.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>

#include "convert/input.h"
#include "core/tool_path.h"
#include "formats/input_file.h"
#include "formats/path_file.h"

namespace diesink {

// True where the content can be a tool path and is not a mesh; where it could be both, as a first
// line "g 1" is, the ending decides, then the mesh.
bool is_path(std::span<const std::byte> bytes, const std::string& name);

// An APT, G-code or CSV path ("-" is stdin), told by its content, that is gone over piece by piece
// and never held whole.
class PathInput {
 public:
  // Opens it, reads all of it once and tells its errors and warnings.
  static Loaded<PathInput> open(const std::string& name);

  // Everything but the points, lengths in the file's unit.
  [[nodiscard]] const ToolPath& head() const { return head_; }

  // Its points in `unit`, from the beginning. Errors: kInput where the file has changed meanwhile.
  Status points(LengthUnit unit, const PathTaker& take);

 private:
  InputBytes bytes_;  // of a pipe
  std::unique_ptr<TextSource> text_;
  std::string shown_;
  PathFormat format_ = PathFormat::kApt;
  ToolPath head_;
};

// A path held whole, of the content of `name`, read before; its warnings are told.
Loaded<ToolPath> load_path(std::span<const std::byte> bytes, const std::string& name);

// Every length into `unit`.
void to_unit(ToolPath& path, LengthUnit unit);

}  // namespace diesink
