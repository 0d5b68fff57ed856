// Rows of words as columns that line up.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace diesink {

// Shape: two blanks between columns, the first row underlined with dashes, no blanks at the ends of
// lines;
//        columns whose every cell below the first row starts with a digit or '-' are set to the
//        right.
// Needs: as many words in every row as in the first.
std::string to_table(const std::vector<std::vector<std::string>>& rows);

}  // namespace diesink
