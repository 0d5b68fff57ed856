// SPDX-License-Identifier: Apache-2.0
#include "core/machining/reach_proof.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// What is remembered at most, 0.3 kilobytes each.
constexpr std::size_t kMostKnown = 100'000;
// From here on the deviation of the mesh tells.
constexpr int kExactLevel = 5;
// Of the corner, where its profile is taken for a plane further out, too: there it is steep.
constexpr double kPlanePart = 0.95;
// Of the corner, how far out a point holds all cutters of a box well.
constexpr double kSteepPart = 0.98;
constexpr int kStepsAside = 3;
// Of the radius, rounding of distances.
constexpr double kHair = 1e-9;
// Of a part's width, how wide boxes are that are not halved.
constexpr double kLeastBox = 1.0 / 16;

// The plane that touches the cutter's profile from below at the offset v from the axis, or as far
// out as it is not too steep: height at the axis's place and slope.
struct ProfilePlane {
  Vec2 slope = Vec2::Zero();
  double height = 0;  // at the axis
};
ProfilePlane plane_under(const CutterShape& cutter, const Vec2& v) {
  ProfilePlane plane;
  const double rho = v.norm(), r = cutter.corner();
  const double d = std::min(rho - cutter.flat(), kPlanePart * r);
  if (!(d > 0)) return plane;
  const double down = std::sqrt((r - d) * (r + d));
  plane.slope = d / down / rho * v;
  plane.height = r - down - d / down * (cutter.flat() + d);
  return plane;
}

double gap_between(const PlanBox& a, const Vec2& middle, double half) {
  const double x = std::max({0.0, a.x0 - middle.x() - half, middle.x() - half - a.x1});
  const double y = std::max({0.0, a.y0 - middle.y() - half, middle.y() - half - a.y1});
  return std::sqrt(x * x + y * y);
}

}  // namespace

double ReachProof::holding_height(double rho) const {
  const double side = rho - cutter_.flat(), inner = cutter_.corner() - deviation_;
  if (rho > cutter_.radius() - deviation_) return kInfinity;
  // Nothing deeper in the cutter than the deviation is the surface.
  if (side <= 0) return deviation_;
  return cutter_.corner() - std::sqrt(std::max(0.0, (inner - side) * (inner + side)));
}

// What the boxes are tried with.
struct ReachProof::Search::Asked {
  const FacetPart* part = nullptr;
  Question question;
  PlanBox box;
  Vec3 middle = Vec3::Zero();
};

// Walls lie where people put them: boxes of axes that end a radius from one would be held up by it
// but for rounding.
ReachProof::Search::Search(const ReachProof& proof)
    : proof_(proof),
      from_(proof.domain_.corners()[0] -
            proof.cutter_.radius() * (std::numbers::phi - 1) * Vec2(1, 1)) {
  known_.reserve(kMostKnown / 4);
  double side = proof.cutter_.radius();
  for (double& of_level : sides_) {
    of_level = side;
    side /= 2;
  }
}

ReachProof::Search::Box ReachProof::Search::make_box(int level, std::int64_t i,
                                                     std::int64_t j) const {
  Box box;
  const double side = sides_[static_cast<std::size_t>(level)];
  box.level = level;
  box.i = i;
  box.j = j;
  box.half = side / 2;
  box.middle =
      from_ + Vec2((static_cast<double>(i) + 0.5) * side, (static_cast<double>(j) + 0.5) * side);
  return box;
}

void ReachProof::Search::put_under(const Asked& asked, Box& box) const {
  if (box.asked == asked_) return;
  box.asked = asked_;
  const ProfilePlane plane = plane_under(proof_.cutter_, asked.middle.head<2>() - box.middle);
  box.slope = plane.slope;
  double least = kInfinity;
  for (std::size_t k = 0; k < asked.part->size; ++k) {
    const Vec3& at = asked.part->p[k];
    least = std::min(least, plane.slope.dot(at.head<2>() - box.middle) - at.z());
  }
  box.over = plane.height + least;
  box.bound = -kInfinity;
}

