// SPDX-License-Identifier: Apache-2.0
#include "core/machining/drop.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace diesink {

namespace {

float rounded_up(double v) {
  const float f = static_cast<float>(v);
  return static_cast<double>(f) < v ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

float rounded_down(double v) { return -rounded_up(-v); }

}  // namespace

PointDrop::PointDrop(const OffsetSurface& offset) : offset_(&offset) {
  const std::size_t count = offset.piece_count();
  std::vector<PlanBox> boxes(count);
  double widths = 0;
  for (std::size_t k = 0; k < count; ++k) {
    boxes[k] = offset.box(k);
    if (k == 0) extent_ = boxes[k];
    extent_.x0 = std::min(extent_.x0, boxes[k].x0);
    extent_.x1 = std::max(extent_.x1, boxes[k].x1);
    extent_.y0 = std::min(extent_.y0, boxes[k].y0);
    extent_.y1 = std::max(extent_.y1, boxes[k].y1);
    widths += std::max(boxes[k].x1 - boxes[k].x0, boxes[k].y1 - boxes[k].y0);
  }
  if (count == 0) {
    start_ = {0, 0};
    return;
  }
  const double w = std::max(extent_.x1 - extent_.x0, 1e-300);
  const double h = std::max(extent_.y1 - extent_.y0, 1e-300);
  // About one cell a piece, but no finer than half the mean piece.
  const double n = static_cast<double>(count);
  const double cell = std::max(std::sqrt(w * h / n), widths / n / 2);
  nx_ = static_cast<int>(std::clamp(w / cell, 1.0, 8192.0));
  ny_ = static_cast<int>(std::clamp(h / cell, 1.0, 8192.0));
  inv_dx_ = nx_ / w;
  inv_dy_ = ny_ / h;
  const auto cell_of = [](double at, double from, double inv, int cells) {
    return static_cast<std::size_t>(std::clamp((at - from) * inv, 0.0, cells - 1.0));
  };
  start_.assign(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) + 1, 0);
  const auto each_cell = [&](const PlanBox& box, const auto& visit) {
    const std::size_t i1 = cell_of(box.x1, extent_.x0, inv_dx_, nx_);
    const std::size_t j1 = cell_of(box.y1, extent_.y0, inv_dy_, ny_);
    for (std::size_t j = cell_of(box.y0, extent_.y0, inv_dy_, ny_); j <= j1; ++j) {
      for (std::size_t i = cell_of(box.x0, extent_.x0, inv_dx_, nx_); i <= i1; ++i) {
        visit(j * static_cast<std::size_t>(nx_) + i);
      }
    }
  };
  for (const PlanBox& box : boxes) each_cell(box, [&](std::size_t c) { ++start_[c + 1]; });
  for (std::size_t c = 0; c + 1 < start_.size(); ++c) start_[c + 1] += start_[c];
  items_.resize(start_.back());
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  for (std::size_t k = 0; k < count; ++k) {
    const PlanBox& box = boxes[k];
    // As wide as the facets' own test lets a point lie beside them.
    const double slack =
        2e-12 * (std::max(std::fabs(box.x0), std::fabs(box.x1)) + offset.cutter().radius());
    const Entry entry{rounded_up(offset.top(k)),    static_cast<std::uint32_t>(k),
                      rounded_down(box.x0 - slack), rounded_up(box.x1 + slack),
                      rounded_down(box.y0),         rounded_up(box.y1)};
    each_cell(box, [&](std::size_t c) { items_[next[c]++] = entry; });
  }
  for (std::size_t c = 0; c + 1 < start_.size(); ++c) {
    std::sort(items_.begin() + start_[c], items_.begin() + start_[c + 1],
              [](const Entry& p, const Entry& q) {
                return p.top != q.top ? p.top > q.top : p.piece < q.piece;
              });
  }
}

