// The plan map of a Ferguson patch: proof that it is not folded, its preimages and a polynomial
// near its inverse. The contraction of preimage() is the interval Newton operator in Krawczyk's
// form, preconditioned at the middle.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/base/ferguson_impl.h"
#include "core/interval.h"
#include "core/parallel.h"

namespace diesink {
namespace {

// Halvings of a patch before what is not shown yet counts as folded.
constexpr int kFoldDepth = 7;

// Coefficients of a polynomial of degree 5 by 5, Bernstein or powers.
using Net = std::array<std::array<double, 6>, 6>;

constexpr double kChoose5[6] = {1, 5, 10, 10, 5, 1};
constexpr double kChoose[6][6] = {{1, 0, 0, 0, 0, 0}, {1, 1, 0, 0, 0, 0}, {1, 2, 1, 0, 0, 0},
                                  {1, 3, 3, 1, 0, 0}, {1, 4, 6, 4, 1, 0}, {1, 5, 10, 10, 5, 1}};

// x_s y_t - x_t y_s in powers, then in Bernstein form over the unit square.
Net plan_jacobian(const FergusonPatch& p) {
  Net powers{};
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t l = 0; l < 4; ++l) {
      for (std::size_t m = 0; m < 4; ++m) {
        for (std::size_t n = 0; n < 4; ++n) {
          // s-derivative of term (k, l) against t-derivative of (m, n).
          if (k == 0 || n == 0) continue;
          const double factor = static_cast<double>(k * n);
          powers[k + m - 1][l + n - 1] +=
              factor * (p.x.c[k][l] * p.y.c[m][n] - p.x.c[m][n] * p.y.c[k][l]);
        }
      }
    }
  }
  Net half{}, net{};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t l = 0; l < 6; ++l) {
      for (std::size_t k = 0; k <= i; ++k) half[i][l] += kChoose[i][k] / kChoose5[k] * powers[k][l];
    }
  }
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      for (std::size_t l = 0; l <= j; ++l) net[i][j] += kChoose[j][l] / kChoose5[l] * half[i][l];
    }
  }
  return net;
}

// Halves a net along its first index; the second call for the other index works on the transposed
// net.
void halve(const Net& net, Net& low, Net& high) {
  for (std::size_t j = 0; j < 6; ++j) {
    std::array<double, 6> b;
    for (std::size_t i = 0; i < 6; ++i) b[i] = net[i][j];
    for (std::size_t level = 0; level < 6; ++level) {
      low[level][j] = b[0];
      high[5 - level][j] = b[5 - level];
      for (std::size_t i = 0; i + level + 1 < 6; ++i) b[i] = 0.5 * (b[i] + b[i + 1]);
    }
  }
}

Net transposed(const Net& net) {
  Net out;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) out[j][i] = net[i][j];
  }
  return out;
}

bool positive(const Net& net, double floor, int depth) {
  bool all = true;
  for (const auto& row : net) {
    for (const double b : row) all = all && b > floor;
  }
  if (all) return true;
  // The corners are values of the Jacobian itself.
  if (!(net[0][0] > floor && net[5][0] > floor && net[0][5] > floor && net[5][5] > floor) ||
      depth == 0)
    return false;
  Net low, high;
  halve(net, low, high);
  // Transposed, so that the next halving goes the other way.
  return positive(transposed(low), floor, depth - 1) &&
         positive(transposed(high), floor, depth - 1);
}

struct Contraction {
  bool empty = false;
  double norm = 0;  // of what the linear part does not explain; below 1 the plan map is one to one
};

