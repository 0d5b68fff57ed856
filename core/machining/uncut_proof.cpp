// SPDX-License-Identifier: Apache-2.0
#include "core/machining/uncut_proof.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/machining/interference.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Of the radius: parts that a thread takes from another, parts to begin with, parts that stay open
// where the limit is not kept, at the most and at the least, and where it is kept at all points
// that were looked at.
constexpr double kShared = 8, kFirst = 0.25, kWidest = 1.0 / 16, kNarrow = 1.0 / 48,
                 kFinest = 1.0 / 65536;
// Of a part, what has to be cut off it to go on with what is left as it is.
constexpr double kWorth = 1.0 / 8;
// Of the radius: no part is so narrow, but by rounding of its corners.
constexpr double kRounding = 1e-9;
// Of the distance that is out of reach, how much further what is in reach goes at least.
constexpr double kBeyond = 0.02;
// Boxes of axes that are looked at for one part, before it is divided; for one that is narrow.
constexpr std::size_t kBoxes = 96, kBoxesOfNarrow = 1024;
constexpr int kSideHalves = 6;
// Corners of what is left; halves of it have at most four more, as their cuts lie along the axes.
constexpr std::size_t kMostOfRest = FacetPart::kMostCorners - 5;

// From a point to all that is on a triangle, of the normal n, and below it.
double distance_to_column(const std::array<Vec3, 3>& v, const Vec3& n, const Vec3& p) {
  const double above = n.dot(p - v[0]);
  bool over = true, foot_inside = true;
  double best2 = kInfinity;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 side = v[(k + 1) % 3] - v[k], off = p - v[k];
    over = over && side.x() * off.y() - side.y() * off.x() >= 0;
    foot_inside = foot_inside && n.cross(side).dot(off) >= 0;
    const double t = std::clamp(off.dot(side) / side.squaredNorm(), 0.0, 1.0);
    best2 = std::min(best2, (off - t * side).squaredNorm());
    // The upright face under the side.
    const double plan2 = side.head<2>().squaredNorm();
    const double s =
        plan2 > 0 ? std::clamp(off.head<2>().dot(side.head<2>()) / plan2, 0.0, 1.0) : 0;
    if (off.z() <= s * side.z()) {
      best2 = std::min(best2, (off - s * side).head<2>().squaredNorm());
    }
  }
  if (over && above <= 0) return 0;
  return above > 0 && foot_inside ? above : std::sqrt(best2);
}

}  // namespace

// One thread's.
class UncutProof::Whittler {
 public:
  Whittler(const UncutProof& proof, const Stands& stands, std::optional<ReachProof::Search>& reach,
           Unproven& found)
      : proof_(proof), stands_(stands), reach_(reach), found_(found) {}

  void look(const FacetPart& part) { look(part, {}); }

 private:
  // Boxes of axes that may come low enough, where that was asked already.
  using Axes = std::optional<ReachProof::Search::Rest>;

  void look(FacetPart part, Axes axes) {
    const double R = proof_.cutter_.radius();
    while (part.size > 2) {
      const double width = wider_side(part.box());
      if (part.area() <= kRounding * R * width) return;
      if (width > kFirst * R) {
        const std::array<FacetPart, 2> both = halves(part);
        look(both[0], axes);
        part = both[1];
        continue;
      }
      const double area = part.area();
      const Tried tried = try_moves(part, width, axes);
      if (tried.done) return;
      if (part.area() < (1 - kWorth) * area) continue;
      // What is known to be too high all over it is not looked at more closely than at that.
      const double over = stands_ && tried.over > 0 ? kWidest * R : tried.over;
      const double least =
          tried.kept_everywhere ? kFinest * R : std::clamp(over, kNarrow * R, kWidest * R);
      if (width <= least) {
        found_.open.push_back(part);
        return;
      }
      const std::array<FacetPart, 2> both = halves(part);
      look(both[0], axes);
      part = both[1];
    }
  }