void PointDrop::pieces_along(const Vec2& a, const Vec2& b, double floor,
                             std::vector<std::uint32_t>& pieces) const {
  const auto row_of = [&](double y) {
    return static_cast<int>(std::clamp((y - extent_.y0) * inv_dy_, 0.0, ny_ - 1.0));
  };
  const auto column_of = [&](double x) {
    return static_cast<int>(std::clamp((x - extent_.x0) * inv_dx_, 0.0, nx_ - 1.0));
  };
  const Vec2 d = b - a;
  const double hair = 1e-9 / inv_dx_;
  for (int j = row_of(std::min(a.y(), b.y())), last = row_of(std::max(a.y(), b.y())); j <= last;
       ++j) {
    // The part of the segment in this row of cells; the outer rows reach on for ever.
    double t0 = 0, t1 = 1;
    if (d.y() != 0) {
      const double low = extent_.y0 + j / inv_dy_, high = extent_.y0 + (j + 1) / inv_dy_;
      const double at_low = j == 0 ? (d.y() > 0 ? 0 : 1) : (low - a.y()) / d.y();
      const double at_high = j == ny_ - 1 ? (d.y() > 0 ? 1 : 0) : (high - a.y()) / d.y();
      t0 = std::max(t0, std::min(at_low, at_high) - 1e-9);
      t1 = std::min(t1, std::max(at_low, at_high) + 1e-9);
    }
    const double xa = a.x() + t0 * d.x(), xb = a.x() + t1 * d.x();
    for (int i = column_of(std::min(xa, xb) - hair), end = column_of(std::max(xa, xb) + hair);
         i <= end; ++i) {
      const std::size_t c =
          static_cast<std::size_t>(j) * static_cast<std::size_t>(nx_) + static_cast<std::size_t>(i);
      for (std::size_t k = start_[c]; k < start_[c + 1]; ++k) {
        if (static_cast<double>(items_[k].top) <= floor) break;
        pieces.push_back(items_[k].piece);
      }
    }
  }
}

void PointDrop::fetch(std::uint32_t piece) const {
  constexpr std::size_t kLine = 64;
  const std::size_t facets = offset_->facets().size(), edges = offset_->edges().size();
  const auto lines = [](const auto& object) {
    const char* at = reinterpret_cast<const char*>(&object);
    for (std::size_t k = 0; k < sizeof object; k += kLine) __builtin_prefetch(at + k);
    __builtin_prefetch(at + sizeof object - 1);
  };
  if (piece < facets) {
    lines(offset_->facets()[piece]);
  } else if (piece < facets + edges) {
    lines(offset_->edges()[piece - facets]);
  } else {
    lines(offset_->vertices()[piece - facets - edges]);
  }
}

Vec2 PointDrop::point_of(std::uint32_t piece, double x, double y) const {
  const CutterShape& cutter = offset_->cutter();
  const std::size_t facets = offset_->facets().size(), edges = offset_->edges().size();
  if (piece >= facets) {
    const Contact at = piece < facets + edges
                           ? contact(offset_->edges()[piece - facets], cutter, x, y)
                           : contact(offset_->vertices()[piece - facets - edges], cutter, x, y);
    return {at.x, at.y};
  }
  // A facet's own point lies against its normal, as far as the facet was shifted along it.
  const std::array<Vec3, 3>& v = offset_->facets()[piece].v;
  const Vec3 n = (v[1] - v[0]).cross(v[2] - v[0]).normalized();
  const double flat = n.head<2>().norm();
  Vec2 point(x, y);
  if (flat > kLevel) point -= (cutter.corner() + cutter.flat() / flat) * n.head<2>();
  return point;
}

template <class Counts>
double PointDrop::highest(double x, double y, double enough, std::uint32_t& piece,
                          const Counts& counts) const {
  if (!(x >= extent_.x0 && x <= extent_.x1 && y >= extent_.y0 && y <= extent_.y1)) {
    return kNoContact;
  }
  const std::size_t i =
      static_cast<std::size_t>(std::clamp((x - extent_.x0) * inv_dx_, 0.0, nx_ - 1.0));
  const std::size_t j =
      static_cast<std::size_t>(std::clamp((y - extent_.y0) * inv_dy_, 0.0, ny_ - 1.0));
  const std::size_t c = j * static_cast<std::size_t>(nx_) + i;
  const CutterShape& cutter = offset_->cutter();
  const std::size_t facet_count = offset_->facets().size();
  const std::size_t edge_end = facet_count + offset_->edges().size();
  const auto beside = [&](const Entry& entry) {
    return x < static_cast<double>(entry.x0) || x > static_cast<double>(entry.x1) ||
           y < static_cast<double>(entry.y0) || y > static_cast<double>(entry.y1);
  };
  // The pieces lie anywhere in memory: they are fetched together, not one after another.
  constexpr std::uint32_t kAhead = 8;
  for (std::uint32_t k = start_[c], end = std::min(start_[c + 1], k + kAhead); k < end; ++k) {
    if (!beside(items_[k])) fetch(items_[k].piece);
  }
  double best = kNoContact;
  for (std::size_t k = start_[c]; k < start_[c + 1]; ++k) {
    const Entry& entry = items_[k];
    if (static_cast<double>(entry.top) <= best) break;
    if (beside(entry)) continue;
    double z = kNoContact;
    if (entry.piece < facet_count) {
      const FacetSpan f = row_span(offset_->facets()[entry.piece], y);
      const double slack = 1e-12 * (std::fabs(x) + cutter.radius());
      if (x < f.span.x0 - slack || x > f.span.x1 + slack) continue;
      const double width = f.span.x1 - f.span.x0;
      const double t = width > 0 ? std::clamp((x - f.span.x0) / width, 0.0, 1.0) : 0;
      z = width > 0 ? f.z0 + t * (f.z1 - f.z0) : std::max(f.z0, f.z1);
    } else if (entry.piece < edge_end) {
      const EdgePiece& edge = offset_->edges()[entry.piece - facet_count];
      const double ox = x - edge.x, oy = y - edge.y;
      const double u = ox * edge.dx + oy * edge.dy, w = oy * edge.dx - ox * edge.dy;
      if (u < edge.u0 || u > edge.u1 || w < edge.w0 || w > edge.w1) continue;
      z = contact(edge, cutter, x, y).z;
    } else {
      const VertexPiece& v = offset_->vertices()[entry.piece - edge_end];
      if (x < v.x0 || x > v.x1 || y < v.y0 || y > v.y1) continue;
      z = contact(v, cutter, x, y).z;
    }
    if (z > best && counts(entry.piece, z)) {
      best = z;
      piece = entry.piece;
    }
    if (best >= enough) break;
  }
  return best;
}

