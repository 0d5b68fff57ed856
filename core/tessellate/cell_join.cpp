// What the borders of one cell show, joined inside it: in pairs, or in a corner.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/tessellate/graph_maker.h"

namespace diesink::cells {

void GraphMaker::link(std::uint32_t from, std::uint32_t to, Label left, Label right,
                      const PlanCurve& curve) {
  const auto id = static_cast<std::uint32_t>(graph_.links.size());
  graph_.links.push_back({from, to, left, right, curve});
  graph_.nodes[from].links.push_back(id);
  graph_.nodes[to].links.push_back(id);
}

namespace {

bool matches(const Item& a, const Item& b) { return a.before == b.after && a.after == b.before; }

}  // namespace

// Whether a curve that comes in and goes out on one side of a cell does not do so the other way
// round: outside it between the two, as a line does that touches the domain's border.
bool GraphMaker::runs_inside(const PlanBox& box, const Item& in, const Item& out) const {
  if (in.side != out.side) return true;
  const GraphNode &a = graph_.nodes[in.node], &b = graph_.nodes[out.node];
  const auto plan_node = [](const GraphNode& n) {
    PlanNode node;
    node.x = n.x;
    node.y = n.y;
    node.heights = n.heights;
    return node;
  };
  PlanNode middle;
  if (!point_on_stretch(surface_, solver_, a.curve, in.before, in.after, plan_node(a), plan_node(b),
                        0.5, middle)) {
    return true;
  }
  switch (in.side) {
    case 0:
      return middle.y >= box.y0;
    case 1:
      return middle.x <= box.x1;
    case 2:
      return middle.y <= box.y1;
    default:
      return middle.x >= box.x0;
  }
}

// Of a conic that runs through the cell twice, the branch that each change lies on: -1 or 1; 0 of
// other lines.
std::vector<int> GraphMaker::branches(const CellInfo& info, const std::vector<Item>& items) const {
  std::vector<int> all(items.size(), 0);
  if (!info.branched) return all;
  CellVerdict verdict;
  std::vector<std::uint32_t> steps = info.steps;
  const CellBox box = CellBox::of(cell(info.cell).box);
  classify(surface_, vertices_, box, steps, options_.flat, verdict);
  for (const PlanFunction& f : verdict.functions) {
    if (f.two == TwoGraphs::kNo) continue;
    for (std::size_t k = 0; k < items.size(); ++k) {
      const Item& item = items[k];
      if (!((item.before == f.a && item.after == f.b) || (item.before == f.b && item.after == f.a)))
        continue;
      // The derivative along the rows has one sign on each branch.
      const double x = graph_.nodes[item.node].x - box.x, y = graph_.nodes[item.node].y - box.y;
      const double slope = f.two == TwoGraphs::kOverY ? f.cgx + f.hxx * x + f.hxy * y
                                                      : f.cgy + f.hxy * x + f.hyy * y;
      all[k] = slope < 0 ? -1 : 1;
    }
  }
  return all;
}

// Joins changes two by two without crossings; false (and nothing done) where they do not pair up.
bool GraphMaker::join_pairs(const CellInfo& info, const std::vector<Item>& items, bool by_curve) {
  const std::size_t n = items.size();
  if (n % 2 != 0) return false;
  std::vector<std::size_t> mate(n, n);
  if (by_curve) {
    const std::vector<int> branch = branches(info, items);
    for (std::size_t i = 0; i < n; ++i) {
      // Two that were found by halving alone need not be of one curve.
      if (graph_.nodes[items[i].node].curve.type == CurveType::kUnsolved) return false;
      for (std::size_t j = 0; j < n; ++j) {
        if (i == j || branch[i] != branch[j] || !matches(items[i], items[j])) continue;
        if (!graph_.nodes[items[i].node].curve.same_as(graph_.nodes[items[j].node].curve)) continue;
        if (mate[i] != n) return false;  // not unique
        mate[i] = j;
      }
      if (mate[i] == n) return false;
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (mate[mate[i]] != i) return false;
      for (std::size_t j = i + 1; j < mate[i]; ++j) {  // chords must not cross
        if (mate[j] < i || mate[j] > mate[i]) return false;
      }
      if (mate[i] > i && !runs_inside(cell(info.cell).box, items[i], items[mate[i]])) return false;
    }
  } else {
    std::vector<std::size_t> order(n);
    for (std::size_t i = 0; i < n; ++i) order[i] = i;
    const bool by_y = info.sorted_by_y;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
      const GraphNode &a = graph_.nodes[items[i].node], &b = graph_.nodes[items[j].node];
      return by_y ? a.y < b.y : a.x < b.x;
    });
    for (std::size_t k = 0; k < n; k += 2) {
      if (!matches(items[order[k]], items[order[k + 1]])) return false;
      if (!graph_.nodes[items[order[k]].node].curve.same_as(
              graph_.nodes[items[order[k + 1]].node].curve))
        return false;
      mate[order[k]] = order[k + 1];
      mate[order[k + 1]] = order[k];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (mate[i] > i) {
      link(items[i].node, items[mate[i]].node, items[i].before, items[i].after,
           graph_.nodes[items[i].node].curve);
    }
  }
  return true;
}

