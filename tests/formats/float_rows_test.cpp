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
#include <utility>
#include <vector>

#include "formats/facet_rows.h"

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

// What put() makes of the numbers, each less the base, and of no byte behind them.
template <class Stored, class Put>
void expect_put(Put put, const std::vector<std::uint32_t>& numbers, std::uint32_t base) {
  std::vector<char> bytes(sizeof(Stored) * numbers.size() + 1, 'x');
  put(numbers, base, bytes.data());
  EXPECT_EQ(bytes.back(), 'x');
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Stored value = 0;
    std::memcpy(&value, bytes.data() + sizeof value * i, sizeof value);
    EXPECT_EQ(value, numbers[i] - base);
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
    expect_put<std::uint16_t>(put_shorts, numbers, kBase);
    expect_put<std::uint32_t>(put_longs, numbers, kBase);
  }
}

TEST(FloatRows, OneNumberOutOfOrderIsSeenWhereverItStands) {
  EXPECT_TRUE(is_ascending({}));
  for (const std::size_t count : {1u, 2u, 9u, 40u, 5000u}) {
    std::vector<std::uint32_t> numbers(count);
    for (std::size_t i = 0; i < count; ++i) {
      numbers[i] = 4294967295u - static_cast<std::uint32_t>((count - i) / 3);
    }
    EXPECT_TRUE(is_ascending(numbers)) << count;
    const std::size_t step = count > 100 ? 7 : 1;
    for (std::size_t at = 1; at < count; at += step) {
      const std::uint32_t was = std::exchange(numbers[at], numbers[at - 1] - 1);
      EXPECT_FALSE(is_ascending(numbers)) << at << " of " << count;
      numbers[at] = was;
    }
  }
}

// What one facet at a time gives, by the rules of the header.
std::vector<char> facets_one_by_one(const std::vector<Vec3>& points,
                                    const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<char> bytes;
  const auto put = [&bytes](const Vec3& p) {
    for (int k = 0; k < 3; ++k) {
      const float f = as_float(p[k]);
      const char* const from = reinterpret_cast<const char*>(&f);
      bytes.insert(bytes.end(), from, from + 4);
    }
  };
  for (const auto& t : triangles) {
    put(facet_normal(points[t[0]], points[t[1]], points[t[2]]));
    for (const std::uint32_t v : t) put(points[v]);
    bytes.insert(bytes.end(), 2, 0);
  }
  return bytes;
}

TEST(FacetRows, EveryCountGivesTheBytesOfOneByOne) {
  std::mt19937_64 random(9);
  for (std::size_t count = 0; count < 40; ++count) {
    std::vector<Vec3> points = random_points(30, random);
    points[3].x() = points[7].y() = -0.0;
    points[8] = points[9];
    points[10] = Vec3::Constant(1e-160);  // squares that leave the range of doubles
    points[11] = Vec3(3e-160, -1e-160, 2e-160);
    points[12] = Vec3::Zero();
    points[13] = Vec3(1e30, -3e37, 0);
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::size_t i = 0; i < count; ++i) {
      const auto any = [&random] { return static_cast<std::uint32_t>(random() % 30); };
      triangles.push_back({any(), any(), any()});
      // The special ones are among blocks of usual ones, at every place of a block.
      if (i % 11 == 3) triangles.back() = {10, 11, 12};
      if (i % 11 == 8) triangles.back() = {8, 9, any()};
    }
    std::vector<char> bytes(1 + 50 * count + 1, 'x');
    put_facets(points, triangles, bytes.data() + 1);
    EXPECT_EQ(bytes.front(), 'x');
    EXPECT_EQ(bytes.back(), 'x');
    const std::vector<char> expected = facets_one_by_one(points, triangles);
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), bytes.begin() + 1)) << count;
  }
}

TEST(FacetRows, ANormalIsOfUnitLengthAndOfTheTurnOfTheCorners) {
  EXPECT_EQ(facet_normal(Vec3::Zero(), 2 * Vec3::UnitX(), 3 * Vec3::UnitY()), Vec3::UnitZ());
  EXPECT_EQ(facet_normal(Vec3::Zero(), Vec3::UnitX(), 2 * Vec3::UnitX()), Vec3::Zero());
  EXPECT_NEAR(facet_normal(Vec3::Zero(), Vec3(1e-160, 0, 0), Vec3(0, 0, 1e-150)).y(), -1, 1e-12);
}

}  // namespace
