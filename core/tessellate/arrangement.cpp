// From the graph of cells to arcs and regions.
// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/arrangement.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/tessellate/border_stops.h"
#include "core/tessellate/cell_graph.h"
#include "core/tessellate/cell_tree.h"
#include "core/tessellate/outline.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

constexpr double kStraight =
    0.03;  // sag over chord from which on a stretch is split once more, in plan
constexpr int kMaxDensity = 7;  // halvings of a stretch at most

// Cells with one corner each, of a tree whose least cells have been widened: where there are more,
// tens of thousands of arcs lie in the wide cells, and joining them, drawing them together and
// laying them straight does not end in sensible time. (An engine in place of a scan has 300; a town
// of upright walls has 1300, and four times as many arcs.)
constexpr std::size_t kMostCornersWidened = 600;

class ArcMaker {
 public:
  ArcMaker(const Impl& surface, const CellGraph& graph, std::vector<BorderStop> stops,
           const std::array<const Seam*, 4>& seams, Arrangement& out)
      : surface_(surface),
        graph_(graph),
        stops_(std::move(stops)),
        seams_(seams),
        out_(out),
        solver_(surface) {}
  void make();

 private:
  [[nodiscard]] bool junction(std::uint32_t node) const {
    return graph_.nodes[node].corner || graph_.nodes[node].border ||
           graph_.nodes[node].links.size() != 2;
  }
  std::uint32_t plan_node(std::uint32_t graph_node);
  void walk(std::uint32_t start, std::uint32_t link);
  void append_stretch(PlanArc& arc, std::uint32_t a, std::uint32_t b, const PlanCurve& curve,
                      int depth);
  void make_border();
  void run_along_seam(const Seam& seam, bool ahead, PlanArc& arc);
  void make_regions();
  double area_of(const std::vector<ArcUse>& loop) const;
  [[nodiscard]] double area_beside(const PlanArc& arc) const;
  bool contains(const std::vector<ArcUse>& loop, double x, double y) const;

  const Impl& surface_;
  const CellGraph& graph_;
  std::vector<BorderStop> stops_;
  const std::array<const Seam*, 4>& seams_;
  Arrangement& out_;
  CurveSolver solver_;
  std::vector<std::uint32_t> plan_of_;       // plan node of a graph node, or kNone
  std::vector<std::uint32_t> stop_node_;     // plan node of a stop
  std::vector<char> walked_;                 // links
  std::vector<std::vector<ArcUse>> around_;  // a plan node's outgoing arcs, anticlockwise
  std::vector<std::vector<std::int64_t>>
      slot_of_link_;  // a graph corner's links in order: arc use ids
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
};

std::uint32_t ArcMaker::plan_node(std::uint32_t g) {
  if (plan_of_[g] != kNone) return plan_of_[g];
  const GraphNode& from = graph_.nodes[g];
  PlanNode node;
  node.x = from.x;
  node.y = from.y;
  node.heights = from.heights;
  node.corner = from.corner;
  node.solved = from.solved;
  plan_of_[g] = static_cast<std::uint32_t>(out_.nodes.size());
  out_.nodes.push_back(std::move(node));
  return plan_of_[g];
}

// Adds the points of a stretch after node a, up to and with b, dense enough for the arc's form in
// plan.
void ArcMaker::append_stretch(PlanArc& arc, std::uint32_t a, std::uint32_t b,
                              const PlanCurve& curve, int depth) {
  const Vec2 p(out_.nodes[a].x, out_.nodes[a].y), q(out_.nodes[b].x, out_.nodes[b].y);
  const Vec2 chord = q - p;
  const double length = chord.norm();
  bool bent = false;
  std::uint32_t mid = kNone;
  if (depth < kMaxDensity && length > 1e-9 * surface_.size && curve.type != CurveType::kUnsolved) {
    PlanNode node;
    if (point_on_stretch(surface_, solver_, curve, arc.left, arc.right, out_.nodes[a],
                         out_.nodes[b], 0.5, node)) {
      const double sag = (Vec2(node.x, node.y) - 0.5 * (p + q)).norm();
      bent = sag > kStraight * length;
      if (bent) {
        mid = static_cast<std::uint32_t>(out_.nodes.size());
        out_.nodes.push_back(std::move(node));
      }
    }
  }
  if (bent) {
    append_stretch(arc, a, mid, curve, depth + 1);
    append_stretch(arc, mid, b, curve, depth + 1);
    return;
  }
  arc.nodes.push_back(b);
  arc.curves.push_back(curve);
}

