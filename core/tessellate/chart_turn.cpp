// SPDX-License-Identifier: Apache-2.0
#include "core/tessellate/chart_turn.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace diesink {
namespace {

// Enough for a sharp end of an ellipse of 20 to 1 to lie between a few steps. A cubic between steps
// stays monotone while neither end's rate is over three times the mean, which holds at any ratio:
// at the sharpest end the rate grows no faster than linearly.
constexpr int kSteps = 128;
constexpr double kStep = 2 * std::numbers::pi / kSteps;

struct CubicStep {
  double v0, v1, m0, m1;  // values and rates by the fraction of the step

  [[nodiscard]] double at(double x) const {
    const double d = v1 - v0;
    return v0 + x * (m0 + x * ((3 * d - 2 * m0 - m1) + x * (m0 + m1 - 2 * d)));
  }
  [[nodiscard]] double rate(double x) const {
    const double d = v1 - v0;
    return m0 + x * (2 * (3 * d - 2 * m0 - m1) + x * 3 * (m0 + m1 - 2 * d));
  }
};

}  // namespace

template <class Rate>
void TurnTable::fill(const Rate& rate) {
  // Gauss-Legendre of order 5 in each step.
  constexpr std::array<double, 5> kAt{0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842,
                                      0.953089922969332};
  constexpr std::array<double, 5> kWeight{0.118463442528095, 0.239314335249683, 0.284444444444444,
                                          0.239314335249683, 0.118463442528095};
  value_.assign(kSteps + 1, 0);
  rate_.assign(kSteps + 1, 0);
  for (int k = 0; k <= kSteps; ++k) {
    const double turn = (k - kSteps / 2) * kStep;
    const auto at = static_cast<std::size_t>(k);
    rate_[at] = rate(turn);
    if (k == kSteps) break;
    double sum = 0;
    for (std::size_t i = 0; i < kAt.size(); ++i) sum += kWeight[i] * rate(turn + kAt[i] * kStep);
    value_[at + 1] = value_[at] + sum * kStep;
  }
  const double middle = value_[kSteps / 2];
  for (double& v : value_) v -= middle;
}

TurnTable TurnTable::ellipse(double a, double b, double start) {
  TurnTable table;
  table.constant_ = a;
  if (a == b) return table;
  table.fill([&](double turn) {
    return std::hypot(a * std::sin(start + turn), b * std::cos(start + turn));
  });
  return table;
}

TurnTable TurnTable::cone(double a, double b, double c, double start) {
  TurnTable table;
  table.constant_ = a / std::hypot(a, c);
  if (a == b) return table;
  // |p x p'| / |p|² of the ruling p = (a cos t, b sin t, -c).
  table.fill([&](double turn) {
    const double x = std::cos(start + turn), y = std::sin(start + turn);
    const double cross2 = c * c * (a * a * y * y + b * b * x * x) + a * a * b * b;
    return std::sqrt(cross2) / (a * a * x * x + b * b * y * y + c * c);
  });
  return table;
}

double TurnTable::first() const {
  return value_.empty() ? -std::numbers::pi * constant_ : value_.front();
}

double TurnTable::last() const {
  return value_.empty() ? std::numbers::pi * constant_ : value_.back();
}

double TurnTable::at(double turn) const {
  if (value_.empty()) return constant_ * turn;
  const double scaled = turn / kStep + kSteps / 2;
  const int k = static_cast<int>(std::clamp(std::floor(scaled), 0.0, kSteps - 1.0));
  const auto i = static_cast<std::size_t>(k);
  const CubicStep step{value_[i], value_[i + 1], rate_[i] * kStep, rate_[i + 1] * kStep};
  return step.at(std::clamp(scaled - k, 0.0, 1.0));
}

double TurnTable::rate(double turn) const {
  if (value_.empty()) return constant_;
  const double scaled = turn / kStep + kSteps / 2;
  const int k = static_cast<int>(std::clamp(std::floor(scaled), 0.0, kSteps - 1.0));
  const auto i = static_cast<std::size_t>(k);
  const CubicStep step{value_[i], value_[i + 1], rate_[i] * kStep, rate_[i + 1] * kStep};
  return step.rate(std::clamp(scaled - k, 0.0, 1.0)) / kStep;
}

double TurnTable::inverse(double s) const {
  if (value_.empty()) return s / constant_;
  const auto above = std::upper_bound(value_.begin() + 1, value_.end() - 1, s);
  const auto i = static_cast<std::size_t>(above - value_.begin() - 1);
  const CubicStep step{value_[i], value_[i + 1], rate_[i] * kStep, rate_[i + 1] * kStep};
  // Newton, kept inside the part that still holds the root.
  double lo = 0, hi = 1, x = (s - step.v0) / (step.v1 - step.v0);
  for (int k = 0; k < 60; ++k) {
    const double off = step.at(x) - s;
    (off > 0 ? hi : lo) = x;
    double next = x - off / step.rate(x);
    if (!(next >= lo && next <= hi)) next = 0.5 * (lo + hi);
    const bool done = std::fabs(next - x) < 1e-15;
    x = next;
    if (done) break;
  }
  return (static_cast<double>(i) - kSteps / 2 + x) * kStep;
}

}  // namespace diesink