  struct Tried {
    bool done = false;            // nothing is left
    bool kept_everywhere = true;  // at the points looked at
    double over = kInfinity;      // the least, where the limit is kept at none of them
  };
  // What keeps the limit at a place: a move, and the facet that is near.
  struct Keeper {
    std::uint32_t move = 0, facet = 0;
  };

  // With the moves that are lowest at the middle and at the corners, or as out of reach.
  Tried try_moves(FacetPart& part, double width, Axes& axes) {
    Tried tried;
    bool somewhere = false;
    const FacetPart whole = part;
    const double enough = (1 - kWorth) * whole.area();
    std::optional<double> most;
    for (std::size_t k = 0; k <= whole.size; ++k) {
      const Vec3 at = k == 0 ? whole.middle() : whole.p[k - 1];
      double over = 0;
      const std::optional<Keeper> keeper = keeper_at(whole, at, most, over);
      if (!keeper) {
        tried.kept_everywhere = false;
        tried.over = std::min(tried.over, over);
        if (k == 0 && reach_ && !part.from) {
          ask_reach(part, width, axes);
          tried.done = part.size < 3;
          if (tried.done || part.area() < enough) return tried;
        }
        if (k == 0 && over > width && width > kWidest * proof_.cutter_.radius()) return tried;
        continue;
      }
      somewhere = true;
      cut_off(part, [&](const Vec3& p) { return keeps(*keeper, part.facet, p); });
      tried.done = part.size < 3;
      if (tried.done || part.area() < enough) return tried;
    }
    if (somewhere) tried.over = 0;
    return tried;
  }

  // In parts no wider than those that stay open.
  void tell_out(const FacetPart& part) {
    if (wider_side(part.box()) <= kWidest * proof_.cutter_.radius()) {
      found_.out.push_back(part);
      return;
    }
    for (const FacetPart& half : halves(part)) {
      if (half.size > 2) tell_out(half);
    }
  }

  // Takes off the part what is out of reach, or in reach for certain.
  void ask_reach(FacetPart& part, double width, Axes& axes) {
    ReachProof::Question question;
    question.lift = proof_.lift(part, proof_.distance_);
    question.low = proof_.distance_ / proof_.normal(part).z();
    question.most_boxes = width > kWidest * proof_.cutter_.radius() ? kBoxes : kBoxesOfNarrow;
    if (!axes) axes = reach_->all(part);
    const ReachProof::Answer answer = reach_->ask(part, question, *axes);
    if (answer.reach == ReachProof::Reach::kOut) {
      tell_out(part);
      part.size = 0;
    }
    if (answer.reach != ReachProof::Reach::kIn) return;
    // What is cut off reaches a little further, so that the corners of what is left do not lie on
    // the very limit of what can be proven.
    const double further =
        std::max(kBeyond, (proof_.limit_ / proof_.distance_ - 1) / 4) * proof_.distance_;
    if (proof_.distance_ + further > proof_.limit_) return;  // nothing could be proven there
    const double lift = question.low + further / proof_.normal(part).z();
    FacetPart rest = part, in;
    cut_off(
        rest,
        [&](const Vec3& p) {
          // Beyond the facet's sides its plane is not the part's.
          const double top = proof_.reach_->height(answer.tip, p.head<2>());
          return top - p.z() <= lift && proof_.keeps(part.facet, part.facet, p, top);
        },
        &in);
    if (rest.size > 0 && rest.area() > (1 - kWorth) * part.area()) return;
    in.from = answer.tip;
    found_.open.push_back(in);
    part = rest;
  }

  [[nodiscard]] bool keeps(const Keeper& keeper, std::uint32_t own, const Vec3& p) const {
    const double top = proof_.moves_.height(keeper.move, p.head<2>());
    return proof_.keeps(keeper.facet, own, p, top);
  }

