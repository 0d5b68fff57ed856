// Numbers of things in sentences.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace diesink {

// "1 facet has no normal" or "3 facets have no normal" of the words "facet has|facets have| no
// normal". Needs: two bars in `words`.
std::string counted(std::size_t count, std::string_view words);

}  // namespace diesink
