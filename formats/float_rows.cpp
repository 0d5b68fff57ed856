// SPDX-License-Identifier: Apache-2.0
//
// Each loop takes as many vertices at a time as the machine's vectors hold, and one by one at the
// end: the same digits either way, as nothing is summed across vertices.
#include "formats/float_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <hwy/cache_control.h>

// What the inclusions for the different targets share stands before them.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/float_rows.cpp"
#include "core/simd.h"

HWY_BEFORE_NAMESPACE();
namespace diesink {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<double>;
using F = hn::Rebind<float, D>;
using V = hn::Vec<D>;

static_assert(sizeof(Vec3) == 3 * sizeof(double));

// Asks the memory for the numbers two kilobytes further on, of which `size` bytes are taken at a
// time: left to itself the machine stops at the end of each page (measured: a fifth faster). What
// lies beyond the end of the numbers is asked for and never read.
HWY_INLINE void ask_ahead(const void* numbers, std::size_t size) {
  constexpr std::size_t kAhead = 2048, kLine = 64;
  for (std::size_t at = 0; at < size; at += kLine) {
    hwy::Prefetch(static_cast<const char*>(numbers) + kAhead + at);
  }
}

// Coordinate i of a vector's worth of vertices, of numbers that repeat every three.
HWY_INLINE std::array<V, 3> repeated(const Vec3& p) {
  std::array<double, 3 * hn::MaxLanes(D())> numbers;
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = p[static_cast<int>(i % 3)];
  const std::size_t lanes = hn::Lanes(D());
  return {hn::LoadU(D(), numbers.data()), hn::LoadU(D(), numbers.data() + lanes),
          hn::LoadU(D(), numbers.data() + 2 * lanes)};
}

HWY_INLINE void store(V v, char* to) {
  // Adding zero turns -0 into 0.
  const auto floats = hn::Add(hn::DemoteTo(F(), v), hn::Zero(F()));
  hn::StoreU(floats, F(), reinterpret_cast<float*>(to));
}

HWY_INLINE void store_one(const Vec3& p, const Vec3& offset, char* to) {
  for (int k = 0; k < 3; ++k, to += sizeof(float)) {
    const float f = static_cast<float>(p[k] - offset[k]) + 0.0F;
    std::memcpy(to, &f, sizeof f);
  }
}

FloatRun measure_kernel(std::span<const Vec3> run, const Vec3& offset, double limit) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  FloatRun found{run.front(), run.front()};
  std::size_t i = 0;
  if (run.size() >= lanes) {
    std::array<V, 3> low{hn::Set(d, run.front().x()), hn::Set(d, run.front().y()),
                         hn::Set(d, run.front().z())};
    std::array<V, 3> high = low;
    const std::array<V, 3> about{hn::Set(d, offset.x()), hn::Set(d, offset.y()),
                                 hn::Set(d, offset.z())};
    const V most = hn::Set(d, limit);
    V worst = hn::Zero(d);
    auto within = hn::Eq(worst, worst);
    for (; i + lanes <= run.size(); i += lanes) {
      ask_ahead(run[i].data(), lanes * sizeof(Vec3));
      std::array<V, 3> p;
      hn::LoadInterleaved3(d, run[i].data(), p[0], p[1], p[2]);
      V squared = hn::Zero(d);
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = hn::Min(low[k], p[k]);
        high[k] = hn::Max(high[k], p[k]);
        within = hn::And(within, hn::Le(hn::Abs(p[k]), most));
        const V held = hn::PromoteTo(d, hn::DemoteTo(F(), hn::Sub(p[k], about[k])));
        const V off = hn::Sub(hn::Add(held, about[k]), p[k]);
        squared = hn::Add(squared, hn::Mul(off, off));
      }
      worst = hn::Max(worst, squared);
    }
    for (int k = 0; k < 3; ++k) {
      found.low[k] = hn::GetLane(hn::MinOfLanes(d, low[static_cast<std::size_t>(k)]));
      found.high[k] = hn::GetLane(hn::MaxOfLanes(d, high[static_cast<std::size_t>(k)]));
    }
    found.moved_squared = hn::GetLane(hn::MaxOfLanes(d, worst));
    found.within = hn::AllTrue(d, within);
  }
  for (; i < run.size(); ++i) {
    const Vec3& p = run[i];
    double squared = 0;
    for (int k = 0; k < 3; ++k) {
      found.low[k] = std::min(found.low[k], p[k]);
      found.high[k] = std::max(found.high[k], p[k]);
      found.within &= std::abs(p[k]) <= limit;  // not so for NaN
      const double off =
          static_cast<double>(static_cast<float>(p[k] - offset[k])) + offset[k] - p[k];
      squared += off * off;
    }
    found.moved_squared = std::max(found.moved_squared, squared);
  }
  return found;
}

