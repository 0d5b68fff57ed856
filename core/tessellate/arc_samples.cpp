// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/arc_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace diesink {
namespace {

constexpr int kMaxDepth = 14;  // halvings of a stretch while its sag is measured
constexpr int kBorderDepth =
    4;  // halvings that every border stretch gets: a base may wave along it
constexpr int kCertifyDepth = 10;  // halvings of a chord while its bound is too large
constexpr int kTouchDepth = 20;    // and while it has none beside a point where faces touch,
constexpr int kTouchTries = 6;     // so many of them even where neither half has any
// Of the tolerance: a chord as short as this in space needs no bound.
constexpr double kShortShare = 0.1;
constexpr double kScanSlack = 1.2;  // the same beside a scan, whose arcs are chains of short curves
constexpr double kSlack = 1.02;     // of the sag asked for, before a chord is halved for its bound
constexpr int kMostTrials = 4;      // to lay an arc's points so that all bounds keep the sag
constexpr double kEdgeFactor =
    1.2;  // edges on arcs may be longer than inside: only one side of them is curved

double chord_distance(const Vec3& a, const Vec3& m, const Vec3& b) {
  const Vec3 d = b - a;
  const double l2 = d.squaredNorm();
  if (!(l2 > 0)) return (m - a).norm();
  const double t = std::clamp((m - a).dot(d) / l2, 0.0, 1.0);
  return (m - a - t * d).norm();
}

}  // namespace

ArcSamples::ArcSamples(const CompoundSurface::Impl& surface, const Arrangement& arrangement,
                       const SamplingOptions& options)
    : surface_(surface), arrangement_(arrangement), options_(options), solver_(surface) {
  for (const PlanArc& arc : arrangement.arcs) {
    for (const Label label : {arc.left, arc.right}) {
      if (label != kNoLabel)
        charts_.try_emplace(label, surface, label).first->second.draw_for(options.tolerance);
    }
  }
}

// The base where it is a scan: flat between the kept nodes.
bool ArcSamples::is_scan(Label label) const {
  return std::holds_alternative<ScannedSurface>(surface_.base) &&
         surface_.steps[surface_.step_of_row[static_cast<std::size_t>(row_of(label))]].solid < 0;
}

double ArcSamples::z_of(const ArcPoint& p, Label label) const {
  if (p.node != ArcPoint::kNoNode) {
    for (const LabelHeight& h : arrangement_.nodes[p.node].heights) {
      if (h.label == label) return h.z;
    }
  }
  for (const LabelHeight& h : p.sides) {
    if (h.label == label) return h.z;
  }
  double z = 0;
  // A label that the point does not know: corners of the domain beside a junction. Its own surface
  // tells.
  if (label != kNoLabel && solver_.height(label, p.x, p.y, z)) return z;
  return p.node != ArcPoint::kNoNode && !arrangement_.nodes[p.node].heights.empty()
             ? arrangement_.nodes[p.node].heights.front().z
             : p.sides[0].z;
}

double ArcSamples::z(std::uint32_t point, Label label) const { return z_of(points[point], label); }

