// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/border_stops.h"

#include <algorithm>
#include <cmath>

#include "core/tessellate/draw_together.h"
#include "core/tessellate/outline.h"
#include "core/tessellate/plan_curve.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// Of the size: what lies no farther apart along the border is one stop. A corner on the border
// shows there in a node for each of its curves, as far apart as these part in the 64 ties
// (border_inset) between the border and where the cells end: this is 27 times as much, enough for
// curves that meet the border at two degrees. Of a vertex's 1e-9 it takes less than half.
constexpr double kNear = 4e-10;

// Of the size: how far a stop may slide along the border, from where its curve leaves the cells to
// where it meets the border. Enough for curves that meet it at an eighth of a degree.
constexpr double kFarthest = 6e-9;

// How much farther off than in plan what has been seen of an apex may be in height: of rulings as
// steep as this.
constexpr double kAside = 1000;

class StopFinder {
 public:
  StopFinder(const Impl& surface, CellGraph& graph, const PlanBox& domain, const PlanBox& inner,
             const std::array<const Seam*, 4>& seams)
      : surface_(surface),
        solver_(surface),
        graph_(graph),
        domain_(domain),
        inner_(inner),
        seams_(seams) {}

  std::vector<BorderStop> find();

 private:
  [[nodiscard]] Vec2 on_border(const GraphNode& node) const;
  [[nodiscard]] BorderStop stop_at_node(std::uint32_t g) const;
  [[nodiscard]] BorderStop stop_at_corner(std::uint8_t k) const;
  [[nodiscard]] bool on_seam(const BorderStop& stop) const;
  BorderStop join(std::vector<BorderStop>& group);
  void draw_to_apex(BorderStop& stop, double most) const;
  void slide(BorderStop& stop, double most) const;
  void unlink(const std::vector<std::uint32_t>& nodes);

  [[nodiscard]] double width() const { return domain_.x1 - domain_.x0; }
  [[nodiscard]] double height() const { return domain_.y1 - domain_.y0; }

  const Impl& surface_;
  CurveSolver solver_;
  CellGraph& graph_;
  const PlanBox& domain_;
  const PlanBox& inner_;
  const std::array<const Seam*, 4>& seams_;
};

// The cells end a hair inside the domain, so that what only touches the border from outside is not
// seen.
Vec2 StopFinder::on_border(const GraphNode& node) const {
  Vec2 at(node.x, node.y);
  if (node.x == inner_.x0) at.x() = domain_.x0;
  if (node.x == inner_.x1) at.x() = domain_.x1;
  if (node.y == inner_.y0) at.y() = domain_.y0;
  if (node.y == inner_.y1) at.y() = domain_.y1;
  return at;
}

BorderStop StopFinder::stop_at_node(std::uint32_t g) const {
  const GraphNode& from = graph_.nodes[g];
  const Vec2 at = on_border(from);
  BorderStop stop;
  stop.side = static_cast<std::uint8_t>(from.side);
  switch (stop.side) {
    case 0:
      stop.along = at.x() - domain_.x0;
      break;
    case 1:
      stop.along = width() + at.y() - domain_.y0;
      break;
    case 2:
      stop.along = width() + height() + domain_.x1 - at.x();
      break;
    default:
      stop.along = 2 * width() + height() + domain_.y1 - at.y();
      break;
  }
  const bool ahead = stop.side < 2;  // the way goes with the coordinate
  stop.before = ahead ? from.low : from.high;
  stop.after = ahead ? from.high : from.low;
  stop.graph = {g};
  stop.node.x = at.x();
  stop.node.y = at.y();
  stop.node.heights = from.heights;
  stop.node.corner = from.corner;
  stop.node.border = true;
  stop.node.seam = seams_[stop.side] != nullptr;
  stop.node.solved = from.solved;
  return stop;
}