// Shrinks the box to what the plan map can bring into `plan`, never losing a point of it.
Contraction contract(const FergusonPatch& p, const PlanBox& plan, ParameterBox& box) {
  const BicubicOver x(p.x, box), y(p.y, box);
  if (is_empty(intersection(x.range(0, 0), {plan.x0, plan.x1})) ||
      is_empty(intersection(y.range(0, 0), {plan.y0, plan.y1}))) {
    return {true, 0};
  }
  const double xs = x.middle(1, 0), xt = x.middle(0, 1), ys = y.middle(1, 0), yt = y.middle(0, 1);
  const double det = xs * yt - xt * ys;
  if (!(std::fabs(det) > 1e-9 * (std::fabs(xs * yt) + std::fabs(xt * ys)))) return {false, 1};
  const double ax = yt / det, ay = -xt / det, bx = -ys / det, by = xs / det;
  const Range jxs = x.range(1, 0), jxt = x.range(0, 1), jys = y.range(1, 0), jyt = y.range(0, 1);
  const Range one = point_range(1);
  const Range ss = one - (ax * jxs + ay * jys), st = -(ax * jxt + ay * jyt);
  const Range ts = -(bx * jxs + by * jys), tt = one - (bx * jxt + by * jyt);
  const double s = 0.5 * (box.s0 + box.s1), t = 0.5 * (box.t0 + box.t1);
  const Range hs = symmetric(0.5 * (box.s1 - box.s0) + 0x1p-52),
              ht = symmetric(0.5 * (box.t1 - box.t0) + 0x1p-52);
  // The value at the middle with its rounding: the polynomial over a point.
  const ParameterBox centre{s, s, t, t};
  const Range rx = Range{plan.x0, plan.x1} - BicubicOver(p.x, centre).range(0, 0);
  const Range ry = Range{plan.y0, plan.y1} - BicubicOver(p.y, centre).range(0, 0);
  const Range ns = point_range(s) + (ax * rx + ay * ry + ss * hs + st * ht);
  const Range nt = point_range(t) + (bx * rx + by * ry + ts * hs + tt * ht);
  const Range in_s = intersection(ns, {box.s0, box.s1}), in_t = intersection(nt, {box.t0, box.t1});
  if (is_empty(in_s) || is_empty(in_t)) return {true, 0};
  box = {in_s.lo, in_s.hi, in_t.lo, in_t.hi};
  return {false, std::max(magnitude(ss) + magnitude(st), magnitude(ts) + magnitude(tt))};
}

}  // namespace

std::optional<Vec2> outline_crossing(std::span<const Vec2> outline) {
  const std::size_t n = outline.size();
  const auto end = [&](std::size_t k) -> const Vec2& { return outline[(k + 1) % n]; };
  std::vector<std::size_t> order(n);
  for (std::size_t k = 0; k < n; ++k) order[k] = k;
  const auto left = [&](std::size_t k) { return std::min(outline[k].x(), end(k).x()); };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return left(a) != left(b) ? left(a) < left(b) : a < b;
  });
  const auto side = [](const Vec2& a, const Vec2& b, const Vec2& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  // Sweep along x: only segments that overlap there can cross.
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t a = order[i];
    const Vec2 &p = outline[a], &q = end(a);
    const double right = std::max(p.x(), q.x());
    for (std::size_t j = i + 1; j < n && left(order[j]) <= right; ++j) {
      const std::size_t b = order[j];
      if ((a + 1) % n == b || (b + 1) % n == a) continue;
      const Vec2 &r = outline[b], &t = end(b);
      if (side(p, q, r) * side(p, q, t) < 0 && side(r, t, p) * side(r, t, q) < 0) return p;
    }
  }
  return std::nullopt;
}

bool unfolded(const FergusonPatch& patch, bool turned) {
  Net net = plan_jacobian(patch);
  double largest = 0;
  for (auto& row : net) {
    for (double& b : row) {
      if (turned) b = -b;
      largest = std::max(largest, std::fabs(b));
    }
  }
  // Above the rounding of the net, and above zero: a collapsed corner is refused as well.
  return positive(net, 1e-9 * largest, 2 * kFoldDepth);
}

bool contract_inside(const FergusonPatch& patch, const PlanBox& plan, ParameterBox& box) {
  const ParameterBox before = box;
  return !contract(patch, plan, box).empty && box.s0 > before.s0 && box.s1 < before.s1 &&
         box.t0 > before.t0 && box.t1 < before.t1;
}

