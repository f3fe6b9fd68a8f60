// What an application sets in its own scene: where it stands, poses of nodes, materials. Handed over with the commands,
// followed tick by tick. docs/theory/haptics.md, section 15.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/haptics/haptics.h"
#include "service/loop/pose_track.h"

namespace omni::loop {

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
