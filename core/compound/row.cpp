// The Boolean expression along a row: every body only over the part of the row it can touch, the
// normals once at the end, face by face.
// Source: Choi et al. 1988, equation (5), Table 1 and overall procedure (f).
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/compound/compound_impl.h"
#include "core/compound/row_kernels.h"
#include "core/compound/row_plan.h"
#include "core/line_search.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Points [begin, end) of a row.
struct Run {
  std::size_t begin = 0, end = 0;
  [[nodiscard]] bool empty() const { return begin >= end; }
};

// The value of one group, or of the whole expression, so far. Outside `known` it is undefined and
// not written.
struct Level {
  RowState state{};
  Run known;
  std::vector<double> z;
  std::vector<std::uint64_t> label;

  void begin(std::size_t count) {
    z.resize(count);
    label.resize(count);
    state = {z.data(), label.data()};
    known = {};
  }
  // Makes the run part of what is known, undefined where it is new.
  void cover(const Run& run) {
    if (known.empty()) {
      undefine(run.begin, run.end);
      known = run;
      return;
    }
    if (run.begin < known.begin) {
      undefine(run.begin, known.begin);
      known.begin = run.begin;
    }
    if (run.end > known.end) {
      undefine(known.end, run.end);
      known.end = run.end;
    }
  }

 private:
  void undefine(std::size_t from, std::size_t to) const {
    std::fill(state.z + from, state.z + to, kNaN);
    std::fill(state.label + from, state.label + to, std::uint64_t{kNoLabel});
  }
};

// One a thread, so that a row allocates nothing once the first of its length is done.
struct Workspace {
  std::vector<double> base_z, base_zx, base_zy;
  std::vector<std::uint32_t> base_face;  // of a scan
  std::vector<Level> levels;
  std::vector<std::uint32_t> steps;  // that can matter on the row
};

Workspace& workspace() {
  thread_local Workspace mine;
  return mine;
}

QuadricGradient gradient_of(const BodyLine& line) {
  const QuadricBody& b = std::get<QuadricBody>(line.body());
  const Vec3 n = b.frame.row(0), o = b.frame.row(1), a = b.frame.row(2);
  const double in = 1 / (b.A * b.A), io = 1 / (b.B * b.B);
  double ia = 0;
  Vec3 centre = b.p, linear = Vec3::Zero(), at_zero = Vec3::UnitZ();
  switch (b.shape) {
    case QuadricShape::kEllipsoid:
      ia = 1 / (b.C * b.C);
      break;
    case QuadricShape::kCylinder:
      break;
    case QuadricShape::kCone:
      ia = -1 / (b.C * b.C);
      centre += b.C * a;
      at_zero = a.z() < 0 ? Vec3(-a) : a;
      break;
    case QuadricShape::kParaboloid:
      linear = -0.5 * a;
      break;
  }
  const auto m = [&](int i, int j) {
    return n[i] * n[j] * in + o[i] * o[j] * io + a[i] * a[j] * ia;
  };
  return {{centre.x(), centre.y(), centre.z()},
          {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)},
          {linear.x(), linear.y(), linear.z()},
          {at_zero.x(), at_zero.y(), at_zero.z()}};
}

// Evaluates one row; the states' labels become the answer's in write().
class RowEvaluation {
 public:
  // `scan`, where it is given, holds what the row finds in the scan: heights, normals, and faces in
  // the place of labels. write() may go to the same arrays.
  RowEvaluation(const CompoundSurface::Impl& impl, double y, std::span<const double> xs,
                const CcRun* scan = nullptr)
      : impl_(impl), y_(y), xs_(xs), search_(xs), work_(workspace()), scan_(scan) {}

  void evaluate() {
    open();
    impl_.index.over({xs_.front(), xs_.back(), y_, y_}, work_.steps);
    for (const std::uint32_t i : work_.steps) apply(impl_.steps[i]);
    level().cover({0, xs_.size()});
  }