void ArcMaker::walk(std::uint32_t start, std::uint32_t link) {
  PlanArc arc;
  const GraphLink& first = graph_.links[link];
  bool along = first.from == start;
  arc.left = along ? first.left : first.right;
  arc.right = along ? first.right : first.left;
  std::uint32_t at = start, l = link;
  arc.nodes.push_back(plan_node(start));
  const auto id = static_cast<std::uint32_t>(out_.arcs.size());
  const auto slot = [&](std::uint32_t node, std::uint32_t of_link, bool forward) {
    const std::vector<std::uint32_t>& links = graph_.nodes[node].links;
    std::vector<std::int64_t>& slots = slot_of_link_[node];
    slots.resize(links.size(), -1);
    for (std::size_t k = 0; k < links.size(); ++k) {
      if (links[k] == of_link && slots[k] < 0) {
        slots[k] = static_cast<std::int64_t>(id) * 2 + (forward ? 0 : 1);
        return;
      }
    }
  };
  if (junction(start)) slot(start, link, true);
  for (;;) {
    walked_[l] = 1;
    const GraphLink& stretch = graph_.links[l];
    along = stretch.from == at;
    const std::uint32_t next = along ? stretch.to : stretch.from;
    append_stretch(arc, arc.nodes.back(), plan_node(next), stretch.curve, 0);
    at = next;
    if (at == start && !junction(start)) {
      arc.closed = true;
      break;
    }
    if (junction(at)) {
      slot(at, l, false);
      break;
    }
    const std::vector<std::uint32_t>& links = graph_.nodes[at].links;
    l = links[0] == l ? links[1] : links[0];
  }
  out_.arcs.push_back(std::move(arc));
}

// The points of the seam between the two nodes of an arc, as kept nodes between them.
void ArcMaker::run_along_seam(const Seam& seam, bool ahead, PlanArc& arc) {
  arc.fixed = true;
  const std::uint32_t last = arc.nodes.back();
  const auto along = [&](std::uint32_t n) {
    return seam.axis == 0 ? out_.nodes[n].y : out_.nodes[n].x;
  };
  const double low = std::fmin(along(arc.nodes.front()), along(last));
  const double high = std::fmax(along(arc.nodes.front()), along(last));
  std::vector<std::uint32_t> nodes;
  auto point = std::upper_bound(seam.points.begin(), seam.points.end(), low,
                                [](double at, const SeamPoint& p) { return at < p.along; });
  for (; point != seam.points.end() && point->along < high; ++point) {
    if (point->change) continue;
    PlanNode node;
    node.x = seam.axis == 0 ? seam.at : point->along;
    node.y = seam.axis == 0 ? point->along : seam.at;
    node.heights = point->heights;
    node.border = node.seam = node.kept = true;
    nodes.push_back(static_cast<std::uint32_t>(out_.nodes.size()));
    out_.nodes.push_back(std::move(node));
  }
  if (!ahead) std::reverse(nodes.begin(), nodes.end());
  arc.nodes.insert(arc.nodes.end() - 1, nodes.begin(), nodes.end());
  arc.curves.resize(arc.nodes.size() - 1);
}

void ArcMaker::make_border() {
  const std::size_t n = stops_.size();
  std::vector<std::uint32_t> arc_after(n);
  for (std::size_t k = 0; k < n; ++k) {
    PlanArc arc;
    arc.border = true;
    arc.left = stops_[k].after;
    arc.nodes = {stop_node_[k], stop_node_[(k + 1) % n]};
    arc.curves.resize(1);
    const std::uint8_t side = stops_[k].side;
    if (seams_[side] != nullptr) run_along_seam(*seams_[side], side < 2, arc);
    arc_after[k] = static_cast<std::uint32_t>(out_.arcs.size());
    out_.arcs.push_back(std::move(arc));
  }
  around_.resize(out_.nodes.size());
  for (std::size_t k = 0; k < n; ++k) {
    std::vector<ArcUse>& out = around_[stop_node_[k]];
    out.insert(out.begin(), {arc_after[k], true});
    out.push_back({arc_after[(k + n - 1) % n], false});
  }
}

