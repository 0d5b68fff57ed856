// Runs put in between passes, gathered into regions that are cut one after another.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/vec.h"

namespace diesink {

struct AddedRun {
  double y = 0;
  std::vector<Vec3> tips;  // x rising
};

// Runs belong together where their x overlaps and their y is at most `gap` apart.
class SteepRegions {
 public:
  explicit SteepRegions(double gap) : gap_(gap) {}

  // Needs: runs come block by block in one direction of y, in any order within a block.
  void add(AddedRun run) { runs_.push_back(std::move(run)); }

  // Takes out the regions that runs beyond y = reached cannot join; each in the order of y, rows
  // from low x to high.
  std::vector<std::vector<AddedRun>> finished(double reached, bool down);
  std::vector<std::vector<AddedRun>> all();

 private:
  std::vector<std::vector<AddedRun>> grouped(std::vector<AddedRun> runs) const;
  double gap_;
  std::vector<AddedRun> runs_;
};

}  // namespace diesink
