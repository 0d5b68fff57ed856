// SPDX-License-Identifier: Apache-2.0
#include "core/mesh_tools/repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/counted.h"
#include "core/mesh_tools/polygon.h"
#include "core/mesh_tools/weld.h"
#include "core/parallel.h"

namespace diesink {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

class Repair {
 public:
  Repair(TriangleMesh& mesh, const RepairOptions& options) : mesh_(mesh), options_(options) {}

  RepairReport run() {
    report_.before = counted(false);
    tell_progress(0.25);
    if (options_.weld > 0) {
      const WeldReport welded = weld(mesh_, options_.weld);
      report_.merged_vertices += welded.merged_vertices;
      report_.removed_degenerate += welded.collapsed_triangles;
    }
    report_.merged_vertices += weld(mesh_).merged_vertices;
    tell_progress(0.4);
    remove_useless();
    tell_progress(0.5);
    orient();
    tell_progress(0.65);
    split();
    fill();
    tell_progress(0.8);
    report_.after = counted(true);
    return std::move(report_);
  }

 private:
  // What that tells of its own progress is no part of the whole's.
  MeshTopology counted(bool as_shared) {
    const ProgressSpan silent;
    return topology_of(mesh_, as_shared);
  }

  void remove_useless() {
    const ProgressSpan silent;
    std::vector<bool> keep(mesh_.triangles.size(), true);
    for (const std::uint32_t i : find_duplicates(mesh_.triangles)) keep[i] = false;
    for (std::size_t i = 0; i < keep.size(); ++i) {
      const Triangle& t = mesh_.triangles[i];
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
        ++report_.removed_degenerate;
        keep[i] = false;
      } else if (!keep[i]) {
        ++report_.removed_duplicates;
      }
    }
    keep_triangles(mesh_, keep);
  }

  void flip(std::size_t t) {
    std::swap(mesh_.triangles[t][1], mesh_.triangles[t][2]);
    ++report_.flipped;
    if (mesh_.corner_normals.empty()) return;
    std::swap(mesh_.corner_normals[t][1], mesh_.corner_normals[t][2]);
    for (std::uint32_t& n : mesh_.corner_normals[t]) {
      const auto [at, is_new] =
          reversed_.emplace(n, static_cast<std::uint32_t>(mesh_.normals.size()));
      if (is_new) {
        const Vec3 other_way = -mesh_.normals[n];
        mesh_.normals.push_back(other_way + Vec3::Zero());
        reversed_.emplace(at->second, n);
      }
      n = at->second;
    }
  }

