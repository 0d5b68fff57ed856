// Samples along common rows, so that the evaluator of rows does the work: each triangle gets the
// rows of the coarsest dyadic spacing that passes through its middle.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/last_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "core/compound/compound_impl.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "core/tessellate/arrangement.h"
#include "core/tessellate/curve_check.h"
#include "core/tessellate/home.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

constexpr std::uint32_t kNone = 0xFFFFFFFFu;
// Points a triangle on average beyond its first, and the least number of points of a domain.
constexpr double kMorePoints = 0.25;
constexpr double kLeastPoints = 200;
// Halvings of the domain's height between rows at most.
constexpr int kFinest = 26;
// Blocks of rows that samples are sorted into: 2 to this power.
constexpr int kBlockBits = 13;
// Rows with fewer points than this are evaluated point by point: setting up a row costs as much.
constexpr std::size_t kShortRow = 6;
// Points of a body's shadow, each way.
constexpr int kBodyPoints = 3;
// Points that are refuted one by one; what is doubtful beyond them counts as refuted.
constexpr std::size_t kMostProofs = 400;
// As large as rounding turns an upright triangle, relative to its area, and absolutely to the size.
constexpr double kTurned = 1e-9, kRounding = 1e-14;

struct Sample {
  std::uint32_t row;  // on the finest level
  std::uint32_t triangle;
  double x, z;   // of the triangle
  double reach;  // how far above or below it its plane is as far as the surface may be
};

// The exponent of a number that is neither 0 nor denormal: its logarithm to the base 2, rounded
// down.
int exponent_of(double v) {
  return static_cast<int>((std::bit_cast<std::uint64_t>(v) >> 52) & 0x7FF) - 1023;
}

// Points of the plan in bins, for the triangles over each.
class BodyPlaces {
 public:
  struct Place {
    double x, y;
    std::uint32_t triangle = kNone;
  };

  BodyPlaces(const Impl& surface, const PlanBox& box) : box_(box) {
    for (const BodyLine& body : surface.bodies) {
      const PlanBox& b = body.plan_box();
      const double x0 = std::fmax(b.x0, box.x0), x1 = std::fmin(b.x1, box.x1),
                   y0 = std::fmax(b.y0, box.y0), y1 = std::fmin(b.y1, box.y1);
      if (!(x0 < x1) || !(y0 < y1)) continue;
      for (int j = 0; j < kBodyPoints; ++j) {
        for (int i = 0; i < kBodyPoints; ++i) {
          places.push_back({x0 + (x1 - x0) * (i + 0.4837) / kBodyPoints,
                            y0 + (y1 - y0) * (j + 0.5113) / kBodyPoints, kNone});
        }
      }
    }
    side_ = static_cast<std::size_t>(
        std::clamp(std::sqrt(static_cast<double>(places.size())), 1.0, 1000.0));
    inverse_x_ = static_cast<double>(side_) / (box.x1 - box.x0);
    inverse_y_ = static_cast<double>(side_) / (box.y1 - box.y0);
    const auto key = [&](const Place& p) { return row(p.y) * side_ + column(p.x); };
    std::sort(places.begin(), places.end(), [&](const Place& p, const Place& q) {
      const std::size_t kp = key(p), kq = key(q);
      return kp != kq ? kp < kq : p.x != q.x ? p.x < q.x : p.y < q.y;
    });
    begin_.assign(side_ * side_ + 1, 0);
    for (const Place& p : places) ++begin_[key(p) + 1];
    for (std::size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
  }

  // Notes the triangle with every place that it covers.
  void cover(std::uint32_t t, const Vec3& a, const Vec3& b, const Vec3& c, double low,
             double high) {
    const std::size_t i0 = column(std::fmin(a.x(), std::fmin(b.x(), c.x()))),
                      i1 = column(std::fmax(a.x(), std::fmax(b.x(), c.x())));
    for (std::size_t j = row(low), last = row(high); j <= last; ++j) {
      for (std::uint32_t k = begin_[j * side_ + i0]; k < begin_[j * side_ + i1 + 1]; ++k) {
        Place& p = places[k];
        if (p.y < low || p.y > high) continue;
        const auto left = [&](const Vec3& u, const Vec3& v) {
          return (v.x() - u.x()) * (p.y - u.y()) - (v.y() - u.y()) * (p.x - u.x()) >= 0;
        };
        if (left(a, b) && left(b, c) && left(c, a)) p.triangle = t;
      }
    }
  }

  std::vector<Place> places;

 private:
  [[nodiscard]] std::size_t clip(double v) const {
    return v > 0 ? std::min(static_cast<std::size_t>(v), side_ - 1) : 0;
  }
  [[nodiscard]] std::size_t column(double x) const { return clip((x - box_.x0) * inverse_x_); }
  [[nodiscard]] std::size_t row(double y) const { return clip((y - box_.y0) * inverse_y_); }

  PlanBox box_;
  std::size_t side_ = 1;
  double inverse_x_ = 1, inverse_y_ = 1;
  std::vector<std::uint32_t> begin_;
};

class LastCheck {
 public:
  LastCheck(const CompoundSurface& surface, int threads, Tessellation& made)
      : surface_(surface),
        impl_(surface.impl()),
        threads_(threads),
        made_(made),
        mesh_(made.mesh),
        near_(std::fmax(made.report.tolerance, made.report.certified_deviation) * (1 + 1e-6) +
              4 * impl_.tie),
        box_{made.report.domain[0], made.report.domain[1], made.report.domain[2],
             made.report.domain[3]},
        bodies_(impl_, box_) {}

