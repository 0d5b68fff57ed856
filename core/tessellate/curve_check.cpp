// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/curve_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <unordered_map>

#include "core/compound/compound_impl.h"
#include "core/tessellate/arrangement.h"
#include "core/tessellate/implicit.h"
#include "core/tessellate/plan_curve.h"

namespace diesink {
namespace {

using Impl = CompoundSurface::Impl;

// Points of a circle about a vertex at which the scan is asked for where it stands upright.
constexpr int kRound = 16;

// Of the size: what vertices of curves are held to.
constexpr double kExact = 1e-9;

class CurveCheck {
 public:
  CurveCheck(const CompoundSurface& surface, Tessellation& made)
      : surface_(surface),
        impl_(surface.impl()),
        made_(made),
        certified_(std::fmax(made.report.tolerance, made.report.certified_deviation)),
        exact_(kExact * impl_.size + (std::holds_alternative<ScannedSurface>(impl_.base)
                                          ? kUnseen * made.report.tolerance
                                          : 0)) {}

  void run() {
    name_faces();
    for (const MeshCurve& curve : made_.mesh.curves) {
      for (std::size_t k = 0; k < curve.vertices.size(); ++k) check(curve, k);
    }
  }

 private:
  // What an element is made of: several where a solid stands in several rows.
  struct Faces {
    std::vector<Implicit> solids;
    bool base = false;
  };

  void name_faces();
  void check(const MeshCurve& curve, std::size_t k);
  // How far a point is off the nearest of the faces; 0 where it is no farther than is allowed.
  [[nodiscard]] double off_by(const Faces& faces, const Vec3& p) const;
  [[nodiscard]] bool is_on_base(const Vec3& p) const;

  const CompoundSurface& surface_;
  const Impl& impl_;
  Tessellation& made_;
  double certified_, exact_;
  std::vector<Faces> faces_;  // of each element
};

void CurveCheck::name_faces() {
  const std::vector<MeshElement>& elements = made_.mesh.elements;
  faces_.resize(elements.size());
  std::unordered_map<std::string_view, std::size_t> by_name;
  for (std::size_t e = 0; e < elements.size(); ++e) by_name.emplace(elements[e].name, e);
  for (const CompoundStep& step : impl_.steps) {
    if (step.kind != BooleanStep::Kind::kTerm) continue;
    std::vector<std::uint8_t> numbers{0};
    if (step.solid >= 0)
      numbers = face_numbers(impl_.bodies[static_cast<std::size_t>(step.solid)].body());
    for (const std::uint8_t number : numbers) {
      const Label label = make_label(step.row, number);
      const auto found = by_name.find(surface_.element_name(label));
      if (found == by_name.end()) continue;
      Faces& faces = faces_[found->second];
      if (step.solid < 0) {
        faces.base = true;
      } else {
        faces.solids.push_back(face_implicit(impl_, label));
      }
    }
  }
}

// (A vertex beside the scan, where it ends, is on it by rounding at the best.)
bool CurveCheck::is_on_base(const Vec3& p) const {
  BaseHit hit;
  const bool scan = std::holds_alternative<ScannedSurface>(impl_.base);
  const double near = scan ? certified_ : exact_;
  const auto reach = [&] { return near * std::sqrt(1 + hit.zx * hit.zx + hit.zy * hit.zy); };
  if (!impl_.base_at(p.x(), p.y(), hit)) return true;
  if (std::fabs(p.z() - hit.z) <= reach()) return true;
  if (!scan) return false;
  bool above = p.z() >= hit.z, below = p.z() <= hit.z;
  for (const double r : {0.1, 0.4, 1.0}) {
    for (int k = 0; k < kRound; ++k) {
      const double turn = 2 * std::numbers::pi * (k + r) / kRound;
      if (!impl_.base_at(p.x() + r * near * std::cos(turn), p.y() + r * near * std::sin(turn), hit))
        return true;
      above = above || p.z() >= hit.z - near;
      below = below || p.z() <= hit.z + near;
    }
  }
  return above && below;
}

double CurveCheck::off_by(const Faces& faces, const Vec3& p) const {
  if (faces.base && is_on_base(p)) return 0;
  // (How far off a base is not measured.)
  double off = faces.base ? certified_ : std::numeric_limits<double>::infinity();
  for (const Implicit& f : faces.solids) off = std::fmin(off, std::fabs(f.value(p)));
  return off <= exact_ ? 0 : off;
}

void CurveCheck::check(const MeshCurve& curve, std::size_t k) {
  const std::vector<std::uint32_t>& chain = curve.vertices;
  const Vec3& p = made_.mesh.positions[chain[k]];
  // Beside a wall a vertex is on one of the two: the nearest counts; else the farthest.
  const bool jump = curve.kind == CurveKind::kJump;
  double off = 0;
  std::uint32_t worst = MeshCurve::kNoElement;
  for (const std::uint32_t e : curve.between) {
    if (e == MeshCurve::kNoElement) continue;
    const double by = off_by(faces_[e], p);
    if (worst != MeshCurve::kNoElement && (jump ? by >= off : by <= off)) continue;
    off = by;
    worst = e;
  }
  if (off == 0) return;
  double length = 0;
  const auto add = [&](std::size_t i) {
    length += 0.5 * (made_.mesh.positions[chain[i]] - p).norm();
  };
  if (k > 0 || curve.closed) add(k > 0 ? k - 1 : chain.size() - 1);
  if (k + 1 < chain.size() || curve.closed) add(k + 1 < chain.size() ? k + 1 : 0);
  const double wide = std::fmin(off, certified_);
  made_.report.add_doubt(p, made_.mesh.elements[worst].name, "a curve is off its face there",
                         std::fmax(length, wide) * wide);
}

}  // namespace

void check_curves(const CompoundSurface& surface, Tessellation& made) {
  CurveCheck(surface, made).run();
}

}  // namespace diesink