double ArcMaker::area_of(const std::vector<ArcUse>& loop) const {
  double area = 0, around = 0;
  std::size_t stretches = 0;
  const PlanNode& o = out_.nodes[out_.arcs[loop[0].arc].nodes[0]];
  for (const ArcUse& use : loop) {
    const PlanArc& arc = out_.arcs[use.arc];
    double part = 0;
    for (std::size_t k = 0; k + 1 < arc.nodes.size(); ++k) {
      const PlanNode &a = out_.nodes[arc.nodes[k]], &b = out_.nodes[arc.nodes[k + 1]];
      part += (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
      around += std::fabs(b.x - a.x) + std::fabs(b.y - a.y);
    }
    area += use.forward ? part : -part;
    stretches += arc.curves.size();
  }
  // Between few stretches the chords may leave out all that the arcs bound.
  constexpr std::size_t kFew = 8;
  if (stretches > kFew || std::fabs(area) > kStraight * around * around) return 0.5 * area;
  for (const ArcUse& use : loop) area += (use.forward ? 1 : -1) * area_beside(out_.arcs[use.arc]);
  return 0.5 * area;
}

// Twice the area between an arc and the chords between its nodes, as of parabolas, on its right.
double ArcMaker::area_beside(const PlanArc& arc) const {
  double area = 0;
  for (std::size_t k = 0; k + 1 < arc.nodes.size(); ++k) {
    const PlanNode &a = out_.nodes[arc.nodes[k]], &b = out_.nodes[arc.nodes[k + 1]];
    PlanNode m;
    if (arc.curves[k].type == CurveType::kUnsolved ||
        !point_on_stretch(surface_, solver_, arc.curves[k], arc.left, arc.right, a, b, 0.5, m))
      continue;
    area += 4.0 / 3 * ((m.x - a.x) * (b.y - a.y) - (m.y - a.y) * (b.x - a.x));
  }
  return area;
}

bool ArcMaker::contains(const std::vector<ArcUse>& loop, double x, double y) const {
  bool inside = false;
  for (const ArcUse& use : loop) {
    const PlanArc& arc = out_.arcs[use.arc];
    for (std::size_t k = 0; k + 1 < arc.nodes.size(); ++k) {
      const PlanNode &a = out_.nodes[arc.nodes[k]], &b = out_.nodes[arc.nodes[k + 1]];
      if ((a.y > y) != (b.y > y) && x < a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)))
        inside = !inside;
    }
  }
  return inside;
}

void ArcMaker::make_regions() {
  std::vector<char> used(out_.arcs.size() * 2, 0);
  struct Loop {
    std::vector<ArcUse> uses;
    Label label;
    double area;
    PlanBox box;
  };
  std::vector<Loop> outers, holes;
  for (std::uint32_t a = 0; a < out_.arcs.size(); ++a) {
    for (int side = 0; side < 2; ++side) {
      const PlanArc& start = out_.arcs[a];
      if (start.border && side == 1) continue;
      if (used[a * 2 + static_cast<std::uint32_t>(side)]) continue;
      Loop loop;
      ArcUse use{a, side == 0};
      loop.label = use.forward ? start.left : start.right;
      for (;;) {
        char& mark = used[use.arc * 2 + (use.forward ? 0u : 1u)];
        if (mark) break;
        mark = 1;
        loop.uses.push_back(use);
        const PlanArc& arc = out_.arcs[use.arc];
        if ((use.forward ? arc.left : arc.right) != loop.label) ++out_.disorder;
        if (arc.closed) break;
        const std::uint32_t end = use.forward ? arc.nodes.back() : arc.nodes.front();
        const std::vector<ArcUse>& out = around_[end];
        std::size_t k = 0;
        while (k < out.size() && !(out[k].arc == use.arc && out[k].forward != use.forward)) ++k;
        if (k == out.size()) {
          ++out_.disorder;
          break;
        }
        use = out[(k + out.size() - 1) % out.size()];
      }
      loop.area = area_of(loop.uses);
      loop.box = {1e300, -1e300, 1e300, -1e300};
      for (const ArcUse& u : loop.uses) {
        for (const std::uint32_t n : out_.arcs[u.arc].nodes) {
          loop.box.x0 = std::fmin(loop.box.x0, out_.nodes[n].x);
          loop.box.x1 = std::fmax(loop.box.x1, out_.nodes[n].x);
          loop.box.y0 = std::fmin(loop.box.y0, out_.nodes[n].y);
          loop.box.y1 = std::fmax(loop.box.y1, out_.nodes[n].y);
        }
      }
      (loop.area > 0 ? outers : holes).push_back(std::move(loop));
    }
  }
  for (Loop& loop : outers) {
    PlanRegion region;
    region.label = loop.label;
    region.loops.push_back(loop.uses);
    out_.regions.push_back(std::move(region));
  }
  // Holes belong to the smallest outer loop of their label around them.
  std::unordered_map<Label, std::vector<std::size_t>> outers_of;
  for (std::size_t k = 0; k < outers.size(); ++k) outers_of[outers[k].label].push_back(k);
  for (Loop& hole : holes) {
    const PlanArc& arc = out_.arcs[hole.uses[0].arc];
    const PlanNode& p = out_.nodes[arc.nodes[arc.nodes.size() / 2]];
    std::size_t best = outers.size();
    for (const std::size_t k : outers_of[hole.label]) {
      const Loop& outer = outers[k];
      if (outer.area < -hole.area) continue;
      if (outer.box.x0 > hole.box.x0 || outer.box.x1 < hole.box.x1 || outer.box.y0 > hole.box.y0 ||
          outer.box.y1 < hole.box.y1) {
        continue;
      }
      if (best < outers.size() && outer.area >= outers[best].area) continue;
      if (contains(outer.uses, p.x, p.y)) best = k;
    }
    if (best < outers.size()) {
      out_.regions[best].loops.push_back(hole.uses);
    } else if (hole.label != kNoLabel) {
      ++out_.disorder;  // a hole in nothing
    }
  }
}

