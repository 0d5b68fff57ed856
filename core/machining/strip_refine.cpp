// Between two rows every stretch is bridged by chords, at the start of each of which the direction
// is free: along the contour of a slope, or along a valley, they are shorter than square to the
// rows. It is enough that one of them leaves little.
// SPDX-License-Identifier: Apache-2.0
#include "core/machining/strip_refine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kDeepest = 24;
constexpr double kUnsure = -1;

// Shift along the rows of the shortest chord to the row dy away on the tangent plane at p.
double contour_shift(const RowPosition& p, double dy) {
  double gx = p.slope.x(), gy = p.slope.y();
  if (std::isinf(gx) || std::isinf(gy)) {
    gx = p.away.x();
    gy = p.away.y();
    return gx == 0 ? 0 : -gy / gx * dy;
  }
  return -gx * gy * dy / (1 + gx * gx);
}

// Shift along the line where the tangent planes at p and q meet.
double valley_shift(const RowPosition& p, const RowPosition& q, double dy) {
  const Vec2 e = p.slope - q.slope;
  if (!std::isfinite(e.x()) || !std::isfinite(e.y()) || std::fabs(e.x()) <= 1e-9) return 0;
  return -e.y() / e.x() * dy;
}

// Shift to where the row `to`, which is at the height z beside p, is as high as p: that way, and no
// farther than twice as far, as the tangent plane's contour leads.
std::optional<double> level_shift(const RowContacts& to, const RowPosition& p, double z,
                                  double shift) {
  double low = 0, high = 2 * shift;
  const std::optional<RowPosition> end = to.at(p.x + high);
  if (!end || (end->z < p.z) == (z < p.z)) return std::nullopt;
  for (int k = 0; k < 20; ++k) {
    const double half = (low + high) / 2;
    const std::optional<RowPosition> at = to.at(p.x + half);
    if (!at) return std::nullopt;
    ((at->z < p.z) == (z < p.z) ? low : high) = half;
  }
  return high;
}

// The ground at p, carried on by d on its tangent plane.
RowPosition carried(const RowPosition& p, const Vec2& d) {
  RowPosition q = p;
  q.x += d.x();
  q.z += p.slope.dot(d);
  return q;
}

// What a cutter at p alone leaves of the ground up to the row dy away: two balls of radius r at a
// distance of l on the ground leave r - sqrt(r² - l²) between the contact of one and the other. A
// level disk leaves all that it does not reach.
double left_by_one(const CutterShape& cutter, const RowPosition& p, double dy) {
  const double r = cutter.corner();
  double best = kInfinity;
  if (cutter.flat() > 0 && p.away.norm() <= cutter.flat()) return best;
  for (const double shift : {0.0, contour_shift(p, dy)}) {
    if (!std::isfinite(shift)) continue;
    const Vec2 d(shift, dy);
    const double rise = p.slope.dot(d), length2 = d.squaredNorm() + rise * rise;
    if (length2 < r * r) best = std::min(best, r - std::sqrt(r * r - length2));
  }
  return best;
}

// Runs that overlap or lie closer than `gap` made one.
std::vector<Stretch> joined(std::vector<Stretch> runs, double gap) {
  std::sort(runs.begin(), runs.end(),
            [](const Stretch& p, const Stretch& q) { return p.x0 < q.x0; });
  std::vector<Stretch> out;
  for (const Stretch& run : runs) {
    if (!out.empty() && run.x0 <= out.back().x1 + gap) {
      out.back().x1 = std::max(out.back().x1, run.x1);
    } else {
      out.push_back(run);
    }
  }
  return out;
}

std::vector<Stretch> padded(const std::vector<Stretch>& runs, double margin) {
  std::vector<Stretch> out;
  for (const Stretch& run : runs) out.push_back({run.x0 - margin, run.x1 + margin});
  return joined(std::move(out), margin);
}