// What was found where the cells end goes on along its curve to the border itself, by `most` at
// most.
void StopFinder::slide(BorderStop& stop, double most) const {
  if (stop.graph.size() != 1 || stop.node.corner || stop.node.seam) return;
  const PlanCurve& curve = graph_.nodes[stop.graph.front()].curve;
  PlanNode& node = stop.node;
  const auto is_own = [&](const LabelHeight& h) {
    return curve.is_height_of(solver_.ref_of(h.label));
  };
  const auto own = std::ranges::find_if(node.heights, is_own);
  const bool known = own != node.heights.end();
  const bool outline = curve.type == CurveType::kOutline;
  if (!known && curve.type != CurveType::kShadow && !outline) return;
  if (outline && std::holds_alternative<ScannedSurface>(surface_.base)) return;
  const Vec2 at(node.x, node.y), unit = stop.side % 2 == 0 ? Vec2::UnitX() : Vec2::UnitY();
  const Vec2 way = most * unit;
  double z0 = known ? own->z : 0;
  if (!known && !outline) z0 = solver_.shadow_height(curve, at.x(), at.y());
  constexpr double kHigher = 1e-7;  // of the size: beside a silhouette heights change by a root
  double t = 0, z = z0;
  const bool found =
      outline ? outline_on_line(surface_, at, way, t, z) : solver_.on_line(curve, at, way, t, z);
  if (!found || !(std::fabs(t) <= 1)) return;
  if ((known || !outline) && !(std::fabs(z - z0) <= kHigher * surface_.size)) return;
  node.x += t * way.x();
  node.y += t * way.y();
  stop.along += (stop.side < 2 ? t : -t) * most;
  for (LabelHeight& h : node.heights) {
    double beside = 0;
    if (is_own(h) || (known && h.z == z0)) {
      h.z = z;
    } else if (solver_.height(h.label, node.x, node.y, beside) &&
               std::fabs(beside - h.z) <= kHigher * surface_.size) {
      h.z = beside;
    }
  }
  join_heights(node.heights, 1e-9 * surface_.size);
}

// Where a cone's apex lies on the border the cells have seen its rulings a hair beside it: what is
// found of them there is the apex, if it is no farther along than `most`.
void StopFinder::draw_to_apex(BorderStop& stop, double most) const {
  PlanNode& node = stop.node;
  if (stop.graph.empty() || node.seam) return;
  const double near = kNear * surface_.size;
  for (const LabelHeight& shown : node.heights) {
    const SurfaceRef ref = solver_.ref_of(shown.label);
    if (ref.solid < 0 || ref.face != kFaceSide) continue;
    const BodyLine& line = surface_.bodies[static_cast<std::size_t>(ref.solid)];
    const auto* body = std::get_if<QuadricBody>(&line.body());
    if (body == nullptr || body->shape != QuadricShape::kCone) continue;
    const Vec3 apex = body->p + body->C * body->frame.row(2).transpose();
    const bool upright = stop.side % 2 == 1;
    const double across = upright ? apex.x() - node.x : apex.y() - node.y;
    const double along = upright ? apex.y() - node.y : apex.x() - node.x;
    if (!(std::fabs(across) <= 4 * surface_.tie && std::fabs(along) <= std::fmin(near, most)))
      continue;
    (upright ? node.y : node.x) += along;
    stop.along += stop.side < 2 ? along : -along;
    for (LabelHeight& h : node.heights) {
      const Implicit face = solver_.implicit(solver_.ref_of(h.label));
      double z = 0;
      if (std::fabs(face.value(apex)) <= near && std::fabs(h.z - apex.z()) <= kAside * near) {
        h.z = apex.z();
      } else if (solver_.height(h.label, node.x, node.y, z)) {
        h.z = z;
      }
    }
    return;
  }
}

// Corner k is where side k begins.
BorderStop StopFinder::stop_at_corner(std::uint8_t k) const {
  const bool right = k == 1 || k == 2, top = k >= 2;
  const double along[4] = {0, width(), width() + height(), 2 * width() + height()};
  const LineState state =
      surface_.evaluate_face(right ? inner_.x1 : inner_.x0, top ? inner_.y1 : inner_.y0);
  BorderStop stop;
  stop.along = along[k];
  stop.side = k;
  stop.before = stop.after = state.label;
  stop.node.x = right ? domain_.x1 : domain_.x0;
  stop.node.y = top ? domain_.y1 : domain_.y0;
  stop.node.border = stop.node.corner = true;
  stop.node.seam = on_seam(stop);
  if (state.label != kNoLabel) stop.node.heights.push_back({state.label, state.z});
  return stop;
}

