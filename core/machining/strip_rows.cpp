// SPDX-License-Identifier: Apache-2.0
#include "core/machining/strip_rows.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

float rounded_down(double v) {
  const float f = static_cast<float>(v);
  return static_cast<double>(f) > v ? std::nextafter(f, -std::numeric_limits<float>::infinity())
                                    : f;
}

float rounded_up(double v) { return -rounded_down(-v); }

double height_of(const CutterShape& cutter, double rho) {
  return rho > cutter.radius() * (1 + 1e-9) ? kInfinity : cutter.height(rho);
}

// Slope of the cutter's lower surface at rho.
double lean_of(const CutterShape& cutter, double rho) {
  const double d = rho - cutter.flat(), r = cutter.corner();
  if (d <= 0) return 0;
  const double below = (r - d) * (r + d);
  return below > 0 ? d / std::sqrt(below) : kInfinity;
}

Vec2 slope_of(const CutterShape& cutter, const Vec2& away) {
  const double rho = away.norm();
  const double lean = lean_of(cutter, rho);
  if (lean == 0 || rho == 0) return Vec2::Zero();
  // Towards the contact it goes up; an infinite slope keeps its direction only.
  Vec2 g = -away / rho;
  for (int k = 0; k < 2; ++k) g[k] = g[k] == 0 ? 0 : g[k] * lean;
  return g;
}

}  // namespace

StripPieces::StripPieces(const OffsetSurface& offset, std::span<const double> ys,
                         std::size_t block) {
  const std::size_t strips = ys.size() > 1 ? ys.size() - 1 : 1;
  const std::size_t blocks = (strips + block - 1) / block;
  start_.assign(blocks + 1, 0);
  const auto blocks_of = [&](const PlanBox& box, std::size_t& first, std::size_t& last) {
    // Rows on or beside the box: those before it and behind it bound the strips it reaches.
    if (box.y1 < ys.front() || box.y0 > ys.back()) return false;
    const auto below = std::upper_bound(ys.begin(), ys.end(), box.y0);
    const auto above = std::lower_bound(ys.begin(), ys.end(), box.y1);
    std::size_t i = static_cast<std::size_t>(below - ys.begin());
    i = i > 0 ? i - 1 : 0;
    if (i > 0 && ys[i] == box.y0) --i;
    std::size_t j = static_cast<std::size_t>(above - ys.begin());
    if (j < ys.size() && ys[j] == box.y1) ++j;
    j = std::clamp<std::size_t>(j, 1, strips) - 1;
    first = std::min(i, strips - 1) / block;
    last = j / block;
    return true;
  };
  const std::size_t count = offset.piece_count();
  std::vector<std::array<std::uint32_t, 2>> spans(count);
  for (std::size_t k = 0; k < count; ++k) {
    std::size_t first = 1, last = 0;
    if (!blocks_of(offset.box(k), first, last)) {
      spans[k] = {1, 0};
      continue;
    }
    spans[k] = {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last)};
    for (std::size_t b = first; b <= last; ++b) ++start_[b + 1];
  }
  for (std::size_t b = 0; b < blocks; ++b) start_[b + 1] += start_[b];
  items_.resize(start_.back());
  std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
  for (std::size_t k = 0; k < count; ++k) {
    if (spans[k][0] > spans[k][1]) continue;
    const PlanBox box = offset.box(k);
    const Item item{static_cast<std::uint32_t>(k), rounded_down(box.x0), rounded_up(box.x1),
                    rounded_down(box.y0), rounded_up(box.y1)};
    for (std::size_t b = spans[k][0]; b <= spans[k][1]; ++b) items_[next[b]++] = item;
  }
}

void slice_row(const OffsetSurface& offset, std::span<const StripPieces::Item> items, double y,
               const Stretch& over, double chord, std::vector<ProfileSegment>& out) {
  for (const StripPieces::Item& item : items) {
    if (y < static_cast<double>(item.y0) || y > static_cast<double>(item.y1) ||
        over.x1 < static_cast<double>(item.x0) || over.x0 > static_cast<double>(item.x1)) {
      continue;
    }
    slice_piece(offset, item.piece, y, over.x0, over.x1, chord, out);
  }
}