  void run() {
    if (mesh_.triangles.empty()) return;
    find_faces();
    lay_samples();
    sort_samples();
    check_samples();
    check_bodies();
  }

 private:
  struct Found {  // what evaluation says over a point
    double z = 0;
    Label label = kNoLabel;
  };

  void find_faces();
  void lay_samples();
  void sort_samples();
  void check_samples();
  void check_bodies();
  void check_point(std::uint32_t triangle, const Vec3& p, double reach, const Found& found);
  [[nodiscard]] bool is_right(std::uint32_t triangle, const Vec3& p, const Found& found) const;
  [[nodiscard]] bool is_one_with(std::uint32_t element, const Vec3& p, double z) const;
  [[nodiscard]] bool ends_beside(double x, double y) const;
  void doubt(std::uint32_t element, const Vec3& place, double area, const char* what);
  std::uint32_t element_of(Label label) const {
    // Neighbours mostly show one face.
    if (label == last_label_) return last_element_;
    last_label_ = label;
    return last_element_ = look_up(label);
  }
  std::uint32_t look_up(Label label) const;

  [[nodiscard]] Found evaluate(double x, double y) const {
    const LineState state = impl_.evaluate(x, y);
    if (state.label == kNoLabel) return {};
    return {state.z, state.label};
  }
  [[nodiscard]] const Vec3& at(std::uint32_t triangle, std::size_t corner) const {
    return mesh_.positions[mesh_.triangles[triangle][corner]];
  }
  [[nodiscard]] double plan_area(std::uint32_t t) const {
    const Vec3 &a = at(t, 0), &b = at(t, 1), &c = at(t, 2);
    return 0.5 * std::fabs((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
  }
  [[nodiscard]] double row_y(std::uint32_t row) const {
    return origin_ + (static_cast<double>(row) * (1.0 / (1u << kFinest))) * height_;
  }

  const CompoundSurface& surface_;
  const Impl& impl_;
  int threads_;
  Tessellation& made_;
  const TriangleMesh& mesh_;
  double near_;  // distance within which the surface has to be
  PlanBox box_;
  BodyPlaces bodies_;
  // Rows: off the round coordinates of drawings.
  double origin_ = 0, height_ = 1;
  std::vector<char> is_face_;  // of each element
  std::unordered_map<std::string, std::uint32_t> by_name_;
  mutable std::unordered_map<Label, std::uint32_t> by_label_;
  mutable Label last_label_ = kNoLabel;
  mutable std::uint32_t last_element_ = kNone;
  std::vector<Sample> samples_;  // by blocks of rows
  std::vector<std::uint32_t> block_begin_;
  std::vector<char> refuted_;  // triangles, once told
  std::size_t proofs_ = 0;
};

void LastCheck::find_faces() {
  is_face_.resize(mesh_.elements.size());
  for (std::uint32_t e = 0; e < mesh_.elements.size(); ++e) {
    const MeshElement& element = mesh_.elements[e];
    is_face_[e] =
        element.name != "skirt" && element.name != "floor" && !element.name.ends_with(".wall");
    by_name_.emplace(element.name, e);
  }
}

std::uint32_t LastCheck::look_up(Label label) const {
  if (label == kNoLabel) return kNone;
  const auto [known, fresh] = by_label_.try_emplace(label, kNone);
  if (fresh) {
    const auto named = by_name_.find(surface_.element_name(label));
    if (named != by_name_.end()) known->second = named->second;
  }
  return known->second;
}

void LastCheck::doubt(std::uint32_t element, const Vec3& place, double area, const char* what) {
  made_.report.add_doubt(place, element == kNone ? "" : mesh_.elements[element].name, what, area);
}

// The triangles' area and side, and the points at which each is compared.
void LastCheck::lay_samples() {
  const double w = box_.x1 - box_.x0, h = box_.y1 - box_.y0;
  height_ = 2 * h;
  origin_ = box_.y0 - (std::numbers::phi - 1) * 0.5 * h;
  const double size = surface_.size();
  refuted_.assign(mesh_.triangles.size(), 0);
  const double cell = std::sqrt(
      w * h / std::fmax(kMorePoints * static_cast<double>(mesh_.triangles.size()), kLeastPoints));
  const int coarsest = std::clamp(std::ilogb(height_ / cell), 0, kFinest);
  std::array<double, kFinest + 1> steps{};
  for (int k = 0; k <= kFinest; ++k) steps[static_cast<std::size_t>(k)] = std::ldexp(height_, -k);
  const double flat = least_altitude(surface_), flat2 = flat * flat;
  const double turned2 = kTurned * kTurned, rounding2 = (kRounding * size) * (kRounding * size);
  samples_.reserve(mesh_.triangles.size() * 2);
  for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
    const std::uint32_t e = mesh_.triangle_element[t];
    if (!is_face_[e]) continue;
    const Vec3 &a = at(t, 0), &b = at(t, 1), &c = at(t, 2);
    const Vec3 u = b - a, v = c - a;
    const Vec3 n = u.cross(v);
    const double longest2 =
        std::fmax(u.squaredNorm(), std::fmax(v.squaredNorm(), (c - b).squaredNorm()));
    const double norm2 = n.squaredNorm();
    if (!(norm2 > flat2 * longest2)) {
      refuted_[t] = 1;
      doubt(e, (a + b + c) / 3, std::sqrt(longest2) * made_.report.tolerance,
            "a triangle without area");
      continue;
    }
    const double upright2 = 2 * (turned2 * norm2 + rounding2 * longest2);
    if (n.z() * n.z() <= upright2) continue;  // no plan to compare over
    if (n.z() < 0) {
      refuted_[t] = 1;
      doubt(e, (a + b + c) / 3, plan_area(t), "a triangle that looks down");
      continue;
    }
    // From the lowest to the highest vertex, and the vertex between.
    const Vec3* low = &a;
    const Vec3* mid = &b;
    const Vec3* high = &c;
    if (low->y() > mid->y()) std::swap(low, mid);
    if (mid->y() > high->y()) std::swap(mid, high);
    if (low->y() > mid->y()) std::swap(low, mid);
    bodies_.cover(t, a, b, c, low->y(), high->y());
    const double rise = high->y() - low->y();
    if (!(rise > steps[kFinest])) continue;
    const int level = std::clamp(exponent_of(height_ / rise) + 2, coarsest, kFinest);
    const double step = steps[static_cast<std::size_t>(level)];
    auto first = static_cast<std::uint32_t>((0.5 * (low->y() + high->y()) - origin_) / step + 0.5);
    std::uint32_t last = first;
    if (rise > 4 * step) {
      first = static_cast<std::uint32_t>((low->y() - origin_) / step) + 1;
      last = static_cast<std::uint32_t>((high->y() - origin_) / step);
    }
    const double slope_x = n.x() / n.z(), slope_y = n.y() / n.z();
    const double reach = near_ * std::sqrt(1 + slope_x * slope_x + slope_y * slope_y);
    for (std::uint32_t k = first; k <= last; ++k) {
      const std::uint32_t row = k << (kFinest - level);
      const double y = row_y(row);
      if (!(y > low->y() && y < high->y())) continue;
      const auto on = [&](const Vec3& p, const Vec3& q) {
        return p.x() + (q.x() - p.x()) * ((y - p.y()) / (q.y() - p.y()));
      };
      double from = on(*low, *high), to = y < mid->y() ? on(*low, *mid) : on(*mid, *high);
      if (from > to) std::swap(from, to);
      const int points = to - from < 2 * cell ? 1 : static_cast<int>((to - from) / cell);
      for (int i = 0; i < points; ++i) {
        const double x = from + (to - from) * (i + 0.5) / points;
        const double z = a.z() - (slope_x * (x - a.x()) + slope_y * (y - a.y()));
        samples_.push_back({row, t, x, z, reach});
      }
    }
  }
}

// By blocks of rows; check_samples() sorts each by rows and x.
void LastCheck::sort_samples() {
  constexpr int kShift = kFinest - kBlockBits;
  block_begin_.assign((std::size_t{1} << kBlockBits) + 1, 0);
  for (const Sample& s : samples_) ++block_begin_[(s.row >> kShift) + 1];
  for (std::size_t k = 1; k < block_begin_.size(); ++k) block_begin_[k] += block_begin_[k - 1];
  std::vector<std::uint32_t> place(block_begin_.begin(), block_begin_.end() - 1);
  std::vector<Sample> sorted(samples_.size());
  for (const Sample& s : samples_) sorted[place[s.row >> kShift]++] = s;
  samples_.swap(sorted);
}

void LastCheck::check_samples() {
  struct Workspace {
    std::vector<double> x, z, nx, ny, nz;
    std::vector<Label> label;
  };
  std::vector<Found> found(samples_.size());
  std::vector<Workspace> workspaces(static_cast<std::size_t>(thread_count(threads_)));
  const auto evaluate_row = [&](std::size_t first, std::size_t end, Workspace& work) {
    const std::size_t count = end - first;
    const double y = row_y(samples_[first].row);
    if (count < kShortRow) {
      for (std::size_t k = first; k < end; ++k) found[k] = evaluate(samples_[k].x, y);
      return;
    }
    for (std::vector<double>* v : {&work.x, &work.z, &work.nx, &work.ny, &work.nz})
      v->resize(count);
    work.label.resize(count);
    for (std::size_t k = 0; k < count; ++k) work.x[k] = samples_[first + k].x;
    surface_.row(
        y, work.x,
        {work.z.data(), work.nx.data(), work.ny.data(), work.nz.data(), work.label.data()});
    for (std::size_t k = 0; k < count; ++k) found[first + k] = {work.z[k], work.label[k]};
  };
  parallel_blocks(block_begin_.size() - 1, 64, threads_,
                  [&](std::size_t begin, std::size_t end, int worker) {
                    Workspace& work = workspaces[static_cast<std::size_t>(worker)];
                    for (std::size_t block = begin; block < end; ++block) {
                      const std::size_t first = block_begin_[block], last = block_begin_[block + 1];
                      std::sort(samples_.data() + first, samples_.data() + last,
                                [](const Sample& a, const Sample& b) {
                                  if (a.row != b.row) return a.row < b.row;
                                  return a.x != b.x ? a.x < b.x : a.triangle < b.triangle;
                                });
                      for (std::size_t k = first; k < last;) {
                        std::size_t row_end = k + 1;
                        while (row_end < last && samples_[row_end].row == samples_[k].row)
                          ++row_end;
                        evaluate_row(k, row_end, work);
                        k = row_end;
                      }
                    }
                  });
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    const Sample& s = samples_[k];
    check_point(s.triangle, {s.x, row_y(s.row), s.z}, s.reach, found[k]);
  }
}

// A triangle is told once.
void LastCheck::check_point(std::uint32_t t, const Vec3& p, double reach, const Found& found) {
  const std::uint32_t e = mesh_.triangle_element[t];
  if (found.label != kNoLabel && element_of(found.label) == e &&
      std::fabs(p.z() - found.z) <= reach)
    return;
  if (refuted_[t] != 0) return;
  if (proofs_ < kMostProofs && is_right(t, p, found)) return;
  ++proofs_;
  refuted_[t] = 1;
  doubt(e, p, plan_area(t), "the surface is another there");
}

// Whether the surface does come near p, and shows the triangle's element near p. The surface is
// near where the ball about p reaches both sides of it, for it is closed by its walls.
bool LastCheck::is_right(std::uint32_t t, const Vec3& p, const Found& found) const {
  const std::uint32_t e = mesh_.triangle_element[t];
  bool shown = false, above = false, below = false, reached = false;
  const auto see = [&](const Vec3& q, const Found& hit) {
    if (hit.label == kNoLabel) return;
    shown = shown || element_of(hit.label) == e;
    above = above || q.z() >= hit.z;
    below = below || q.z() <= hit.z;
    reached = reached || (Vec3(q.x(), q.y(), hit.z) - p).norm() <= near_;
  };
  const auto done = [&] { return shown && (reached || (above && below)); };
  see(p, found);
  see(p + Vec3(0, 0, near_), found);
  see(p - Vec3(0, 0, near_), found);
  if (found.label != kNoLabel && !shown) shown = is_one_with(e, p, found.z);
  // In a sliver that closes in on a corner points about p hardly meet the face; across its open end
  // there is some.
  for (std::size_t k = 0; k < 3 && !shown; ++k) {
    for (const double share : {0.5, 0.25, 0.75}) {
      const Vec3 q = at(t, k) + share * (at(t, (k + 1) % 3) - at(t, k));
      if ((q - p).norm() < near_ && element_of(evaluate(q.x(), q.y()).label) == e) shown = true;
    }
  }
  for (const int effort : {40, 1500}) {
    for (const double r : {1.0, 0.6, 0.2}) {
      for (int i = 0; i < effort && !done(); ++i) {
        const double z = 1 - (2 * i + 1.0) / effort, s = std::sqrt(1 - z * z);
        const double turn = std::numbers::pi * (1 + std::sqrt(5.0)) * i;
        const Vec3 q = p + r * near_ * Vec3(s * std::cos(turn), s * std::sin(turn), z);
        see(q, evaluate(q.x(), q.y()));
      }
    }
  }
  return done();
}

// The element's own surface has the height that shows over p: the two faces cannot be told apart.
bool LastCheck::is_one_with(std::uint32_t e, const Vec3& p, double z) const {
  const CurveSolver solver(impl_);
  for (const CompoundStep& step : impl_.steps) {
    if (step.kind != BooleanStep::Kind::kTerm) continue;
    std::vector<std::uint8_t> faces{0};
    if (step.solid >= 0)
      faces = face_numbers(impl_.bodies[static_cast<std::size_t>(step.solid)].body());
    for (const std::uint8_t face : faces) {
      const Label label = make_label(step.row, face);
      double own = 0;
      if (element_of(label) == e && solver.height(label, p.x(), p.y(), own) &&
          std::fabs(own - z) <= flat_height(impl_, made_.report.tolerance))
        return true;
    }
  }
  return false;
}

// No surface, or the border of the domain, within reach.
bool LastCheck::ends_beside(double x, double y) const {
  if (x - near_ <= box_.x0 || x + near_ >= box_.x1 || y - near_ <= box_.y0 || y + near_ >= box_.y1)
    return true;
  for (const double r : {0.1, 0.4, 1.0}) {
    for (int k = 0; k < 24; ++k) {
      const double turn = 2 * std::numbers::pi * (k + r) / 24;
      if (impl_.evaluate(x + r * near_ * std::cos(turn), y + r * near_ * std::sin(turn)).label ==
          kNoLabel)
        return true;
    }
  }
  return false;
}

// The triangle over each place of a body has to show what is there.
void LastCheck::check_bodies() {
  for (const BodyPlaces::Place& p : bodies_.places) {
    const Found found = evaluate(p.x, p.y);
    if (p.triangle != kNone) {
      const Vec3& a = at(p.triangle, 0);
      const Vec3 n = (at(p.triangle, 1) - a).cross(at(p.triangle, 2) - a);
      const double z = a.z() - (n.x() * (p.x - a.x()) + n.y() * (p.y - a.y())) / n.z();
      check_point(p.triangle, {p.x, p.y, z}, near_ * n.norm() / n.z(), found);
    } else if (found.label != kNoLabel && !ends_beside(p.x, p.y)) {
      doubt(element_of(found.label), {p.x, p.y, found.z}, near_ * near_,
            "no triangle over the surface");
    }
  }
}

}  // namespace

void last_check(const CompoundSurface& surface, int threads, Tessellation& made) {
  LastCheck(surface, threads, made).run();
  check_curves(surface, made);
  // One place may be told for more than one reason.
  TessellationReport& report = made.report;
  const std::array<double, 4>& d = report.domain;
  report.uncertified_area = std::fmin(report.uncertified_area, (d[1] - d[0]) * (d[3] - d[2]));
}

}  // namespace diesink