ArcPoint ArcSamples::point_at(std::uint32_t a, double t) const {
  const PlanArc& arc = arrangement_.arcs[a];
  const std::size_t last = arc.nodes.size() - 2;
  const std::size_t k = std::min(static_cast<std::size_t>(t), last);
  const double s = t - static_cast<double>(k);
  if (s == 0 && k > 0 && arrangement_.nodes[arc.nodes[k]].kept) {
    ArcPoint p;
    const PlanNode& node = arrangement_.nodes[arc.nodes[k]];
    p.x = node.x;
    p.y = node.y;
    p.node = arc.nodes[k];
    return p;
  }
  const PlanNode &n0 = arrangement_.nodes[arc.nodes[k]], &n1 = arrangement_.nodes[arc.nodes[k + 1]];
  ArcPoint p;
  PlanNode found;
  bool solved = false;
  const PlanCurve& curve = arc.curves[k];
  const bool scan_border =
      curve.type == CurveType::kOutline && std::holds_alternative<ScannedSurface>(surface_.base);
  if (curve.type != CurveType::kUnsolved && !scan_border) {
    solved = point_on_stretch(surface_, solver_, curve, arc.left, arc.right, n0, n1, s, found);
  }
  const auto height_in = [](const PlanNode& n, Label label, double& z) {
    for (const LabelHeight& h : n.heights) {
      if (h.label == label) {
        z = h.z;
        return true;
      }
    }
    return false;
  };
  if (solved) {
    p.x = found.x;
    p.y = found.y;
    for (int side = 0; side < 2; ++side) {
      const Label label = side == 0 ? arc.left : arc.right;
      p.sides[static_cast<std::size_t>(side)].label = label;
      if (label != kNoLabel) height_in(found, label, p.sides[static_cast<std::size_t>(side)].z);
    }
    return p;
  }
  p.x = s == 0 ? n0.x : n0.x + s * (n1.x - n0.x);
  p.y = s == 0 ? n0.y : n0.y + s * (n1.y - n0.y);
  double gap = 0;
  int known = 0;
  for (int side = 0; side < 2; ++side) {
    const Label label = side == 0 ? arc.left : arc.right;
    LabelHeight& h = p.sides[static_cast<std::size_t>(side)];
    h.label = label;
    if (label == kNoLabel) continue;
    double z0 = 0, z1 = 0;
    const bool k0 = height_in(n0, label, z0), k1 = height_in(n1, label, z1);
    h.z = z0 + s * (z1 - z0);
    // Stretches without an equation lie on the label's own surface all the same (border), or in a
    // least cell.
    const bool own = (arc.border || curve.type == CurveType::kOutline) && !is_scan(label);
    if (own || !(k0 && k1)) {
      double z = 0;
      if (solver_.height(label, p.x, p.y, z)) h.z = z;
    }
    gap = known++ == 0 ? h.z : gap - h.z;
  }
  if (known == 2 && std::fabs(gap) <= 1e-9 * surface_.size) p.sides[1].z = p.sides[0].z;
  return p;
}

double ArcSamples::halfway(std::uint32_t a, double t0, double t1) const {
  const PlanArc& arc = arrangement_.arcs[a];
  const std::size_t last = arc.nodes.size() - 2;
  const std::size_t k0 = std::min(static_cast<std::size_t>(t0), last);
  const std::size_t k1 = std::min(static_cast<std::size_t>(t1), last);
  if (k0 == k1) return 0.5 * (t0 + t1);
  const auto length_in = [&](std::size_t k) {
    const PlanNode &p = arrangement_.nodes[arc.nodes[k]], &q = arrangement_.nodes[arc.nodes[k + 1]];
    const double from = std::fmax(t0, static_cast<double>(k));
    const double to = std::fmin(t1, static_cast<double>(k + 1));
    return std::hypot(q.x - p.x, q.y - p.y) * (to - from);
  };
  double total = 0;
  for (std::size_t k = k0; k <= k1; ++k) total += length_in(k);
  double passed = 0;
  for (std::size_t k = k0; k <= k1; ++k) {
    const double length = length_in(k);
    if (passed + length >= 0.5 * total && length > 0) {
      const double from = std::fmax(t0, static_cast<double>(k));
      const double to = std::fmin(t1, static_cast<double>(k + 1));
      const double t = from + (to - from) * (0.5 * total - passed) / length;
      return t > t0 && t < t1 ? t : 0.5 * (t0 + t1);
    }
    passed += length;
  }
  return 0.5 * (t0 + t1);
}

ArcPoint ArcSamples::end_of(std::uint32_t a, bool last) const {
  const PlanArc& arc = arrangement_.arcs[a];
  const std::uint32_t n = last ? arc.nodes.back() : arc.nodes.front();
  const PlanNode& node = arrangement_.nodes[n];
  ArcPoint p;
  p.x = node.x;
  p.y = node.y;
  p.node = n;
  return p;
}

double ArcSamples::lifted_sag(std::uint32_t a, const ArcPoint& p, const ArcPoint& m,
                              const ArcPoint& q) const {
  const PlanArc& arc = arrangement_.arcs[a];
  double sag = 0;
  for (const Label label : {arc.left, arc.right}) {
    if (label == kNoLabel) continue;
    sag = std::fmax(sag, chord_distance({p.x, p.y, z_of(p, label)}, {m.x, m.y, z_of(m, label)},
                                        {q.x, q.y, z_of(q, label)}));
  }
  return sag;
}