void floats_kernel(std::span<const Vec3> from, const Vec3& offset, char* to) {
  const std::size_t lanes = hn::Lanes(D());
  const std::array<V, 3> about = repeated(offset);
  std::size_t i = 0;
  for (; i + lanes <= from.size(); i += lanes, to += 12 * lanes) {
    const double* const p = from[i].data();
    ask_ahead(p, lanes * sizeof(Vec3));
    for (std::size_t k = 0; k < 3; ++k) {
      store(hn::Sub(hn::LoadU(D(), p + k * lanes), about[k]), to + 4 * k * lanes);
    }
  }
  for (; i < from.size(); ++i, to += 12) store_one(from[i], offset, to);
}

bool unit_kernel(std::span<const Vec3> from, double slack, char* to) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  const V one = hn::Set(d, 1), most = hn::Set(d, slack);
  auto unit = hn::Eq(one, one);
  std::size_t i = 0;
  for (; i + lanes <= from.size(); i += lanes, to += 12 * lanes) {
    const double* const p = from[i].data();
    ask_ahead(p, lanes * sizeof(Vec3));
    V x, y, z;
    hn::LoadInterleaved3(d, p, x, y, z);
    const V squared = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
    unit = hn::And(unit, hn::Le(hn::Abs(hn::Sub(squared, one)), most));
    for (std::size_t k = 0; k < 3; ++k) store(hn::LoadU(d, p + k * lanes), to + 4 * k * lanes);
  }
  bool all = hn::AllTrue(d, unit);
  for (; i < from.size(); ++i, to += 12) {
    const Vec3& n = from[i];
    all &= std::abs(n.x() * n.x() + n.y() * n.y() + n.z() * n.z() - 1) <= slack;
    store_one(n, Vec3::Zero(), to);
  }
  return all;
}

void shorts_kernel(std::span<const std::uint32_t> from, std::uint32_t base, char* to) {
  const hn::ScalableTag<std::uint32_t> d;
  const hn::Rebind<std::uint16_t, decltype(d)> narrow;
  const std::size_t lanes = hn::Lanes(d);
  const auto less = hn::Set(d, base);
  std::size_t i = 0;
  for (; i + lanes <= from.size(); i += lanes, to += 2 * lanes) {
    ask_ahead(from.data() + i, lanes * sizeof(std::uint32_t));
    // As signed numbers, whose narrowing every instruction set has; below 65536 it is the same.
    const auto number = hn::Sub(hn::LoadU(d, from.data() + i), less);
    const auto half = hn::DemoteTo(narrow, hn::BitCast(hn::RebindToSigned<decltype(d)>(), number));
    hn::StoreU(half, narrow, reinterpret_cast<std::uint16_t*>(to));
  }
  for (; i < from.size(); ++i, to += 2) {
    const auto half = static_cast<std::uint16_t>(from[i] - base);
    std::memcpy(to, &half, sizeof half);
  }
}

void longs_kernel(std::span<const std::uint32_t> from, std::uint32_t base, char* to) {
  const hn::ScalableTag<std::uint32_t> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto less = hn::Set(d, base);
  std::size_t i = 0;
  for (; i + lanes <= from.size(); i += lanes, to += 4 * lanes) {
    ask_ahead(from.data() + i, lanes * sizeof(std::uint32_t));
    hn::StoreU(hn::Sub(hn::LoadU(d, from.data() + i), less), d,
               reinterpret_cast<std::uint32_t*>(to));
  }
  for (; i < from.size(); ++i, to += 4) {
    const std::uint32_t number = from[i] - base;
    std::memcpy(to, &number, sizeof number);
  }
}