std::uint32_t GraphMaker::add_corner(const std::vector<Item>& items, const Vec2& at,
                                     const PlanCurve* one, const PlanCurve* two, double z1,
                                     double z2, const Vec3* vertex) {
  GraphNode node;
  node.corner = true;
  node.x = at.x();
  node.y = at.y();
  node.solved = one != nullptr || vertex != nullptr;
  const double close = 1e-9 * surface_.size;
  for (const Item& item : items) {
    const Label label = item.after;
    if (label == kNoLabel) continue;
    const SurfaceRef ref = solver_.ref_of(label);
    double z = 0;
    bool known = false;
    if (one != nullptr && one->is_height_of(ref)) {
      z = z1;
      known = true;
    } else if (two != nullptr && two->is_height_of(ref)) {
      z = z2;
      known = true;
    } else {
      known = solver_.height(label, at.x(), at.y(), z);
      // A vertex that lies on the face is its height there: beside a silhouette a root is not.
      if (vertex != nullptr && std::fabs(solver_.implicit(ref).value(*vertex)) <= close) {
        z = vertex->z();
        known = true;
      }
    }
    // On a silhouette the root is half-precise; its double root is not. (Nor is a height that the
    // corner's curves were solved for, unless both are ends of bodies, which ask for no height.)
    const bool solved_for = known && one != nullptr &&
                            (one->type == CurveType::kMeet || two->type == CurveType::kMeet) &&
                            (one->is_height_of(ref) || two->is_height_of(ref));
    double zs = 0;
    if (!solved_for && solver_.silhouette_height(label, at.x(), at.y(), zs) &&
        (!known || std::fabs(zs - z) <= 1e-6 * surface_.size)) {
      z = zs;
      known = true;
    }
    if (!known) {
      // The face does not reach the point by rounding: take the nearest change that knows it.
      for (const LabelHeight& h : graph_.nodes[item.node].heights) {
        if (h.label == label) z = h.z;
      }
    }
    bool seen = false;
    for (const LabelHeight& h : node.heights) seen = seen || h.label == label;
    if (!seen) node.heights.push_back({label, z});
  }
  join_heights(node.heights, close);
  const auto id = static_cast<std::uint32_t>(graph_.nodes.size());
  graph_.nodes.push_back(std::move(node));
  for (const Item& item : items) {
    // Seen from the corner outwards: the label behind the item (anticlockwise before it) is on the
    // right.
    link(id, item.node, item.after, item.before, graph_.nodes[item.node].curve);
  }
  return id;
}

// Every function that may part labels in the cell vanishes at p: nothing hides beside it.
bool GraphMaker::is_star_centre(const CellInfo& info, const TreeCell& c, const Vec2& p) const {
  CellVerdict all, here;
  std::vector<std::uint32_t> steps = info.steps;
  classify(surface_, vertices_, CellBox::of(c.box), steps, options_.flat, all);
  const double near = 64 * surface_.tie;  // what lies apart by less is one
  steps = info.steps;
  classify(surface_, vertices_, {p.x(), p.y(), near, near}, steps, options_.flat, here);
  if (here.functions.full || here.candidates.full) return false;
  for (const PlanFunction& f : all.functions) {
    bool found = false;
    for (const PlanFunction& g : here.functions) {
      found = found ||
              (f.kind == g.kind && f.solid == g.solid && f.id == g.id && f.a == g.a && f.b == g.b);
    }
    if (!found) return false;
  }
  return true;
}