void preimage(const FergusonPatch& patch, const PlanBox& plan, ParameterBoxes& out) {
  struct Open {
    ParameterBox box;
    int depth;
  };
  constexpr int kDepth = 40;
  std::array<Open, kDepth + 2> stack;
  std::size_t open = 0;
  const double c = patch.closeness;
  stack[open++] = {{-c, 1 + c, -c, 1 + c}, 0};
  while (open > 0) {
    Open now = stack[--open];
    for (int round = 0;; ++round) {
      const ParameterBox before = now.box;
      const Contraction k = contract(patch, plan, now.box);
      if (k.empty) break;
      const double ds = now.box.s1 - now.box.s0, dt = now.box.t1 - now.box.t0;
      const bool shrank = ds < 0.8 * (before.s1 - before.s0) || dt < 0.8 * (before.t1 - before.t0);
      if (shrank && round < 12) continue;
      if (k.norm < 0.5 || now.depth == kDepth) {
        out.add(now.box);
        break;
      }
      // Not nearly linear over so large a box: both halves.
      Open other = now;
      ++now.depth;
      ++other.depth;
      if (ds > dt) {
        now.box.s1 = other.box.s0 = 0.5 * (now.box.s0 + now.box.s1);
      } else {
        now.box.t1 = other.box.t0 = 0.5 * (now.box.t0 + now.box.t1);
      }
      stack[open++] = other;
      round = -1;
    }
  }
}

InversePatch fit_inverse(const FergusonPatch& patch) {
  InversePatch out;
  out.cx = 0.5 * (patch.box.x0 + patch.box.x1);
  out.cy = 0.5 * (patch.box.y0 + patch.box.y1);
  out.ix = 2 / (patch.box.x1 - patch.box.x0);
  out.iy = 2 / (patch.box.y1 - patch.box.y0);
  // Least squares over a grid of samples that is denser towards the patch's border; normal
  // equations by Cholesky.
  constexpr std::size_t kTerms = kInverseTerms;
  constexpr int kSamples = 11;
  std::array<std::array<double, kTerms>, kTerms> a{};
  for (int i = 0; i < kSamples; ++i) {
    for (int j = 0; j < kSamples; ++j) {
      const auto place = [](int k) {
        return 0.5 - 0.5 * std::cos(3.14159265358979 * k / (kSamples - 1));
      };
      const double s = place(i), t = place(j);
      const double xi = (patch.x.at(s, t) - out.cx) * out.ix,
                   eta = (patch.y.at(s, t) - out.cy) * out.iy;
      std::array<double, kTerms> row;
      std::size_t term = 0;
      double along = 1;
      for (int k = 0; k <= kInverseDegree; ++k, along *= xi) {
        double power = along;
        for (int l = 0; l + k <= kInverseDegree; ++l, power *= eta) row[term++] = power;
      }
      for (std::size_t r = 0; r < kTerms; ++r) {
        for (std::size_t c = 0; c <= r; ++c) a[r][c] += row[r] * row[c];
        out.s[r] += row[r] * s;
        out.t[r] += row[r] * t;
      }
    }
  }
  for (std::size_t r = 0; r < kTerms; ++r) {
    a[r][r] *= 1 + 1e-12;  // a thin patch leaves some terms undetermined
    for (std::size_t c = 0; c <= r; ++c) {
      double sum = a[r][c];
      for (std::size_t k = 0; k < c; ++k) sum -= a[r][k] * a[c][k];
      a[r][c] = c < r ? sum / a[c][c] : std::sqrt(std::max(sum, 1e-14));
    }
  }
  for (std::array<double, kTerms>* f : {&out.s, &out.t}) {
    for (std::size_t r = 0; r < kTerms; ++r) {
      for (std::size_t k = 0; k < r; ++k) (*f)[r] -= a[r][k] * (*f)[k];
      (*f)[r] /= a[r][r];
    }
    for (std::size_t r = kTerms; r-- > 0;) {
      for (std::size_t k = r + 1; k < kTerms; ++k) (*f)[r] -= a[k][r] * (*f)[k];
      (*f)[r] /= a[r][r];
    }
  }
  return out;
}

void FergusonSurface::make_inverses() {
  inverses_.resize(patches_.size());
  parallel_blocks(patches_.size(), 16, 0, [this](std::size_t begin, std::size_t end, int) {
    for (std::size_t p = begin; p < end; ++p) inverses_[p] = fit_inverse(patches_[p]);
  });
}

}  // namespace diesink
