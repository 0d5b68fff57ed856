// SPDX-License-Identifier: Apache-2.0
#include "core/solids/polyhedron.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/number.h"
#include "core/solids/frame.h"

namespace diesink {
namespace {

using Loop = std::vector<std::uint8_t>;

std::string corner_name(std::size_t corner) { return 'P' + std::to_string(corner + 1); }

// "face3 (P3 P4 P8 P7)" with the numbers of the program's statements.
std::string face_text(std::size_t number, const FaceCorners& face) {
  std::string text = "face" + std::to_string(number) + " (";
  for (std::size_t k = 0; k < face.count; ++k) {
    text += (k > 0 ? " " : "") + corner_name(face.corner[k]);
  }
  return text + ')';
}

// The face's corners as vertices, neighbours that coincide once.
Loop loop_of(const FaceCorners& face, std::span<const std::uint8_t> vertex_of) {
  Loop loop;
  for (std::size_t k = 0; k < face.count; ++k) {
    const std::uint8_t vertex = vertex_of[face.corner[k]];
    if (loop.empty() || loop.back() != vertex) loop.push_back(vertex);
  }
  while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
  return loop;
}

// Width of a loop: the largest distance of a vertex from the line through the two that lie farthest
// apart.
double width_of(const Loop& loop, const std::vector<Vec3>& at) {
  Vec3 from = at[loop[0]], to = from;
  for (const std::uint8_t a : loop) {
    for (const std::uint8_t b : loop) {
      if ((at[b] - at[a]).squaredNorm() > (to - from).squaredNorm()) from = at[a], to = at[b];
    }
  }
  const double length = (to - from).norm();
  if (length == 0) return 0;
  double width = 0;
  for (const std::uint8_t v : loop) {
    width = std::max(width, (at[v] - from).cross(to - from).norm() / length);
  }
  return width;
}

// Newell's normal about the first vertex: differences of equal coordinates vanish before they are
// multiplied, so a loop parallel to an axis has a normal with exact zeros. Length: twice the area.
Vec3 area_vector(const Loop& loop, const std::vector<Vec3>& at) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 1; k + 1 < loop.size(); ++k) {
    const Vec3 a = at[loop[k]] - at[loop[0]], b = at[loop[k + 1]] - at[loop[0]];
    sum += a.cross(b);
  }
  return sum;
}

Plane plane_of(const Loop& loop, const std::vector<Vec3>& at, double width) {
  Plane plane;
  plane.n = unit(area_vector(loop, at));
  // A component within the rounding of the corners themselves is zero: walls meant vertical are
  // vertical.
  double largest = 0;
  for (const std::uint8_t v : loop) largest = std::max(largest, at[v].cwiseAbs().maxCoeff());
  const double noise = 4 * std::numeric_limits<double>::epsilon() * largest / width;
  bool snapped = false;
  for (int k = 0; k < 3; ++k) {
    if (plane.n[k] != 0 && std::fabs(plane.n[k]) < std::min(noise, 1e-9)) {
      plane.n[k] = 0;
      snapped = true;
    }
  }
  if (snapped) plane.n = unit(plane.n);
  Vec3 offset = Vec3::Zero();
  for (const std::uint8_t v : loop) offset += at[v] - at[loop[0]];
  const Vec3 middle = at[loop[0]] + offset / static_cast<double>(loop.size());
  plane.d = -plane.n.dot(middle) + 0.0;
  return plane;
}

double height_over(const Plane& plane, const Vec3& p) { return plane.n.dot(p) + plane.d; }

// How far a corner lies to the right of an edge at the most: > 0 where the loop turns the wrong way
// or crosses itself. Edges shorter than `least` have no direction worth the name and are passed
// over.
double turning_fault(const Loop& loop, const std::vector<Vec3>& at, const Vec3& normal,
                     double least) {
  double fault = 0;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Vec3& a = at[loop[k]];
    const Vec3 edge = at[loop[(k + 1) % loop.size()]] - a;
    if (edge.norm() <= least) continue;
    for (const std::uint8_t v : loop) {
      fault = std::max(fault, -edge.cross(at[v] - a).dot(normal) / edge.norm());
    }
  }
  return fault;
}

Error input_error(std::string message) { return {ErrorCode::kInput, std::move(message), {}}; }

}  // namespace