void ArcMaker::make() {
  plan_of_.assign(graph_.nodes.size(), kNone);
  walked_.assign(graph_.links.size(), 0);
  for (std::size_t l = 0; l < graph_.links.size(); ++l) walked_[l] = graph_.links[l].gone ? 1 : 0;
  slot_of_link_.resize(graph_.nodes.size());
  for (const BorderStop& stop : stops_) {
    const auto id = static_cast<std::uint32_t>(out_.nodes.size());
    stop_node_.push_back(id);
    for (const std::uint32_t g : stop.graph) plan_of_[g] = id;
    out_.nodes.push_back(stop.node);
  }
  for (std::uint32_t g = 0; g < graph_.nodes.size(); ++g) {
    if (!junction(g)) continue;
    for (const std::uint32_t l : graph_.nodes[g].links) {
      if (!walked_[l]) walk(g, l);
    }
  }
  for (std::uint32_t l = 0; l < graph_.links.size(); ++l) {
    if (!walked_[l]) walk(graph_.links[l].from, l);
  }
  around_.resize(out_.nodes.size());
  const auto add_slots = [&](std::uint32_t g) {
    for (const std::int64_t s : slot_of_link_[g]) {
      if (s >= 0) around_[plan_of_[g]].push_back({static_cast<std::uint32_t>(s / 2), s % 2 == 0});
    }
  };
  for (std::uint32_t g = 0; g < graph_.nodes.size(); ++g) {
    if (junction(g) && !graph_.nodes[g].border && plan_of_[g] != kNone) add_slots(g);
  }
  // Anticlockwise from the way on: what is ahead comes first.
  for (const BorderStop& stop : stops_)
    std::for_each(stop.graph.rbegin(), stop.graph.rend(), add_slots);
  make_border();
  make_regions();
}

}  // namespace

double border_inset(const Impl& surface, int variant) {
  constexpr double kTies[] = {64, 8, 512};
  return kTies[variant % 3] * surface.tie;
}

double flat_height(const Impl& surface, double tolerance) {
  return std::fmax(1e-9 * surface.size, 1e-4 * tolerance);
}

