// SPDX-License-Identifier: Apache-2.0
#include "core/machining/pass_profile.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace diesink {
namespace {

struct Sample {
  double x = 0, z = 0, slope = 0;
};

// Chords of a concave function between two samples. For slopes s0 >= s >= s1 at the left end, of
// the chord and at the right end the function lies at most (s - s1)(s0 - s)/(s0 - s1)·width above
// the chord.
template <class At>
void chords(const At& at, const Sample& p, const Sample& q, double chord, std::uint32_t piece,
            int depth, std::vector<ProfileSegment>& out) {
  const double width = q.x - p.x;
  const double s = (q.z - p.z) / width;
  const double rise = p.slope - s, fall = s - q.slope;
  double gap = 0;
  if (rise > 0 && fall > 0) {
    gap = std::isinf(rise)
              ? (std::isinf(fall) ? std::numeric_limits<double>::infinity() : fall * width)
          : std::isinf(fall) ? rise * width
                             : rise * fall / (rise + fall) * width;
  }
  const double middle = p.x + width / 2;
  if (depth == 0 || !(gap > chord) || middle <= p.x || middle >= q.x) {
    out.push_back({p.x, p.z, q.x, q.z, piece});
    return;
  }
  const Sample m = at(middle);
  chords(at, p, m, chord, piece, depth - 1, out);
  chords(at, m, q, chord, piece, depth - 1, out);
}

// Slope of the height along x while the contact stays: at the best contact this is the slope of the
// best height (envelope theorem).
double slope_of_fixed(const CutterShape& cutter, double x, double y, const Contact& c) {
  const double ox = c.x - x, oy = c.y - y, rho = std::sqrt(ox * ox + oy * oy);
  const double d = rho - cutter.flat();
  if (d <= 0 || rho <= 0) return 0;
  const double below = (cutter.corner() - d) * (cutter.corner() + d);
  const double lean = ox / rho;
  if (below <= 0) {
    if (lean == 0) return 0;
    return std::copysign(std::numeric_limits<double>::infinity(), lean);
  }
  return lean * d / std::sqrt(below);
}

double slope_along_x(const VertexPiece&, const CutterShape& cutter, double x, double y,
                     const Contact& c) {
  return slope_of_fixed(cutter, x, y, c);
}

double slope_along_x(const EdgePiece& edge, const CutterShape& cutter, double x, double y,
                     const Contact& c) {
  if (cutter.corner() > 0) {
    return slope_of_fixed(cutter, x, y, c);
  }
  // A flat end meets a rising edge with its rim, where its own height has no slope: the contact
  // moves.
  const double r = cutter.flat();
  if (std::hypot(c.x - x, c.y - y) < r * (1 - 1e-9))
    return 0;  // an end of the edge, under the flat
  const double w = (y - edge.y) * edge.dx - (x - edge.x) * edge.dy;
  const double below = (r - w) * (r + w), turn = std::fabs(edge.slope) * w * edge.dy;
  if (below <= 0) {
    return turn == 0 ? edge.slope * edge.dx
                     : std::copysign(std::numeric_limits<double>::infinity(), turn);
  }
  return edge.slope * edge.dx + turn / std::sqrt(below);
}

// The part of the piece's region that lies in the row's run; `span` is the region's own.
template <class Piece>
void slice_round(const Piece& piece, const CutterShape& cutter, Span span, double y, double x0,
                 double x1, double chord, std::uint32_t k, std::vector<ProfileSegment>& out) {
  span.x0 = std::max(span.x0, x0);
  span.x1 = std::min(span.x1, x1);
  if (!(span.x0 < span.x1)) return;
  const auto at = [&](double x) {
    const Contact c = contact(piece, cutter, x, y);
    return Sample{x, c.z, slope_along_x(piece, cutter, x, y, c)};
  };
  const Sample p = at(span.x0), q = at(span.x1);
  if (p.z == kNoContact || q.z == kNoContact) {
    // The ends of the reach, missed by rounding.
    const double shrink = 1e-12 * (std::fabs(span.x0) + std::fabs(span.x1) + cutter.radius());
    const Sample p2 = at(span.x0 + shrink), q2 = at(span.x1 - shrink);
    if (!(p2.x < q2.x) || p2.z == kNoContact || q2.z == kNoContact) return;
    chords(at, p2, q2, chord, k, 40, out);
    return;
  }
  chords(at, p, q, chord, k, 40, out);
}

double height_at(const ProfileSegment& s, double x) {
  if (x <= s.x0) return s.z0;
  if (x >= s.x1) return s.z1;
  return s.z0 + (x - s.x0) / (s.x1 - s.x0) * (s.z1 - s.z0);
}

void slice_facet(const FacetPiece& facet, double y, double x0, double x1, std::uint32_t k,
                 std::vector<ProfileSegment>& out) {
  const FacetSpan f = row_span(facet, y);
  if (!(f.span.x0 < f.span.x1)) return;
  const ProfileSegment whole{f.span.x0, f.z0, f.span.x1, f.z1, k};
  const double lo = std::max(x0, whole.x0), hi = std::min(x1, whole.x1);
  if (lo < hi) out.push_back({lo, height_at(whole, lo), hi, height_at(whole, hi), k});
}

void emit(const ProfileSegment& s, double x0, double x1, std::vector<ProfileSegment>& out,
          std::size_t run) {
  if (!(x0 < x1)) return;
  if (out.size() > run && out.back().piece == s.piece && out.back().x1 == x0) {
    // Usually the rest of a segment that was cut a moment ago: mend it.
    ProfileSegment& last = out.back();
    const double z = height_at(s, x0);
    if (z == last.z1) {
      const double slope0 = (last.z1 - last.z0) * (x1 - x0);
      const double slope1 = (height_at(s, x1) - z) * (last.x1 - last.x0);
      if (std::fabs(slope0 - slope1) <= 1e-14 * (std::fabs(slope0) + std::fabs(slope1))) {
        last.x1 = x1;
        last.z1 = height_at(s, x1);
        return;
      }
    }
  }
  out.push_back({x0, height_at(s, x0), x1, height_at(s, x1), s.piece});
}

void merge(std::span<const ProfileSegment> a, std::span<const ProfileSegment> b,
           std::vector<ProfileSegment>& out) {
  const std::size_t run = out.size();
  std::size_t i = 0, j = 0;
  double x = -std::numeric_limits<double>::infinity();
  while (i < a.size() || j < b.size()) {
    if (i < a.size() && a[i].x1 <= x) {
      ++i;
      continue;
    }
    if (j < b.size() && b[j].x1 <= x) {
      ++j;
      continue;
    }
    const double infinite = std::numeric_limits<double>::infinity();
    const double ax = i < a.size() ? std::max(a[i].x0, x) : infinite;
    const double bx = j < b.size() ? std::max(b[j].x0, x) : infinite;
    if (ax < bx) {
      const double end = std::min(a[i].x1, bx);
      emit(a[i], ax, end, out, run);
      x = end;
    } else if (bx < ax) {
      const double end = std::min(b[j].x1, ax);
      emit(b[j], bx, end, out, run);
      x = end;
    } else {
      const double end = std::min(a[i].x1, b[j].x1);
      const double d0 = height_at(a[i], ax) - height_at(b[j], ax);
      const double d1 = height_at(a[i], end) - height_at(b[j], end);
      if (d0 >= 0 && d1 >= 0) {
        emit(a[i], ax, end, out, run);
      } else if (d0 <= 0 && d1 <= 0) {
        emit(b[j], ax, end, out, run);
      } else {
        const double cross = ax + d0 / (d0 - d1) * (end - ax);
        emit(d0 > 0 ? a[i] : b[j], ax, cross, out, run);
        emit(d0 > 0 ? b[j] : a[i], cross, end, out, run);
      }
      x = end;
    }
  }
}

}  // namespace

