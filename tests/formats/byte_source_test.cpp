// A file that is read piece by piece while another program cuts it or writes to it.
// SPDX-License-Identifier: Apache-2.0
#include "formats/byte_source.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/mesh_file.h"
#include "formats/registry.h"
#include "formats/stl.h"
#include "tests/support/die_mesh.h"
#include "tests/support/temp_path.h"

namespace diesink {
namespace {

namespace fs = std::filesystem;

class ByteSourceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = test::temp_path("pieces") + ".stl";
    // More facets than are read at a time.
    const Result<WrittenMesh> written = kStl.write(test::die_mesh(60, 6, 1), {});
    ASSERT_TRUE(written);
    bytes_ = written->files[0].bytes;
    put(bytes_.size());
  }
  void TearDown() override { fs::remove(path_); }

  void put(std::size_t size) const {
    std::ofstream(path_, std::ios::binary)
        .write(static_cast<const char*>(static_cast<const void*>(bytes_.data())),
               static_cast<std::streamsize>(size));
  }
  static ReadOptions with(int threads) {
    ReadOptions options;
    options.threads = threads;
    return options;
  }

  std::string path_;
  std::vector<std::byte> bytes_;
};

// Another program does something to the file before the read with this number, counted from 0.
class Disturbed final : public ByteSource {
 public:
  Disturbed(const ByteSource& bytes, int before, std::function<void()> disturb)
      : bytes_(bytes), before_(before), disturb_(std::move(disturb)) {}
  [[nodiscard]] std::size_t size() const override { return bytes_.size(); }
  [[nodiscard]] const std::byte* at(std::size_t offset, std::span<std::byte> room) const override {
    if (reads_++ == before_) disturb_();
    return bytes_.at(offset, room);
  }
  [[nodiscard]] bool happened() const { return reads_ > before_; }

 private:
  const ByteSource& bytes_;
  int before_;
  std::function<void()> disturb_;
  mutable std::atomic<int> reads_{0};
};

TEST_F(ByteSourceTest, GivesTheFilesBytes) {
  const std::unique_ptr<ByteSource> file = open_bytes(path_);
  ASSERT_NE(file, nullptr);
  ASSERT_EQ(file->size(), bytes_.size());
  for (const std::size_t offset : {std::size_t{0}, std::size_t{83}, bytes_.size() - 7}) {
    std::vector<std::byte> room(std::min<std::size_t>(4000, bytes_.size() - offset));
    const std::byte* const got = file->at(offset, room);
    ASSERT_NE(got, nullptr);
    EXPECT_EQ(std::memcmp(got, bytes_.data() + offset, room.size()), 0) << "at " << offset;
  }
}

TEST_F(ByteSourceTest, OnlyRegularFilesAreRead) {
  EXPECT_EQ(open_bytes(path_ + ".not-there"), nullptr);
  EXPECT_EQ(open_bytes(::testing::TempDir()), nullptr);
  EXPECT_EQ(open_bytes("/dev/zero"), nullptr);
  const std::string pipe = path_ + ".pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(open_bytes(pipe), nullptr);  // at once, though nobody writes into it
  fs::remove(pipe);
}

TEST_F(ByteSourceTest, WhatIsMissingIsToldWithItsPlace) {
  const std::unique_ptr<ByteSource> file = open_bytes(path_);
  fs::resize_file(path_, 1000);
  std::vector<std::byte> room(100);
  EXPECT_NE(file->at(900, room), nullptr);
  EXPECT_EQ(file->at(901, room), nullptr);
  EXPECT_EQ(file->at(bytes_.size() - 100, room), nullptr);
}

TEST_F(ByteSourceTest, AFileCutWhileItIsReadIsAnErrorWhereverItIsCut) {
  for (const int threads : {1, 4}) {
    for (const std::size_t left : {std::size_t{0}, std::size_t{84}, bytes_.size() / 2}) {
      int before = 0;
      for (bool happened = true; happened; ++before) {
        put(bytes_.size());
        const std::unique_ptr<ByteSource> file = open_bytes(path_);
        const Disturbed cut(*file, before, [&] { fs::resize_file(path_, left); });
        Diagnostics diagnostics;
        const Result<TriangleMesh> mesh = read_binary_stl(cut, with(threads), diagnostics);
        happened = cut.happened();
        if (!happened) {
          EXPECT_TRUE(mesh);
        } else if (!mesh) {
          EXPECT_EQ(mesh.error().code, ErrorCode::kInput);
          EXPECT_NE(mesh.error().message.find("cannot read"), std::string::npos)
              << mesh.error().message;
          EXPECT_GE(mesh.error().where.byte, 0);
        } else {
          // Cut behind what had been read by then: only where a part is left.
          EXPECT_EQ(left, bytes_.size() / 2);
        }
      }
      EXPECT_GT(before, 2) << "the file is read in pieces";
    }
  }
}

TEST_F(ByteSourceTest, AFileWrittenToWhileItIsReadGivesASoundMeshOrAnError) {
  const float bad = std::numeric_limits<float>::quiet_NaN();
  for (const int threads : {1, 4}) {
    int refused = 0, before = 0;
    for (bool happened = true; happened; ++before) {
      put(bytes_.size());
      const std::unique_ptr<ByteSource> file = open_bytes(path_);
      const Disturbed written(*file, before, [&] {
        std::fstream out(path_, std::ios::binary | std::ios::in | std::ios::out);
        const std::uint32_t many = 0xFFFFFFFFU;
        out.seekp(80).write(static_cast<const char*>(static_cast<const void*>(&many)), 4);
        const auto last = static_cast<std::streamoff>(bytes_.size() - kStlFacetBytes + 12);
        out.seekp(last).write(static_cast<const char*>(static_cast<const void*>(&bad)), 4);
      });
      Diagnostics diagnostics;
      const Result<TriangleMesh> mesh = read_binary_stl(written, with(threads), diagnostics);
      happened = written.happened();
      if (!mesh) {
        EXPECT_TRUE(happened);
        EXPECT_FALSE(mesh.error().message.empty());
        ++refused;
        continue;
      }
      for (const Vec3& p : mesh->positions) ASSERT_TRUE(p.allFinite());
      for (const auto& t : mesh->triangles) {
        for (const std::uint32_t v : t) ASSERT_LT(v, mesh->positions.size());
      }
    }
    EXPECT_GT(refused, 0);
  }
}

TEST_F(ByteSourceTest, AFileThatIsAnotherOneWhenItIsOpenedAgainIsRead) {
  const std::size_t size = bytes_in_pieces(path_, bytes_.size());
  EXPECT_EQ(size, bytes_.size());
  EXPECT_EQ(bytes_in_pieces(path_, size - 1), 0U);
  for (const std::size_t left : {std::size_t{0}, std::size_t{83}, std::size_t{84}, size - 1}) {
    put(left);
    EXPECT_EQ(bytes_in_pieces(path_, size), 0U);
    Diagnostics diagnostics;
    const Result<MeshFile> mesh = read_mesh_pieces(path_, {}, diagnostics);
    ASSERT_FALSE(mesh) << left;
    EXPECT_EQ(mesh.error().where.file, path_);
  }
}

}  // namespace
}  // namespace diesink