  // Shells over edges of two triangles, each turned the way most of its triangles are.
  void orient() {
    const std::size_t count = mesh_.triangles.size();
    const std::vector<EdgeUse> uses = edge_uses(mesh_.triangles, mesh_.positions.size());
    struct Neighbour {
      std::uint32_t triangle;
      bool opposed;
    };
    std::vector<std::array<Neighbour, 3>> neighbours(count);
    std::vector<std::uint8_t> degree(count, 0), open(count, 0);
    for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
      const std::uint32_t a = edge[0].corner / 3;
      if (edge.size() != 2) {
        for (const EdgeUse& use : edge) open[use.corner / 3] = 1;
        return;
      }
      const std::uint32_t b = edge[1].corner / 3;
      const bool opposed = edge[0].forward == edge[1].forward;
      neighbours[a][degree[a]++] = {b, opposed};
      neighbours[b][degree[b]++] = {a, opposed};
    });
    enum : std::uint8_t { kUnseen, kStays, kTurns };
    std::vector<std::uint8_t> verdict(count, kUnseen);
    std::vector<std::uint32_t> shell;
    for (std::uint32_t seed = 0; seed < count; ++seed) {
      if (verdict[seed] != kUnseen) continue;
      shell.assign(1, seed);
      verdict[seed] = kStays;
      bool orientable = true, closed = true;
      std::size_t turned = 0;
      for (std::size_t i = 0; i < shell.size(); ++i) {
        const std::uint32_t t = shell[i];
        if (open[t] != 0) closed = false;
        for (std::size_t k = 0; k < degree[t]; ++k) {
          const Neighbour& other = neighbours[t][k];
          const std::uint8_t wanted = (verdict[t] == kTurns) != other.opposed ? kTurns : kStays;
          if (verdict[other.triangle] == kUnseen) {
            verdict[other.triangle] = wanted;
            turned += wanted == kTurns ? 1 : 0;
            shell.push_back(other.triangle);
          } else if (verdict[other.triangle] != wanted) {
            orientable = false;
          }
        }
      }
      if (!orientable) {
        ++report_.unorientable;
        continue;
      }
      bool swap = 2 * turned > shell.size();
      // A closed shell that was consistent may bound a cavity and stays; one that was not is turned
      // outside out.
      if (closed && turned > 0) swap = volume_of(shell, verdict, kTurns) < 0;
      for (const std::uint32_t t : shell) {
        if ((verdict[t] == kTurns) != swap) flip(t);
      }
    }
    // All of it inside out, where it is closed.
    if (report_.before.boundary_edges == 0 && topology_of(mesh_).volume < 0) {
      for (std::size_t t = 0; t < count; ++t) flip(t);
    }
  }

  double volume_of(const std::vector<std::uint32_t>& shell,
                   const std::vector<std::uint8_t>& verdict, std::uint8_t turns) const {
    const Vec3 origin = mesh_.positions[mesh_.triangles[shell[0]][0]];
    double volume = 0;
    for (const std::uint32_t t : shell) {
      const Triangle& v = mesh_.triangles[t];
      const Vec3 a = mesh_.positions[v[0]] - origin, b = mesh_.positions[v[1]] - origin,
                 c = mesh_.positions[v[2]] - origin;
      volume += (verdict[t] == turns ? -1 : 1) * a.dot(b.cross(c));
    }
    return volume;
  }

  // The uses of an edge of many triangles, each with the one that bounds the same material. Around
  // the edge, seen against its direction, the material of a triangle that runs along it forward
  // lies clockwise of it.
  void pair_up(std::span<const EdgeUse> edge, DisjointSets& fans) const {
    const Vec3 low = mesh_.positions[edge[0].low];
    const Vec3 axis = (mesh_.positions[edge[0].high] - low).normalized();
    const Vec3 across = axis.unitOrthogonal(), along = axis.cross(across);
    struct Leaf {
      double angle;
      const EdgeUse* use;
    };
    std::vector<Leaf> leaves;
    for (const EdgeUse& use : edge) {
      const std::uint32_t apex = mesh_.triangles[use.corner / 3][(use.corner % 3 + 2) % 3];
      const Vec3 out = mesh_.positions[apex] - low;
      leaves.push_back({std::atan2(out.dot(along), out.dot(across)), &use});
    }
    std::sort(leaves.begin(), leaves.end(), [](const Leaf& a, const Leaf& b) {
      return a.angle != b.angle ? a.angle < b.angle : a.use->corner < b.use->corner;
    });
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      const EdgeUse& lower = *leaves[i].use;
      const EdgeUse& upper = *leaves[(i + 1) % leaves.size()].use;
      if (lower.forward || !upper.forward) continue;
      fans.join(corner_at_low(lower), corner_at_low(upper));
      fans.join(corner_at_high(lower), corner_at_high(upper));
    }
  }

  // Every set of triangles that hangs together at a vertex but the first gets a copy of it.
  void split() {
    const std::vector<EdgeUse> uses = edge_uses(mesh_.triangles, mesh_.positions.size());
    DisjointSets fans(3 * mesh_.triangles.size());
    for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
      if (edge.size() == 2) {
        fans.join(corner_at_low(edge[0]), corner_at_low(edge[1]));
        fans.join(corner_at_high(edge[0]), corner_at_high(edge[1]));
      } else if (edge.size() > 2) {
        ++report_.split_edges;
        pair_up(edge, fans);
      }
    });
    constexpr std::uint32_t kNone = 0xFFFFFFFFU;
    std::vector<std::uint32_t> first_fan(mesh_.positions.size(), kNone);
    std::vector<std::uint32_t> vertex_of_fan(3 * mesh_.triangles.size(), kNone);
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t fan = fans.find(3 * t + k);
        std::uint32_t& vertex = vertex_of_fan[fan];
        const std::uint32_t v = mesh_.triangles[t][k];
        if (vertex == kNone && first_fan[v] == kNone) {
          first_fan[v] = fan;
          vertex = v;
        } else if (vertex == kNone) {
          vertex = static_cast<std::uint32_t>(mesh_.positions.size());
          const Vec3 copy = mesh_.positions[v];
          mesh_.positions.push_back(copy);
          if (!mesh_.vertex_colors.empty()) {
            const std::array<std::uint8_t, 4> color = mesh_.vertex_colors[v];
            mesh_.vertex_colors.push_back(color);
          }
          ++report_.split_vertices;
        }
      }
    }
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (std::uint32_t k = 0; k < 3; ++k)
        mesh_.triangles[t][k] = vertex_of_fan[fans.find(3 * t + k)];
    }
  }

  void fill() {
    double size = options_.max_hole;
    if (size < 0) size = (report_.before.bounds[1] - report_.before.bounds[0]).norm() / 20;
    if (!(size > 0)) return;
    constexpr std::uint32_t kNone = 0xFFFFFFFFU;
    // After the split a vertex has at most one side without a neighbour that starts at it.
    std::vector<std::uint32_t> side_from(mesh_.positions.size(), kNone);
    for_each_edge(edge_uses(mesh_.triangles, mesh_.positions.size()),
                  [&](std::span<const EdgeUse> edge) {
                    edges_.push_back(edge_key(edge[0].low, edge[0].high));
                    if (edge.size() == 1)
                      side_from[edge[0].forward ? edge[0].low : edge[0].high] = edge[0].corner;
                  });
    std::sort(edges_.begin(), edges_.end());
    std::vector<std::uint32_t> loop;
    for (std::uint32_t start = 0; start < side_from.size(); ++start) {
      if (side_from[start] == kNone) continue;
      const std::uint32_t triangle = side_from[start] / 3;
      loop.clear();
      std::uint32_t at = start;
      while (at != kNone && side_from[at] != kNone) {
        loop.push_back(at);
        const std::uint32_t corner = std::exchange(side_from[at], kNone);
        at = mesh_.triangles[corner / 3][(corner % 3 + 1) % 3];
      }
      if (at == start && loop.size() >= 3) fill_loop(loop, triangle, size);
    }
  }

  void fill_loop(std::vector<std::uint32_t>& loop, std::uint32_t neighbour, double size) {
    // The hole's triangles run along its edges the other way.
    std::reverse(loop.begin(), loop.end());
    std::vector<Vec3> corners;
    for (const std::uint32_t v : loop) corners.push_back(mesh_.positions[v]);
    Vec3 low = corners[0], high = corners[0];
    for (const Vec3& p : corners) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    if ((high - low).norm() > size) return;
    std::vector<Triangle> cut;
    if (!cut_polygon(corners, cut)) return;
    if (!closes(loop, cut)) {
      // A corner triangle of a sheet's border would be repeated, its third edge have four
      // triangles.
      const auto last = static_cast<std::uint32_t>(loop.size());
      cut.clear();
      for (std::uint32_t i = 0; i < last; ++i) cut.push_back({i, (i + 1) % last, last});
      Vec3 middle = Vec3::Zero();
      for (const Vec3& p : corners) middle += p / static_cast<double>(last);
      if (!mesh_.vertex_colors.empty()) mesh_.vertex_colors.push_back(mesh_.vertex_colors[loop[0]]);
      loop.push_back(static_cast<std::uint32_t>(mesh_.positions.size()));
      mesh_.positions.push_back(middle);
    }
    ++report_.filled_holes;
    report_.added_triangles += cut.size();
    for (const Triangle& c : cut) {
      const Triangle t{loop[c[0]], loop[c[1]], loop[c[2]]};
      mesh_.triangles.push_back(t);
      if (!mesh_.triangle_element.empty())
        mesh_.triangle_element.push_back(mesh_.triangle_element[neighbour]);
      if (mesh_.corner_normals.empty()) continue;
      const Vec3 a = mesh_.positions[t[0]];
      const Vec3 normal = (mesh_.positions[t[1]] - a).cross(mesh_.positions[t[2]] - a);
      const double length = normal.norm();
      const auto number = static_cast<std::uint32_t>(mesh_.normals.size());
      mesh_.normals.push_back(length > 0 ? Vec3(normal / length) : Vec3(Vec3::UnitZ()));
      mesh_.corner_normals.push_back({number, number, number});
    }
  }

  static std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
  }

  // No edge across the hole is there already.
  [[nodiscard]] bool closes(const std::vector<std::uint32_t>& loop,
                            const std::vector<Triangle>& cut) const {
    const auto count = static_cast<std::uint32_t>(loop.size());
    for (const Triangle& t : cut) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3];
        if ((a + 1) % count == b || (b + 1) % count == a) continue;
        if (std::binary_search(edges_.begin(), edges_.end(), edge_key(loop[a], loop[b])))
          return false;
      }
    }
    return true;
  }

  TriangleMesh& mesh_;
  const RepairOptions& options_;
  std::vector<std::uint64_t> edges_;  // before holes are filled, sorted
  RepairReport report_;
  std::map<std::uint32_t, std::uint32_t> reversed_;
};