void slice_piece(const OffsetSurface& offset, std::uint32_t k, double y, double x0, double x1,
                 double chord, std::vector<ProfileSegment>& out) {
  const std::size_t facets = offset.facets().size(), edges = offset.edges().size();
  if (k < facets) {
    slice_facet(offset.facets()[k], y, x0, x1, k, out);
  } else if (k < facets + edges) {
    const EdgePiece& edge = offset.edges()[k - facets];
    slice_round(edge, offset.cutter(), row_span(edge, offset.cutter(), y), y, x0, x1, chord, k,
                out);
  } else {
    const VertexPiece& vertex = offset.vertices()[k - facets - edges];
    slice_round(vertex, offset.cutter(), row_span(vertex, offset.cutter(), y), y, x0, x1, chord, k,
                out);
  }
}

void slice_piece_along(const OffsetSurface& offset, std::uint32_t k, const PlanLine& line,
                       double chord, std::vector<ProfileSegment>& out) {
  const std::size_t facets = offset.facets().size(), edges = offset.edges().size();
  if (k < facets) {
    FacetPiece facet = offset.facets()[k];
    for (Vec3& v : facet.v) v.head<2>() = line.to_line(v.head<2>());
    slice_facet(facet, 0, 0, line.length, k, out);
  } else if (k < facets + edges) {
    EdgePiece edge = offset.edges()[k - facets];
    const Vec2 start = line.to_line({edge.x, edge.y});
    const Vec2 d(edge.dx * line.dx + edge.dy * line.dy, edge.dy * line.dx - edge.dx * line.dy);
    edge.x = start.x();
    edge.y = start.y();
    edge.dx = d.x();
    edge.dy = d.y();
    slice_round(edge, offset.cutter(), row_span(edge, offset.cutter(), 0), 0, 0, line.length, chord,
                k, out);
  } else {
    VertexPiece vertex = offset.vertices()[k - facets - edges];
    const Span span = line_span(vertex, offset.cutter(), line.from, {line.dx, line.dy});
    const Vec2 at = line.to_line({vertex.x, vertex.y});
    vertex.x = at.x();
    vertex.y = at.y();
    slice_round(vertex, offset.cutter(), span, 0, 0, line.length, chord, k, out);
  }
}