RowPosition RowContacts::on(const ProfileSegment& s, double x) const {
  const CutterShape& cutter = offset_->cutter();
  const std::size_t facets = offset_->facets().size(), edges = offset_->edges().size();
  RowPosition out;
  out.x = x;
  out.z = s.z0 + (s.x1 > s.x0 ? (x - s.x0) / (s.x1 - s.x0) * (s.z1 - s.z0) : 0);
  if (s.piece < facets) {
    const auto& v = offset_->facets()[s.piece].v;
    const Vec3 n = (v[1] - v[0]).cross(v[2] - v[0]);
    const double size = n.norm(), flat = n.head<2>().norm();
    if (flat > kLevel * size) {
      out.away = n.head<2>() * (cutter.corner() / size + cutter.flat() / flat);
      out.slope = -n.head<2>() / n.z();
    }
    return out;
  }
  const bool edge = s.piece < facets + edges;
  const Contact c = edge ? contact(offset_->edges()[s.piece - facets], cutter, x, y_)
                         : contact(offset_->vertices()[s.piece - facets - edges], cutter, x, y_);
  out.border = edge ? offset_->edges()[s.piece - facets].border
                    : offset_->vertices()[s.piece - facets - edges].border;
  if (c.z != kNoContact) {
    out.away = Vec2(x - c.x, y_ - c.y);
    out.slope = slope_of(cutter, out.away);
  }
  return out;
}

std::optional<RowPosition> RowContacts::at(double x) const {
  auto s = std::upper_bound(profile_.begin(), profile_.end(), x,
                            [](double v, const ProfileSegment& p) { return v < p.x0; });
  if (s == profile_.begin()) return std::nullopt;
  --s;
  if (x > s->x1) return std::nullopt;
  return on(*s, x);
}

Between left_between(const CutterShape& cutter, const RowPosition& a, const RowPosition& b,
                     const Vec2& d) {
  const double r = cutter.corner(), dz = b.z - a.z;
  const double flat2 = d.squaredNorm(), length2 = flat2 + dz * dz;
  Between out;
  // Two balls of the corner's radius on a chord hold every ball of the same radius between them
  // that is smaller by r - sqrt(r² - l²/4); the same for the disk they are spread over.
  out.ridge = length2 < 4 * r * r ? r - std::sqrt(r * r - length2 / 4) : kInfinity;
  // Or: both lifted to the higher one, where two disks hold what is between them.
  if (const double w = cutter.flat(); flat2 < 4 * w * w) {
    out.ridge = std::min(out.ridge, std::fabs(dz) / 2 + w - std::sqrt(w * w - flat2 / 4));
  }
  // The chord less the lowest the cutter may stand: convex over each half, so its ends decide.
  const double middle = (a.z + b.z) / 2;
  double both, from_a, from_b;
  if (r > 0) {
    const double ha = height_of(cutter, a.away.norm()), hb = height_of(cutter, b.away.norm());
    const auto roll_a = [&](double t) {
      return a.z + ha - height_of(cutter, (a.away + t * d).norm());
    };
    const auto roll_b = [&](double t) {
      return b.z + hb - height_of(cutter, (b.away - t * d).norm());
    };
    both = std::max(middle - roll_a(0.5), middle - roll_b(0.5));
    from_a = b.z - roll_a(1);
    from_b = a.z - roll_b(1);
  } else {
    both = std::max(middle - (a.z + a.slope.dot(d) / 2), middle - (b.z - b.slope.dot(d) / 2));
    from_a = b.z - (a.z + a.slope.dot(d));
    from_b = a.z - (b.z - b.slope.dot(d));
    if (std::isnan(both)) both = kInfinity;
  }
  const double sink = std::max(0.0, std::min(both, std::min(from_a, from_b)));
  // Square to the surface it is less than straight down, by its lean.
  const double lean = std::min(a.slope.squaredNorm(), b.slope.squaredNorm());
  out.sink = std::isinf(sink) ? sink : sink / std::sqrt(1 + (std::isinf(lean) ? 0 : lean));
  return out;
}

}  // namespace diesink