void add_row(std::string& text, std::string_view what, std::size_t before, std::size_t after) {
  const auto padded = [](std::string word, std::size_t width) {
    return word.size() < width ? std::string(width - word.size(), ' ') + word : word;
  };
  text += what;
  text += padded(std::to_string(before), 34 - std::min<std::size_t>(what.size(), 33));
  text += padded(std::to_string(after), 12) + "\n";
}

}  // namespace

RepairReport repair(TriangleMesh& mesh, const RepairOptions& options) {
  return Repair(mesh, options).run();
}

std::string to_text(const RepairReport& report) {
  const MeshTopology &b = report.before, &a = report.after;
  std::string text = "                            before       after\n";
  add_row(text, "vertices", b.vertices, a.vertices);
  add_row(text, "triangles", b.triangles, a.triangles);
  add_row(text, "shells", b.shells, a.shells);
  add_row(text, "degenerate triangles", b.degenerate, a.degenerate);
  add_row(text, "repeated triangles", b.duplicates, a.duplicates);
  add_row(text, "boundary edges", b.boundary_edges, a.boundary_edges);
  add_row(text, "boundary loops", b.boundary_loops, a.boundary_loops);
  add_row(text, "misoriented edges", b.misoriented_edges, a.misoriented_edges);
  add_row(text, "non-manifold edges", b.nonmanifold_edges, a.nonmanifold_edges);
  add_row(text, "non-manifold vertices", b.nonmanifold_vertices, a.nonmanifold_vertices);
  const auto did = [&](std::size_t count, std::string_view words) {
    if (count > 0) text += counted(count, words) + "\n";
  };
  did(report.merged_vertices, "vertex|vertices| merged");
  did(report.removed_degenerate, "degenerate triangle|degenerate triangles| removed");
  did(report.removed_duplicates, "repeated triangle|repeated triangles| removed");
  did(report.flipped, "triangle|triangles| turned over");
  did(report.split_edges, "edge|edges| of more than two triangles taken apart");
  did(report.split_vertices, "vertex|vertices| doubled where surfaces only touched");
  did(report.filled_holes, "hole|holes| filled");
  did(report.added_triangles, "triangle|triangles| added");
  did(report.unorientable, "one-sided shell|one-sided shells| left as is");
  text += a.watertight ? "watertight\n" : "not watertight: " + a.why_not + "\n";
  return text;
}

}  // namespace diesink