void ArcSamples::sample(std::uint32_t a, std::vector<Trial>& out) const {
  const PlanArc& arc = arrangement_.arcs[a];
  std::vector<Piece> pieces;
  struct Open {
    double t0, t1;
    ArcPoint p0, p1;
    int depth;
  };
  std::vector<Open> open;
  const std::size_t stretches = arc.nodes.size() - 1;
  const bool is_scan_border = arc.border && is_scan(arc.left);
  if (arc.fixed) {  // its own points, and no others
    for (std::size_t k = 1; k < stretches; ++k) {
      const double t = static_cast<double>(k);
      out.push_back({t, point_at(a, t)});
    }
    return;
  }
  const double most = sag_of(a);
  const bool scan = has_scan(a);
  ArcPoint last = end_of(a, false);
  for (std::size_t k = 0; k < stretches; ++k) {
    const double t0 = static_cast<double>(k), t1 = static_cast<double>(k + 1);
    const ArcPoint next = k + 1 == stretches ? end_of(a, true) : point_at(a, t1);
    open.push_back({t0, t1, last, next, 0});
    last = next;
    while (!open.empty()) {
      const Open o = open.back();
      open.pop_back();
      const double tm = 0.5 * (o.t0 + o.t1);
      const ArcPoint m = point_at(a, tm);
      const double sag = lifted_sag(a, o.p0, m, o.p1);
      const bool deep = o.depth >= kMaxDepth;
      if (!deep && (sag > 2 * most || (arc.border && o.depth < kBorderDepth && !is_scan_border))) {
        open.push_back({tm, o.t1, m, o.p1, o.depth + 1});
        open.push_back({o.t0, tm, o.p0, m, o.depth + 1});
        continue;
      }
      double weight = std::sqrt(sag / most);
      for (const Label label : {arc.left, arc.right}) {
        if (label == kNoLabel || is_scan(label)) continue;
        const Vec3 p0(o.p0.x, o.p0.y, z_of(o.p0, label)), p1(o.p1.x, o.p1.y, z_of(o.p1, label));
        const double edge =
            kEdgeFactor * charts_.at(label).spacing({m.x, m.y, z_of(m, label)}, options_.tolerance);
        weight = std::fmax(weight, (p1 - p0).norm() / std::fmax(edge, options_.shortest));
      }
      pieces.push_back({o.t0, o.t1, weight});
    }
  }
  // Pieces come in order: the stack is worked off from the front of each stretch. Laid again more
  // densely where the bound of a chord, which is somewhat above its sag, asks for it: halving it
  // would leave one twice as dense as the rest.
  for (int trial = 1;; ++trial) {
    out.clear();
    lay_points(a, pieces, out);
    bool enough = true;
    std::size_t k = 0;
    double t0 = 0;
    ArcPoint p = end_of(a, false);
    for (std::size_t i = 0; i <= out.size() && trial < kMostTrials && !scan; ++i) {
      const bool at_end = i == out.size();
      const double t1 = at_end ? static_cast<double>(stretches) : out[i].t;
      const ArcPoint q = at_end ? end_of(a, true) : out[i].p;
      const double d = bound(a, t0, p, t1, q);
      const bool dense = d > most && d < 4 * most;
      while (k > 0 && (k == pieces.size() || pieces[k].t0 > t0)) --k;
      for (; k < pieces.size() && pieces[k].t0 < t1; ++k) {
        if (dense && pieces[k].t1 > t0) pieces[k].weight *= std::sqrt(1.01 * d / most);
      }
      enough = enough && !dense;
      t0 = t1;
      p = q;
    }
    if (enough || trial == kMostTrials) return;
  }
}

// Points between the ends of an arc at equal parts of the weights. Kept nodes part them into runs.
void ArcSamples::lay_points(std::uint32_t a, const std::vector<Piece>& pieces,
                            std::vector<Trial>& out) const {
  const PlanArc& arc = arrangement_.arcs[a];
  const std::size_t stretches = arc.nodes.size() - 1;
  std::size_t k = 0;
  for (std::size_t from = 0; from < stretches;) {
    std::size_t to = from + 1;
    while (to < stretches && !arrangement_.nodes[arc.nodes[to]].kept) ++to;
    std::size_t last_piece = k;
    double total = 0;
    while (last_piece < pieces.size() && pieces[last_piece].t0 < static_cast<double>(to))
      total += pieces[last_piece++].weight;
    int count = std::max(1, static_cast<int>(std::ceil(total - 1e-9)));
    if (arc.closed && from == 0 && to == stretches) count = std::max(count, 4);
    double passed = 0;
    for (int i = 1; i < count; ++i) {
      const double want = total > 0 ? total * i / count : 0;
      double t = 0;
      if (total > 0) {
        while (k + 1 < last_piece && passed + pieces[k].weight < want) passed += pieces[k++].weight;
        const Piece& piece = pieces[k];
        const double f =
            piece.weight > 0 ? std::clamp((want - passed) / piece.weight, 0.0, 1.0) : 0;
        t = piece.t0 + f * (piece.t1 - piece.t0);
      } else {
        t = static_cast<double>(from) + static_cast<double>(to - from) * i / count;
      }
      out.push_back({t, point_at(a, t)});
    }
    if (to < stretches)
      out.push_back({static_cast<double>(to), point_at(a, static_cast<double>(to))});
    k = last_piece;
    from = to;
  }
}