bool point_on_stretch(const Impl& surface, const CurveSolver& solver, const PlanCurve& curve,
                      Label left, Label right, const PlanNode& a, const PlanNode& b, double s,
                      PlanNode& node) {
  const Vec2 p(a.x, a.y), q(b.x, b.y);
  const Vec2 chord = q - p;
  const auto height_at = [](const PlanNode& n, Label label, double fallback) {
    for (const LabelHeight& h : n.heights) {
      if (h.label == label) return h.z;
    }
    return fallback;
  };
  const Vec2 middle = p + s * chord, across(-chord.y(), chord.x());
  double t = 0, z = 0;
  if (curve.type == CurveType::kOutline) {
    if (!outline_on_line(surface, middle, across, t, z)) return false;
  } else if (curve.type == CurveType::kMeet) {
    const Label own = left != kNoLabel && curve.is_height_of(solver.ref_of(left)) ? left : right;
    const double za = height_at(a, own, 0);
    z = za + s * (height_at(b, own, za) - za);
  } else {
    z = solver.shadow_height(curve, middle.x(), middle.y());
  }
  if (curve.type != CurveType::kOutline && !solver.on_line(curve, middle, across, t, z))
    return false;
  if (!(std::fabs(t) <= 0.75)) return false;
  node = PlanNode{};
  node.x = middle.x() + t * across.x();
  node.y = middle.y() + t * across.y();
  for (const Label label : {left, right}) {
    if (label == kNoLabel) continue;
    double own = z;
    const bool on_curve = curve.is_height_of(solver.ref_of(label));
    if (!on_curve && !solver.height(label, node.x, node.y, own)) own = height_at(a, label, z);
    node.heights.push_back({label, own});
  }
  if (node.heights.size() == 2) {  // a wall too low to be one
    LabelHeight &l = node.heights[0], &r = node.heights[1];
    if (std::fabs(l.z - r.z) <= 1e-9 * surface.size) {
      const bool left_is = curve.is_height_of(solver.ref_of(l.label));
      (left_is ? r.z : l.z) = left_is ? l.z : r.z;
    }
  }
  return true;
}

double least_cell(double longer_side, double tolerance) {
  // Half of it: what two of them make up may be joined as one, too.
  return std::clamp(0.5 * kUnseen * tolerance, std::ldexp(longer_side, -28),
                    std::ldexp(longer_side, -22));
}

Result<Arrangement> arrange(const CompoundSurface& compound, const PlanBox& domain,
                            const ArrangementOptions& asked) {
  const Impl& surface = compound.impl();
  ArrangementOptions options = asked;
  const double longer = std::fmax(domain.x1 - domain.x0, domain.y1 - domain.y0);
  if (!(options.least > 0)) options.least = least_cell(longer, options.tolerance);
  const bool tiled = std::ranges::any_of(options.seams, [](const Seam* s) { return s != nullptr; });
  const double inset = border_inset(surface, tiled ? 0 : options.variant);
  const auto off = [&](std::size_t side) { return options.seams[side] == nullptr ? inset : 0; };
  const PlanBox inner{domain.x0 + off(3), domain.x1 - off(1), domain.y0 + off(0),
                      domain.y1 - off(2)};
  TreeLimits limits;
  limits.least = options.least;
  if (!(options.flat > 0)) options.flat = flat_height(surface, options.tolerance);
  limits.flat = options.flat;
  limits.variant = options.variant;
  limits.most_cells = options.most_cells;
  limits.may_widen = options.may_widen;
  limits.most_of_a_seed = options.budget.cells;
  limits.threads = options.threads;
  CellTree tree(surface, inner, limits);
  const Error too_fine{ErrorCode::kLimit,
                       "the surface has more detail than " + std::to_string(options.most_cells) +
                           " cells of the plan can part",
                       {surface.program.file}};
  const bool widened = tree.widened;
  if (widened) {
    const auto corners = std::ranges::count(tree.cells, CellKind::kCorner, &TreeCell::kind);
    if (static_cast<std::size_t>(corners) > kMostCornersWidened) return too_fine;
  }
  CellGraph graph = make_graph(surface, tree, options);
  if (tree.stopped) return too_fine;
  Arrangement out;
  out.box = domain;
  out.widened = widened;
  out.keeps_seams = graph.keeps_seams;
  out.uncertified_area = graph.uncertified_area;
  out.uncertified_place = graph.uncertified_place;
  out.cells = tree.cells.size();
  if (!out.keeps_seams) return out;
  for (const TreeCell& c : tree.cells) out.least_cells += c.kind == CellKind::kLeast ? 1u : 0u;
  ArcMaker(surface, graph, border_stops(surface, graph, domain, inner, options.seams),
           options.seams, out)
      .make();
  bool any = false;
  for (const PlanRegion& region : out.regions) any = any || region.label != kNoLabel;
  if (!any) {
    return Error{ErrorCode::kInput,
                 "no vertical line of the domain meets the surface: nothing to tessellate",
                 {surface.program.file}};
  }
  return out;
}

}  // namespace diesink