Result<Body> make_polyhedron(std::span<const Vec3> corners, std::span<const FaceCorners> faces) {
  Polyhedron body;
  body.vertices.assign(corners.begin(), corners.end());
  const std::array<Vec3, 2> box = bounds_of(Body(body));
  const double size = (box[1] - box[0]).norm();
  if (size < kLeastLength) return input_error("the solid has no extent: its corners coincide");
  const double allowed = kPlanarity * size;
  const std::string flat = "the solid is flat: its corners lie in one plane";

  body.vertices.clear();
  std::vector<std::uint8_t> vertex_of;
  std::vector<std::size_t> corner_of;  // first corner at a vertex, for messages
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const auto same = std::ranges::find_if(body.vertices, [&](const Vec3& v) {
      return (v - corners[c]).norm() <= kCoincidence * size;
    });
    vertex_of.push_back(static_cast<std::uint8_t>(same - body.vertices.begin()));
    if (same == body.vertices.end()) {
      body.vertices.push_back(corners[c]);
      corner_of.push_back(c);
    }
  }
  const std::vector<Vec3>& at = body.vertices;

  double volume = 0;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    PolyhedronFace face;
    face.number = static_cast<std::uint8_t>(f + 1);
    face.loop = loop_of(faces[f], vertex_of);
    const double width = face.loop.size() < 3 ? 0 : width_of(face.loop, at);
    if (width <= 2 * kCoincidence * size) continue;
    if (width <= allowed) {
      return input_error(face_text(f + 1, faces[f]) + " is only " + number_text(width) +
                         " wide; corners meant to coincide or to lie in line must do so");
    }
    const Vec3 area = area_vector(face.loop, at);
    if (area.norm() <= 1e-6 * width * width) {
      return input_error(face_text(f + 1, faces[f]) +
                         " crosses itself; its corners are needed in order around it");
    }
    face.plane = plane_of(face.loop, at, width);
    double off = 0;
    for (const std::uint8_t v : face.loop) {
      off = std::max(off, std::fabs(height_over(face.plane, at[v])));
    }
    if (off > allowed) {
      return input_error(face_text(f + 1, faces[f]) + " is not planar: a corner lies " +
                         number_text(off) + " off it (allowed: " + number_text(allowed) + ')');
    }
    if (turning_fault(face.loop, at, face.plane.n, allowed) > allowed) {
      return input_error(face_text(f + 1, faces[f]) +
                         " is not convex or crosses itself; its corners are needed in order "
                         "around it");
    }
    double depth = 0;
    for (const Vec3& v : at) depth = std::max(depth, std::fabs(height_over(face.plane, v)));
    if (depth <= allowed) return input_error(flat);
    volume += area.dot(at[face.loop[0]] - at[0]);
    body.faces.push_back(std::move(face));
  }
  if (body.faces.size() < 4) return input_error(flat);

  if (volume < 0) {
    for (PolyhedronFace& face : body.faces) {
      std::reverse(face.loop.begin() + 1, face.loop.end());
      face.plane.n = (-face.plane.n).array() + 0.0;
      face.plane.d = -face.plane.d + 0.0;
    }
  }
  for (const PolyhedronFace& face : body.faces) {
    for (std::size_t v = 0; v < at.size(); ++v) {
      const double outside = height_over(face.plane, at[v]);
      if (outside <= allowed) continue;
      return input_error("the solid is not convex: " + corner_name(corner_of[v]) + " lies " +
                         number_text(outside) + " outside " +
                         face_text(face.number, faces[face.number - 1u]));
    }
  }
  return Body(std::move(body));
}

void stand_upright(Polyhedron& body, double width) {
  constexpr double kMostLean = 1e-6;  // lest a face that is small altogether be taken for a wall
  for (PolyhedronFace& face : body.faces) {
    Plane& plane = face.plane;
    double low = body.vertices[face.loop[0]].z(), high = low;
    for (const std::uint8_t v : face.loop) {
      low = std::min(low, body.vertices[v].z());
      high = std::max(high, body.vertices[v].z());
    }
    const double lean = std::fabs(plane.n.z());
    if (lean == 0 || lean > kMostLean || lean * (high - low) > width) continue;
    plane.n = unit({plane.n.x(), plane.n.y(), 0});
    plane.d = -plane.n.dot(body.vertices[face.loop[0]]) + 0.0;
  }
}

}  // namespace diesink
