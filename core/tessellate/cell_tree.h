// The plan of the die cut into cells so small that what happens in each is known: one face, one
// crease, one corner. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/compound/compound_impl.h"
#include "core/tessellate/cell_bounds.h"
#include "core/tessellate/search_budget.h"

namespace diesink {

enum class CellKind : std::uint8_t {
  kPlain,    // one label
  kArc,      // one regular function: arcs that enter and leave
  kCorner,   // two independent functions, or one body's own vertex: at most one corner
  kUnknown,  // to be split
  kLeast,    // of the least size: whatever is in it is joined in one corner
};

// What the enclosures say of a cell.
struct CellVerdict {
  CellKind kind = CellKind::kUnknown;
  FunctionList functions;   // that may vanish in the cell
  FaceList candidates;      // faces that may be the surface in the cell; no label for a hole
  bool hole = false;        // there may be no surface somewhere in the cell
  bool has_vertex = false;  // kCorner by a body's own vertex
  bool star = false;        // kCorner only if every function runs through the corner
  bool branched = false;    // kCorner only if arcs side by side, two of them of one conic
  Vec3 vertex = Vec3::Zero();
  double depth = 0;  // height between the lowest and the highest candidate
};

// Points where a body's own curves meet at no angle or more than two of them meet.
struct BodyVertices {
  std::vector<Vec3> points;
};

struct TreeCell {
  PlanBox box;
  std::int32_t child = -1;  // first of four, or -1 for a leaf: order (x low, y low), (high, low),
                            // (low, high), (high, high)
  CellKind kind = CellKind::kUnknown;
  std::uint8_t level = 0;
  std::int32_t info = -1;  // leaf that is not plain: index into CellTree::infos
  Label label = kNoLabel;  // plain: its label (kNoLabel: a hole)
};

// A leaf in which something happens.
struct CellInfo {
  std::int32_t cell = 0;
  bool has_vertex = false;
  Vec3 vertex = Vec3::Zero();
  bool star = false;  // as of the verdict
  bool branched = false;
  bool sorted_by_y = false;  // kArc: crossings pair up in ascending y (else in ascending x)
  double depth = 0;
  std::vector<std::uint32_t> steps;  // of the expression that matter in the cell
};

struct TreeLimits {
  double least = 0;  // plan length under which no cell is split
  double flat = 0;   // height under which candidates count as one surface
  int variant = 0;   // cells are cut elsewhere for each
  std::size_t most_of_a_seed = SearchBudget().cells;  // SearchBudget::cells
  std::size_t most_cells = 0;  // where there would be more the tree stops; 0 = no limit
  bool may_widen = false;      // instead: parts of it are grown with wider least cells
  int threads = 0;             // 0 = all cores; the tree is the same for any number
};

class CellTree {
 public:
  // Needs: a plan box inside the domain.
  CellTree(const CompoundSurface::Impl& surface, const PlanBox& box, const TreeLimits& limits);

  std::vector<TreeCell> cells;
  std::vector<std::int32_t> roots;  // columns * rows of them, x fastest
  int columns = 1, rows = 1;
  std::vector<CellInfo> infos;
  bool stopped = false;  // by TreeLimits::most_cells: what it says is not to be used
  bool widened = false;  // by TreeLimits::may_widen

  // Splits leaves once more and everything below them as far as needed.
  void split_leaves(const std::vector<std::int32_t>& leaves);

 private:
  // What grows below one cell, by numbers of its own; the first cell is that one.
  struct Sprout {
    std::vector<TreeCell> cells;
    std::vector<CellInfo> infos;
    std::size_t most_cells = 0;
    bool stopped = false;
    double wider = 1;  // its least cells, times TreeLimits::least
  };
  struct Seed {
    std::int32_t cell = 0;
    std::vector<std::uint32_t> steps;  // that may matter in it
    bool divide = false;               // whatever it holds
  };
  void open_up(std::vector<Seed>& seeds);
  void grow_all(const std::vector<Seed>& seeds);
  // Makes a cell a leaf, or divides it and returns true; `here` comes back without the steps that
  // do not matter in it.
  bool decide(Sprout& sprout, std::int32_t cell, std::vector<std::uint32_t>& here) const;
  void grow(Sprout& sprout, std::int32_t cell, const std::vector<std::uint32_t>& steps) const;
  void divide(std::vector<TreeCell>& all, std::int32_t cell) const;
  void take(Sprout&& sprout, std::int32_t cell);

  const CompoundSurface::Impl& surface_;
  TreeLimits limits_;
  std::vector<BodyVertices> vertices_;
};

// Decides a box; `steps` are those that may matter in it and come back without those that cannot.
void classify(const CompoundSurface::Impl& surface, const std::vector<BodyVertices>& vertices,
              const CellBox& box, std::vector<std::uint32_t>& steps, double flat,
              CellVerdict& verdict);

// Candidates that differ by less than the tolerance can see: one surface for the tree.
bool is_shallow(const CellVerdict& verdict, const CellBox& box, double flat);

std::vector<BodyVertices> body_vertices(const CompoundSurface::Impl& surface);

}  // namespace diesink