  // `most`: what stands so high over the part is nowhere near enough to it; made when it is needed.
  std::optional<Keeper> keeper_at(const FacetPart& part, const Vec3& p, std::optional<double>& most,
                                  double& over) {
    const std::uint32_t own = part.facet;
    if (stands_) {
      over = stands_(p.head<2>()) - proof_.limit_;
      if (over > 0) return std::nullopt;
    }
    if (last_ != PathMoves::kNone && keeps({last_, own}, own, p)) return Keeper{last_, own};
    const Facet& facet = proof_.facets_[own];
    const Vec3 tip = tip_of(proof_.cutter_, {p, facet.n});
    if (!most) {
      // Where what no move keeps is asked for its reach, how high it stands does not matter.
      most = reach_ && !part.from ? (1 + kRounding) * proof_.lift(part, proof_.limit_) : kInfinity;
    }
    double top = p.z() + *most;
    std::uint32_t move = proof_.moves_.lowest_near(tip.head<2>(), p.head<2>(), top);
    if (move != PathMoves::kNone && proof_.keeps(own, own, p, top))
      return Keeper{last_ = move, own};
    const std::uint32_t lower = proof_.moves_.lowest(p.head<2>(), top);
    if (lower != PathMoves::kNone) move = lower;
    over = (top - p.z()) * facet.n.z() - proof_.limit_;
    if (move == PathMoves::kNone) return std::nullopt;
    const std::optional<std::uint32_t> near = proof_.nearby(own, p, top);
    if (!near) return std::nullopt;
    last_ = move;
    return Keeper{move, *near};
  }

  // Cuts off the hull of the corners at which `kept` holds and of the places on the sides up to
  // which it does, where the rest stays one convex part. Needs: it holds on a convex part of the
  // plan.
  template <class Kept>
  static void cut_off(FacetPart& part, const Kept& holds, FacetPart* off = nullptr) {
    std::array<bool, FacetPart::kMostCorners> kept{};
    std::size_t count = 0, changes = 0;
    for (std::size_t k = 0; k < part.size; ++k) {
      kept[k] = holds(part.p[k]);
      count += kept[k] ? 1 : 0;
    }
    if (count == part.size) {
      if (off != nullptr) *off = part;
      part.size = 0;
      return;
    }
    for (std::size_t k = 0; k < part.size; ++k) {
      changes += kept[k] != kept[(k + 1) % part.size] ? 1 : 0;
    }
    if (changes != 2 || part.size - count + 2 > kMostOfRest) return;
    FacetPart rest, gone;
    rest.facet = gone.facet = part.facet;
    rest.from = gone.from = part.from;
    for (std::size_t k = 0; k < part.size; ++k) {
      const std::size_t next = (k + 1) % part.size;
      FacetPart& own = kept[k] ? gone : rest;
      own.p[own.size++] = part.p[k];
      if (kept[k] == kept[next]) continue;
      Vec3 in = part.p[kept[k] ? k : next], out = part.p[kept[k] ? next : k];
      for (int half = 0; half < kSideHalves; ++half) {
        const Vec3 middle = (in + out) / 2;
        (holds(middle) ? in : out) = middle;
      }
      rest.p[rest.size++] = in;
      gone.p[gone.size++] = in;
    }
    part = rest;
    if (off != nullptr) *off = gone;
  }

  const UncutProof& proof_;
  const Stands& stands_;
  std::optional<ReachProof::Search>& reach_;
  Unproven& found_;
  std::uint32_t last_ = PathMoves::kNone;  // most often the neighbour's move keeps it, too
};

bool UncutProof::keeps(std::uint32_t facet, std::uint32_t own, const Vec3& p, double top) const {
  if (!(top < kInfinity)) return false;
  const Facet& f = facets_[facet];
  if (facet == own) {
    const double above = top - p.z();
    if (above <= limit_) return true;
    if (above * f.n.z() > limit_) return false;
  }
  return distance_to_column(f.v, f.n, {p.x(), p.y(), top}) <= limit_;
}

