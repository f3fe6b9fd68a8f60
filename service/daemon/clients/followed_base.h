// Where a base is that something carries: the poses that one tool reports, checked, for the state memory. Control
// thread only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "service/ipc/server.h"
#include "service/protocol/base_pose.h"
#include "service/protocol/state_memory.h"

namespace omni::daemon {

// Two poses of one base differ by no more than this, in a time and at once: an arm or a person carries it. A source
// that says otherwise has lost its way; what is between the two poses is not known.
inline constexpr double kFastestBase_m_s = 5;
inline constexpr double kFastestBaseTurn_rad_s = 20;
inline constexpr double kBaseNoise_m = 0.01;
inline constexpr double kBaseNoise_rad = 0.2;

class FollowedBase {
 public:
  static constexpr std::int64_t kHandOver_ns = 1'000'000'000;  // a source that is silent for so long may be replaced
  static constexpr std::int64_t kOldest_ns = 1'000'000'000;    // of a pose, when it comes
  static constexpr std::int64_t kLatest_ns = 100'000'000;      // that a pose may lie ahead

  // `follows`: it does so before anything is reported, in every headset's spaces.
  explicit FollowedBase(bool follows = false) {
    if (follows) headset_.emplace();
  }

  struct Taken {
    std::optional<protocol::BaseSample> sample;  // to be published
    const char* problem = nullptr;               // why it is not used; once, not with every pose
  };
  // `now_ns`: CLOCK_MONOTONIC.
  Taken HandleMotion(ipc::ClientId id, const protocol::BaseMotion& motion, std::int64_t now_ns);
  // The end of a client. It goes on to follow: the last pose holds, not tracked.
  std::optional<protocol::BaseSample> Remove(ipc::ClientId id, std::int64_t now_ns);

  // Whose base moves: the headset in whose space it is; without names: of any. None: it stands where it was measured.
  const std::optional<protocol::HeadsetNames>& headset() const { return headset_; }
  // Its source sees it, as far as it has said.
  bool seen() const { return newest_ && (newest_->flags & protocol::kBaseSeen) != 0; }

 private:
  Taken Refuse(ipc::ClientId id, const char* problem, std::optional<protocol::BaseSample> sample);
  std::optional<protocol::BaseSample> Lost(std::int64_t t_ns);
  bool Leaps(const protocol::BaseSample& next) const;

  std::optional<protocol::HeadsetNames> headset_;
  ipc::ClientId source_ = 0;  // 0: none
  std::int64_t heard_ns_ = 0;
  ipc::ClientId refused_ = 0;  // the client that was refused last, and why
  const char* problem_ = nullptr;
  std::optional<protocol::BaseSample> newest_;  // published
  protocol::BaseSample seen_;                   // the newest that was seen, if there is a newest
};

}  // namespace omni::daemon