bool GraphMaker::join_corner(const CellInfo& info, const TreeCell& c,
                             const std::vector<Item>& items) {
  const PlanBox& b = c.box;
  const bool least = c.kind == CellKind::kLeast;
  const double margin = (least ? 1.0 : 1e-6) * std::fmax(b.x1 - b.x0, b.y1 - b.y0);
  // Beyond the cell by rounding; beyond the domain no farther than what counts as its border.
  const PlanBox &low = cell(tree_.roots.front()).box, &high = cell(tree_.roots.back()).box;
  const double near = std::fmin(margin, 64 * surface_.tie);
  const auto within = [&](const Vec2& p) {
    return p.x() >= b.x0 - (b.x0 > low.x0 ? margin : near) &&
           p.x() <= b.x1 + (b.x1 < high.x1 ? margin : near) &&
           p.y() >= b.y0 - (b.y0 > low.y0 ? margin : near) &&
           p.y() <= b.y1 + (b.y1 < high.y1 ? margin : near);
  };
  const auto seen = [&](const PlanCurve& curve, const Vec2& p, double z) {
    for (const Item& item : items) {
      if (item.after == kNoLabel) continue;
      const SurfaceRef ref = solver_.ref_of(item.after);
      if (curve.is_height_of(ref) && !solver_.on_sheet(item.after, p, z)) return false;
    }
    return true;
  };
  // A corner is one only if every curve that comes in runs through it. (The least cells of all
  // cannot choose.)
  const bool chooses = !least || parts_corners(c, items);
  const double off = 1e-9 * surface_.size;
  const auto own_height = [&](const GraphNode& node) {
    const SurfaceRef& r = node.curve.first;
    for (const LabelHeight& h : node.heights) {
      if (solver_.ref_of(h.label) == r) return h.z;
    }
    // The end of a body that neither label belongs to.
    if (node.curve.type == CurveType::kShadow)
      return solver_.shadow_height(node.curve, node.x, node.y);
    return node.heights.empty() ? 0.0 : node.heights.front().z;
  };
  const auto runs_through_all = [&](const Vec2& p) {
    for (const Item& item : items) {
      const GraphNode& node = graph_.nodes[item.node];
      const Vec2 along = p - Vec2(node.x, node.y);
      const double length = along.norm();
      if (!(length > 1e-9 * surface_.size)) continue;
      const Vec2 across(-along.y() / length, along.x() / length);
      double t = 0, z = own_height(node);
      if (!solver_.on_line(node.curve, p, across, t, z))
        continue;  // tangent there: no word against it
      if (std::fabs(t) > off && (least || std::fabs(t) < length)) return false;
    }
    return true;
  };
  // A line that leaves the cell and comes back has stretches that do not end in the corner; of one
  // without an equation nothing says that it runs through a point.
  if (!least) {
    for (const Item& one : items) {
      if (graph_.nodes[one.node].curve.type == CurveType::kUnsolved) return false;
      const auto same = std::count_if(items.begin(), items.end(), [&](const Item& other) {
        return graph_.nodes[one.node].curve.same_as(graph_.nodes[other.node].curve);
      });
      if (same > 2) return false;
    }
  }
  if (info.has_vertex) {
    if (chooses && !runs_through_all(info.vertex.head<2>())) return false;
    add_corner(items, info.vertex.head<2>(), nullptr, nullptr, 0, 0, &info.vertex);
    return true;
  }
  Vec2 middle = Vec2::Zero();
  for (const Item& item : items)
    middle += Vec2(graph_.nodes[item.node].x, graph_.nodes[item.node].y);
  middle /= static_cast<double>(items.size());
  // Curves that cross tell the corner best; those that run along one another (a silhouette flush
  // with a wall) only where no others do.
  for (const bool crossing : {true, false}) {
    for (std::size_t i = 0; i < items.size(); ++i) {
      for (std::size_t j = i + 1; j < items.size(); ++j) {
        const GraphNode &m = graph_.nodes[items[i].node], &n = graph_.nodes[items[j].node];
        if (m.curve.same_as(n.curve)) continue;
        Vec2 at = middle;
        double z1 = own_height(m), z2 = own_height(n);
        const PlanCurve one = m.curve, two = n.curve;
        if (!solver_.corner(one, two, at, z1, z2) || !within(at)) continue;
        if (solver_.cross_at(one, two, at, z1, z2) != crossing) continue;
        // The other sheet of a side is not the corner that is seen.
        if (!seen(one, at, z1) || !seen(two, at, z2)) continue;
        if (chooses && !runs_through_all(at)) continue;
        if (!least && info.star && !is_star_centre(info, c, at)) continue;
        if (least) {
          // Tiny cells lie on the corner; their own box is the better bound.
          at.x() = std::clamp(at.x(), b.x0 - margin, b.x1 + margin);
          at.y() = std::clamp(at.y(), b.y0 - margin, b.y1 + margin);
        }
        add_corner(items, at, &one, &two, z1, z2, nullptr);
        return true;
      }
    }
  }
  if (!least) return false;
  // One crease alone, come in from more than two sides: it crosses itself. (Where it comes in
  // beside a corner of the cell it may have been found by halving alone: as flat as it is there, a
  // tie is far longer in plan.)
  const Item* on = nullptr;
  bool alone = items.size() > 2;
  for (const Item& item : items) {
    const PlanCurve& curve = graph_.nodes[item.node].curve;
    if (curve.type == CurveType::kUnsolved) {
      alone = alone && (matches(item, items[0]) ||
                        (item.before == items[0].before && item.after == items[0].after));
    } else {
      alone = alone && (on == nullptr || curve.same_as(graph_.nodes[on->node].curve));
      on = &item;
    }
  }
  if (alone && on != nullptr) {
    const PlanCurve crease = graph_.nodes[on->node].curve;
    Vec2 at = middle;
    double z = own_height(graph_.nodes[on->node]);
    if (solver_.double_point(crease, at, z) && within(at) && seen(crease, at, z)) {
      add_corner(items, at, &crease, &crease, z, z, nullptr);
      return true;
    }
  }
  if (chooses) return false;
  add_corner(items, middle, nullptr, nullptr, 0, 0, nullptr);
  return true;
}

