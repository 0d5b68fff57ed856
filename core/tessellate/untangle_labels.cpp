// Labels of the faces between chords: what the chords say, else what evaluation finds.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/tessellate/untangler.h"

namespace diesink {
namespace {

constexpr std::size_t kMostEvaluated = 64;  // triangles of a face that are asked for its label

}  // namespace

Vec2 Untangler::middle(std::uint32_t t) const {
  const auto& c = triangles_[t];
  return (points_[c[0]] + points_[c[1]] + points_[c[2]]) / 3;
}

double Untangler::area(std::uint32_t t) const {
  const auto& c = triangles_[t];
  const Vec2 u = points_[c[1]] - points_[c[0]], v = points_[c[2]] - points_[c[0]];
  return 0.5 * (u.x() * v.y() - u.y() * v.x());
}

Label Untangler::label_at(std::uint32_t t) const {
  const Vec2 p = middle(t);
  return surface_.evaluate_face(p.x(), p.y()).label;
}

void Untangler::tell(const Vec2& place, double doubtful) {
  if (!(doubtful > 0)) return;
  if (out_.uncertified_area == 0) out_.uncertified_place = place;
  out_.uncertified_area += doubtful;
}

void Untangler::label_face(const Face& face) {
  struct Said {
    std::uint32_t triangle, u, v;
    Label label;
    bool seam;
  };
  std::vector<Said> said;
  for (const std::uint32_t t : face.triangles) {
    const auto& c = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t u = c[k], v = c[(k + 1) % 3];
      const Chord* chord = chord_between(u, v);
      if (chord == nullptr) continue;
      for (const Claim& claim : chord->claims)
        said.push_back({t, u, v, u < v ? claim.left : claim.right, chord->seam});
    }
  }
  const auto agree = [&](const Said& s) { return s.label == said.front().label; };
  if (!said.empty() && std::ranges::all_of(said, agree)) {
    for (const std::uint32_t t : face.triangles) label_[t] = said.front().label;
    return;
  }
  std::vector<std::uint32_t> asked = face.triangles;
  std::ranges::stable_sort(asked,
                           [&](std::uint32_t a, std::uint32_t b) { return area(a) > area(b); });
  if (asked.size() > kMostEvaluated) asked.resize(kMostEvaluated);
  std::map<Label, double> found;  // what evaluation finds, and over how much
  for (const std::uint32_t t : asked) found[label_at(t)] += area(t);
  if (no_holes_) {
    found.erase(kNoLabel);
    for (const Said& s : said) {
      if (s.label != kNoLabel) found.try_emplace(s.label, 0.0);
    }
  }
  Label best = found.empty() ? kNoLabel : found.begin()->first;
  for (const auto& [label, share] : found) {
    if (share > found[best]) best = label;
  }
  // The other side of a cut between tiles has been made already, or will be, with the cut's labels.
  const auto first = std::ranges::find_if(said, [](const Said& s) { return s.seam; });
  bool one_by_one = false;
  if (first != said.end()) {
    best = first->label;
    one_by_one =
        std::ranges::any_of(said, [&](const Said& s) { return s.seam && s.label != best; });
  }
  for (const std::uint32_t t : face.triangles) label_[t] = one_by_one ? label_at(t) : best;
  for (const Said& s : said) {
    if (one_by_one && s.seam) label_[s.triangle] = s.label;
  }
  // What is not as its chords have it, or not as it is where it was asked; a chord that is wrong
  // tells of a square beside it.
  double whole = 0, doubtful = one_by_one ? HUGE_VAL : 0;
  for (const std::uint32_t t : face.triangles) whole += area(t);
  for (const auto& [label, share] : found) doubtful += label != best ? share : 0;
  const Said* wrong = nullptr;
  for (const Said& s : said) {
    if (s.label == best) continue;
    if (wrong == nullptr) wrong = &s;
    doubtful += (points_[s.v] - points_[s.u]).squaredNorm();
  }
  tell(wrong != nullptr ? Vec2(0.5 * (points_[wrong->u] + points_[wrong->v]))
                        : middle(face.triangles.front()),
       std::fmin(whole, doubtful));
}

void Untangler::label_faces() {
  triangles_ = triangulation_.triangles();
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const auto& c = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) left_of_[pair_key(c[k], c[(k + 1) % 3])] = t;
  }
  label_.assign(triangles_.size(), kNoLabel);
  std::vector<char> known(triangles_.size(), 0);
  for (std::uint32_t first = 0; first < triangles_.size(); ++first) {
    if (known[first]) continue;
    Face face;
    face.triangles.push_back(first);
    known[first] = 1;
    for (std::size_t k = 0; k < face.triangles.size(); ++k) {
      const auto& c = triangles_[face.triangles[k]];
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t u = c[e], v = c[(e + 1) % 3], other = across(u, v);
        if (other == kNone || known[other] || chord_between(u, v) != nullptr) continue;
        known[other] = 1;
        face.triangles.push_back(other);
      }
    }
    label_face(face);
  }
}

}  // namespace diesink