// Samples where the arc crosses the lines of the grid: the edge points of the grid array.
void ArcSamples::sample_on_grid(std::uint32_t a, std::vector<Trial>& out) const {
  const PlanArc& arc = arrangement_.arcs[a];
  std::vector<double> ts;
  const std::size_t stretches = arc.nodes.size() - 1;
  for (std::size_t k = 0; k < stretches; ++k) {
    // Halves of halves: within each the arc is taken to cross a line at most once.
    constexpr int kParts = 8;
    double t0 = static_cast<double>(k);
    ArcPoint p0 = k == 0 ? end_of(a, false) : point_at(a, t0);
    for (int i = 1; i <= kParts; ++i) {
      const double t1 = static_cast<double>(k) + static_cast<double>(i) / kParts;
      const bool last_part = k + 1 == stretches && i == kParts;
      const ArcPoint p1 = last_part ? end_of(a, true) : point_at(a, t1);
      for (int axis = 0; axis < 2; ++axis) {
        const std::vector<double>& lines = axis == 0 ? *options_.grid_x : *options_.grid_y;
        const double c0 = axis == 0 ? p0.x : p0.y, c1 = axis == 0 ? p1.x : p1.y;
        auto line = std::upper_bound(lines.begin(), lines.end(), std::fmin(c0, c1));
        for (; line != lines.end() && *line < std::fmax(c0, c1); ++line) {
          double lo = t0, hi = t1;
          for (int n = 0; n < 48 && hi - lo > 1e-14 * (1 + hi); ++n) {
            const double mid = 0.5 * (lo + hi);
            const ArcPoint m = point_at(a, mid);
            const double c = axis == 0 ? m.x : m.y;
            ((c < *line) == (c0 < c1) ? lo : hi) = mid;
          }
          ts.push_back(0.5 * (lo + hi));
        }
        // On a line between two parts.
        if (!last_part && c0 != c1 && std::binary_search(lines.begin(), lines.end(), c1))
          ts.push_back(t1);
      }
      t0 = t1;
      p0 = p1;
    }
  }
  std::sort(ts.begin(), ts.end());
  // What a corner lies beside by a thousandth of the grid's interval, the corner stands for.
  const auto interval = [](const std::vector<double>& lines) {
    return lines.size() > 1 ? lines[1] - lines[0] : 0;
  };
  const double close = 1e-3 * std::fmin(interval(*options_.grid_x), interval(*options_.grid_y));
  const ArcPoint ends[2] = {end_of(a, false), end_of(a, true)};
  double last = 0;
  for (const double t : ts) {
    if (t - last < 1e-6 || static_cast<double>(stretches) - t < 1e-6)
      continue;  // of a stretch: a line through a grid node
    const ArcPoint p = point_at(a, t);
    if (!arc.closed && (std::hypot(p.x - ends[0].x, p.y - ends[0].y) < close ||
                        std::hypot(p.x - ends[1].x, p.y - ends[1].y) < close)) {
      continue;
    }
    out.push_back({t, p});
    last = t;
  }
  while (arc.closed && out.size() < 3) {
    const double at = static_cast<double>(stretches) * static_cast<double>(out.size() + 1) / 4;
    out.push_back({at, point_at(a, at)});
  }
  std::sort(out.begin(), out.end(), [](const Trial& x, const Trial& y) { return x.t < y.t; });
}

std::uint32_t ArcSamples::insert(std::uint32_t a, std::uint32_t after, const Trial& trial) {
  SampledArc& arc = arcs[a];
  const auto point = static_cast<std::uint32_t>(points.size());
  points.push_back(trial.p);
  points.back().arc = a;
  const auto sample = static_cast<std::uint32_t>(arc.samples.size());
  ArcSample s;
  s.point = point;
  s.next = arc.samples[after].next;
  s.t = trial.t;
  const std::uint32_t before_point = arc.samples[after].point,
                      next_point = arc.samples[s.next].point;
  arc.samples.push_back(s);
  arc.samples[after].next = sample;
  chords_.erase(key(before_point, next_point));
  chords_[key(before_point, point)] = {a, after};
  chords_[key(point, next_point)] = {a, sample};
  return sample;
}

