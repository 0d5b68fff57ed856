// SPDX-License-Identifier: Apache-2.0
#include "core/machining/path_links.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/machining/interference.h"
#include "core/number.h"

namespace diesink {
namespace {

constexpr std::size_t kPointsATime = 4096;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Rapid moves cost so much less than moves at feed, when ways are compared.
constexpr double kRapidsAFeed = 5;

std::size_t cell_of(double at, double from, double inv, int cells) {
  // The first where a cutter far larger than the part leaves no number.
  return static_cast<std::size_t>(std::fmin(std::fmax((at - from) * inv, 0.0), cells - 1.0));
}

}  // namespace

Result<double> clearance_over(const TriangleMesh& mesh, const PathOptions& options, double grow) {
  double top = kNoContact;
  for (const Vec3& p : mesh.positions) top = std::fmax(top, p.z());
  const double diameter = options.cutter.diameter;
  const double usual = diameter > grow ? top + diameter : top + grow + diameter;
  const double clearance = options.clearance.value_or(usual);
  if (clearance > top + grow) return clearance;
  std::string message = "the clearance plane " + number_text(clearance) +
                        " must lie above the surface, whose highest point is " + number_text(top);
  if (clearance > top) {
    message += ", and by more than the " + number_text(grow) +
               " that are left on it, INTOL being so much smaller than OUTTOL";
  }
  return Error{ErrorCode::kInput, std::move(message), {}};
}

TopGrid::TopGrid(const OffsetSurface& offset, double cell) {
  const std::size_t count = offset.piece_count();
  for (std::size_t k = 0; k < count; ++k) {
    const PlanBox box = offset.box(k);
    if (k == 0) extent_ = box;
    extent_.x0 = std::fmin(extent_.x0, box.x0);
    extent_.x1 = std::fmax(extent_.x1, box.x1);
    extent_.y0 = std::fmin(extent_.y0, box.y0);
    extent_.y1 = std::fmax(extent_.y1, box.y1);
  }
  const double w = std::fmax(extent_.x1 - extent_.x0, 1e-300);
  const double h = std::fmax(extent_.y1 - extent_.y0, 1e-300);
  nx_ = static_cast<int>(std::clamp(w / cell, 1.0, 2048.0));
  ny_ = static_cast<int>(std::clamp(h / cell, 1.0, 2048.0));
  inv_dx_ = nx_ / w;
  inv_dy_ = ny_ / h;
  tops_.assign(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_), kNoContact);
  for (std::size_t k = 0; k < count; ++k) {
    const PlanBox box = offset.box(k);
    const double top = offset.top(k);
    const std::size_t i1 = cell_of(box.x1, extent_.x0, inv_dx_, nx_);
    const std::size_t j1 = cell_of(box.y1, extent_.y0, inv_dy_, ny_);
    for (std::size_t j = cell_of(box.y0, extent_.y0, inv_dy_, ny_); j <= j1; ++j) {
      for (std::size_t i = cell_of(box.x0, extent_.x0, inv_dx_, nx_); i <= i1; ++i) {
        double& at = tops_[j * static_cast<std::size_t>(nx_) + i];
        at = std::fmax(at, top);
      }
    }
  }
}

double TopGrid::over(const Vec2& a, const Vec2& b) const {
  double top = kNoContact;
  const std::size_t i1 = cell_of(std::fmax(a.x(), b.x()), extent_.x0, inv_dx_, nx_);
  const std::size_t j1 = cell_of(std::fmax(a.y(), b.y()), extent_.y0, inv_dy_, ny_);
  for (std::size_t j = cell_of(std::fmin(a.y(), b.y()), extent_.y0, inv_dy_, ny_); j <= j1; ++j) {
    for (std::size_t i = cell_of(std::fmin(a.x(), b.x()), extent_.x0, inv_dx_, nx_); i <= i1; ++i) {
      top = std::fmax(top, tops_[j * static_cast<std::size_t>(nx_) + i]);
    }
  }
  return top;
}

