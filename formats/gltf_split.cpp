// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_split.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "formats/float_rows.h"

namespace diesink {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

Error wrong(std::string what) { return Error{ErrorCode::kInput, std::move(what), {}}; }

// The numbers of the triangles one after the other.
std::span<const std::uint32_t> flat(std::span<const Triangle> triangles) {
  return triangles.empty() ? std::span<const std::uint32_t>{}
                           : std::span(triangles.front().data(), 3 * triangles.size());
}

// Whether the numbers are below `count`; `first`: how many triangles the mesh has before these.
Status check_range(std::span<const Triangle> triangles, std::size_t first, std::size_t count,
                   const char* what) {
  // All at once, which is fast; one by one only to say which.
  if (triangles.empty() || range_of(flat(triangles))[1] < count) return ok();
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (*std::max_element(triangles[t].begin(), triangles[t].end()) >= count) {
      return wrong("triangle " + std::to_string(first + t) + " has a " + what + " beyond the " +
                   std::to_string(count) + " of the mesh");
    }
  }
  return ok();
}

// Whether every array has its length and every element is there.
Status check(const TriangleMesh& mesh, bool with_normals) {
  const std::size_t triangle_count = mesh.triangles.size();
  if (!mesh.triangle_element.empty() && mesh.triangle_element.size() != triangle_count) {
    return wrong("the mesh has " + std::to_string(mesh.triangle_element.size()) +
                 " element numbers, expected one for each of " + std::to_string(triangle_count) +
                 " triangles");
  }
  if (with_normals && mesh.corner_normals.size() != triangle_count) {
    return wrong("the mesh has normals for " + std::to_string(mesh.corner_normals.size()) +
                 " triangles, expected " + std::to_string(triangle_count));
  }
  if (!mesh.vertex_colors.empty() && mesh.vertex_colors.size() != mesh.positions.size()) {
    return wrong("the mesh has " + std::to_string(mesh.vertex_colors.size()) +
                 " vertex colours, expected " + std::to_string(mesh.positions.size()));
  }
  return ok();
}

// The mesh's triangles, element by element.
struct ElementOrder {
  std::vector<std::size_t> first;    // of each element, and the end
  std::vector<std::uint32_t> order;  // triangle numbers, those of an element as the mesh has them;
                                     // empty where the mesh's own order is already this one
};

// A counting sort by element. The triangles are cut into as many parts as a core has places in
// flight, each with counts of its own: a count that follows itself waits for its own store, the
// counts of the parts do not wait for each other.
void sort_by_element(const std::vector<std::uint32_t>& of, ElementOrder& sorted) {
  constexpr std::size_t kParts = 4;
  const std::size_t part = of.size() / kParts, element_count = sorted.first.size() - 1;
  std::vector<std::array<std::uint32_t, kParts>> next(element_count);
  const auto for_triangles = [&](auto use) {
    for (std::size_t t = 0; t < part; ++t) {
      for (std::size_t p = 0; p < kParts; ++p) use(p, p * part + t);
    }
    for (std::size_t t = kParts * part; t < of.size(); ++t) use(kParts - 1, t);
  };
  for_triangles([&](std::size_t p, std::size_t t) { ++next[of[t]][p]; });
  std::uint32_t at = 0;
  for (std::size_t e = 0; e < element_count; ++e) {
    sorted.first[e] = at;
    for (std::uint32_t& count : next[e]) at += std::exchange(count, at);
  }
  sorted.first[element_count] = at;
  sorted.order.resize(of.size());
  for_triangles([&, to = sorted.order.data()](std::size_t p, std::size_t t) {
    to[next[of[t]][p]++] = static_cast<std::uint32_t>(t);
  });
}