void ArcSamples::certify(std::uint32_t a, std::uint32_t n, int depth) {
  SampledArc& arc = arcs[a];
  const std::uint32_t next = arc.samples[n].next;
  const std::vector<double>& known = arrangement_.arcs[a].bounds;
  if (!known.empty()) {
    arc.samples[n].deviation = known[static_cast<std::size_t>(arc.samples[n].t)];
    largest_deviation = std::fmax(largest_deviation, arc.samples[n].deviation);
    return;
  }
  const double d = bound(a, arc.samples[n], arc.samples[next]);
  // Over the far side of a wall two bounds are added, to more than the sag that is there: as long
  // as the tolerance holds the sum is well.
  const PlanArc& own = arrangement_.arcs[a];
  const bool wall =
      !own.border && own.left != kNoLabel && own.right != kNoLabel &&
      own.curves[std::min(static_cast<std::size_t>(arc.samples[n].t), own.curves.size() - 1)]
              .type != CurveType::kMeet;
  const double most = has_scan(a) ? kScanSlack * sag_of(a)
                      : wall      ? options_.tolerance
                                  : kSlack * sag_of(a);
  const double short_enough = kShortShare * options_.tolerance;
  const auto length_of = [&](const ArcPoint& p, const ArcPoint& q) {
    double length = std::hypot(p.x - q.x, p.y - q.y);
    for (const Label label : {own.left, own.right}) {
      if (label != kNoLabel)
        length = std::fmax(length, (lifted(p, label) - lifted(q, label)).norm());
    }
    return length;
  };
  const ArcPoint p = points[arc.samples[n].point], q = points[arc.samples[next].point];
  const double t0 = arc.samples[n].t;
  const double t1 =
      arc.samples[next].t <= t0 ? static_cast<double>(own.nodes.size() - 1) : arc.samples[next].t;
  // What halving helps: of a chord without a bound, one of its halves has one. Faces that touch the
  // wall's upright surface do so in a point, which gets a short chord; or all along, where it would
  // not help. So it is beside a silhouette, where a face is upright: chords are short in plan long
  // before they are in space.
  const bool tiny = std::hypot(p.x - q.x, p.y - q.y) <= 0.05 * options_.tolerance;
  const auto halves = [&] {
    if (d < 1e300) return !tiny;
    if (!tiny && (!wall || depth < kTouchTries)) return true;
    if (tiny && length_of(p, q) <= short_enough) return false;
    const double t = halfway(a, t0, t1);
    const ArcPoint m = point_at(a, t);
    return bound(a, t0, p, t, m) < 1e300 || bound(a, t, m, t1, q) < 1e300;
  };
  if (d > most && depth < (d < 1e300 ? kCertifyDepth : kTouchDepth) && options_.grid_x == nullptr &&
      !own.fixed && halves()) {
    const double t = halfway(a, t0, t1);
    const std::uint32_t mid = insert(a, n, {t, point_at(a, t)});
    certify(a, n, depth + 1);
    certify(a, mid, depth + 1);
    return;
  }
  if (!(d < 1e300) && length_of(p, q) <= short_enough) {
    // As a whole too short to matter: the arc of a stretch stays within the stretch's own length.
    arcs[a].samples[n].deviation = short_enough;
  } else if (!(d < 1e300)) {
    // Not shown; the measured sag of the halves stands in, and the length is reported.
    arcs[a].samples[n].deviation = lifted_sag(a, p, point_at(a, 0.5 * (t0 + t1)), q);
    if (unproven_length == 0) unproven_point = arcs[a].samples[n].point;
    unproven_length += std::hypot(p.x - q.x, p.y - q.y);
  } else {
    arcs[a].samples[n].deviation = d;
  }
  largest_deviation = std::fmax(largest_deviation, arcs[a].samples[n].deviation);
}

