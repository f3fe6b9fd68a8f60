#include "layer/src/spaces/base_pose.h"

#include <cmath>
#include <limits>
#include <mutex>

namespace omni::layer {
namespace {
constexpr double kInFront_m = 0.45;
constexpr double kBelow_m = 0.35;
}  // namespace

Pose DefaultBasePose() {
  // -90 degrees about x: base z -> LOCAL y, base y -> LOCAL -z.
  const double h = std::sqrt(0.5);
  return {{0.0, -kBelow_m, -kInFront_m}, glm::dquat(h, -h, 0.0, 0.0)};
}

void BasePoseHistory::Set(const BasePose& base_pose, XrTime now) {
  const std::unique_lock lock(mutex_);
  epochs_.assign(1, {std::numeric_limits<XrTime>::min(), base_pose});
  for (const auto& change : changes_)
    if (change.changeTime > now) Append(change);
}

bool BasePoseHistory::OnChange(const XrEventDataReferenceSpaceChangePending& change) {
  const std::unique_lock lock(mutex_);
  if (changes_.size() >= kMostEpochs) changes_.erase(changes_.begin());
  changes_.push_back(change);
  return Append(change);
}

bool BasePoseHistory::Append(const XrEventDataReferenceSpaceChangePending& change) {
  Epoch next = epochs_.back();
  if (change.referenceSpaceType != next.base_pose.space) return true;
  next.since = change.changeTime;
  if (change.poseValid) {
    next.base_pose.X_LO = Compose(Inverse(FromXr(change.poseInPreviousSpace)), next.base_pose.X_LO);
  } else {
    next.base_pose.tracked = false;
  }
  if (epochs_.size() >= kMostEpochs) epochs_.erase(epochs_.begin());
  epochs_.push_back(next);
  return change.poseValid != XR_FALSE;
}

BasePose BasePoseHistory::At(XrTime time) const {
  const std::shared_lock lock(mutex_);
  for (std::size_t i = epochs_.size(); i-- > 1;)
    if (time >= epochs_[i].since) return epochs_[i].base_pose;
  return epochs_.front().base_pose;
}

}  // namespace omni::layer
