// The compound surface: bodies added to and subtracted from a base, evaluated on vertical lines.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/base_surface.h"
#include "core/mesh.h"
#include "core/part_program/part_program.h"
#include "core/vec.h"

namespace diesink {

// The face that wins on a vertical line: row of the Boolean table and face number, in one word that
// compares fast.
using Label = std::uint32_t;
inline constexpr Label kNoLabel = 0xFFFFFFFFu;  // no surface: a hole
constexpr Label make_label(int row, std::uint32_t face) {
  return (static_cast<Label>(row) << 4) | static_cast<Label>(face);
}
constexpr int row_of(Label label) { return static_cast<int>(label >> 4); }
constexpr int face_of(Label label) { return static_cast<int>(label & 15u); }

// One CC-datum (paper, Fig. 8): a point of the surface, its unit normal turned upward, and what it
// lies on.
struct CcDatum {
  double z = 0;
  Vec3 n = Vec3::UnitZ();
  int surface = 0;  // 0 = base, k = k-th solid of the program
  int row = 0;      // row of the Boolean table, 0 for the first term
  int face = 0;     // 0 for the base, else the number of core/geometry.h
};

// A run of CC-data along x at one y, structure of arrays; all arrays have the length of the run.
// Where there is no surface z is NaN, the normal 0 and the label kNoLabel.
struct CcRun {
  double* z = nullptr;
  double* nx = nullptr;
  double* ny = nullptr;
  double* nz = nullptr;
  Label* label = nullptr;
};

// Ties: a later term takes the point only where it is beyond the value so far by more than
// tie_tolerance();
//       that is 2^-42 of the largest coordinate, above rounding and below 1e-12 of the model's
//       size.
// Immutable after make(); every const function may be called from several threads.
class CompoundSurface {
 public:
  struct Impl;

  // `scan` is the mesh that a MESH base names, in the program's unit with Z up, as its file has it;
  // what the program does not state of the domain and the grid is filled in from it.
  // Needs: a program that parse_part_program accepted.
  // Errors: kInput where a base grid is folded in plan, or a MESH base has no scan or one that
  //         cannot be a base; kLimit where the domain filled in gives too many grid points.
  static Result<CompoundSurface> make(const PartProgram& program,
                                      std::optional<TriangleMesh> scan = std::nullopt);

  CompoundSurface(CompoundSurface&&) noexcept;
  CompoundSurface& operator=(CompoundSurface&&) noexcept;
  ~CompoundSurface();

  // The CC-datum over (x, y); empty where there is no surface.
  // Bound: |dz| <= 1e-12 of size() (tests/core/evaluate_test.cpp); on a MESH base that of
  //        ScannedSurface::at().
  [[nodiscard]] std::optional<CcDatum> at(double x, double y) const;

  // CC-data at (xs[i], y) for ascending xs. The same labels and heights as at() point by point.
  void row(double y, std::span<const double> xs, const CcRun& out) const;

  // CC-data at (xs[i], ys[j]), both ascending: row() over all rows, and the same digits. A scan is
  // drawn as a whole.
  // Shape: arrays of xs.size() ys.size() values, row after row.
  void grid(std::span<const double> xs, std::span<const double> ys, const CcRun& out,
            int threads) const;

  [[nodiscard]] const PartProgram& program() const;
  [[nodiscard]] double size() const;  // largest absolute coordinate of domain, solids and base
  [[nodiscard]] double tie_tolerance() const;  // length, see above
  [[nodiscard]] int row_count() const;         // terms of the Boolean table
  [[nodiscard]] int surface_of_row(int row) const;
  [[nodiscard]] Sign sign_of_row(int row) const;
  [[nodiscard]] std::string element_name(Label label) const;  // "S2.side", "B"

  [[nodiscard]] const Impl& impl() const { return *impl_; }

 private:
  explicit CompoundSurface(std::unique_ptr<const Impl> impl);
  std::unique_ptr<const Impl> impl_;
};

}  // namespace diesink
