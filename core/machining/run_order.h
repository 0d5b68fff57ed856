// The order in which short runs are cut, and which way.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/machining/path_links.h"
#include "core/machining/steep_regions.h"

namespace diesink {

// Cuts all runs, each time the one that begins or ends nearest to where the last one ended; of
// equally near ones the lowest y, then the first. With `oneway` runs are not turned round.
void cut_nearest_first(std::vector<AddedRun> runs, bool oneway, const PathStream& stream,
                       PathJoiner& joiner);

}  // namespace diesink