ReachProof::Search::Rest ReachProof::Search::all(const FacetPart& part) const {
  const double R = proof_.cutter_.radius();
  const PlanBox box = part.box();
  const auto cell = [&](double at) {
    return static_cast<std::int64_t>(std::floor(at / sides_[0]));
  };
  Rest rest;
  for (std::int64_t j = cell(box.y0 - R - from_.y()), je = cell(box.y1 + R - from_.y()); j <= je;
       ++j) {
    for (std::int64_t i = cell(box.x0 - R - from_.x()), ie = cell(box.x1 + R - from_.x()); i <= ie;
         ++i) {
      rest.push_back(make_box(0, i, j));
    }
  }
  return rest;
}

bool ReachProof::Search::meets_domain(const Vec2& middle, double half) const {
  const std::array<Vec2, 4>& c = proof_.domain_.corners();
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec2 side = c[(k + 1) % 4] - c[k], off = middle - c[k];
    const double left = side.x() * off.y() - side.y() * off.x();
    const double reach = half * (std::fabs(side.x()) + std::fabs(side.y()));
    if (left + reach < -kHair * proof_.cutter_.radius() * side.norm()) return false;
  }
  return true;
}

const ReachProof::Search::Axes& ReachProof::Search::axes(const Box& box) {
  constexpr std::int64_t kMost = std::int64_t{1} << 27;
  const std::uint64_t key = (static_cast<std::uint64_t>(box.level) << 58) ^
                            (static_cast<std::uint64_t>(box.i + kMost) << 29) ^
                            static_cast<std::uint64_t>(box.j + kMost);
  if (known_.size() >= kMostKnown) known_.clear();
  const auto [at, fresh] = known_.try_emplace(key);
  Axes& axes = at->second;
  if (!fresh) return axes;
  const Vec2& c = box.middle;
  const double far = box.half * std::numbers::sqrt2;
  const PointDrop::Touch touch = proof_.drop_->touch(c.x(), c.y());
  axes.tip = {c.x(), c.y(), touch.z};
  if (touch.z == kNoContact) return axes;
  const double rho = (touch.point - c).norm(), R = proof_.cutter_.radius();
  const auto on_surface = [&](const Vec2& q) {
    const Vec3 p = proof_.offset_->from_frame({q.x(), q.y(), 0});
    const std::optional<CcDatum> cc = proof_.surface_->at(p.x(), p.y());
    return cc ? Holder{q, cc->z, true} : Holder{};
  };
  const auto take = [&](const PointDrop::Touch& touched, Holder& mesh, Holder& exact) {
    if (touched.z == kNoContact) return;
    const Vec2 off = touched.point - c;
    mesh = {touched.point, touched.height, false};
    if (box.level < kExactLevel) return;
    // A hair beyond an edge, where the surface may be higher.
    exact = on_surface(touched.point + kHair * off);
    (exact.z + proof_.deviation_ > mesh.z ? mesh : exact) = Holder{};
  };
  take(touch, axes.holders[0], axes.holders[1]);
  // Where some of the cutters do not reach that far, or steeply, a point that is nearer.
  const double r = proof_.cutter_.corner();
  const double reach = R - std::max((1 - kSteepPart) * r, proof_.deviation_ + kHair * R) - far;
  if (rho > reach && reach > 0) {
    // A slanted edge is touched again, further along.
    PointDrop::Touch aside = touch;
    Vec2 back = c;
    for (int step = 0; step < kStepsAside; ++step) {
      const double away = (back - aside.point).norm();
      if (!(away > reach)) break;
      back = aside.point +
             (1 + kHair) * proof_.offset_->cutter().radius() / away * (back - aside.point);
      aside = proof_.drop_->touch(back.x(), back.y());
      if (aside.z == kNoContact) break;
    }
    axes.aside = {back.x(), back.y(), aside.z};
    take(proof_.drop_->touch_within(c.x(), c.y(), reach), axes.holders[2], axes.holders[3]);
    // As far within as all of them reach; the surface itself is where it is.
    const double all = R - std::max((1 - kSteepPart) * r, kHair * R) - far;
    const auto pulled_in = [&](const Vec2& q) {
      const double off = (q - c).norm();
      return on_surface(off > all ? Vec2(c + all / off * (q - c)) : q);
    };
    axes.holders[4] = pulled_in(touch.point);
    if (aside.z != kNoContact) axes.holders[5] = pulled_in(aside.point);
  }
  return axes;
}

