// SPDX-License-Identifier: Apache-2.0
//
// Four facets at a time where the machine's vectors hold a position, one by one elsewhere and at
// the end: the same digits either way.
#include "formats/facet_rows.h"

#include <cmath>
#include <cstring>

#include "formats/stl.h"

// What the inclusions for the different targets share stands before them.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "formats/facet_rows.cpp"
#include "core/simd.h"

#ifndef DIESINK_FACET_ROWS_SHARED
#define DIESINK_FACET_ROWS_SHARED
namespace diesink {
namespace {

using Corners = std::array<std::uint32_t, 3>;

// Where the square of a normal's length can be trusted: its parts are far from both ends of the
// doubles' range.
constexpr double kLeastSquare = 1e-280, kMostSquare = 1e280;

inline void put_floats_of(const Vec3& p, char* to) {
  // Adding zero turns -0 into 0: equal positions stay equal to the bit.
  const std::array<float, 3> held{static_cast<float>(p.x()) + 0.0F,
                                  static_cast<float>(p.y()) + 0.0F,
                                  static_cast<float>(p.z()) + 0.0F};
  std::memcpy(to, held.data(), sizeof held);
}

void put_facet(const Vec3* positions, const Corners& t, char* to) {
  const Vec3 &a = positions[t[0]], &b = positions[t[1]], &c = positions[t[2]];
  put_floats_of(facet_normal(a, b, c), to);
  put_floats_of(a, to + 12);
  put_floats_of(b, to + 24);
  put_floats_of(c, to + 36);
  std::memset(to + 48, 0, 2);
}

}  // namespace
}  // namespace diesink
#endif

HWY_BEFORE_NAMESPACE();
namespace diesink {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, 4>;
using F = hn::Rebind<float, D>;

static_assert(sizeof(Vec3) == 3 * sizeof(double));

// The corners at `to` and the two after it, 16 bytes each, of which the next write takes the last
// 4; the cross product at `cross` as z, x, y. The products and differences are facet_normal()'s.
HWY_INLINE void put_corners(const Vec3* positions, const Corners& t, char* to, double* cross) {
  const D d;
  const F f;
  const auto three = hn::FirstN(d, 3);
  const auto a = hn::MaskedLoad(three, d, positions[t[0]].data());
  const auto b = hn::MaskedLoad(three, d, positions[t[1]].data());
  const auto c = hn::MaskedLoad(three, d, positions[t[2]].data());
  alignas(32) static constexpr std::array<std::int64_t, 4> kNext{1, 2, 0, 3};
  const auto next = hn::SetTableIndices(d, kNext.data());
  const auto u = hn::Sub(b, a), v = hn::Sub(c, a);
  const auto u_next = hn::TableLookupLanes(u, next), v_next = hn::TableLookupLanes(v, next);
  hn::Store(hn::Sub(hn::Mul(u, v_next), hn::Mul(u_next, v)), d, cross);
  const auto zero = hn::Zero(f);
  hn::StoreU(hn::Add(hn::DemoteTo(f, a), zero), f, reinterpret_cast<float*>(to));
  hn::StoreU(hn::Add(hn::DemoteTo(f, b), zero), f, reinterpret_cast<float*>(to + 12));
  hn::StoreU(hn::Add(hn::DemoteTo(f, c), zero), f, reinterpret_cast<float*>(to + 24));
}

void facets_kernel(const Vec3* positions, std::span<const Corners> triangles, char* to) {
  std::size_t i = 0;
  if constexpr (hn::MaxLanes(D()) == 4) {
    const D d;
    const F f;
    alignas(32) std::array<double, 16> crosses;
    alignas(32) std::array<float, 16> normals;
    const auto one = hn::Set(d, 1), least = hn::Set(d, kLeastSquare),
               most = hn::Set(d, kMostSquare);
    // One facet at least is left for the loop below: these write two bytes past their own.
    for (; i + 4 < triangles.size(); i += 4, to += 4 * kStlFacetBytes) {
      const Corners* const t = triangles.data() + i;
      // Each facet's normal is put before its corners, and its attribute after.
      hn::Vec<D> x, y, z, none;
      for (std::size_t k = 0; k < 4; ++k) {
        put_corners(positions, t[k], to + k * kStlFacetBytes + 12, crosses.data() + 4 * k);
        std::memset(to + k * kStlFacetBytes + 48, 0, 2);
      }
      hn::LoadInterleaved4(d, crosses.data(), z, x, y, none);
      const auto squared = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
      if (!hn::AllTrue(d, hn::And(hn::Ge(squared, least), hn::Le(squared, most)))) {
        for (std::size_t k = 0; k < 4; ++k) put_facet(positions, t[k], to + k * kStlFacetBytes);
        continue;
      }
      const auto scale = hn::Div(one, hn::Sqrt(squared));
      const auto zero = hn::Zero(f);
      const auto held = [&](hn::Vec<D> part) {
        return hn::Add(hn::DemoteTo(f, hn::Mul(part, scale)), zero);
      };
      hn::StoreInterleaved4(held(x), held(y), held(z), zero, f, normals.data());
      for (std::size_t k = 0; k < 4; ++k) {
        std::memcpy(to + k * kStlFacetBytes, normals.data() + 4 * k, 12);
      }
    }
  }
  for (; i < triangles.size(); ++i, to += kStlFacetBytes) put_facet(positions, triangles[i], to);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace diesink
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace diesink {
namespace {
HWY_EXPORT(facets_kernel);
}  // namespace

// Written out by coordinates, as the loop above does it.
Vec3 facet_normal(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double ux = b.x() - a.x(), uy = b.y() - a.y(), uz = b.z() - a.z();
  const double vx = c.x() - a.x(), vy = c.y() - a.y(), vz = c.z() - a.z();
  const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
  const double squared = nx * nx + ny * ny + nz * nz;
  if (squared >= kLeastSquare && squared <= kMostSquare) {
    const double scale = 1 / std::sqrt(squared);
    return {nx * scale, ny * scale, nz * scale};
  }
  // Where the squares leave the range of doubles.
  const double length = std::hypot(nx, ny, nz);
  if (!(length > 0)) return Vec3::Zero();
  return {nx / length, ny / length, nz / length};
}

void put_facets(std::span<const Vec3> positions,
                std::span<const std::array<std::uint32_t, 3>> triangles, char* to) {
  HWY_DYNAMIC_DISPATCH(facets_kernel)(positions.data(), triangles, to);
}

}  // namespace diesink
#endif  // HWY_ONCE
