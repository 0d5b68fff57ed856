// What a face or the shadow of a body can do over a plan box: certain enclosures, linear part plus
// remainder. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <type_traits>

#include "core/compound/compound_impl.h"

namespace diesink {

// A fixed-capacity list; `full` is set where something did not fit (the cell is then split).
// Raw storage: making one costs nothing, copying one costs what it holds. T is trivially copyable.
template <class T, int N>
class ShortList {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  int count = 0;
  bool full = false;

  ShortList() {}  // NOLINT: the storage stays as it is
  ShortList(const ShortList& other) { *this = other; }
  ShortList& operator=(const ShortList& other) {
    if (this == &other) return *this;
    count = other.count;
    full = other.full;
    std::memcpy(storage_, other.storage_, static_cast<std::size_t>(count) * sizeof(T));
    return *this;
  }
  ~ShortList() = default;

  void clear() { count = 0, full = false; }
  void push(const T& item) {
    if (count < N) {
      std::memcpy(storage_ + static_cast<std::size_t>(count++) * sizeof(T), &item, sizeof(T));
    } else {
      full = true;
    }
  }
  T* begin() { return std::launder(reinterpret_cast<T*>(storage_)); }
  T* end() { return begin() + count; }
  const T* begin() const { return std::launder(reinterpret_cast<const T*>(storage_)); }
  const T* end() const { return begin() + count; }
  T& operator[](int i) { return begin()[i]; }
  const T& operator[](int i) const { return begin()[i]; }

 private:
  alignas(T) std::byte storage_[static_cast<std::size_t>(N) * sizeof(T)];
};

// A box by centre and half widths; a half width may be zero (a segment).
struct CellBox {
  double x = 0, y = 0, hx = 0, hy = 0;
  static CellBox of(const PlanBox& b) {
    return {0.5 * (b.x0 + b.x1), 0.5 * (b.y0 + b.y1), 0.5 * (b.x1 - b.x0), 0.5 * (b.y1 - b.y0)};
  }
};

// z of a face over a box: c + gx dx + gy dy + [lo, hi] about the centre, wherever the face's own
// surface is defined.
struct FaceOver {
  Label label = kNoLabel;
  std::int32_t solid = -1;  // -1 = base
  std::uint8_t face = 0;
  bool upper = true;
  bool side = false;  // a quadric side: its silhouette may lie in the box
  bool has_mid =
      false;  // z is on `upper`'s side of the middle plane mc + mgx dx + mgy dy (between the roots)
  bool tangent = false;    // the linear part is the tangent plane (else the middle plane)
  std::int32_t same = -1;  // sides of one quadric seen from one side have one number; -1: no side
  double c = 0, gx = 0, gy = 0;
  double lo = 0, hi = 0;
  double mc = 0, mgx = 0, mgy = 0;
  Range zx, zy;  // gradient over the box; unbounded near a silhouette
};

// The zero line of a conic in a box as two graphs, over y or over x, that are nearly straight.
enum class TwoGraphs : std::uint8_t { kNo, kOverY, kOverX };

// A function of the plan across whose zero line labels may change.
struct PlanFunction {
  enum class Kind : std::uint8_t {
    kShadow,
    kSilhouette,
    kRim,
    kFaces,
    kCrossing,
    kOutline
  } kind = Kind::kShadow;
  std::int32_t solid = -1;           // the body, or the first of two
  std::uint32_t id = 0;              // which of the body's functions; labels for kCrossing
  Label a = kNoLabel, b = kNoLabel;  // kFaces, kCrossing
  double v = 0;                      // at the centre
  Range gx, gy;                      // gradient over the box
  double lo = 0, hi = 0;             // value over the box
  double cgx = 0, cgy = 0;           // gradient at the centre
  double bend = 0;                   // bound of the second-order part over the box
  bool exact = false;                // v, cgx, cgy and the next three are all of it: a conic
  double hxx = 0, hxy = 0, hyy = 0;  // second derivatives
  TwoGraphs two = TwoGraphs::kNo;    // where it is not regular
  bool implicit_side =
      false;  // kCrossing: the value is q of a quadric side on the other surface ...
  Label implicit_label = kNoLabel;  // ... and this is that side
  // Shadows: the body's height on the zero line, as a plane about the centre; where that loses,
  // nothing is seen there.
  bool has_height = false;
  double hc = 0, hgx = 0, hgy = 0;

  // What it is over the box; of which faces it is stays as it was.
  void take_values(const PlanFunction& of) {
    v = of.v;
    gx = of.gx;
    gy = of.gy;
    lo = of.lo;
    hi = of.hi;
    cgx = of.cgx;
    cgy = of.cgy;
    bend = of.bend;
    exact = of.exact;
    hxx = of.hxx;
    hxy = of.hxy;
    hyy = of.hyy;
    two = of.two;
  }
  [[nodiscard]] bool regular_x() const { return gx.lo > 0 || gx.hi < 0; }
  [[nodiscard]] bool regular_y() const { return gy.lo > 0 || gy.hi < 0; }
  [[nodiscard]] bool regular() const { return regular_x() || regular_y(); }
  // The direction of its gradient is within some 31 degrees of that in the middle all over the box,
  // or it is two graphs: an arc of its zero line is close to its chord, so that points of the chord
  // lead to points of the arc. (A gradient that changes its length alone, as between two lines that
  // are nearly one, bends nothing.)
  [[nodiscard]] bool is_nearly_straight() const;
  // What of its zero line is in the box enters and leaves.
  [[nodiscard]] bool passes() const { return regular() || two != TwoGraphs::kNo; }
};

using FaceList = ShortList<FaceOver, 12>;
using FunctionList = ShortList<PlanFunction, 24>;

// A body over a box, seen from above (upper = true) or below.
struct BodyOver {
  Coverage coverage = Coverage::kOutside;
  FaceList faces;       // those that may bound the body there
  FunctionList shadow;  // functions that may vanish on the shadow's border in the box
  FunctionList rims;    // functions that may vanish where two of the faces meet
};

// Bound: every height the body takes in the box lies in the enclosure of one of the listed faces.
void body_over(const CompoundSurface::Impl& surface, const CompoundStep& step, bool upper,
               const CellBox& box, BodyOver& out);

// The base over a box; `outline` gets a function where its border may pass.
Coverage base_over(const CompoundSurface::Impl& surface, const CompoundStep& step,
                   const CellBox& box, FaceOver& face, FunctionList& outline);

// Range over the box of f - g.
Range difference_over(const FaceOver& f, const FaceOver& g, const CellBox& box);

// Two quadric sides that are both there all over the box and do not meet in it for sure: at the
// centre is everywhere the higher one.
bool sides_run_apart(const CompoundSurface::Impl& surface, const FaceOver& f, const FaceOver& g,
                     const CellBox& box);

// Range over the box of a quadric side's form on another face's height: zero where they meet.
Range side_form_over(const CompoundSurface::Impl& surface, const FaceOver& side,
                     const FaceOver& height, const CellBox& box);

// The function across whose zero line f and g change places, regular even near the silhouette of
// one of them.
PlanFunction crossing_over(const CompoundSurface::Impl& surface, const FaceOver& f,
                           const FaceOver& g, const CellBox& box);

}  // namespace diesink
