// Names of files and folders that no other test or run has.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <string>

namespace diesink::test {

// Within the folder for temporary files; not made.
inline std::string temp_path(const std::string& name) {
  const ::testing::TestInfo* const test = ::testing::UnitTest::GetInstance()->current_test_info();
  return ::testing::TempDir() + "diesink-" + name + "-" + std::to_string(::getpid()) +
         (test != nullptr ? std::string("-") + test->name() : "");
}

}  // namespace diesink::test