void UpperEnvelope::take(std::vector<ProfileSegment>& segments) {
  std::sort(segments.begin(), segments.end(), [](const ProfileSegment& p, const ProfileSegment& q) {
    if (p.x0 != q.x0) return p.x0 < q.x0;
    if (p.x1 != q.x1) return p.x1 < q.x1;
    return p.piece < q.piece;
  });
  // Into as few chains of segments that follow each other as there are segments over one place at
  // most: each goes on the chain that ended first, or begins one. Then by twos.
  const auto later = [](const Chain& p, const Chain& q) {
    return p.end != q.end ? p.end > q.end : p.index > q.index;
  };
  open_.clear();
  chain_of_.clear();
  ends_.clear();
  for (const ProfileSegment& s : segments) {
    if (open_.empty() || open_.front().end > s.x0) {
      open_.push_back({s.x1, static_cast<std::uint32_t>(ends_.size())});
      ends_.push_back(0);
    } else {
      std::pop_heap(open_.begin(), open_.end(), later);
      open_.back().end = s.x1;
    }
    const std::uint32_t chain = open_.back().index;
    chain_of_.push_back(chain);
    ++ends_[chain];
    std::push_heap(open_.begin(), open_.end(), later);
  }
  if (ends_.size() > 1) {
    other_.resize(segments.size());
    std::size_t sum = 0;
    for (std::size_t& end : ends_) {
      const std::size_t size = end;
      end = sum;
      sum += size;
    }
    for (std::size_t k = 0; k < segments.size(); ++k) other_[ends_[chain_of_[k]]++] = segments[k];
    segments.swap(other_);
  }
  while (ends_.size() > 1) {
    other_.clear();
    next_ends_.clear();
    std::size_t begin = 0;
    for (std::size_t k = 0; k < ends_.size(); k += 2) {
      const std::span<const ProfileSegment> all(segments);
      if (k + 1 < ends_.size()) {
        merge(all.subspan(begin, ends_[k] - begin), all.subspan(ends_[k], ends_[k + 1] - ends_[k]),
              other_);
        begin = ends_[k + 1];
      } else {
        other_.insert(other_.end(), segments.begin() + static_cast<std::ptrdiff_t>(begin),
                      segments.end());
      }
      next_ends_.push_back(other_.size());
    }
    segments.swap(other_);
    ends_.swap(next_ends_);
  }
}

}  // namespace diesink
