// Files appear whole or not at all, whatever fails.
// SPDX-License-Identifier: Apache-2.0
#include "formats/output_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "formats/input_file.h"
#include "formats/mesh_file.h"
#include "tests/support/random_mesh.h"
#include "tests/support/temp_path.h"

namespace diesink {
namespace {

namespace fs = std::filesystem;

class OutputFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = test::temp_path("output");
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  static std::string content(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static Status put(OutputFiles& output, const std::string& file, std::string_view text) {
    const Result<ByteSink*> sink = output.open(file);
    if (!sink) return sink.error();
    return (*sink)->put(std::as_bytes(std::span(text)));
  }

  std::string folder_;
};

TEST_F(OutputFile, AppearsOnlyWithCommit) {
  {
    OutputFiles output;
    ASSERT_TRUE(put(output, path("a"), "one"));
    EXPECT_FALSE(fs::exists(path("a")));
    EXPECT_EQ(files(), 1U);  // the temporary
  }
  EXPECT_EQ(files(), 0U);
  ASSERT_TRUE(write_file(path("a"), "two"));
  EXPECT_EQ(content(path("a")), "two");
  EXPECT_EQ(files(), 1U);
}

TEST_F(OutputFile, ReplacesAFileAndKeepsItsModeAndItsLink) {
  std::ofstream(path("real")) << "old";
  fs::permissions(path("real"),
                  fs::perms::owner_read | fs::perms::owner_write | fs::perms::others_read);
  fs::create_symlink("real", path("link"));
  ASSERT_TRUE(write_file(path("link"), "new"));
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(content(path("real")), "new");
  EXPECT_EQ(fs::status(path("real")).permissions(),
            fs::perms::owner_read | fs::perms::owner_write | fs::perms::others_read);
}

TEST_F(OutputFile, SaysWhyItCannot) {
  const Status missing = write_file(path("no/such/folder"), "x");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kOutput);
  EXPECT_EQ(to_text(missing.error()),
            path("no/such/folder") + ": error: cannot create: No such file or directory");
  const Status folder = write_file(folder_, "x");
  ASSERT_FALSE(folder);
  EXPECT_NE(to_text(folder.error()).find("Is a directory"), std::string::npos);
  EXPECT_FALSE(write_file("", "x"));
  EXPECT_TRUE(write_file("/dev/null", "x"));
  const Status full = write_file("/dev/full", std::string(100, 'x'));
  ASSERT_FALSE(full);
  EXPECT_NE(to_text(full.error()).find("No space left"), std::string::npos);
  EXPECT_EQ(files(), 0U);
}

TEST_F(OutputFile, AFailedRenameTakesTheOthersBack) {
  std::ofstream(path("b")) << "old";
  OutputFiles output;
  // Put in place from the last: b, then c, then a, which has become a folder in the meantime.
  ASSERT_TRUE(put(output, path("a"), "new a"));
  ASSERT_TRUE(put(output, path("c"), "new c"));
  ASSERT_TRUE(put(output, path("b"), "new b"));
  fs::create_directories(path("a/inside"));
  const Status done = output.commit();
  ASSERT_FALSE(done);
  EXPECT_EQ(content(path("b")), "old");
  EXPECT_FALSE(fs::exists(path("c")));
  EXPECT_EQ(files(), 2U);
}

TEST_F(OutputFile, AFullDiskLeavesNothing) {
  std::ofstream(path("a")) << "old";
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{100'000, 100'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    bool failed = false;
    {
      OutputFiles output;
      const Result<WrittenMesh> written = write_mesh_file(path("a"), testing::torus_mesh(100, 100),
                                                          {}, output, format_of_ending(".stl"));
      failed = !written || !output.commit();
    }
    ::_exit(failed ? 7 : 0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  // The child ends without destructors, as a killed program would; its temporary is what a kill may
  // leave.
  EXPECT_EQ(WEXITSTATUS(status), 7);
  EXPECT_EQ(content(path("a")), "old");
  EXPECT_EQ(files(), 1U);
}

TEST_F(OutputFile, AnInterruptLeavesNothing) {
  std::array<int, 2> ready{};
  ASSERT_EQ(::pipe(ready.data()), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGINT, [](int) {
      unlink_temporaries();
      ::_exit(130);
    });
    OutputFiles output;
    const bool begun = put(output, path("a"), "half") && put(output, path("b"), "half");
    const char said = begun ? 'y' : 'n';
    if (::write(ready[1], &said, 1) != 1) ::_exit(1);
    ::pause();
    ::_exit(0);
  }
  char said = 0;
  ASSERT_EQ(::read(ready[0], &said, 1), 1);
  EXPECT_EQ(said, 'y');
  EXPECT_EQ(files(), 2U);
  ::kill(child, SIGINT);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(files(), 0U);
}

TEST_F(OutputFile, ALongNameHasRoomForItsTemporary) {
  const std::string name(255, 'x');
  EXPECT_TRUE(write_file(path(name), "x"));
  EXPECT_EQ(content(path(name)), "x");
}

TEST_F(OutputFile, InputIsReadWithinItsLimit) {
  std::ofstream(path("a")) << "12345";
  EXPECT_TRUE(read_file(path("a"), 5));
  const Result<InputBytes> more = read_file(path("a"), 4);
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().code, ErrorCode::kLimit);
  EXPECT_FALSE(read_file(folder_));
  EXPECT_FALSE(read_file("/dev/zero"));
  EXPECT_FALSE(read_file(path("none")));
}

}  // namespace
}  // namespace diesink
