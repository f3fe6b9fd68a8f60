// Follows a pose that an application sends now and then: position and velocity are continuous, and a pose that is not
// updated comes to rest. docs/theory/haptics.md, section 15.
#pragma once

#include <cstdint>
#include <type_traits>

#include "service/base/vec.h"

namespace omni::loop {

// Of a body's pivot (a point fixed to it) at one time.
struct PoseSample {
  std::int64_t t_ns = 0;     // when the body is there, CLOCK_MONOTONIC; may lie ahead
  std::uint64_t number = 0;  // another number than before: a new sample; 0: none yet
  bool leaps = false;        // jumps there instead of moving
  base::Quat rotation;
  base::Vec3 position_m;
  base::Vec3 velocity_m_s;
  base::Vec3 angular_velocity_rad_s;
};
static_assert(std::is_trivially_copyable_v<PoseSample>);

struct TrackedPose {
  base::Quat rotation;  // unit
  base::Vec3 position_m;
  base::Vec3 velocity_m_s;
  base::Vec3 angular_velocity_rad_s;
};

inline constexpr double kFastestTrack_m_s = 0.5;  // a displacement that would need more takes longer
inline constexpr double kFastestTurn_rad_s = 5;
inline constexpr double kTrackLeap_m = 0.050;  // a larger step is a leap
inline constexpr double kTrackLeap_rad = 0.5;
inline constexpr std::int64_t kExtrapolate_ns = 50'000'000;  // beyond a sample's time, then it stands still
inline constexpr std::int64_t kShortestTrack_ns = 5'000'000;
inline constexpr std::int64_t kLongestTrack_ns = 100'000'000;  // samples further ahead are reached after this time

struct PoseTrack {
  std::uint64_t number = 0;                            // of the newest sample taken
  std::int64_t begin_ns = 0, end_ns = 0, rest_ns = 0;  // from, to; then on with its velocity until rest
  TrackedPose from, to;
};
static_assert(std::is_trivially_copyable_v<PoseTrack>);

// Where it is at t_ns. Before the first sample: `track.to` as it was made.
TrackedPose PoseAt(const PoseTrack& track, std::int64_t t_ns) noexcept;

// Adds a sample at t_ns, if it is new and valid (finite, unit quaternion). True: the pose leaps there.
bool Follow(const PoseSample& sample, std::int64_t t_ns, PoseTrack& track) noexcept;

}  // namespace omni::loop
