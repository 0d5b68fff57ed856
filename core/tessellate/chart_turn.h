// A smooth increasing function of an angle: arc length of an ellipse, developed angle of a cone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace diesink {

// s(turn) for turn in [-pi, pi], s(0) = 0: a cubic through its exact values and derivatives at even
// steps, and that cubic's own inverse, so that going there and back loses nothing.
class TurnTable {
 public:
  TurnTable() = default;  // s = turn

  // Arc length of the ellipse (a cos t, b sin t) from t = start; turn = t - start.
  static TurnTable ellipse(double a, double b, double start);

  // Angle that a cone's side turns through when it is rolled out flat: base ellipse as above,
  // height c.
  static TurnTable cone(double a, double b, double c, double start);

  [[nodiscard]] double at(double turn) const;
  [[nodiscard]] double rate(double turn) const;  // ds / dturn
  // Needs: s in [first(), last()].
  [[nodiscard]] double inverse(double s) const;
  [[nodiscard]] double first() const;  // s(-pi)
  [[nodiscard]] double last() const;   // s(pi)

 private:
  template <class Rate>
  void fill(const Rate& rate);

  double constant_ = 1;               // of a circular one: s = constant_ turn
  std::vector<double> value_, rate_;  // empty for a circular one
};

}  // namespace diesink