// The parts of a profile in the runs.
std::vector<ProfileSegment> clipped(const std::vector<ProfileSegment>& profile,
                                    const std::vector<Stretch>& runs) {
  std::vector<ProfileSegment> out;
  std::size_t k = 0;
  for (const Stretch& run : runs) {
    while (k < profile.size() && profile[k].x1 <= run.x0) ++k;
    for (std::size_t i = k; i < profile.size() && profile[i].x0 < run.x1; ++i) {
      const ProfileSegment& s = profile[i];
      const auto z = [&](double x) { return s.z0 + (x - s.x0) / (s.x1 - s.x0) * (s.z1 - s.z0); };
      ProfileSegment part = s;
      if (s.x0 < run.x0) {
        part.x0 = run.x0;
        part.z0 = z(run.x0);
      }
      if (s.x1 > run.x1) {
        part.x1 = run.x1;
        part.z1 = z(run.x1);
      }
      if (part.x0 < part.x1) out.push_back(part);
    }
  }
  return out;
}

}  // namespace

std::optional<double> StripRefiner::beside_wall(const RowPosition& from, const RowPosition& across,
                                                double from_y, double dy,
                                                const RowContacts* middle) const {
  const CutterShape& cutter = offset_->cutter();
  const auto is_wall = [&](const RowPosition& rim, double ground) {
    const double top = rim.z + (rim.away.norm() < cutter.radius() ? cutter.height(rim.away.norm())
                                                                  : cutter.corner());
    return top - cutter.corner() - ground > wall_;
  };
  // The ground from p on to the foot, which lies no farther than `to`; `half` is a position on the
  // way, if one is known that is on the ground too.
  const auto ground_left = [&](const RowPosition& p, double to, const RowPosition* half,
                               double part) {
    double best = kInfinity;
    for (const double shift : {0.0, contour_shift(p, to)}) {
      if (!std::isfinite(shift)) continue;
      const Vec2 d(shift, to);
      const RowPosition foot = carried(p, d);
      const Between whole = left_between(cutter, p, foot, d);
      if (half == nullptr || shift != 0) {
        best = std::min(best, whole.sum());
        continue;
      }
      const double lean = half->slope.squaredNorm();
      const double under = std::max(0.0, p.z + part * (foot.z - p.z) - half->z) /
                           std::sqrt(1 + (std::isinf(lean) ? 0 : lean));
      best = std::min(best, whole.ridge + under +
                                std::max(left_between(cutter, p, *half, part * d).sink,
                                         left_between(cutter, *half, foot, (1 - part) * d).sink));
    }
    return best;
  };
  const std::optional<RowPosition> between = middle == nullptr ? std::nullopt : middle->at(from.x);
  const double part = middle == nullptr ? 0 : (middle->y() - from_y) / dy;
  if (from.border != across.border) {
    const RowPosition &rim = from.border ? from : across, &ground = from.border ? across : from;
    const double to = from.border ? -dy : dy;
    if (!is_wall(rim, std::max(ground.z, carried(ground, {0, to}).z)))
      return left_by_one(cutter, ground, to);
    if (!between) return ground_left(ground, to, nullptr, 0);
    const double at = from.border ? 1 - part : part;  // of the row between, from the ground on
    if (between->border) return ground_left(ground, at * to, nullptr, 0);
    return ground_left(ground, to, &*between, at);
  }
  if (!from.border) return std::nullopt;
  // A rim on both sides: nothing is known of a ground between, but what the row between tells.
  if (!between || between->border) return 0;
  const double back = std::max(part, 1 - part) * dy;
  const RowPosition low = carried(*between, {0, -part * dy});
  const RowPosition high = carried(*between, {0, (1 - part) * dy});
  if (!is_wall(from, std::max(between->z, low.z)) ||
      !is_wall(across, std::max(between->z, high.z))) {
    return std::nullopt;
  }
  return left_between(cutter, low, high, {0, dy}).ridge +
         left_between(cutter, *between, carried(*between, {0, back}), {0, back}).sink;
}