std::array<std::uint32_t, 2> range_kernel(std::span<const std::uint32_t> numbers) {
  const hn::ScalableTag<std::uint32_t> d;
  const std::size_t lanes = hn::Lanes(d);
  std::uint32_t low = numbers.front(), high = low;
  std::size_t i = 0;
  if (numbers.size() >= lanes) {
    auto least = hn::Set(d, low), most = least;
    for (; i + lanes <= numbers.size(); i += lanes) {
      ask_ahead(numbers.data() + i, lanes * sizeof(std::uint32_t));
      const auto n = hn::LoadU(d, numbers.data() + i);
      least = hn::Min(least, n);
      most = hn::Max(most, n);
    }
    low = hn::GetLane(hn::MinOfLanes(d, least));
    high = hn::GetLane(hn::MaxOfLanes(d, most));
  }
  for (; i < numbers.size(); ++i) {
    low = std::min(low, numbers[i]);
    high = std::max(high, numbers[i]);
  }
  return {low, high};
}

bool ascending_kernel(std::span<const std::uint32_t> numbers) {
  const hn::ScalableTag<std::uint32_t> d;
  const std::size_t lanes = hn::Lanes(d), pairs = numbers.empty() ? 0 : numbers.size() - 1;
  constexpr std::size_t kBlock = 4096;  // without a way out in between
  std::size_t i = 0;
  while (i + lanes <= pairs) {
    const std::size_t end = std::min(pairs, i + kBlock);
    auto same = hn::Zero(d);
    for (; i + lanes <= end; i += lanes) {
      ask_ahead(numbers.data() + i, lanes * sizeof(std::uint32_t));
      const auto before = hn::LoadU(d, numbers.data() + i);
      const auto after = hn::LoadU(d, numbers.data() + i + 1);
      same = hn::Or(same, hn::Xor(before, hn::Min(before, after)));
    }
    if (!hn::AllTrue(d, hn::Eq(same, hn::Zero(d)))) return false;
  }
  return std::is_sorted(numbers.begin() + static_cast<std::ptrdiff_t>(i), numbers.end());
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace diesink
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace diesink {
namespace {
HWY_EXPORT(measure_kernel);
HWY_EXPORT(floats_kernel);
HWY_EXPORT(unit_kernel);
HWY_EXPORT(shorts_kernel);
HWY_EXPORT(longs_kernel);
HWY_EXPORT(range_kernel);
HWY_EXPORT(ascending_kernel);
}  // namespace

FloatRun measure_floats(std::span<const Vec3> run, const Vec3& offset, double limit) {
  return HWY_DYNAMIC_DISPATCH(measure_kernel)(run, offset, limit);
}

void put_floats(std::span<const Vec3> from, const Vec3& offset, char* to) {
  HWY_DYNAMIC_DISPATCH(floats_kernel)(from, offset, to);
}

bool put_unit_floats(std::span<const Vec3> from, double slack, char* to) {
  return HWY_DYNAMIC_DISPATCH(unit_kernel)(from, slack, to);
}

void put_shorts(std::span<const std::uint32_t> from, std::uint32_t base, char* to) {
  HWY_DYNAMIC_DISPATCH(shorts_kernel)(from, base, to);
}

void put_longs(std::span<const std::uint32_t> from, std::uint32_t base, char* to) {
  HWY_DYNAMIC_DISPATCH(longs_kernel)(from, base, to);
}

std::array<std::uint32_t, 2> range_of(std::span<const std::uint32_t> numbers) {
  return HWY_DYNAMIC_DISPATCH(range_kernel)(numbers);
}

bool is_ascending(std::span<const std::uint32_t> numbers) {
  return HWY_DYNAMIC_DISPATCH(ascending_kernel)(numbers);
}

}  // namespace diesink
#endif  // HWY_ONCE