void GraphMaker::join(std::int32_t i, const std::vector<OnBorder>& found) {
  const CellInfo& info = tree_.infos[static_cast<std::size_t>(i)];
  const TreeCell c = cell(info.cell);
  std::vector<Item> items;
  for (const OnBorder& f : found) {
    const GraphNode& n = graph_.nodes[f.node];
    const double w = c.box.x1 - c.box.x0, h = c.box.y1 - c.box.y0;
    Item item;
    item.node = f.node;
    item.side = f.side;
    const bool ahead = f.side == 0 || f.side == 1;  // the way round goes with the coordinate
    item.before = ahead ? n.low : n.high;
    item.after = ahead ? n.high : n.low;
    switch (f.side) {
      case 0:
        item.position = n.x - c.box.x0;
        break;
      case 1:
        item.position = w + (n.y - c.box.y0);
        break;
      case 2:
        item.position = w + h + (c.box.x1 - n.x);
        break;
      default:
        item.position = 2 * w + h + (c.box.y1 - n.y);
        break;
    }
    items.push_back(item);
  }
  // Changes at one place keep the order in which the segment was searched, upwards.
  std::stable_sort(items.begin(), items.end(),
                   [](const Item& a, const Item& b) { return a.position < b.position; });
  for (std::size_t k = 0; k + 1 < items.size(); ++k) {
    if (items[k].after != items[k + 1].before && items[k].position == items[k + 1].position &&
        items[k + 1].after == items[k].before) {
      std::swap(items[k], items[k + 1]);
    }
  }
  bool round = true;
  for (std::size_t k = 0; k < items.size(); ++k) {
    round = round && items[k].after == items[(k + 1) % items.size()].before;
  }
  const bool least = c.kind == CellKind::kLeast;
  if (least) {
    const double width = std::fmax(c.box.x1 - c.box.x0, c.box.y1 - c.box.y0);
    // A least cell is harmless where nothing in it is farther from its corner than the tolerance
    // sees.
    if (width > kUnseen * options_.tolerance) {
      if (info.depth > 0.25 * options_.tolerance) {
        tell((c.box.x1 - c.box.x0) * (c.box.y1 - c.box.y0), {c.box.x0, c.box.y0});
      }
    }
  }
  if (items.empty()) {
    // Three lines may close round something that no border tells of.
    if (info.star && !least) to_split_.push_back(info.cell);
    return;
  }
  bool done = false;
  if (round) {
    if (c.kind == CellKind::kArc) {
      done = join_pairs(info, items, false) || (items.size() == 2 && join_corner(info, c, items));
    } else if (info.has_vertex || (info.star && !least)) {
      done = join_corner(info, c, items);
    } else {
      done = join_pairs(info, items, true) ||
             (!(least && goes_deeper(info, c, items)) && !(info.branched && !least) &&
              join_corner(info, c, items));
    }
  } else if (least && !goes_deeper(info, c, items)) {
    done = join_corner(info, c, items);
  }
  if (!done) to_split_.push_back(info.cell);
}

}  // namespace diesink::cells
