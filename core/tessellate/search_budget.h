// How much is searched before a place is given up and told.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace diesink {

// Counts, never a clock: what is given up is the same on every machine, and its plan area goes into
// uncertified_area. A die that is in order takes a hundredth of each.
struct SearchBudget {
  // Cells below one part of the tree. Where something coincides along a line and nothing tells,
  // there would be as many as least cells lie along it: the part is grown anew with least cells 16
  // times as wide.
  std::size_t cells = 100'000;
  // Cells that splitting those whose borders do not join may add to those of the tree; then they
  // are joined as they are.
  std::size_t added = 1'000'000;
  // Pieces of the least length that nothing settles, of one side of a cell; where there are more
  // the side is searched anew with pieces 16 times as long.
  std::size_t pieces = 4096;
  // Chords of one region's border that cross, over all rounds of splitting them: more are of
  // borders that overlap.
  std::size_t crossings = 20'000;
  // Ways to lay the cells before chords that still cross are laid straight (untangle.h).
  int variants = 8;
};

}  // namespace diesink