  void write(const CcRun& out) {
    const Level& last = level();
    std::copy(last.state.z, last.state.z + xs_.size(), out.z);
    for (std::size_t begin = 0; begin < xs_.size();) {
      const std::uint64_t label = last.state.label[begin];
      std::size_t end = begin + 1;
      while (end < xs_.size() && last.state.label[end] == label) ++end;
      std::fill(out.label + begin, out.label + end, static_cast<Label>(label));
      normals(static_cast<Label>(label), begin, end, out);
      begin = end;
    }
  }

 private:
  void apply(const CompoundStep& step) {
    switch (step.kind) {
      case BooleanStep::Kind::kGroupOpen:
        open();
        break;
      case BooleanStep::Kind::kGroupClose:
        close();
        break;
      case BooleanStep::Kind::kTerm:
        if (step.solid < 0) {
          base_term(step);
        } else {
          body_term(step, impl_.bodies[static_cast<std::size_t>(step.solid)]);
        }
        break;
    }
  }

  Level& level() { return work_.levels[depth_ - 1]; }

  void open() {
    if (work_.levels.size() <= depth_) work_.levels.resize(depth_ + 1);
    work_.levels[depth_++].begin(xs_.size());
  }

  void close() {
    const Level& group = level();
    --depth_;
    if (group.known.empty()) return;
    level().cover(group.known);
    apply_heights(group.state.z, group.state.label, group.known.begin, group.known.end, impl_.tie,
                  level().state);
  }

  void base_term(const CompoundStep& step) {
    if (!base_done_) evaluate_base();
    const bool plus = step.sign == Sign::kPlus;
    const Run run = plus ? Run{0, xs_.size()} : level().known;
    if (run.empty()) return;
    level().cover(run);
    apply_base(work_.base_z.data(), make_label(step.row, 0), plus, run.begin, run.end, impl_.tie,
               level().state);
  }

  void evaluate_base() {
    base_done_ = true;
    work_.base_z.resize(xs_.size());
    if (scan_ != nullptr) {
      std::copy_n(scan_->z, xs_.size(), work_.base_z.data());
      work_.base_face.assign(scan_->label, scan_->label + xs_.size());
    } else if (const PlaneSurface* plane = std::get_if<PlaneSurface>(&impl_.base)) {
      plane->row(y_, xs_, work_.base_z.data());
    } else if (const FergusonSurface* ferguson = std::get_if<FergusonSurface>(&impl_.base)) {
      work_.base_zx.resize(xs_.size());
      work_.base_zy.resize(xs_.size());
      ferguson->row(y_, xs_, work_.base_z.data(), work_.base_zx.data(), work_.base_zy.data());
    } else if (const ScannedSurface* scan = std::get_if<ScannedSurface>(&impl_.base)) {
      work_.base_zx.resize(xs_.size());
      work_.base_zy.resize(xs_.size());
      work_.base_face.resize(xs_.size());
      scan->row(y_, xs_, work_.base_z.data(), work_.base_zx.data(), work_.base_zy.data(),
                work_.base_face.data());
    } else {
      std::fill(work_.base_z.begin(), work_.base_z.end(), kNaN);
    }
  }

  void body_term(const CompoundStep& step, const BodyLine& body) {
    const Range span = row_span(body, y_);
    if (!(span.lo <= span.hi)) return;
    Run run{search_.first_from(span.lo), search_.first_from(std::nextafter(span.hi, HUGE_VAL))};
    if (step.sign == Sign::kMinus) {
      run = {std::max(run.begin, level().known.begin), std::min(run.end, level().known.end)};
    }
    if (run.empty()) return;
    level().cover(run);
    make_body_row(body, y_, step.row, step.sign, impl_.tie, constants_);
    apply_body(constants_, xs_.data(), run.begin, run.end, level().state);
  }

