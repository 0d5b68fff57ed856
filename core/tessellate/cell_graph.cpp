// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/cell_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <unordered_map>

#include "core/parallel.h"
#include "core/tessellate/border_stops.h"
#include "core/tessellate/draw_together.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// Rounds of splitting after which cells that go on and on spoiling each other are joined as they
// are.
constexpr int kPasses = 200;

// Part of the least cell down to which corners of several heights are parted.
constexpr double kDeeper = 0x1p-6;

// Where a change lies on a cell's border: side 0 bottom, 1 right, 2 top, 3 left.
struct OnBorder {
  std::int32_t info = 0;
  std::uint8_t side = 0;
  std::uint32_t node = 0;
};

// A label change as a cell sees it, going round it anticlockwise.
struct Item {
  double position = 0;  // along the way round
  std::uint8_t side = 0;
  std::uint32_t node = 0;
  Label before = kNoLabel, after = kNoLabel;
};

class GraphMaker {
 public:
  GraphMaker(const Impl& surface, CellTree& tree, const ArrangementOptions& options)
      : surface_(surface),
        tree_(tree),
        options_(options),
        solver_(surface),
        vertices_(body_vertices(surface)),
        line_(surface, vertices_, options.flat, options.least) {}

  CellGraph make();

 private:
  [[nodiscard]] TreeCell& cell(std::int32_t i) { return tree_.cells[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const TreeCell& cell(std::int32_t i) const {
    return tree_.cells[static_cast<std::size_t>(i)];
  }

  void inside(std::int32_t c);
  void beside(std::int32_t a, std::int32_t b, bool upright);
  void on_border(std::int32_t c, std::uint8_t side);
  void segment(std::int32_t a, std::int32_t b, bool upright);
  // A stretch of border between two leaves, or of one on the domain's border.
  struct Stretch {
    std::uint64_t key = 0;
    std::int32_t info = 0;  // whose steps decide it
    Vec2 from, to;
  };
  [[nodiscard]] Stretch border_stretch(std::int32_t c, std::uint8_t side) const;
  [[nodiscard]] Stretch stretch_between(std::int32_t a, std::int32_t b, bool upright) const;
  [[nodiscard]] std::vector<LineChange> search(const Stretch& stretch) const;
  const std::vector<LineChange>& changes_on(const Stretch& stretch);
  void add_node(const LineChange& change);
  void take_seam(std::int32_t c, std::uint8_t side);
  static std::uint64_t pair_key(std::int32_t a, std::int32_t b) {
    return std::uint64_t{static_cast<std::uint32_t>(a)} << 32 | static_cast<std::uint32_t>(b);
  }

  // Leaves with something in them beside a cell, side by side.
  template <class Take>
  void around(std::int32_t c, const Take& take) const;
  template <class Take>
  void leaves_on(std::int32_t in, std::uint8_t side, const PlanBox& box, const Take& take) const;
  void settle_cells();
  bool joins(std::int32_t info, const GraphMaker& known);
  bool split_failed(bool last);
  [[nodiscard]] bool goes_deeper(const CellInfo& info, const TreeCell& c,
                                 const std::vector<Item>& items) const;

  void join(std::int32_t info, const std::vector<OnBorder>& found);
  void link(std::uint32_t from, std::uint32_t to, Label left, Label right, const PlanCurve& curve);
  bool join_pairs(const CellInfo& info, const std::vector<Item>& items, bool by_curve);
  [[nodiscard]] bool runs_inside(const PlanBox& box, const Item& in, const Item& out) const;
  bool join_corner(const CellInfo& info, const TreeCell& cell, const std::vector<Item>& items);
  [[nodiscard]] bool is_star_centre(const CellInfo& info, const TreeCell& cell,
                                    const Vec2& p) const;
  std::uint32_t add_corner(const std::vector<Item>& items, const Vec2& at, const PlanCurve* one,
                           const PlanCurve* two, double z1, double z2, const Vec3* vertex);

  const Impl& surface_;
  CellTree& tree_;
  const ArrangementOptions& options_;
  CurveSolver solver_;
  std::vector<BodyVertices> vertices_;
  ChangeSearch line_;
  CellGraph graph_;
  std::vector<OnBorder> found_;
  std::vector<std::int32_t> to_split_;
  std::uint32_t first_new_ = 0;
  std::size_t seam_changes_ = 0;  // taken into the graph
  bool last_ = false;             // cells are joined as they are
  // What stretches of border between leaves have shown: it does not change as other cells are
  // split.
  std::unordered_map<std::uint64_t, std::vector<LineChange>> known_;
};

const std::vector<LineChange>& GraphMaker::changes_on(const Stretch& stretch) {
  const auto [known, fresh] = known_.try_emplace(stretch.key);
  if (fresh) known->second = search(stretch);
  return known->second;
}

// Both leaves of every stretch of common border, by descent; a plain leaf has no change on its
// border.
void GraphMaker::inside(std::int32_t c) {
  const std::int32_t child = cell(c).child;
  if (child < 0) return;
  for (std::int32_t k = 0; k < 4; ++k) inside(child + k);
  beside(child, child + 1, true);
  beside(child + 2, child + 3, true);
  beside(child, child + 2, false);
  beside(child + 1, child + 3, false);
}

void GraphMaker::beside(std::int32_t a, std::int32_t b, bool upright) {
  const std::int32_t ca = cell(a).child, cb = cell(b).child;
  if ((ca < 0 && cell(a).info < 0) || (cb < 0 && cell(b).info < 0)) return;
  if (ca < 0 && cb < 0) {
    segment(a, b, upright);
    return;
  }
  // Children of a on the common border, and of b.
  const std::int32_t a0 = ca < 0 ? a : upright ? ca + 1 : ca + 2, a1 = ca < 0 ? a : ca + 3;
  const std::int32_t b0 = cb < 0 ? b : cb, b1 = cb < 0 ? b : upright ? cb + 2 : cb + 1;
  beside(a0, b0, upright);
  beside(a1, b1, upright);
}

void GraphMaker::on_border(std::int32_t c, std::uint8_t side) {
  const std::int32_t child = cell(c).child;
  if (child >= 0) {
    static constexpr std::int32_t kOnSide[4][2] = {{0, 1}, {1, 3}, {2, 3}, {0, 2}};
    on_border(child + kOnSide[side][0], side);
    on_border(child + kOnSide[side][1], side);
    return;
  }
  if (cell(c).info < 0) return;
  first_new_ = static_cast<std::uint32_t>(graph_.nodes.size());
  if (options_.seams[side] != nullptr) {
    take_seam(c, side);
  } else {
    for (const LineChange& change : changes_on(border_stretch(c, side))) add_node(change);
  }
  for (std::uint32_t n = first_new_; n < graph_.nodes.size(); ++n) {
    graph_.nodes[n].border = true;
    graph_.nodes[n].side = static_cast<std::int8_t>(side);
    found_.push_back({cell(c).info, side, n});
  }
}

// What changes on a cut between tiles is the seam's to say; each of its points is one cell's.
void GraphMaker::take_seam(std::int32_t c, std::uint8_t side) {
  const Seam& seam = *options_.seams[side];
  const PlanBox& b = cell(c).box;
  const bool upright = side == 1 || side == 3;
  const double low = upright ? b.y0 : b.x0, high = upright ? b.y1 : b.x1;
  const bool last = high >= seam.to;
  auto point = std::lower_bound(seam.points.begin(), seam.points.end(), low,
                                [](const SeamPoint& p, double at) { return p.along < at; });
  for (; point != seam.points.end(); ++point) {
    if (last ? point->along > high : point->along >= high) break;
    if (!point->change) continue;
    add_node({upright ? seam.at : point->along, upright ? point->along : seam.at, point->low,
              point->high, point->curve, point->heights});
    ++seam_changes_;
  }
}

GraphMaker::Stretch GraphMaker::border_stretch(std::int32_t c, std::uint8_t side) const {
  const PlanBox& b = cell(c).box;
  return {pair_key(c, -1 - static_cast<std::int32_t>(side)), cell(c).info,
          Vec2(side == 1 ? b.x1 : b.x0, side == 2 ? b.y1 : b.y0),
          Vec2(side == 3 ? b.x0 : b.x1, side == 0 ? b.y0 : b.y1)};
}

// Between two leaves, the first to the left of or below the other: the smaller one's side; its own
// steps are the fewer.
GraphMaker::Stretch GraphMaker::stretch_between(std::int32_t a, std::int32_t b,
                                                bool upright) const {
  const bool a_smaller = cell(a).level >= cell(b).level;
  const PlanBox& box = cell(a_smaller ? a : b).box;
  Stretch stretch{pair_key(a, b), cell(a_smaller ? a : b).info, Vec2::Zero(), Vec2::Zero()};
  if (upright) {
    const double x = a_smaller ? box.x1 : box.x0;
    stretch.from = Vec2(x, box.y0);
    stretch.to = Vec2(x, box.y1);
  } else {
    const double y = a_smaller ? box.y1 : box.y0;
    stretch.from = Vec2(box.x0, y);
    stretch.to = Vec2(box.x1, y);
  }
  return stretch;
}

void GraphMaker::segment(std::int32_t a, std::int32_t b, bool upright) {
  const std::int32_t ia = cell(a).info, ib = cell(b).info;
  first_new_ = static_cast<std::uint32_t>(graph_.nodes.size());
  for (const LineChange& change : changes_on(stretch_between(a, b, upright))) add_node(change);
  for (std::uint32_t n = first_new_; n < graph_.nodes.size(); ++n) {
    found_.push_back({ia, static_cast<std::uint8_t>(upright ? 1 : 2), n});
    found_.push_back({ib, static_cast<std::uint8_t>(upright ? 3 : 0), n});
  }
}

std::vector<LineChange> GraphMaker::search(const Stretch& stretch) const {
  std::vector<LineChange> changes;
  line_.find(stretch.from, stretch.to, tree_.infos[static_cast<std::size_t>(stretch.info)].steps,
             changes);
  return changes;
}

void GraphMaker::add_node(const LineChange& change) {
  GraphNode node;
  node.x = change.x;
  node.y = change.y;
  node.low = change.low;
  node.high = change.high;
  node.curve = change.curve;
  node.solved = change.curve.type != CurveType::kUnsolved;
  node.heights = change.heights;
  graph_.nodes.push_back(std::move(node));
}

void GraphMaker::link(std::uint32_t from, std::uint32_t to, Label left, Label right,
                      const PlanCurve& curve) {
  const auto id = static_cast<std::uint32_t>(graph_.links.size());
  graph_.links.push_back({from, to, left, right, curve});
  graph_.nodes[from].links.push_back(id);
  graph_.nodes[to].links.push_back(id);
}

bool matches(const Item& a, const Item& b) { return a.before == b.after && a.after == b.before; }

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

// Joins changes two by two without crossings; false (and nothing done) where they do not pair up.
bool GraphMaker::join_pairs(const CellInfo& info, const std::vector<Item>& items, bool by_curve) {
  const std::size_t n = items.size();
  if (n % 2 != 0) return false;
  std::vector<std::size_t> mate(n, n);
  if (by_curve) {
    for (std::size_t i = 0; i < n; ++i) {
      // Two that were found by halving alone need not be of one curve.
      if (graph_.nodes[items[i].node].curve.type == CurveType::kUnsolved) return false;
      for (std::size_t j = 0; j < n; ++j) {
        if (i == j || !matches(items[i], items[j])) continue;
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
  const auto lies_on = [](const PlanCurve& c, const SurfaceRef& r) {
    return c.first == r || (c.type == CurveType::kMeet && c.second == r);
  };
  for (const Item& item : items) {
    const Label label = item.after;
    if (label == kNoLabel) continue;
    const SurfaceRef ref = solver_.ref_of(label);
    double z = 0;
    bool known = false;
    if (one != nullptr && lies_on(*one, ref)) {
      z = z1;
      known = true;
    } else if (two != nullptr && lies_on(*two, ref)) {
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
                            (lies_on(*one, ref) || lies_on(*two, ref));
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
  if (here.functions.full) return false;
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
  const double margin =
      (c.kind == CellKind::kLeast ? 1.0 : 1e-6) * std::fmax(b.x1 - b.x0, b.y1 - b.y0);
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
      const bool on = curve.first == ref || (curve.type == CurveType::kMeet && curve.second == ref);
      if (on && !solver_.on_sheet(item.after, p, z)) return false;
    }
    return true;
  };
  // A corner is one only if every curve that comes in runs through it. (Least cells cannot choose.)
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
      if (std::fabs(t) > 1e-7 * surface_.size && std::fabs(t) < length) return false;
    }
    return true;
  };
  // A line that leaves the cell and comes back has stretches that do not end in the corner; of one
  // without an equation nothing says that it runs through a point.
  if (c.kind != CellKind::kLeast) {
    for (const Item& one : items) {
      if (graph_.nodes[one.node].curve.type == CurveType::kUnsolved) return false;
      const auto same = std::count_if(items.begin(), items.end(), [&](const Item& other) {
        return graph_.nodes[one.node].curve.same_as(graph_.nodes[other.node].curve);
      });
      if (same > 2) return false;
    }
  }
  if (info.has_vertex) {
    if (c.kind != CellKind::kLeast && !runs_through_all(info.vertex.head<2>())) return false;
    add_corner(items, info.vertex.head<2>(), nullptr, nullptr, 0, 0, &info.vertex);
    return true;
  }
  Vec2 middle = Vec2::Zero();
  for (const Item& item : items)
    middle += Vec2(graph_.nodes[item.node].x, graph_.nodes[item.node].y);
  middle /= static_cast<double>(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    for (std::size_t j = i + 1; j < items.size(); ++j) {
      const GraphNode &m = graph_.nodes[items[i].node], &n = graph_.nodes[items[j].node];
      if (m.curve.same_as(n.curve)) continue;
      Vec2 at = middle;
      double z1 = own_height(m), z2 = own_height(n);
      const PlanCurve one = m.curve, two = n.curve;
      if (!solver_.corner(one, two, at, z1, z2) || !within(at)) continue;
      // The other sheet of a side is not the corner that is seen.
      if (!seen(one, at, z1) || !seen(two, at, z2)) continue;
      if (c.kind != CellKind::kLeast && !runs_through_all(at)) continue;
      if (c.kind != CellKind::kLeast && info.star && !is_star_centre(info, c, at)) continue;
      if (c.kind == CellKind::kLeast) {
        // Tiny cells lie on the corner; their own box is the better bound.
        at.x() = std::clamp(at.x(), b.x0 - margin, b.x1 + margin);
        at.y() = std::clamp(at.y(), b.y0 - margin, b.y1 + margin);
      }
      add_corner(items, at, &one, &two, z1, z2, nullptr);
      return true;
    }
  }
  if (c.kind != CellKind::kLeast) return false;
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
      graph_.uncertified_area += info.depth <= 0.25 * options_.tolerance
                                     ? 0
                                     : (c.box.x1 - c.box.x0) * (c.box.y1 - c.box.y0);
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
             (!(least && goes_deeper(info, c, items)) && join_corner(info, c, items));
    }
  } else if (least && !goes_deeper(info, c, items)) {
    done = join_corner(info, c, items);
  }
  if (!done) to_split_.push_back(info.cell);
}

template <class Take>
void GraphMaker::leaves_on(std::int32_t in, std::uint8_t side, const PlanBox& box,
                           const Take& take) const {
  // Cells that end on the line where the box's side is, on its other side, along the box. Borders
  // that are one line have one coordinate, to the bit.
  const PlanBox& b = cell(in).box;
  const bool upright = side == 1 || side == 3;
  const double line = side == 0 ? box.y0 : side == 1 ? box.x1 : side == 2 ? box.y1 : box.x0;
  const double low = upright ? b.x0 : b.y0, high = upright ? b.x1 : b.y1;
  const bool beyond = side == 1 || side == 2;
  if (beyond ? !(low <= line && line < high) : !(low < line && line <= high)) return;
  const double from = upright ? b.y0 : b.x0, to = upright ? b.y1 : b.x1;
  const double at = upright ? box.y0 : box.x0, end = upright ? box.y1 : box.x1;
  if (to <= at || from >= end) return;
  const std::int32_t child = cell(in).child;
  if (child < 0) {
    if (cell(in).info >= 0) take(in);
    return;
  }
  for (std::int32_t k = 0; k < 4; ++k) leaves_on(child + k, side, box, take);
}

// take(leaf, side): the other leaf, or -1 for the domain's border.
template <class Take>
void GraphMaker::around(std::int32_t c, const Take& take) const {
  const PlanBox& box = cell(c).box;
  const PlanBox& first = cell(tree_.roots.front()).box;
  const PlanBox& last = cell(tree_.roots.back()).box;
  const bool border[4] = {box.y0 == first.y0, box.x1 == last.x1, box.y1 == last.y1,
                          box.x0 == first.x0};
  for (std::uint8_t side = 0; side < 4; ++side) {
    if (border[side]) {
      take(-1, side);
      continue;
    }
    for (const std::int32_t root : tree_.roots)
      leaves_on(root, side, box, [&](std::int32_t leaf) { take(leaf, side); });
  }
}

// Beside a silhouette heights differ by more than the tolerance sees between points of the plan
// that are 1e-7 of the size apart: what a least cell would make one corner there is looked for a
// little longer.
bool GraphMaker::goes_deeper(const CellInfo& info, const TreeCell& c,
                             const std::vector<Item>& items) const {
  // What was found by halving alone may go on and on beside itself, and is no clearer deeper down.
  for (const Item& item : items) {
    if (graph_.nodes[item.node].curve.type == CurveType::kUnsolved) return false;
  }
  const double width = std::fmax(c.box.x1 - c.box.x0, c.box.y1 - c.box.y0);
  return !last_ && info.depth > 0.25 * options_.tolerance && width > kDeeper * options_.least;
}

// Splits the cells that did not join, or has them joined as they are in the last pass; false where
// there are none.
bool GraphMaker::split_failed(bool last) {
  if (to_split_.empty()) return false;
  std::vector<std::int32_t> split;
  last_ = last;
  for (const std::int32_t c : to_split_) {
    const PlanBox b = cell(c).box;
    if (last || (cell(c).kind != CellKind::kLeast &&
                 std::fmax(b.x1 - b.x0, b.y1 - b.y0) <= 2 * options_.least)) {
      cell(c).kind = CellKind::kLeast;
    } else {
      split.push_back(c);
    }
  }
  tree_.split_leaves(split);
  return true;
}

// Whether a cell's changes join, all by itself; `known` has what its borders show.
bool GraphMaker::joins(std::int32_t info, const GraphMaker& known) {
  graph_ = {};
  found_.clear();
  to_split_.clear();
  last_ = known.last_;
  const std::int32_t c = tree_.infos[static_cast<std::size_t>(info)].cell;
  around(c, [&](std::int32_t leaf, std::uint8_t side) {
    const auto first = static_cast<std::uint32_t>(graph_.nodes.size());
    if (leaf < 0 && options_.seams[side] != nullptr) {
      take_seam(c, side);
    } else {
      const bool before = side == 0 || side == 3;  // the other leaf is the lower
      const std::uint64_t key = leaf < 0 ? pair_key(c, -1 - static_cast<std::int32_t>(side))
                                : before ? pair_key(leaf, c)
                                         : pair_key(c, leaf);
      for (const LineChange& change : known.known_.at(key)) add_node(change);
    }
    for (std::uint32_t n = first; n < graph_.nodes.size(); ++n) found_.push_back({info, side, n});
  });
  join(info, found_);
  return to_split_.empty();
}

// Splits cells until each joins by itself: in rounds, of the cells whose borders are new. What a
// round finds depends on no other cell of it, so that threads share it out.
void GraphMaker::settle_cells() {
  std::vector<std::int32_t> open(tree_.infos.size());
  for (std::size_t i = 0; i < open.size(); ++i) open[i] = static_cast<std::int32_t>(i);
  std::vector<std::unique_ptr<GraphMaker>> workers;
  for (int t = 0; t < thread_count(options_.threads); ++t)
    workers.push_back(std::make_unique<GraphMaker>(surface_, tree_, options_));
  for (int round = 0; !open.empty() && !tree_.stopped; ++round) {
    std::vector<Stretch> fresh;
    for (const std::int32_t i : open) {
      const std::int32_t c = tree_.infos[static_cast<std::size_t>(i)].cell;
      around(c, [&](std::int32_t leaf, std::uint8_t side) {
        if (leaf < 0 && options_.seams[side] != nullptr) return;
        const bool before = side == 0 || side == 3, upright = side == 1 || side == 3;
        const Stretch stretch = leaf < 0 ? border_stretch(c, side)
                                : before ? stretch_between(leaf, c, upright)
                                         : stretch_between(c, leaf, upright);
        if (known_.try_emplace(stretch.key).second) fresh.push_back(stretch);
      });
    }
    std::vector<std::vector<LineChange>> found(fresh.size());
    parallel_blocks(fresh.size(), 64, options_.threads,
                    [&](std::size_t begin, std::size_t end, int) {
                      for (std::size_t k = begin; k < end; ++k) found[k] = search(fresh[k]);
                    });
    for (std::size_t k = 0; k < fresh.size(); ++k) known_[fresh[k].key] = std::move(found[k]);
    std::vector<char> joined(open.size());
    parallel_blocks(open.size(), 64, options_.threads,
                    [&](std::size_t begin, std::size_t end, int worker) {
                      GraphMaker& mine = *workers[static_cast<std::size_t>(worker)];
                      for (std::size_t k = begin; k < end; ++k)
                        joined[k] = mine.joins(open[k], *this) ? 1 : 0;
                    });
    to_split_.clear();
    for (std::size_t k = 0; k < open.size(); ++k) {
      if (!joined[k]) to_split_.push_back(tree_.infos[static_cast<std::size_t>(open[k])].cell);
    }
    const auto infos = static_cast<std::int32_t>(tree_.infos.size());
    std::vector<std::int32_t> next;
    const std::vector<std::int32_t> failed = to_split_;
    if (!split_failed(round >= kPasses)) break;
    // What has no leaf of its own any more is not looked at again.
    for (const std::int32_t c : failed) {
      if (cell(c).info >= 0) next.push_back(cell(c).info);  // least now, joined whatever it holds
      around(c, [&](std::int32_t leaf, std::uint8_t) {
        if (leaf >= 0) next.push_back(cell(leaf).info);
      });
    }
    for (auto i = infos; i < static_cast<std::int32_t>(tree_.infos.size()); ++i) next.push_back(i);
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    open = std::move(next);
  }
}

CellGraph GraphMaker::make() {
  settle_cells();
  // Each round the cells that did not join are split; the least cells always join, so it ends.
  for (int pass = 0; !tree_.stopped; ++pass) {
    graph_ = {};
    seam_changes_ = 0;
    found_.clear();
    to_split_.clear();
    for (const std::int32_t root : tree_.roots) inside(root);
    const int nx = tree_.columns, ny = tree_.rows;
    const auto root = [&](int i, int j) {
      return tree_.roots[static_cast<std::size_t>(j * nx + i)];
    };
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        if (i + 1 < nx) beside(root(i, j), root(i + 1, j), true);
        if (j + 1 < ny) beside(root(i, j), root(i, j + 1), false);
        if (j == 0) on_border(root(i, j), 0);
        if (i + 1 == nx) on_border(root(i, j), 1);
        if (j + 1 == ny) on_border(root(i, j), 2);
        if (i == 0) on_border(root(i, j), 3);
      }
    }
    std::stable_sort(found_.begin(), found_.end(),
                     [](const OnBorder& a, const OnBorder& b) { return a.info < b.info; });
    std::vector<OnBorder> own;
    std::size_t k = 0;
    for (std::size_t i = 0; i < tree_.infos.size(); ++i) {
      own.clear();
      while (k < found_.size() && found_[k].info == static_cast<std::int32_t>(i))
        own.push_back(found_[k++]);
      if (tree_.infos[i].cell >= 0) join(static_cast<std::int32_t>(i), own);
    }
    if (!split_failed(pass >= kPasses)) break;
  }
  std::size_t on_seams = 0;
  for (const Seam* seam : options_.seams) on_seams += seam != nullptr ? seam->changes() : 0;
  graph_.keeps_seams = tree_.stopped || seam_changes_ == on_seams;
  pull_to_border(surface_, options_, graph_);
  draw_together(surface_, options_, graph_);
  pull_to_border(surface_, options_, graph_);  // corners that have come to lie on it
  return std::move(graph_);
}

}  // namespace

CellGraph make_graph(const Impl& surface, CellTree& tree, const ArrangementOptions& options) {
  return GraphMaker(surface, tree, options).make();
}

}  // namespace diesink