Result<ElementOrder> order_by_element(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t>& of = mesh.triangle_element;
  const std::size_t element_count = std::max<std::size_t>(mesh.elements.size(), 1);
  ElementOrder found;
  found.first.assign(element_count + 1, 0);
  if (of.empty()) {
    std::fill(found.first.begin() + 1, found.first.end(), mesh.triangles.size());
    return found;
  }
  const bool sorted = is_ascending(of);
  const std::uint32_t most = sorted ? of.back() : range_of(of)[1];
  if (most >= element_count) {
    return wrong("a triangle belongs to element " + std::to_string(most) + " of " +
                 std::to_string(mesh.elements.size()));
  }
  if (!sorted) {
    sort_by_element(of, found);
    return found;
  }
  auto at = of.begin();
  for (std::size_t e = 0; e < element_count; ++e) {
    at = std::upper_bound(at, of.end(), static_cast<std::uint32_t>(e));
    found.first[e + 1] = static_cast<std::size_t>(at - of.begin());
  }
  return found;
}

// The vertices made so far for each position, all within one primitive.
template <bool kNormals>
class CornerTable {
 public:
  explicit CornerTable(std::size_t positions) : heads_(positions) {}

  // Forgets the vertices of the last primitive, those below `first`.
  void next_primitive(std::uint32_t first) {
    first_ = first;
    more_.clear();
  }

  struct Found {
    std::uint32_t vertex;
    bool made;  // now, as `fresh`
  };
  // The vertex of this corner; `fresh` where there was none. Whether there was cannot be foretold
  // and is no branch, and what is made now depends on the table alone, not on the last `fresh`;
  // that a position has another normal already is rare.
  Found vertex(std::uint32_t position, std::uint32_t normal, std::uint32_t fresh) {
    const Head was = heads_[position];
    const bool made = static_cast<std::uint32_t>(was) <= first_;
    const Head is = made ? head(normal, fresh) : was;
    heads_[position] = is;
    if constexpr (kNormals) {
      if (is >> 32 != normal) [[unlikely]] {
        const std::uint32_t other = further(position, normal, fresh);
        return {other, other == fresh};
      }
    }
    return {static_cast<std::uint32_t>(is) - 1, made};
  }

  // Positions that got a vertex at all.
  [[nodiscard]] std::size_t used() const {
    return heads_.size() -
           static_cast<std::size_t>(std::count(heads_.begin(), heads_.end(), Head{0}));
  }

 private:
  // A position's vertex and one; above it, with normals, the first normal it had.
  using Head = std::conditional_t<kNormals, std::uint64_t, std::uint32_t>;
  static Head head(std::uint32_t normal, std::uint32_t vertex) {
    if constexpr (kNormals) return Head{normal} << 32 | (vertex + 1);
    return vertex + 1;
  }

  static constexpr std::uint32_t kEnd = 0xFFFFFFFFu;
  struct More {
    std::uint32_t position, normal, vertex, next;
  };

  // Among the further normals of a position. The last of a position's chain is believed only where
  // it says so itself, so that nothing need be cleared.
  std::uint32_t further(std::uint32_t position, std::uint32_t normal, std::uint32_t fresh) {
    if (last_.empty()) last_.resize(heads_.size());
    const std::uint32_t last = last_[position];
    const bool chained = last < more_.size() && more_[last].position == position;
    for (std::uint32_t at = chained ? last : kEnd; at != kEnd; at = more_[at].next) {
      if (more_[at].normal == normal) return more_[at].vertex;
    }
    last_[position] = static_cast<std::uint32_t>(more_.size());
    more_.push_back({position, normal, fresh, chained ? last : kEnd});
    return fresh;
  }

  std::vector<Head> heads_;
  std::vector<std::uint32_t> last_;  // of a position's further normals; none: no position has any
  std::vector<More> more_;
  std::uint32_t first_ = 0;
};

