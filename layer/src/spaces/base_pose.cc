#include "layer/src/spaces/base_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "layer/src/spaces/tool_motion.h"

namespace omni::layer {
namespace {

using protocol::BaseSample;

constexpr double kInFront_m = 0.45;
constexpr double kBelow_m = 0.35;

bool HasFlag(const BaseSample& sample, std::uint32_t flag) noexcept { return (sample.flags & flag) != 0; }

Motion MotionOfBase(const BaseSample& sample) noexcept {
  const auto& p = sample.position_space_m;
  const auto& q = sample.orientation_space_wxyz;
  const auto& v = sample.linear_velocity_space_m_s;
  const auto& w = sample.angular_velocity_space_rad_s;
  Motion m;
  m.X = {{p[0], p[1], p[2]}, glm::normalize(glm::dquat(q[0], q[1], q[2], q[3]))};
  m.v = {v[0], v[1], v[2]};
  m.w = {w[0], w[1], w[2]};
  return m;
}

BaseMotion At(const BaseSample& sample, bool tracked) noexcept {
  return {.valid = true,
          .tracked = tracked,
          .space = static_cast<XrReferenceSpaceType>(sample.space),
          .X_LO = MotionOfBase(sample)};
}

// A pose that stands for another time than its own does not move.
BaseMotion HeldAt(const BaseSample& sample) noexcept {
  BaseMotion held = At(sample, false);
  held.X_LO.v = held.X_LO.w = glm::dvec3(0.0);
  return held;
}

// Of a leap neither the place nor the velocity is trusted until another pose continues it.
BaseMotion PredictBase(const BaseSample& newest, std::int64_t t_ns, std::int64_t now_ns) noexcept {
  if (!HasFlag(newest, protocol::kBaseSeen) || HasFlag(newest, protocol::kBaseLeapt)) return HeldAt(newest);
  BaseMotion out = At(newest, now_ns - newest.t_ns <= kBaseSilence_ns);
  const std::int64_t ahead_ns = std::clamp<std::int64_t>(t_ns - newest.t_ns, 0, kMaxBasePrediction_ns);
  out.X_LO = MovedOn(out.X_LO, 1e-9 * static_cast<double>(ahead_ns));
  return out;
}

BaseMotion BetweenPoses(const BaseSample& before, const BaseSample& after, std::int64_t t_ns) noexcept {
  const bool kept = t_ns >= before.t_ns;  // else it is before the oldest
  const bool one_motion = HasFlag(before, protocol::kBaseSeen) && HasFlag(after, protocol::kBaseSeen) &&
                          !HasFlag(after, protocol::kBaseLeapt) && before.space == after.space;
  if (!kept || !one_motion || after.t_ns <= before.t_ns) return HeldAt(before);
  BaseMotion out = At(before, after.t_ns - before.t_ns <= kMaxBaseGap_ns);
  out.X_LO = Interpolate(out.X_LO, before.t_ns, MotionOfBase(after), after.t_ns, t_ns);
  return out;
}

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

BaseMotion BaseMotionAt(const client::StateReader& reader, std::int64_t t_ns, std::int64_t now_ns) noexcept {
  BaseSample before;
  BaseSample after;
  if (!reader.ReadNewest(after)) return {};
  if (t_ns >= after.t_ns) return PredictBase(after, t_ns, now_ns);
  return reader.ReadAround(t_ns, before, after) ? BetweenPoses(before, after, t_ns) : BaseMotion{};
}

}  // namespace omni::layer