void ArcSamples::sample_all(int threads) {
  const std::size_t n = arrangement_.arcs.size();
  std::vector<std::vector<Trial>> trials(n);
  parallel_blocks(n, 4, threads, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t a = begin; a < end; ++a) {
      if (options_.grid_x != nullptr && !arrangement_.arcs[a].fixed) {
        sample_on_grid(static_cast<std::uint32_t>(a), trials[a]);
      } else if (!(arrangement_.arcs[a].border && arrangement_.arcs[a].left == kNoLabel)) {
        sample(static_cast<std::uint32_t>(a), trials[a]);
      }
      add_fades(static_cast<std::uint32_t>(a), trials[a]);
    }
  });
  // Numbers in the order of arcs: the same for any number of threads.
  std::vector<std::uint32_t> point_of_node(arrangement_.nodes.size(), kNone);
  arcs.assign(n, {});
  const auto junction = [&](std::uint32_t arc, bool last) {
    const PlanArc& of = arrangement_.arcs[arc];
    std::uint32_t& point = point_of_node[last ? of.nodes.back() : of.nodes.front()];
    if (point == kNone) {
      point = static_cast<std::uint32_t>(points.size());
      points.push_back(end_of(arc, last));
    }
    return point;
  };
  for (std::uint32_t a = 0; a < n; ++a) {
    SampledArc& arc = arcs[a];
    const auto append = [&](std::uint32_t point, double t) {
      ArcSample s;
      s.point = point;
      s.t = t;
      if (!arc.samples.empty())
        arc.samples.back().next = static_cast<std::uint32_t>(arc.samples.size());
      arc.samples.push_back(s);
    };
    append(junction(a, false), 0);
    for (const Trial& trial : trials[a]) {
      const std::uint32_t node = trial.p.node;
      if (node != ArcPoint::kNoNode && point_of_node[node] != kNone) {
        append(point_of_node[node], trial.t);
        continue;
      }
      if (node != ArcPoint::kNoNode)
        point_of_node[node] = static_cast<std::uint32_t>(points.size());
      append(static_cast<std::uint32_t>(points.size()), trial.t);
      points.push_back(trial.p);
      points.back().arc = a;
    }
    const PlanArc& of = arrangement_.arcs[a];
    if (of.closed) {
      arc.samples.back().next = 0;
    } else {
      append(junction(a, true), static_cast<double>(of.nodes.size() - 1));
    }
  }
  // Fixed ones first: the chords of others make way for theirs.
  std::vector<std::uint32_t> order;
  for (const bool fixed : {true, false}) {
    for (std::uint32_t a = 0; a < n; ++a) {
      if (arrangement_.arcs[a].fixed == fixed) order.push_back(a);
    }
  }
  for (const std::uint32_t a : order) {
    SampledArc& arc = arcs[a];
    const PlanArc& of = arrangement_.arcs[a];
    const auto first_count = static_cast<std::uint32_t>(arc.samples.size());
    for (std::uint32_t k = 0; k < first_count; ++k) {
      const std::uint32_t after = arc.samples[k].next;
      if (after == ArcSample::kEnd) continue;
      const auto [it, fresh] =
          chords_.try_emplace(key(arc.samples[k].point, arc.samples[after].point), Ref{a, k});
      if (fresh) continue;
      // Two arcs between the same two corners. Each gets a point of its own, lest what lies between
      // them have no area; a straight border needs none, what is fixed takes none.
      const Ref other = it->second;
      const auto halve = [&](std::uint32_t of_arc, std::uint32_t from) {
        const std::vector<ArcSample>& samples = arcs[of_arc].samples;
        const std::uint32_t to = samples[from].next;
        const double t1 = to == 0 ? static_cast<double>(arrangement_.arcs[of_arc].nodes.size() - 1)
                                  : samples[to].t;
        const double t = 0.5 * (samples[from].t + t1);
        insert(of_arc, from, {t, point_at(of_arc, t)});
      };
      const std::uint64_t both = key(arc.samples[k].point, arc.samples[after].point);
      const bool halve_other = !arrangement_.arcs[other.arc].fixed;
      if (halve_other) halve(other.arc, other.sample);
      chords_[both] = {a, k};
      if (!of.border || !halve_other) {
        halve(a, k);
        if (!halve_other) chords_[both] = other;
      }
    }
  }
  for (std::uint32_t a = 0; a < n; ++a) {
    const auto first_count = static_cast<std::uint32_t>(arcs[a].samples.size());
    for (std::uint32_t k = 0; k < first_count; ++k) {
      if (arcs[a].samples[k].next != ArcSample::kEnd) certify(a, k, 0);
    }
  }
}

}  // namespace diesink
