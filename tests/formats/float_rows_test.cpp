// Vertices narrowed to floats by blocks, against one at a time.
// SPDX-License-Identifier: Apache-2.0
#include "formats/float_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace {

using namespace diesink;

constexpr double kLimit = 1e9;

std::vector<Vec3> random_points(std::size_t count, std::mt19937_64& random) {
  std::uniform_real_distribution<double> any(-300, 300);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i)
    points.emplace_back(any(random), any(random), any(random));
  return points;
}

float as_float(double x) { return static_cast<float>(x) + 0.0F; }

// One byte off every alignment.
std::vector<float> floats_of(std::span<const Vec3> points, const Vec3& offset) {
  std::vector<char> bytes(1 + 12 * points.size() + 1, 'x');
  put_floats(points, offset, bytes.data() + 1);
  EXPECT_EQ(bytes.front(), 'x');
  EXPECT_EQ(bytes.back(), 'x');
  std::vector<float> floats(3 * points.size());
  if (!floats.empty()) std::memcpy(floats.data(), bytes.data() + 1, 12 * points.size());
  return floats;
}

TEST(FloatRows, EveryLengthIsNarrowedAsOneByOne) {
  std::mt19937_64 random(1);
  const Vec3 offset(1000.25, -7, 0.1);
  for (std::size_t count = 0; count < 40; ++count) {
    std::vector<Vec3> points = random_points(count, random);
    if (count > 2) points[count - 1].y() = points[0].z() = -0.0;
    for (const Vec3& about : {Vec3(Vec3::Zero()), offset}) {
      const std::vector<float> floats = floats_of(points, about);
      for (std::size_t i = 0; i < floats.size(); ++i) {
        const int k = static_cast<int>(i % 3);
        EXPECT_EQ(floats[i], as_float(points[i / 3][k] - about[k]));
        EXPECT_FALSE(floats[i] == 0 && std::signbit(floats[i]));
      }
      if (count == 0) continue;
      const FloatRun run = measure_floats(points, about, kLimit);
      Vec3 low = points[0], high = points[0];
      double moved = 0;
      for (const Vec3& p : points) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
        double squared = 0;
        for (int k = 0; k < 3; ++k) {
          volatile const float held = static_cast<float>(p[k] - about[k]);
          const double off = static_cast<double>(held) + about[k] - p[k];
          squared += off * off;
        }
        moved = std::max(moved, squared);
      }
      EXPECT_EQ(run.low, low);
      EXPECT_EQ(run.high, high);
      EXPECT_EQ(run.moved_squared, moved);
      EXPECT_GT(moved, 0);
      EXPECT_TRUE(run.within);
    }
  }
}

TEST(FloatRows, OneNumberBeyondTheLimitIsSeenWhereverItStands) {
  std::mt19937_64 random(2);
  constexpr std::size_t kCount = 21;
  for (const double bad : {std::nan(""), 1.5e9, -std::numeric_limits<double>::infinity(), 1e300}) {
    for (std::size_t at = 0; at < 3 * kCount; ++at) {
      std::vector<Vec3> points = random_points(kCount, random);
      points[at / 3][static_cast<int>(at % 3)] = bad;
      EXPECT_FALSE(measure_floats(points, Vec3::Zero(), kLimit).within) << bad << " at " << at;
    }
  }
}

TEST(FloatRows, NormalsThatAreNotUnitAreToldWhereverTheyStand) {
  std::mt19937_64 random(3);
  constexpr std::size_t kCount = 21;
  std::vector<Vec3> normals = random_points(kCount, random);
  for (Vec3& n : normals) n.normalize();
  std::array<char, 12 * kCount> bytes{};
  EXPECT_TRUE(put_unit_floats(normals, 2e-3, bytes.data()));
  for (std::size_t i = 0; i < 3 * kCount; ++i) {
    float value = 0;
    std::memcpy(&value, bytes.data() + 4 * i, 4);
    EXPECT_EQ(value, as_float(normals[i / 3][static_cast<int>(i % 3)]));
  }
  for (std::size_t at = 0; at < kCount; ++at) {
    for (const double scale : {0.0, 1.01, std::nan("")}) {
      std::vector<Vec3> spoilt = normals;
      spoilt[at] *= scale;
      EXPECT_FALSE(put_unit_floats(spoilt, 2e-3, bytes.data())) << scale << " at " << at;
    }
  }
}

TEST(FloatRows, NumbersBecomeShortsAndTellTheirRange) {
  std::mt19937_64 random(4);
  for (std::size_t count = 1; count < 80; ++count) {
    constexpr std::uint32_t kBase = 3000000000;
    std::vector<std::uint32_t> numbers(count);
    for (std::uint32_t& n : numbers) n = kBase + static_cast<std::uint32_t>(random() % 65536);
    if (count % 3 == 0) numbers[count / 2] = kBase + 65535;
    if (count % 3 == 1) numbers[count / 2] = kBase;
    EXPECT_EQ(range_of(numbers), (std::array{*std::min_element(numbers.begin(), numbers.end()),
                                             *std::max_element(numbers.begin(), numbers.end())}));
    std::vector<char> bytes(2 * count + 1, 'x');
    put_shorts(numbers, kBase, bytes.data());
    EXPECT_EQ(bytes.back(), 'x');
    for (std::size_t i = 0; i < count; ++i) {
      std::uint16_t value = 0;
      std::memcpy(&value, bytes.data() + 2 * i, 2);
      EXPECT_EQ(value, numbers[i] - kBase);
    }
  }
}

}  // namespace
