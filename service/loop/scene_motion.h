// What an application sets in its own scene: where it stands, poses of nodes, materials. Handed over with the commands,
// followed tick by tick. docs/theory/haptics.md, section 15.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/vec.h"
#include "service/haptics/haptics.h"

namespace omni::loop {

// Follows a pose that an application sends now and then: position and velocity are continuous, and a pose that is not
// updated comes to rest.
//
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
bool AddPoseSample(const PoseSample& sample, std::int64_t t_ns, PoseTrack& track) noexcept;

// Of an object's pose x = R x_rest + t; position and velocity are those of the body's point at the scene's origin. The
// tick follows the object's own middle.
struct ObjectSample {
  std::uint32_t object = haptics::kNoIndex;
  std::uint32_t reserved = 0;
  PoseSample pose;  // in the scene's frame
};

struct SceneControl {
  std::uint64_t generation = 0;  // of the scene that this is about: ignored while another one is active
  PoseSample placement;          // of the scene's frame in the base frame; number 0: at the origin
  std::uint32_t object_count = 0;
  std::uint32_t material_count = 0;
  std::array<ObjectSample, haptics::kMaxMoved> objects;
  std::array<haptics::MaterialChange, haptics::kMaxLiveMaterials> materials;
};
static_assert(std::is_trivially_copyable_v<SceneControl>);

struct SceneMotionState {
  PoseTrack placement;
  std::array<PoseTrack, haptics::kMaxMoved> tracks;        // of objects[i] of the control
  std::array<std::uint32_t, haptics::kMaxMoved> object{};  // of each track, plus one; 0: none yet
  bool begun = false;  // poses that were set before the scene was active are no motion: it starts there
};
static_assert(std::is_trivially_copyable_v<SceneMotionState>);

// The renderer's input for one tick.
struct SceneNow {
  haptics::Placement placement;
  bool leaps = false;
  std::uint32_t object_count = 0;
  std::array<haptics::ObjectPose, haptics::kMaxMoved> objects;
};

// Objects keep their place in the control's list once they are in it. `state` is new with every scene.
void FollowScene(const SceneControl& control, const haptics::Scene& scene, std::int64_t t_ns, SceneMotionState& state,
                 SceneNow& now) noexcept;

}  // namespace omni::loop