bool StopFinder::on_seam(const BorderStop& stop) const {
  const bool corner = stop.graph.empty();
  return seams_[stop.side] != nullptr || (corner && seams_[(stop.side + 3u) % 4u] != nullptr);
}

// What runs from one of the nodes to another and nowhere else is nothing.
void StopFinder::unlink(const std::vector<std::uint32_t>& nodes) {
  const auto is_own = [&](std::uint32_t g) { return std::ranges::find(nodes, g) != nodes.end(); };
  for (const std::uint32_t g : nodes) {
    for (const std::uint32_t l : graph_.nodes[g].links) {
      GraphLink& link = graph_.links[l];
      link.gone = link.gone || (is_own(link.from) && is_own(link.to));
    }
    std::erase_if(graph_.nodes[g].links, [&](std::uint32_t l) { return graph_.links[l].gone; });
  }
}

BorderStop StopFinder::join(std::vector<BorderStop>& group) {
  if (group.size() == 1) return std::move(group.front());
  const auto is_corner = [](const BorderStop& stop) { return stop.graph.empty(); };
  const auto corner = std::ranges::find_if(group, is_corner);
  const bool has_corner = corner != group.end();
  // The corner of the domain is what is known best; then a corner that was solved for.
  auto best = corner;
  if (!has_corner) {
    best = std::ranges::find_if(group, [](const BorderStop& stop) { return stop.node.corner; });
    if (best == group.end()) best = group.begin();
  }
  BorderStop joined;
  joined.along = best->along;
  joined.side = best->side;
  joined.node = best->node;
  if (has_corner) joined.node.heights.clear();  // at a tie it may name what nothing beside it does
  joined.node.corner = true;
  bool first = true;
  for (const BorderStop& stop : group) {
    if (stop.graph.empty()) continue;
    if (first) joined.before = stop.before;
    first = false;
    joined.after = stop.after;
    joined.graph.insert(joined.graph.end(), stop.graph.begin(), stop.graph.end());
    for (const LabelHeight& h : stop.node.heights) {
      const bool known = std::ranges::any_of(
          joined.node.heights, [&](const LabelHeight& o) { return o.label == h.label; });
      if (!known) joined.node.heights.push_back(h);
    }
  }
  join_heights(joined.node.heights, 1e-9 * surface_.size);
  unlink(joined.graph);
  return joined;
}

std::vector<BorderStop> StopFinder::find() {
  std::vector<BorderStop> single;
  for (std::uint32_t g = 0; g < graph_.nodes.size(); ++g) {
    if (graph_.nodes[g].border) single.push_back(stop_at_node(g));
  }
  for (std::uint8_t k = 0; k < 4; ++k) single.push_back(stop_at_corner(k));
  const auto earlier = [](const BorderStop& a, const BorderStop& b) { return a.along < b.along; };
  std::stable_sort(single.begin(), single.end(), earlier);
  // (On a cut between tiles nothing moves: the other tile does not know.)
  const double near = kNear * surface_.size, round = 2 * (width() + height());
  const auto is_near = [&](const BorderStop& a, const BorderStop& b) {
    const double gap = b.along - a.along;
    return (gap < 0 ? gap + round : gap) <= near && !on_seam(a) && !on_seam(b);
  };
  // From behind a gap on, so that no group is parted at the lower left corner.
  const std::size_t n = single.size();
  std::size_t start = 0;
  while (start < n && is_near(single[(start + n - 1) % n], single[start])) ++start;
  std::rotate(single.begin(), single.begin() + static_cast<std::ptrdiff_t>(start % n),
              single.end());
  std::vector<BorderStop> stops, group;
  for (BorderStop& stop : single) {
    if (!group.empty() && !is_near(group.back(), stop)) {
      stops.push_back(join(group));
      group.clear();
    }
    group.push_back(std::move(stop));
  }
  stops.push_back(join(group));
  std::stable_sort(stops.begin(), stops.end(), earlier);
  // No farther than leaves each between its neighbours.
  std::vector<double> gap(stops.size());
  for (std::size_t k = 0; k < stops.size(); ++k) {
    const double ahead = stops[(k + 1) % stops.size()].along - stops[k].along;
    gap[k] = ahead < 0 ? ahead + round : ahead;
  }
  for (std::size_t k = 0; k < stops.size(); ++k) {
    const double beside = std::fmin(gap[k], gap[(k + stops.size() - 1) % stops.size()]);
    slide(stops[k], std::fmin(kFarthest * surface_.size, 0.49 * beside));
    draw_to_apex(stops[k], 0.49 * beside);
  }
  return stops;
}

}  // namespace