std::optional<std::uint32_t> UncutProof::nearby(std::uint32_t own, const Vec3& p,
                                                double top) const {
  if (keeps(own, own, p, top)) return own;
  // Beside a wall, or where the surface rises or bends, another facet may be nearer.
  std::optional<std::uint32_t> found;
  if (!(top < kInfinity)) return found;
  around_->over({p.x() - limit_, p.x() + limit_, p.y() - limit_, p.y() + limit_},
                [&](std::uint32_t other) {
                  if (!found && other != own && keeps(other, own, p, top)) found = other;
                });
  return found;
}

UncutProof::UncutProof(const TriangleMesh& mesh, const OffsetSurface& offset,
                       const CutterShape& cutter, const FrameDomain& domain, double limit,
                       int threads)
    : cutter_(cutter), limit_(limit), threads_(threads), moves_(cutter) {
  for (const auto& [i, j, k] : mesh.triangles) {
    Facet facet{{offset.to_frame(mesh.positions[i]), offset.to_frame(mesh.positions[j]),
                 offset.to_frame(mesh.positions[k])},
                Vec3::Zero()};
    const Vec3 n = (facet.v[1] - facet.v[0]).cross(facet.v[2] - facet.v[0]);
    const double size = n.norm();
    if (!faces_up(n, size)) continue;
    facet.n = n / size;
    facets_.push_back(facet);
  }
  for (std::uint32_t f = 0; f < facets_.size(); ++f) {
    FacetPart part;
    part.facet = f;
    for (const Vec3& v : facets_[f].v) part.p[part.size++] = v;
    boxes_.push_back(part.box());
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec2 &a = domain.corners()[k], side = domain.corners()[(k + 1) % 4] - a;
      part = cut_by(part, [&](const Vec3& p) {
        return side.x() * (p.y() - a.y()) - side.y() * (p.x() - a.x());
      });
    }
    // The largest by several threads.
    std::vector<FacetPart> waiting;
    if (part.size > 2) waiting.push_back(part);
    while (!waiting.empty()) {
      const FacetPart next = waiting.back();
      waiting.pop_back();
      if (wider_side(next.box()) <= kShared * cutter.radius()) {
        all_.push_back(next);
        continue;
      }
      for (const FacetPart& half : halves(next)) {
        if (half.size > 2) waiting.push_back(half);
      }
    }
  }
  around_.emplace(boxes_);
}

UncutProof::Unproven UncutProof::unproven(const std::vector<FacetPart>& parts,
                                          const Stands& stands) {
  constexpr std::size_t kPartsABlock = 32;
  if (!binned_) moves_.bin();
  binned_ = true;
  std::vector<Unproven> found((parts.size() + kPartsABlock - 1) / kPartsABlock);
  // One a thread: what it remembers saves time and changes nothing.
  std::vector<std::optional<ReachProof::Search>> searches(
      static_cast<std::size_t>(thread_count(threads_)));
  for (auto& search : searches) {
    if (reach_ != nullptr) search.emplace(*reach_);
  }
  parallel_blocks(parts.size(), kPartsABlock, threads_,
                  [&](std::size_t begin, std::size_t end, int worker) {
                    Whittler whittler(*this, stands, searches[static_cast<std::size_t>(worker)],
                                      found[begin / kPartsABlock]);
                    for (std::size_t k = begin; k < end; ++k) whittler.look(parts[k]);
                  });
  Unproven all;
  for (const Unproven& some : found) {
    all.open.insert(all.open.end(), some.open.begin(), some.open.end());
    all.out.insert(all.out.end(), some.out.begin(), some.out.end());
  }
  return all;
}

double UncutProof::top(const Vec2& p) const {
  double below = kInfinity;
  static_cast<void>(moves_.lowest(p, below));
  return below;
}

}  // namespace diesink