double StripRefiner::left_at(const RowPosition& from, const RowContacts& to, double dy,
                             const RowContacts* middle, Worst& worst) const {
  const CutterShape& cutter = offset_->cutter();
  const std::optional<RowPosition> across = to.at(from.x);
  const auto outside = [&](double y) {
    const Span inside = domain_->pass(y);
    return from.x < inside.x0 || from.x > inside.x1;
  };
  if (!across) {
    // The surface ends, a radius before that row or farther. The rim is rolled about from here; the
    // ground up to it is touched at most so far from here:
    const bool nearer = middle != nullptr && !middle->at(from.x);
    // Or the domain does, on one of its sides, which are cut along.
    if (nearer && (outside(to.y()) || outside(middle->y()))) return 0;
    const double empty = nearer ? middle->y() - (to.y() - dy) : dy;
    const double reach =
        std::fabs(empty) - cutter.radius() + std::copysign(1.0, dy) * from.away.y();
    if (from.border || !(reach > 0)) return 0;
    const double left = left_by_one(cutter, from, std::copysign(reach, dy));
    if (left > limit_ && left > worst.left) worst = {left, to.y() - dy + empty / 2};
    return left;
  }
  double best = kInfinity;
  bool border = from.border;
  const auto bridge = [&](double shift) {
    const std::optional<RowPosition> other = shift == 0 ? across : to.at(from.x + shift);
    if (!other) return;
    border = border || other->border;
    const Vec2 d(shift, dy);
    if (middle == nullptr) {
      best = std::min(best, left_between(cutter, from, *other, d).sum());
      return;
    }
    const double part = (middle->y() - (to.y() - dy)) / dy;
    const std::optional<RowPosition> between = middle->at(from.x + part * shift);
    if (!between) return;
    border = border || between->border;
    const double lean = between->slope.squaredNorm();
    const double under = std::max(0.0, from.z + part * (other->z - from.z) - between->z) /
                         std::sqrt(1 + (std::isinf(lean) ? 0 : lean));
    best =
        std::min(best, left_between(cutter, from, *other, d).ridge + under +
                           std::max(left_between(cutter, from, *between, part * d).sink,
                                    left_between(cutter, *between, *other, (1 - part) * d).sink));
  };
  const std::array<double, 4> shifts{0, contour_shift(from, dy), contour_shift(*across, dy),
                                     valley_shift(from, *across, dy)};
  for (const double shift : shifts) {
    if (std::isfinite(shift)) bridge(shift);
    if (best <= limit_) return best;
  }
  // Where a steep contour bends: along it to the same height on the other row.
  for (const double shift : {shifts[1], shifts[2]}) {
    if (!std::isfinite(shift) || shift == 0) continue;
    if (const std::optional<double> level = level_shift(to, from, across->z, shift)) bridge(*level);
    if (best <= limit_) return best;
  }
  if (border) {
    if (const std::optional<double> beside = beside_wall(from, *across, to.y() - dy, dy, middle)) {
      best = std::min(best, *beside);
      if (best <= limit_) {
        if (middle == nullptr) return kUnsure;
        const std::optional<RowPosition> between = middle->at(from.x);
        if (!between || !(between->z < std::min(from.z, across->z) - limit_)) return 0;
        best = std::min(from.z, across->z) - between->z;  // a pocket, whatever its walls
      }
    }
  }
  if (best > worst.left) {
    worst.left = best;
    // Where the slopes of both sides would meet; the middle where they do not.
    const double bend = from.slope.y() - across->slope.y();
    const double at = (across->z - across->slope.y() * dy - from.z) / bend;
    const double part = at / dy;
    worst.y = to.y() - dy + (part > 0.1 && part < 0.9 && bend * dy < 0 ? part : 0.5) * dy;
  }
  return best;
}

