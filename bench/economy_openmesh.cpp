// OpenMesh's decimater, held to the tolerance by a module of our own.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "bench/economy.h"
#include "bench/economy_openmesh.h"

namespace diesink::bench {
namespace {

// Refuses a collapse that makes a triangle or crease edge deviate by more than the tolerance.
template <class M>
class KeepsTolerance : public OpenMesh::Decimater::ModBaseT<M> {
 public:
  DECIMATING_MODULE(KeepsTolerance, M, KeepsTolerance);
  explicit KeepsTolerance(M& mesh) : Base(mesh, true) {}
  void set(const Surfaces* surfaces, const std::vector<std::vector<std::uint32_t>>* of,
           double tolerance) {
    surfaces_ = surfaces;
    of_ = of;
    tolerance_ = tolerance;
  }
  float collapse_priority(const CollapseInfo& ci) override {
    const auto index = [](auto handle) { return static_cast<std::uint32_t>(handle.idx()); };
    const auto point = [&](auto handle) {
      const auto& p = Base::mesh().point(handle);
      return Vec3(p[0], p[1], p[2]);
    };
    const std::uint32_t to = index(ci.v1);
    // A crease stays one, a corner stays.
    for (const std::uint32_t k : (*of_)[index(ci.v0)]) {
      if (!has(to, k)) return float(Base::ILLEGAL_COLLAPSE);
    }
    for (auto f = Base::mesh().cvf_iter(ci.v0); f.is_valid(); ++f) {
      if (*f == ci.fl || *f == ci.fr) continue;
      std::array<typename M::VertexHandle, 3> v;
      std::size_t n = 0;
      for (auto fv = Base::mesh().cfv_iter(*f); fv.is_valid(); ++fv)
        v[n++] = *fv == ci.v0 ? ci.v1 : *fv;
      double best = 1e300;
      for (const std::uint32_t k : (*of_)[index(v[0])]) {
        if (has(index(v[1]), k) && has(index(v[2]), k)) {
          best = std::fmin(best,
                           triangle_error((*surfaces_)[k], point(v[0]), point(v[1]), point(v[2])));
        }
      }
      if (best > tolerance_) return float(Base::ILLEGAL_COLLAPSE);
      for (std::size_t e = 0; e < 3; ++e) {
        const auto p = v[e], q = v[(e + 1) % 3];
        if (p != ci.v1 && q != ci.v1) continue;
        std::array<std::uint32_t, 2> both{};
        std::size_t common = 0;
        for (const std::uint32_t k : (*of_)[index(p)]) {
          if (has(index(q), k) && common < 2) both[common++] = k;
        }
        if (common == 2 && (*of_)[index(ci.v0)].size() > 1 &&
            chord_error((*surfaces_)[both[0]], (*surfaces_)[both[1]], point(p), point(q)) >
                tolerance_)
          return float(Base::ILLEGAL_COLLAPSE);
      }
    }
    return float(Base::LEGAL_COLLAPSE);
  }

 private:
  [[nodiscard]] bool has(std::uint32_t v, std::uint32_t k) const {
    return std::count((*of_)[v].begin(), (*of_)[v].end(), k) > 0;
  }
  const Surfaces* surfaces_ = nullptr;
  const std::vector<std::vector<std::uint32_t>>* of_ = nullptr;
  double tolerance_ = 0;
};

}  // namespace

Soup decimated(const Scene& scene, double tolerance, double& seconds) {
  const Soup fine = ours(scene, 0.1 * tolerance, seconds);
  const double start = now();
  Mesh mesh;
  std::vector<Mesh::VertexHandle> handle;
  const Surfaces surfaces(scene, 0.1 * tolerance);
  std::vector<std::vector<std::uint32_t>> of(fine.points.size());
  for (std::size_t v = 0; v < fine.points.size(); ++v) {
    const Vec3& p = fine.points[v];
    handle.push_back(mesh.add_vertex({p.x(), p.y(), p.z()}));
    surfaces.at(p, of[v]);
  }
  for (const auto& t : fine.triangles) mesh.add_face(handle[t[0]], handle[t[1]], handle[t[2]]);
  mesh.request_face_normals();
  mesh.request_vertex_status();
  mesh.request_edge_status();
  mesh.request_face_status();
  mesh.update_face_normals();
  {
    OpenMesh::Decimater::DecimaterT<Mesh> decimater(mesh);
    OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
    OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle flipping;
    KeepsTolerance<Mesh>::Handle keeps;
    decimater.add(quadric);
    decimater.add(flipping);
    decimater.add(keeps);
    decimater.module(flipping).set_max_normal_deviation(30);
    decimater.module(keeps).set(&surfaces, &of, tolerance);
    decimater.initialize();
    decimater.decimate();
  }
  seconds = now() - start;
  return {fine.points, triangles_left(mesh)};
}

}  // namespace diesink::bench