// The triangles of a primitive in vertices of its own, which follow those there are.
template <bool kNormals, bool kOrdered>
std::uint32_t split_corners(const TriangleMesh& mesh, const std::vector<std::uint32_t>& order,
                            std::size_t first, std::size_t last, std::uint32_t first_vertex,
                            CornerTable<kNormals>& made, SplitMesh& split, Triangle* to) {
  CornerTable<kNormals> table =
      std::move(made);  // nobody else's, which keeps its parts in registers
  std::uint32_t fresh = first_vertex;
  constexpr std::size_t kBlock = 4096;
  for (std::size_t begin = first; begin < last; begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, last);
    // Room for a vertex a corner: each is written where the next one goes, new or not.
    const std::size_t room = fresh + 3 * (end - begin) + 1;
    if (split.position.size() < room) split.position.resize(room);
    if (kNormals && split.normal.size() < room) split.normal.resize(room);
    std::uint32_t* const position_of = split.position.data();
    std::uint32_t* const normal_of = split.normal.data();
    const Triangle* const triangles = mesh.triangles.data();
    const Triangle* const normals = mesh.corner_normals.data();
    const std::uint32_t* const ordered = order.data();
    for (std::size_t i = begin; i < end; ++i, ++to) {
      const std::size_t t = kOrdered ? ordered[i] : i;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t position = triangles[t][k];
        const std::uint32_t normal = kNormals ? normals[t][k] : 0;
        const auto [vertex, is_new] = table.vertex(position, normal, fresh);
        (*to)[k] = vertex - first_vertex;
        position_of[fresh] = position;
        if (kNormals) normal_of[fresh] = normal;
        fresh += is_new ? 1 : 0;
      }
    }
  }
  made = std::move(table);
  return fresh;
}

// Whether the triangles use a run of positions, every one of it, and their corners' normals have
// the positions' numbers: then nothing needs numbers of its own.
class RunFinder {
 public:
  // `count`: how many positions, and normals, there are.
  explicit RunFinder(std::size_t count) : seen_(count, 0) {}

  bool find(std::span<const Triangle> triangles, std::span<const Triangle> normals,
            SplitPrimitive& primitive) {
    if (++stamp_ == 0) {
      std::fill(seen_.begin(), seen_.end(), std::uint8_t{0});
      stamp_ = 1;
    }
    // Bytes may be anything's for the compiler; these are nobody's but ours.
    std::uint8_t* const seen = seen_.data();
    const std::uint8_t stamp = stamp_;
    std::uint32_t low = 0xFFFFFFFFu, high = 0;
    constexpr std::size_t kBlock = 1024;  // triangles, which stay in the nearest cache meanwhile
    for (std::size_t t = 0; t < triangles.size(); t += kBlock) {
      const auto block = triangles.subspan(t, std::min(kBlock, triangles.size() - t));
      if (!normals.empty() &&
          std::memcmp(block.data(), normals.data() + t, block.size_bytes()) != 0) {
        return false;
      }
      const auto [least, most] = range_of(flat(block));
      low = std::min(low, least);
      high = std::max(high, most);
      if (high >= seen_.size()) return false;
      // Memory has time meanwhile for the block that comes next.
      const std::size_t next = std::min(t + kBlock, triangles.size() - block.size());
      for (std::size_t i = 0; i < block.size(); ++i) {
        __builtin_prefetch(triangles.data() + next + i);
        if (!normals.empty()) __builtin_prefetch(normals.data() + next + i);
        const std::uint32_t a = block[i][0], b = block[i][1],
                            c = block[i][2];  // before a store that might change them
        seen[a] = seen[b] = seen[c] = stamp;
      }
    }
    const std::size_t count = std::size_t{high} - low + 1;
    if (count > 3 * triangles.size()) return false;
    // Without a way out in between, which lets the compiler take many at a time.
    unsigned other = 0;
    for (std::size_t v = low; v <= high; ++v) other |= static_cast<unsigned>(seen[v] ^ stamp);
    if (other != 0) return false;
    primitive.as_given = true;
    primitive.first_vertex = low;
    primitive.vertex_count = static_cast<std::uint32_t>(count);
    return true;
  }