// A corner that lies on the border but for a tie, and the changes on the border beside it, are one
// node there: what is between them is nothing.
void pull_to_border(const Impl& surface, const ArrangementOptions& options, CellGraph& graph) {
  const double near = 64 * surface.tie;
  // How far outside the corner of curves that touch may come out (kDoubleRoot).
  const double rounding = kDoubleRoot * surface.size;
  // What touches the border in the corner is as wide as this where the cells end, with any radius
  // up to the size.
  const double inset = border_inset(surface, options.variant);
  const double touch = 2 * std::sqrt(2 * inset * surface.size);
  for (std::uint32_t c = 0; c < graph.nodes.size(); ++c) {
    if (!graph.nodes[c].corner || graph.nodes[c].links.empty()) continue;
    std::vector<std::uint32_t>& links = graph.nodes[c].links;
    const auto other_end = [&](std::uint32_t l) {
      return graph.links[l].from == c ? graph.links[l].to : graph.links[l].from;
    };
    // On the border a hair from the corner, and nothing else hangs on it.
    const auto is_beside = [&](std::uint32_t l) {
      const GraphNode &n = graph.nodes[other_end(l)], &corner = graph.nodes[c];
      // (On a cut between tiles nothing moves: the other tile does not know.)
      if (n.side >= 0 && options.seams[static_cast<std::size_t>(n.side)] != nullptr) return false;
      if (!n.border || n.links.size() != 1) return false;
      const double dx = std::fabs(n.x - corner.x), dy = std::fabs(n.y - corner.y);
      const bool upright = n.side == 1 || n.side == 3;
      const bool outside = n.side == 0   ? corner.y < n.y
                           : n.side == 1 ? corner.x > n.x
                           : n.side == 2 ? corner.y > n.y
                                         : corner.x < n.x;
      return (upright ? dx : dy) <= (outside ? rounding : near) && (upright ? dy : dx) <= touch;
    };
    const auto count =
        static_cast<std::size_t>(std::count_if(links.begin(), links.end(), is_beside));
    if (count == 0 || count == links.size()) continue;
    // One after another in the order round the corner, on one side of the domain.
    while (!is_beside(links.front()) || is_beside(links.back()))
      std::rotate(links.begin(), links.begin() + 1, links.end());
    const GraphNode first = graph.nodes[other_end(links.front())];
    const bool upright = first.side == 1 || first.side == 3;
    const auto along = [&](const GraphNode& of) { return upright ? of.y : of.x; };
    bool one_side = true;
    GraphNode low = first, high = first;
    for (std::size_t k = 0; k < count; ++k) {
      const GraphNode& n = graph.nodes[other_end(links[k])];
      one_side = one_side && is_beside(links[k]) && n.side == first.side;
      if (along(n) < along(low)) low = n;
      if (along(n) > along(high)) high = n;
    }
    if (!one_side) continue;
    for (std::size_t k = 0; k < count; ++k) {
      GraphNode& gone = graph.nodes[other_end(links[k])];
      gone.links.clear();
      gone.border = false;
      graph.links[links[k]].gone = true;
    }
    links.erase(links.begin(), links.begin() + static_cast<std::ptrdiff_t>(count));
    GraphNode& node = graph.nodes[c];
    (upright ? node.x : node.y) = upright ? first.x : first.y;
    node.border = true;
    node.side = first.side;
    node.low = low.low;
    node.high = high.high;
  }
}

std::vector<BorderStop> border_stops(const Impl& surface, CellGraph& graph, const PlanBox& domain,
                                     const PlanBox& inner,
                                     const std::array<const Seam*, 4>& seams) {
  return StopFinder(surface, graph, domain, inner, seams).find();
}

}  // namespace diesink
