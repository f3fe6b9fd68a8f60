#include "service/loop/scene_motion.h"

#include <algorithm>

#include "service/haptics/contact/frame.h"
#include "service/haptics/scene/scene.h"

namespace omni::loop {
namespace {

base::Vec3 MiddleOf(const float (&lower)[3], const float (&upper)[3]) noexcept {
  return {0.5 * (double{lower[0]} + upper[0]), 0.5 * (double{lower[1]} + upper[1]),
          0.5 * (double{lower[2]} + upper[2])};
}

// The same motion, of another point of the body: p' = p + R c, v' = v + w x R c.
PoseSample AboutPivot(const PoseSample& sample, const base::Vec3& pivot_m, bool leaps) noexcept {
  const base::Vec3 arm_m = Rotated(sample.rotation, pivot_m);
  PoseSample about = sample;
  about.leaps = sample.leaps || leaps;
  about.position_m = sample.position_m + arm_m;
  about.velocity_m_s = sample.velocity_m_s + Cross(sample.angular_velocity_rad_s, arm_m);
  return about;
}

PoseTrack AtRest(const base::Vec3& pivot_m) noexcept {
  PoseTrack track;
  track.from.position_m = track.to.position_m = pivot_m;
  return track;
}

// t of x = R x_rest + t, from where the pivot is.
base::Vec3 TranslationOf(const TrackedPose& pose, const base::Vec3& pivot_m) noexcept {
  return pose.position_m - Rotated(pose.rotation, pivot_m);
}

base::Vec3 PivotOf(const haptics::Scene& scene) noexcept {
  return 0.5 * (scene.header().lower_base_m + scene.header().upper_base_m);
}

void FollowBasePose(const SceneControl& control, const haptics::Scene& scene, std::int64_t t_ns,
                    SceneMotionState& state, SceneNow& now) noexcept {
  if (control.placement.number == 0) return;
  const base::Vec3 pivot_m = PivotOf(scene);
  const bool first = state.placement.number == 0;
  if (first) state.placement = AtRest(pivot_m);
  now.leaps = AddPoseSample(AboutPivot(control.placement, pivot_m, first), t_ns, state.placement);
  if (state.placement.number == 0) return;  // it was not a valid pose
  const TrackedPose pose = PoseAt(state.placement, t_ns);
  now.placement = {pose.rotation, TranslationOf(pose, pivot_m)};
}

}  // namespace

void FollowScene(const SceneControl& control, const haptics::Scene& scene, std::int64_t t_ns, SceneMotionState& state,
                 SceneNow& now) noexcept {
  now.placement = {};
  now.leaps = false;
  now.object_count = 0;
  if (scene.empty()) return;
  FollowBasePose(control, scene, t_ns, state, now);
  const std::uint32_t count = std::min<std::uint32_t>(control.object_count, haptics::kMaxMoved);
  for (std::uint32_t i = 0; i < count; ++i) {
    const ObjectSample& sample = control.objects[i];
    if (sample.object >= scene.objects().size()) continue;
    const haptics::Object& object = scene.objects()[sample.object];
    const base::Vec3 pivot_m = MiddleOf(object.lower_base_m, object.upper_base_m);
    PoseTrack& track = state.tracks[i];
    if (state.object[i] != sample.object + 1) track = AtRest(pivot_m);
    state.object[i] = sample.object + 1;
    const bool leaps = AddPoseSample(AboutPivot(sample.pose, pivot_m, !state.begun), t_ns, track);
    if (track.number == 0) continue;
    const TrackedPose pose = PoseAt(track, t_ns);
    now.objects[now.object_count++] = {sample.object, pose.rotation, TranslationOf(pose, pivot_m), leaps};
  }
  state.begun = true;
}

}  // namespace omni::loop
