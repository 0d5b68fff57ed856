// SPDX-License-Identifier: Apache-2.0
#include "core/machining/pass_family.h"

#include <cmath>
#include <utility>

#include "core/base/ferguson.h"

namespace diesink {
namespace {

class StraightPasses final : public PassFamily {
 public:
  StraightPasses(const Machining& m, double angle)
      : along_(std::cos(angle), std::sin(angle)), square_(-along_.y(), along_.x()) {
    if (std::fabs(along_.x()) < 1e-15) along_.x() = square_.y() = 0;
    if (std::fabs(along_.y()) < 1e-15) along_.y() = square_.x() = 0;
    for (const double x : m.x_range) {
      for (const double y : m.y_range) {
        const Vec2 p(x, y);
        first_ = std::fmin(first_, p.dot(square_));
        last_ = std::fmax(last_, p.dot(square_));
        low_ = std::fmin(low_, p.dot(along_));
        high_ = std::fmax(high_, p.dot(along_));
      }
    }
  }
  [[nodiscard]] double first() const override { return first_; }
  [[nodiscard]] double last() const override { return last_; }
  [[nodiscard]] PlanCurve curve(double position) const override {
    return [this, position](double s) -> Vec2 {
      return (low_ + s * (high_ - low_)) * along_ + position * square_;
    };
  }
  [[nodiscard]] double step(double, double, double distance) const override { return distance; }

 private:
  Vec2 along_, square_;
  double first_ = 1e300, last_ = -1e300, low_ = 1e300, high_ = -1e300;
};

class IsoparametricPasses final : public PassFamily {
 public:
  IsoparametricPasses(FergusonSurface base, bool along_u)
      : base_(std::move(base)), along_u_(along_u) {}
  [[nodiscard]] double first() const override { return 0; }
  [[nodiscard]] double last() const override {
    return (along_u_ ? base_.rows() : base_.columns()) - 1;
  }
  [[nodiscard]] PlanCurve curve(double position) const override {
    return [this, position](double s) -> Vec2 { return at(position, s).r.head<2>(); };
  }
  [[nodiscard]] double step(double position, double s, double distance) const override {
    const FergusonSurface::Point p = at(position, s);
    const Vec2 along = (along_u_ ? p.ru : p.rv).head<2>(),
               across = (along_u_ ? p.rv : p.ru).head<2>();
    const double square = std::fabs(along.x() * across.y() - along.y() * across.x()) / along.norm();
    return distance / square;
  }

 private:
  [[nodiscard]] FergusonSurface::Point at(double position, double s) const {
    const double along = s * ((along_u_ ? base_.columns() : base_.rows()) - 1);
    return along_u_ ? base_.point(along, position) : base_.point(position, along);
  }
  FergusonSurface base_;
  bool along_u_;
};

}  // namespace

Result<std::unique_ptr<PassFamily>> make_pass_family(const PartProgram& program,
                                                     const PathOptions& options) {
  std::unique_ptr<PassFamily> family;
  if (options.along == PathAlong::kAngle) {
    family = std::make_unique<StraightPasses>(program.machining, options.angle);
    return family;
  }
  const FergusonBase* grid = std::get_if<FergusonBase>(&program.base);
  if (grid == nullptr) {
    return Error{ErrorCode::kInput, "paths along u or v need a Ferguson base surface", {}};
  }
  Result<FergusonSurface> base = FergusonSurface::make(*grid);
  if (!base) return base.error();
  family = std::make_unique<IsoparametricPasses>(std::move(*base), options.along == PathAlong::kU);
  return family;
}

}  // namespace diesink