std::vector<Stretch> StripRefiner::too_much(const RowContacts& a, const RowContacts& b,
                                            const RowContacts* middle,
                                            std::span<const Stretch> among, double margin,
                                            Worst& worst, std::vector<Stretch>* unsure) const {
  // Long pieces are looked at in steps, so that a short fault does not call for a long row; of
  // short ones only so many that the shortest step is a small part of an interval.
  const double longest = std::min(offset_->cutter().radius() / 2, 4 * margin);
  const double shortest = margin / 4;
  std::vector<Stretch> bad;
  for (const bool down : {false, true}) {
    const RowContacts& from = down ? b : a;
    const RowContacts& to = down ? a : b;
    const double dy = to.y() - from.y();
    const std::vector<ProfileSegment>& profile = from.profile();
    for (const Stretch& run : among) {
      const auto first = std::partition_point(
          profile.begin(), profile.end(), [&](const ProfileSegment& s) { return s.x1 <= run.x0; });
      double seen = -kInfinity, last = 0;
      const auto look = [&](const ProfileSegment& s, double x) {
        const double left = left_at(from.on(s, x), to, dy, middle, worst);
        const Stretch step{std::isinf(seen) ? x : seen, x};
        if (left > limit_ || last > limit_) bad.push_back(step);
        if (unsure != nullptr && (left == kUnsure || last == kUnsure)) unsure->push_back(step);
        seen = x;
        last = left;
      };
      for (auto s = first; s != profile.end() && s->x0 < run.x1; ++s) {
        const double x0 = std::max(s->x0, run.x0), x1 = std::min(s->x1, run.x1);
        const bool gap = s != first && s->x0 > (s - 1)->x1;
        const bool ends = s + 1 == profile.end() || (s + 1)->x0 >= run.x1;
        if (gap || x0 - seen >= shortest || x1 - x0 >= shortest) {
          if (gap) last = 0;
          look(*s, x0);
        }
        if (!ends && x1 - seen < shortest) continue;
        const double parts = std::ceil((x1 - x0) / longest);
        for (double p = 1; p < parts; ++p) look(*s, x0 + (x1 - x0) * (p / parts));
        look(*s, x1);
      }
    }
  }
  return joined(std::move(bad), margin);
}

void StripRefiner::refine(const RowContacts& a, const RowContacts& b,
                          std::span<const StripPieces::Item> items, std::vector<AddedRow>& out) {
  const Stretch all{-kInfinity, kInfinity};
  const std::size_t before = out.size();
  near_.clear();
  refine(a, b, items, {&all, 1}, 0, out);
  std::stable_sort(out.begin() + static_cast<std::ptrdiff_t>(before), out.end(),
                   [](const AddedRow& p, const AddedRow& q) { return p.y < q.y; });
}

void StripRefiner::refine(const RowContacts& a, const RowContacts& b,
                          std::span<const StripPieces::Item> items, std::span<const Stretch> among,
                          int depth, std::vector<AddedRow>& out) {
  Worst worst;
  std::vector<Stretch> unsure;
  std::vector<Stretch> looks = too_much(a, b, nullptr, among, margin_, worst, &unsure);
  const double width = b.y() - a.y();
  const bool bad = !looks.empty();
  if (width <= least_ || depth == kDeepest) {
    // Where in them, closely: what is told should be no more than what is not known.
    for (const Stretch& run : too_much(a, b, nullptr, looks, width, worst, nullptr)) {
      unsettled_.push_back({run.x0, run.x1, a.y(), b.y()});
    }
    return;
  }
  if (width > 2 * margin_) looks.insert(looks.end(), unsure.begin(), unsure.end());
  if (width > offset_->cutter().radius() / 2) looks.assign(among.begin(), among.end());
  if (looks.empty()) return;
  looks = joined(std::move(looks), margin_);
  if (near_.empty()) {  // of the strip, for all its rows
    for (const StripPieces::Item& item : items) {
      if (static_cast<double>(item.y1) >= a.y() && static_cast<double>(item.y0) <= b.y()) {
        near_.push_back(item);
      }
    }
  }
  const std::array<double, 3> places{bad ? worst.y : a.y() + width / 2, a.y() + width / 4,
                                     a.y() + 3 * width / 4};
  for (const double y : places) {
    std::vector<ProfileSegment> profile;
    const Span row_span = domain_->pass(y);
    for (const Stretch& run : padded(looks, 2 * margin_)) {
      const Stretch inside{std::max(run.x0, row_span.x0), std::min(run.x1, row_span.x1)};
      if (inside.x0 < inside.x1) slice_row(*offset_, near_, y, inside, chord_, profile);
    }
    UpperEnvelope().take(profile);
    const RowContacts middle(*offset_, y, std::move(profile));
    Worst still;
    const std::vector<Stretch> needed = too_much(a, b, &middle, looks, margin_, still, nullptr);
    if (needed.empty()) continue;
    AddedRow row{y, clipped(middle.profile(), padded(needed, margin_))};
    const RowContacts cut(*offset_, row.y, row.profile);
    if (!row.profile.empty()) out.push_back(std::move(row));
    refine(a, cut, items, needed, depth + 1, out);
    refine(cut, b, items, needed, depth + 1, out);
    return;
  }
}

}  // namespace diesink
