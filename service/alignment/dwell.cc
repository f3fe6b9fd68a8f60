#include "service/alignment/dwell.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "service/base/eigen.h"

namespace omni::alignment {

std::optional<base::Vec3> DwellDetector::Add(double t_s, const base::Vec3& tip_m) {
  using Eigen::Vector3d;
  const Vector3d tip = base::ToEigen(tip_m);
  if (last_ && (tip - base::ToEigen(*last_)).norm() < options_.apart_m) {
    window_.clear();
    progress_ = 0;
    return std::nullopt;
  }
  if (!window_.empty() && !(t_s > window_.back().t_s)) return std::nullopt;
  window_.push_back({t_s, tip_m});
  // From the newest back: as long as all are close to their mean.
  Vector3d sum = Vector3d::Zero();
  std::size_t kept = 0;
  for (std::size_t i = window_.size(); i-- > 0;) {
    const Vector3d p = base::ToEigen(window_[i].tip_m);
    if (kept > 0 && (p - sum / static_cast<double>(kept)).norm() > options_.still_m) break;
    sum += p;
    ++kept;
  }
  window_.erase(window_.begin(), window_.end() - static_cast<std::ptrdiff_t>(kept));
  progress_ = std::clamp((t_s - window_.front().t_s) / options_.still_s, 0.0, 1.0);
  if (progress_ < 1) return std::nullopt;
  const Vector3d mean = sum / static_cast<double>(kept);
  last_ = base::FromEigen(mean);
  window_.clear();
  return last_;
}

void DwellDetector::MarkTouched(const base::Vec3& tip_m) {
  Reset();
  last_ = tip_m;
}

void DwellDetector::Reset() {
  window_.clear();
  progress_ = 0;
}

Rigid MeanPose(const std::vector<Rigid>& poses) {
  Rigid mean;
  if (poses.empty()) return mean;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  const Eigen::Vector4d first = base::ToEigen(poses.front().orientation).coeffs();
  for (const Rigid& pose : poses) {
    position += base::ToEigen(pose.position_m);
    const Eigen::Vector4d q = base::ToEigen(pose.orientation).coeffs();
    sum += q.dot(first) < 0 ? Eigen::Vector4d(-q) : q;
  }
  mean.position_m = base::FromEigen(Eigen::Vector3d(position / static_cast<double>(poses.size())));
  mean.orientation = base::FromEigen(Eigen::Quaterniond(sum).normalized());
  return mean;
}

}  // namespace omni::alignment