  void normals(Label label, std::size_t begin, std::size_t end, const CcRun& out) const {
    const auto constant = [&](const Vec3& n) {
      std::fill(out.nx + begin, out.nx + end, n.x());
      std::fill(out.ny + begin, out.ny + end, n.y());
      std::fill(out.nz + begin, out.nz + end, n.z());
    };
    if (label == kNoLabel) return constant(Vec3::Zero());
    const CompoundStep& step =
        impl_.steps[impl_.step_of_row[static_cast<std::size_t>(row_of(label))]];
    if (step.solid < 0 && !std::holds_alternative<PlaneSurface>(impl_.base)) {
      const ScannedSurface* scan = std::get_if<ScannedSurface>(&impl_.base);
      if (scan != nullptr && scan->smooth()) return smooth_normals(*scan, begin, end, out);
      if (scan_ != nullptr) return scan_normals(begin, end, out);
      return slope_normals(work_.base_zx.data() + begin, work_.base_zy.data() + begin, end - begin,
                           out.nx + begin, out.ny + begin, out.nz + begin);
    }
    if (step.solid >= 0) {
      const BodyLine& body = impl_.bodies[static_cast<std::size_t>(step.solid)];
      if (body.has_side() && face_of(label) == kFaceSide) {
        return quadric_normals(gradient_of(body), xs_.data() + begin, y_, out.z + begin,
                               end - begin, out.nx + begin, out.ny + begin, out.nz + begin);
      }
    }
    constant(impl_.normal(label, Vec3(xs_[begin], y_, out.z[begin])));
  }

  void smooth_normals(const ScannedSurface& scan, std::size_t begin, std::size_t end,
                      const CcRun& out) const {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 n = scan.normal(work_.base_face[i], xs_[i], y_);
      out.nx[i] = n.x();
      out.ny[i] = n.y();
      out.nz[i] = n.z();
    }
  }

  // The facets' normals to where they do not stand yet.
  void scan_normals(std::size_t begin, std::size_t end, const CcRun& out) const {
    if (out.nx == scan_->nx) return;
    std::copy(scan_->nx + begin, scan_->nx + end, out.nx + begin);
    std::copy(scan_->ny + begin, scan_->ny + end, out.ny + begin);
    std::copy(scan_->nz + begin, scan_->nz + end, out.nz + begin);
  }

  const CompoundSurface::Impl& impl_;
  double y_;
  std::span<const double> xs_;
  LineSearch search_;
  Workspace& work_;
  const CcRun* scan_;
  std::size_t depth_ = 0;
  bool base_done_ = false;
  BodyRow constants_;
};

}  // namespace

void CompoundSurface::row(double y, std::span<const double> xs, const CcRun& out) const {
  if (xs.empty()) return;
  RowEvaluation row(*impl_, y, xs);
  row.evaluate();
  row.write(out);
}

void CompoundSurface::grid(std::span<const double> xs, std::span<const double> ys, const CcRun& out,
                           int threads) const {
  const std::size_t columns = xs.size(), rows = ys.size();
  if (columns == 0 || rows == 0) return;
  const ScannedSurface* scan = std::get_if<ScannedSurface>(&impl_->base);
  // A pass over all triangles is worth it unless few of them are met.
  constexpr std::size_t kTrianglesPerPoint = 8;
  const bool drawn =
      scan != nullptr && scan->triangles().size() / kTrianglesPerPoint <= columns * rows &&
      std::any_of(impl_->steps.begin(), impl_->steps.end(), [](const CompoundStep& s) {
        return s.kind == BooleanStep::Kind::kTerm && s.solid < 0;
      });
  const double begin_of_rows = drawn ? 0.8 : 0;
  if (drawn) {
    const ProgressSpan span(0, begin_of_rows);
    // What the scan shows stands where the answer will: no array besides.
    scan->grid(xs, ys, {out.z, out.nx, out.ny, out.nz, out.label}, threads);
  }
  const ProgressSpan span(begin_of_rows, 1);
  // Blocks of about 16 k points: many a thread, each long enough to be worth handing out.
  const std::size_t block = std::max<std::size_t>(1, 16384 / columns);
  parallel_blocks(rows, block, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t j = begin; j < end; ++j) {
      const std::size_t at = j * columns;
      const CcRun to{out.z + at, out.nx + at, out.ny + at, out.nz + at, out.label + at};
      RowEvaluation row(*impl_, ys[j], xs, drawn ? &to : nullptr);
      row.evaluate();
      row.write(to);
    }
  });
}

}  // namespace diesink