void PathStream::add(const Vec3& tip, Motion motion) {
  PathReport& r = *report_;
  if (r.points > 0) {
    if (tip == last_) return;
    if (watch_ && motion == Motion::kFeed) watch_(last_, tip);
    (motion == Motion::kFeed ? r.feed_length : r.rapid_length) += (tip - last_).norm();
  }
  ++r.points;
  last_ = tip;
  waiting_.push_back({frame_->from_frame(tip), motion});
  if (waiting_.size() == kPointsATime) hand_on();
}

void PathStream::hand_on() {
  if (status_ && !begun_) status_ = receiver_->begin(*head_);
  begun_ = true;
  if (status_) status_ = receiver_->take(waiting_);
  waiting_.clear();
}

Status PathStream::finish() {
  // To the first point and back at the clearance plane is no path.
  if (report_->points < 4) {
    return Error{ErrorCode::kInput,
                 "the cutter meets no surface in the domain: the path would be empty",
                 {}};
  }
  if (!waiting_.empty()) hand_on();
  return status_;
}

double PathJoiner::along_surface(const Vec3& from, const Vec3& to) {
  link_.clear();
  const double across = (to - from).head<2>().norm();
  if (profile_ == nullptr || !(across > 0)) return kInfinity;
  // Not over holes: nothing is known of what is in them.
  double covered = 0;
  for (const ProfileSegment& s : profile_->take(from.head<2>(), to.head<2>(), kNoContact)) {
    covered += s.x1 - s.x0;
  }
  if (covered < across * (1 - 1e-6)) return kInfinity;
  const Vec3 lift(0, 0, lift_);
  if (safe_move(from - lift, to - lift, *profile_, tolerance_, link_) > tolerance_) {
    return kInfinity;
  }
  double length = 0;
  Vec3 last = from;
  for (Vec3& p : link_) {
    p += lift;
    length += (p - last).norm();
    last = p;
  }
  return length;
}

void PathJoiner::cut(std::span<const Vec3> run, bool by_clearance) {
  const Vec3& to = run.front();
  bool linked = false;
  if (!out_->empty() && !by_clearance) {
    const Vec3 from = out_->last();
    const double across = (to - from).head<2>().norm();
    // Over the material all is at feed; over the clearance plane the way down is.
    const bool near = across <= link_limit_;
    const double by_plane = clearance_ - to.z() + (clearance_ - from.z() + across) / kRapidsAFeed;
    double straight = kInfinity, height = 0;
    if (near || across < by_plane) {
      height =
          std::fmax(tops_->over(from.head<2>(), to.head<2>()) + lift_, std::fmax(from.z(), to.z()));
      if (height < clearance_) straight = (height - from.z()) + (height - to.z()) + across;
    }
    const double most = near ? kInfinity : by_plane;
    const double surface =
        across + std::fabs(to.z() - from.z()) < std::fmin(straight, most) && across < most
            ? along_surface(from, to)
            : kInfinity;
    if (surface < std::fmin(straight, most)) {
      for (const Vec3& p : link_) out_->add(p, Motion::kFeed);
      linked = true;
    } else if (straight < most) {
      out_->add({from.x(), from.y(), height}, Motion::kFeed);
      out_->add({to.x(), to.y(), height}, Motion::kFeed);
      linked = true;
    }
  }
  if (!linked) {
    if (!out_->empty()) {
      const Vec3 from = out_->last();
      out_->add({from.x(), from.y(), clearance_}, Motion::kRapid);
    }
    out_->add({to.x(), to.y(), clearance_}, Motion::kRapid);
  }
  for (const Vec3& tip : run) out_->add(tip, Motion::kFeed);
}

void PathJoiner::finish() {
  if (out_->empty()) return;
  const Vec3 from = out_->last();
  out_->add({from.x(), from.y(), clearance_}, Motion::kRapid);
}

}  // namespace diesink