 private:
  std::vector<std::uint8_t> seen_;  // the stamp of the last primitive that uses the position
  std::uint8_t stamp_ = 0;
};

// split_by_element() of a mesh whose arrays have their lengths.
template <bool kNormals>
Result<SplitMesh> split_checked(const TriangleMesh& mesh, bool runs) {
  SplitMesh split;
  const std::size_t triangle_count = mesh.triangles.size();
  if (triangle_count == 0) return split;

  const Result<ElementOrder> by_element = order_by_element(mesh);
  if (!by_element) return by_element.error();
  const auto& [first, order] = *by_element;
  const std::size_t element_count = first.size() - 1;

  std::optional<RunFinder> finder;
  if (runs && order.empty()) {
    const std::size_t normals = kNormals ? mesh.normals.size() : mesh.positions.size();
    finder.emplace(std::min(mesh.positions.size(), normals));
  }
  const auto check_indices = [&](std::size_t begin, std::size_t end) {
    const auto part = [&](const std::vector<Triangle>& of) {
      return std::span(of).subspan(begin, end - begin);
    };
    Status found = check_range(part(mesh.triangles), begin, mesh.positions.size(), "vertex");
    if (found && kNormals) {
      found = check_range(part(mesh.corner_normals), begin, mesh.normals.size(), "normal");
    }
    return found;
  };
  if (!order.empty()) {
    if (Status found = check_indices(0, triangle_count); !found) return found.error();
  }
  std::optional<CornerTable<kNormals>> table;
  std::uint32_t next_vertex = 0;
  std::size_t next_triangle = 0;
  for (std::size_t e = 0; e < element_count; ++e) {
    if (first[e] == first[e + 1]) continue;
    SplitPrimitive primitive;
    if (!mesh.elements.empty()) primitive.element = static_cast<std::uint32_t>(e);
    primitive.first_triangle = first[e];
    primitive.triangle_count = first[e + 1] - first[e];
    const auto own = [&](const std::vector<Triangle>& of) {
      return std::span(of).subspan(primitive.first_triangle, primitive.triangle_count);
    };
    if (finder && finder->find(own(mesh.triangles),
                               kNormals ? own(mesh.corner_normals) : std::span<const Triangle>{},
                               primitive)) {
      split.primitives.push_back(primitive);
      continue;
    }
    if (order.empty()) {
      if (Status found = check_indices(first[e], first[e + 1]); !found) return found.error();
    }
    if (!table) {
      table.emplace(mesh.positions.size());
      split.position.reserve(mesh.positions.size() + mesh.positions.size() / 8);
      if (kNormals) split.normal.reserve(split.position.capacity());
      split.triangles = std::make_unique_for_overwrite<Triangle[]>(triangle_count - first[e]);
    }
    primitive.first_vertex = next_vertex;
    primitive.first_triangle = next_triangle;
    table->next_primitive(next_vertex);
    const auto corners =
        order.empty() ? split_corners<kNormals, false> : split_corners<kNormals, true>;
    next_vertex = corners(mesh, order, first[e], first[e + 1], next_vertex, *table, split,
                          split.triangles.get() + next_triangle);
    next_triangle += primitive.triangle_count;
    primitive.vertex_count = next_vertex - primitive.first_vertex;
    split.primitives.push_back(primitive);
  }
  split.position.resize(next_vertex);
  if (kNormals) split.normal.resize(next_vertex);
  if (table) split.used_positions = table->used();
  return split;
}

}  // namespace

Result<SplitMesh> split_by_element(const TriangleMesh& mesh, bool with_normals, bool runs) {
  if (Status status = check(mesh, with_normals); !status) return status.error();
  return with_normals ? split_checked<true>(mesh, runs) : split_checked<false>(mesh, runs);
}

}  // namespace diesink
