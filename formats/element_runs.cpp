// SPDX-License-Identifier: Apache-2.0
#include "formats/element_runs.h"

#include <array>

namespace diesink {
namespace {

constexpr std::array kCurveKinds{CurveKind::kCrease, CurveKind::kEdge, CurveKind::kJump,
                                 CurveKind::kOther};

}  // namespace

ElementRuns element_runs(const TriangleMesh& mesh) {
  ElementRuns runs;
  const std::size_t elements = std::max<std::size_t>(mesh.elements.size(), 1);
  runs.begin.assign(elements + 1, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) ++runs.begin[element_of(mesh, t) + 1];
  for (std::size_t e = 0; e < elements; ++e) runs.begin[e + 1] += runs.begin[e];
  std::vector<std::size_t> next(runs.begin.begin(), runs.begin.end() - 1);
  runs.triangles.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    runs.triangles[next[element_of(mesh, t)]++] = static_cast<std::uint32_t>(t);
  }
  return runs;
}

std::string one_line(std::string_view text) {
  std::string line(text);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '_';
  }
  return line;
}

std::string_view name_of(CurveKind kind) {
  switch (kind) {
    case CurveKind::kCrease:
      return "crease";
    case CurveKind::kEdge:
      return "edge";
    case CurveKind::kJump:
      return "jump";
    case CurveKind::kOther:
      break;
  }
  return "curve";
}

std::string curve_label(const TriangleMesh& mesh, const MeshCurve& curve) {
  std::string label(name_of(curve.kind));
  label += ':';
  if (curve.between[0] >= mesh.elements.size() && curve.between[1] >= mesh.elements.size()) {
    return label + one_line(curve.name);
  }
  for (std::size_t side = 0; side < 2; ++side) {
    if (side == 1) label += '|';
    if (curve.between[side] < mesh.elements.size()) {
      label += one_line(mesh.elements[curve.between[side]].name);
    }
  }
  if (!curve.name.empty()) label += "|" + one_line(curve.name);
  return label;
}

bool read_curve_label(std::string_view label, const TriangleMesh& mesh, MeshCurve& curve) {
  for (const CurveKind kind : kCurveKinds) {
    const std::string_view word = name_of(kind);
    if (label.size() <= word.size() || label.substr(0, word.size()) != word ||
        label[word.size()] != ':')
      continue;
    curve.kind = kind;
    const std::string_view rest = label.substr(word.size() + 1);
    const std::size_t bar = rest.find('|');
    if (bar == std::string_view::npos) {
      curve.name = std::string(rest);
      return true;
    }
    std::array sides{rest.substr(0, bar), rest.substr(bar + 1)};
    if (const std::size_t second = sides[1].find('|'); second != std::string_view::npos) {
      curve.name = std::string(sides[1].substr(second + 1));
      sides[1] = sides[1].substr(0, second);
    }
    for (std::size_t side = 0; side < 2; ++side) {
      for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        if (!sides[side].empty() && one_line(mesh.elements[e].name) == sides[side]) {
          curve.between[side] = static_cast<std::uint32_t>(e);
          break;
        }
      }
    }
    return true;
  }
  return false;
}

}  // namespace diesink