double PointDrop::at(double x, double y, double enough) const {
  std::uint32_t piece = 0;
  return highest(x, y, enough, piece, [](std::uint32_t, double) { return true; });
}

PointDrop::Touch PointDrop::touch(double x, double y) const {
  std::uint32_t piece = 0;
  Touch touch;
  touch.z = highest(x, y, std::numeric_limits<double>::infinity(), piece,
                    [](std::uint32_t, double) { return true; });
  if (touch.z == kNoContact) return touch;
  touch.point = point_of(piece, x, y);
  touch.height = touch.z + offset_->cutter().height((touch.point - Vec2(x, y)).norm());
  return touch;
}

std::optional<Vec3> PointDrop::point_within(std::uint32_t piece, const Vec2& c, double z,
                                            double reach) const {
  const std::size_t facets = offset_->facets().size(), edges = offset_->edges().size();
  const Vec2 touched = point_of(piece, c.x(), c.y());
  const double rho = (touched - c).norm(), high = z + offset_->cutter().height(rho);
  if (rho <= reach) return Vec3(touched.x(), touched.y(), high);
  if (piece < facets) {
    // Towards the axis, as long as the facet goes.
    const std::array<Vec3, 3>& v = offset_->facets()[piece].v;
    const Vec3 n = (v[1] - v[0]).cross(v[2] - v[0]);
    const Vec2 to = c + reach / rho * (touched - c), on_piece = to - touched + c;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 side = (v[(k + 1) % 3] - v[k]).head<2>(), off = on_piece - v[k].head<2>();
      if (side.x() * off.y() - side.y() * off.x() < 0) return std::nullopt;
    }
    return Vec3(to.x(), to.y(), high - n.head<2>().dot(to - touched) / n.z());
  }
  if (piece >= facets + edges) return std::nullopt;
  const EdgePiece& e = offset_->edges()[piece - facets];
  const double ox = c.x() - e.x, oy = c.y() - e.y;
  const double u = ox * e.dx + oy * e.dy, w = oy * e.dx - ox * e.dy;
  if (std::fabs(w) > reach) return std::nullopt;
  const double half = std::sqrt((reach - w) * (reach + w));
  const double low = std::max(0.0, u - half), end = std::min(e.length, u + half);
  if (low > end) return std::nullopt;
  const double s = std::clamp((touched.x() - e.x) * e.dx + (touched.y() - e.y) * e.dy, low, end);
  return Vec3(e.x + s * e.dx, e.y + s * e.dy, e.z + s * e.slope);
}

PointDrop::Touch PointDrop::touch_within(double x, double y, double reach) const {
  std::uint32_t highest_piece = 0;
  const Vec2 c(x, y);
  Touch touch;
  touch.z = highest(x, y, std::numeric_limits<double>::infinity(), highest_piece,
                    [&](std::uint32_t piece, double& z) {
                      const std::optional<Vec3> at = point_within(piece, c, z, reach);
                      if (!at) return false;
                      const double held =
                          at->z() - offset_->cutter().height((at->head<2>() - c).norm());
                      if (!(held > touch.z)) return false;
                      z = held;
                      touch = {held, at->head<2>(), at->z()};
                      return true;
                    });
  return touch;
}

}  // namespace diesink