double ReachProof::Search::held_at(const Holder& holder, const Vec2& axis) const {
  const CutterShape& cutter = proof_.cutter_;
  const double rho = (holder.q - axis).norm();
  if (!holder.exact) return holder.z - proof_.holding_height(rho);
  return rho <= cutter.radius() ? holder.z - cutter.height(rho) : -kInfinity;
}

bool ReachProof::Search::settled(const Asked& asked, Box& box, const Holder& holder) const {
  if (holder.z == -kInfinity) return false;
  // The corners are no higher than the middle: what it holds there falls off to all sides.
  const double most = held_at(holder, box.middle) + box.over;
  if (most <= asked.question.lift && most <= box.bound) return false;
  double least = kInfinity;  // of what it leaves
  for (const double x : {-box.half, box.half}) {
    for (const double y : {-box.half, box.half}) {
      const Vec2 off(x, y);
      const double held = held_at(holder, box.middle + off);
      least = std::min(least, held - box.slope.dot(off));
    }
  }
  const double bound = least + box.over;
  if (bound > asked.question.lift) return true;
  if (bound > box.bound) {
    box.bound = bound;
    box.holder = holder;
  }
  return false;
}

ReachProof::Answer ReachProof::Search::ask(const FacetPart& part, const Question& question,
                                           Rest& rest) {
  const double R = proof_.cutter_.radius();
  const Asked asked{&part, question, part.box(), part.middle()};
  ++asked_;
  const double narrow = std::max(sides_.back(), kLeastBox * wider_side(asked.box));
  std::size_t boxes = 0;
  while (!rest.empty()) {
    Box box = rest.back();
    rest.pop_back();
    if (gap_between(asked.box, box.middle, box.half) > R || !meets_domain(box.middle, box.half)) {
      continue;
    }
    if (box.asked != asked_) {
      put_under(asked, box);
      if (settled(asked, box, Holder(box.holder))) continue;
    }
    const Axes& own = axes(box);
    const bool done =
        std::any_of(own.holders.begin(), own.holders.end(),
                    [&](const Holder& holder) { return settled(asked, box, holder); });
    if (done) continue;
    const auto low = [&](const Vec3& tip) {
      if (tip.z() == kNoContact || !meets_domain(tip.head<2>(), 0)) return false;
      const auto low_over = [&](const Vec3& p) {
        return proof_.height(tip, p.head<2>()) - p.z() <= question.low;
      };
      return low_over(asked.middle) || std::ranges::any_of(part.corners(), low_over);
    };
    for (const Vec3& tip : {own.tip, own.aside}) {
      if (!low(tip)) continue;
      rest.push_back(box);
      return {Reach::kIn, tip};
    }
    if (2 * box.half <= narrow || ++boxes > question.most_boxes) {
      rest.push_back(box);
      return {};
    }
    const std::size_t begin = rest.size();
    for (const std::int64_t dj : {0, 1}) {
      for (const std::int64_t di : {0, 1}) {
        Box quarter = make_box(box.level + 1, 2 * box.i + di, 2 * box.j + dj);
        put_under(asked, quarter);
        if (!settled(asked, quarter, box.holder)) rest.push_back(quarter);
      }
    }
    // The one that may come lowest first: where one does, no more is to be proven.
    std::sort(rest.begin() + static_cast<std::ptrdiff_t>(begin), rest.end(),
              [](const Box& a, const Box& b) {
                return a.bound != b.bound ? a.bound > b.bound : a.j != b.j ? a.j < b.j : a.i < b.i;
              });
  }
  return {Reach::kOut, Vec3::Zero()};
}

}  // namespace diesink
