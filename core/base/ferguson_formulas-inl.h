// The arithmetic of a Ferguson patch, written once for one point and for several at a time: T is
// double or a vector, `lift` turns a double into a T. Both do the same operations in the same
// order, so that both give the same digits. Included inside a namespace, once an instruction set,
// without an include guard. DIESINK_INLINE says how to inline.
// SPDX-License-Identifier: Apache-2.0

// A bicubic at one t: cubics in s of the value (r) and of the derivative by t (d).
template <class T>
struct PatchLine {
  T r0, r1, r2, r3, d0, d1, d2, d3;
};

template <class T, class Lift>
DIESINK_INLINE T cubic(const std::array<double, 4>& c, T t, Lift lift) {
  return ((lift(c[3]) * t + lift(c[2])) * t + lift(c[1])) * t + lift(c[0]);
}

template <class T, class Lift>
DIESINK_INLINE T cubic_slope(const std::array<double, 4>& c, T t, Lift lift) {
  return (lift(3 * c[3]) * t + lift(2 * c[2])) * t + lift(c[1]);
}

template <class T, class Lift>
DIESINK_INLINE PatchLine<T> line_at(const Bicubic& f, T t, Lift lift) {
  return {cubic(f.c[0], t, lift),       cubic(f.c[1], t, lift),       cubic(f.c[2], t, lift),
          cubic(f.c[3], t, lift),       cubic_slope(f.c[0], t, lift), cubic_slope(f.c[1], t, lift),
          cubic_slope(f.c[2], t, lift), cubic_slope(f.c[3], t, lift)};
}

// Value and derivatives by s and t at s of a line.
template <class T>
struct PatchValue {
  T f, fs, ft;
};

template <class T, class Lift>
DIESINK_INLINE PatchValue<T> value_at(const PatchLine<T>& l, T s, Lift lift) {
  return {((l.r3 * s + l.r2) * s + l.r1) * s + l.r0,
          ((lift(3.0) * l.r3) * s + lift(2.0) * l.r2) * s + l.r1,
          ((l.d3 * s + l.d2) * s + l.d1) * s + l.d0};
}

// The start of the inversion along one y: polynomials in xi.
struct InverseLine {
  double s[kInverseDegree + 1], t[kInverseDegree + 1];
};

inline InverseLine inverse_line(const InversePatch& p, double y) {
  const double eta = (y - p.cy) * p.iy;
  InverseLine out;
  std::size_t term = kInverseTerms;
  for (std::size_t i = kInverseDegree + 1; i-- > 0;) {
    double s = 0, t = 0;
    for (std::size_t j = kInverseDegree - i + 1; j-- > 0;) {
      --term;
      s = s * eta + p.s[term];
      t = t * eta + p.t[term];
    }
    out.s[i] = s;
    out.t[i] = t;
  }
  return out;
}

template <class T, class Lift>
DIESINK_INLINE void start_at(const InversePatch& p, const InverseLine& line, T x, Lift lift, T& s,
                             T& t) {
  const T xi = (x - lift(p.cx)) * lift(p.ix);
  s = lift(line.s[kInverseDegree]);
  t = lift(line.t[kInverseDegree]);
  for (std::size_t i = kInverseDegree; i-- > 0;) {
    s = s * xi + lift(line.s[i]);
    t = t * xi + lift(line.t[i]);
  }
}

// One Newton step towards x(s, t) = px, y(s, t) = py, and the plan's derivatives where it starts.
template <class T>
struct NewtonStep {
  T ds, dt;
  PlanSlopes<T> slopes;
};

template <class T, class Lift>
DIESINK_INLINE NewtonStep<T> newton_step(const FergusonPatch& p, T px, T py, T s, T t, Lift lift) {
  const PatchValue<T> x = value_at(line_at(p.x, t, lift), s, lift);
  const PatchValue<T> y = value_at(line_at(p.y, t, lift), s, lift);
  const T rx = px - x.f, ry = py - y.f;
  const T inverse = lift(1.0) / (x.fs * y.ft - x.ft * y.fs);
  return {(rx * y.ft - ry * x.ft) * inverse,
          (x.fs * ry - y.fs * rx) * inverse,
          {x.fs, x.ft, y.fs, y.ft, inverse}};
}

// Slopes of the height by x and y.
template <class T>
struct PlanSlope {
  T zx, zy;
};

template <class T>
DIESINK_INLINE PlanSlope<T> warped_slope(const PatchValue<T>& z, const PlanSlopes<T>& n) {
  return {(z.fs * n.yt - z.ft * n.ys) * n.inverse, (z.ft * n.xs - z.fs * n.xt) * n.inverse};
}

template <class T, class Lift>
DIESINK_INLINE PlanSlope<T> affine_slope(const PatchValue<T>& z, const AffinePlan& a, Lift lift) {
  return {z.fs * lift(a.ux) + z.ft * lift(a.vx), z.fs * lift(a.uy) + z.ft * lift(a.vy)};
}
