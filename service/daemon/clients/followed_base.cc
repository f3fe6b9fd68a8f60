#include "service/daemon/clients/followed_base.h"

#include <algorithm>

#include "service/alignment/rigid.h"
#include "service/daemon/clients/base_poses.h"

namespace omni::daemon {
namespace {

alignment::Rigid PoseOf(const protocol::BaseSample& sample) {
  return ToRigid({.position_m = sample.position_space_m, .orientation_wxyz = sample.orientation_space_wxyz});
}

double Norm(const std::array<double, 3>& v) { return base::Norm({v[0], v[1], v[2]}); }

}  // namespace

FollowedBase::Taken FollowedBase::HandleMotion(ipc::ClientId id, const protocol::BaseMotion& motion,
                                               std::int64_t now_ns) {
  if (source_ != 0 && source_ != id && now_ns - heard_ns_ < kHandOver_ns) {
    return Refuse(id, "another program reports already where the base is; end it first", {});
  }
  source_ = id;
  heard_ns_ = now_ns;
  if (motion.state == protocol::BaseState::kStands) {
    headset_.reset();
    return {.sample = Lost(now_ns)};
  }
  headset_ = motion.headset;
  if (motion.state == protocol::BaseState::kLost) return {.sample = Lost(now_ns)};
  if (!(motion.t_ns >= now_ns - kOldest_ns && motion.t_ns <= now_ns + kLatest_ns)) {
    return Refuse(id, "poses of the base come 1 s late, or more than 0.1 s early", Lost(now_ns));
  }
  if (newest_ && motion.t_ns <= newest_->t_ns) return {};  // two programs' clocks, or the same pose again
  const protocol::WirePose unit =
      ToWire(alignment::Compose(ToRigid(motion.base_space), {}));  // the quaternion to unit length
  protocol::BaseSample sample{.t_ns = motion.t_ns,
                              .flags = protocol::kBaseSeen,
                              .space = motion.space,
                              .position_space_m = motion.base_space.position_m,
                              .orientation_space_wxyz = unit.orientation_wxyz,
                              .linear_velocity_space_m_s = motion.linear_velocity_m_s,
                              .angular_velocity_space_rad_s = motion.angular_velocity_rad_s};
  if (Leaps(sample)) {
    sample.flags |= protocol::kBaseLeapt;
    sample.linear_velocity_space_m_s = sample.angular_velocity_space_rad_s = {};  // where it went to, not how
  }
  newest_ = seen_ = sample;
  return {.sample = sample};
}

FollowedBase::Taken FollowedBase::Refuse(ipc::ClientId id, const char* problem,
                                         std::optional<protocol::BaseSample> sample) {
  const bool is_new = id != refused_ || problem != problem_;
  refused_ = id;
  problem_ = problem;
  return {.sample = sample, .problem = is_new ? problem : nullptr};
}

std::optional<protocol::BaseSample> FollowedBase::Remove(ipc::ClientId id, std::int64_t now_ns) {
  if (id != source_) return std::nullopt;
  source_ = 0;
  return Lost(now_ns);
}

// The last known pose, at rest. Nothing while none was known, or once it is lost.
std::optional<protocol::BaseSample> FollowedBase::Lost(std::int64_t t_ns) {
  if (!seen()) return std::nullopt;
  newest_->t_ns = std::max(newest_->t_ns, t_ns);
  newest_->flags = 0;
  newest_->linear_velocity_space_m_s = newest_->angular_velocity_space_rad_s = {};
  return newest_;
}

bool FollowedBase::Leaps(const protocol::BaseSample& next) const {
  if (Norm(next.linear_velocity_space_m_s) > kFastestBase_m_s ||
      Norm(next.angular_velocity_space_rad_s) > kFastestBaseTurn_rad_s) {
    return true;
  }
  if (!newest_) return false;
  const double dt_s = 1e-9 * static_cast<double>(next.t_ns - seen_.t_ns);
  const alignment::Rigid from = PoseOf(seen_), to = PoseOf(next);
  return next.space != seen_.space ||
         base::Distance(from.position_m, to.position_m) > kBaseNoise_m + dt_s * kFastestBase_m_s ||
         alignment::Angle_rad(from, to) > kBaseNoise_rad + dt_s * kFastestBaseTurn_rad_s;
}

}  // namespace omni::daemon
