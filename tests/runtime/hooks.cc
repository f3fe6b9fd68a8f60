#include "tests/runtime/hooks.h"

#include <cmath>
#include <mutex>
#include <string_view>

#include "tests/runtime/commands.h"
#include "tests/runtime/entry_points.h"
#include "tests/runtime/frame/frame_layers.h"
#include "tests/runtime/spaces/clock.h"
#include "tests/runtime/state.h"

namespace {

using omni::runtime::Motion;
using omni::runtime::TheState;

// Runs `change` on the state, exclusively.
template <class Change>
int Alone(Change change) {
  omni::runtime::State& state = TheState();
  const std::unique_lock lock(state.mutex);
  return change(state) ? 0 : -1;
}

std::string_view Text(const char* text) { return text == nullptr ? std::string_view() : std::string_view(text); }

Motion MotionOf(const float pose[7], const float velocity[6]) {
  Motion motion;
  motion.pose = {{pose[3], pose[4], pose[5], pose[6]}, {pose[0], pose[1], pose[2]}};
  if (velocity != nullptr) {
    motion.linear_m_s = {velocity[0], velocity[1], velocity[2]};
    motion.angular_rad_s = {velocity[3], velocity[4], velocity[5]};
  }
  return motion;
}

}  // namespace

#pragma GCC visibility push(default)

int omni_test_reset(void) {
  return Alone([](auto& state) {
    omni::runtime::ForgetFrame();
    return omni::runtime::ResetWorld(state);
  });
}

int omni_test_set_device(const char* hand, int present, const char* profile) {
  const int index = omni::runtime::HandIndex(Text(hand));
  return Alone([&](auto& state) { return index >= 0 && state.world.SetDevice(index, present != 0, Text(profile)); });
}

int omni_test_set_tracking(const char* hand, int valid, int tracked) {
  const int index = omni::runtime::HandIndex(Text(hand));
  return Alone([&](auto& state) { return omni::runtime::SetTracking(state, index, valid != 0, tracked != 0); });
}

int omni_test_set_bool(const char* path, int value) {
  return Alone([&](auto& state) { return state.world.SetBool(Text(path), value != 0); });
}

int omni_test_set_float(const char* path, float value) {
  return Alone([&](auto& state) { return state.world.SetFloat(Text(path), value); });
}

int omni_test_set_vector2(const char* path, float x, float y) {
  return Alone([&](auto& state) { return state.world.SetVector2(Text(path), x, y); });
}

int omni_test_set_pose(const char* path, const float pose[7], const float velocity[6]) {
  if (pose == nullptr) return -1;
  return Alone([&](auto& state) { return state.world.SetPose(Text(path), MotionOf(pose, velocity)); });
}

int omni_test_set_head(const float pose[7], const float velocity[6]) {
  if (pose == nullptr) return -1;
  return Alone([&](auto& state) { return omni::runtime::SetHead(state, MotionOf(pose, velocity)); });
}

int omni_test_set_focus(int focus) {
  return Alone([&](auto& state) { return omni::runtime::SetFocus(state, focus != 0); });
}

int omni_test_set_user_presence(int present) {
  return Alone([&](auto& state) { return omni::runtime::SetUserPresence(state, present != 0); });
}

int omni_test_recenter(const float pose[7], int64_t delay_ns) {
  if (pose == nullptr) return -1;
  return omni_test_move_space("local", pose, delay_ns, 1);
}

int omni_test_move_space(const char* space, const float pose[7], int64_t delay_ns, int reported) {
  if (pose == nullptr) return -1;
  const XrReferenceSpaceType type = omni::runtime::SpaceNamed(Text(space));
  return Alone([&](auto& state) {
    return omni::runtime::Recenter(state, type, MotionOf(pose, nullptr).pose, delay_ns, reported != 0);
  });
}

int omni_test_offer_stage(int offered) {
  return Alone([&](auto& state) {
    state.world.has_stage = offered != 0;
    return true;
  });
}

int omni_test_offer_models(int offered) {
  return Alone([&](auto& state) {
    state.world.has_models = offered != 0;
    return true;
  });
}

int omni_test_number_models(uint64_t first) {
  return Alone([&](auto& state) {
    state.world.first_model = first;
    return first > 0;
  });
}

int omni_test_offer_timespec(int offered) {
  return Alone([&](auto& state) {
    state.world.has_timespec = offered != 0;
    return true;
  });
}

int omni_test_offer_shapes(int offered) {
  return Alone([&](auto& state) {
    state.world.has_shapes = offered != 0;
    return true;
  });
}

int omni_test_refuse_instances(int result) {
  return Alone([&](auto& state) {
    state.world.creation = static_cast<XrResult>(result);
    return true;
  });
}

int omni_test_hold_images(int held) {
  return Alone([&](auto& state) {
    state.world.holds_images = held != 0;
    return true;
  });
}

int omni_test_report_velocities(int reported) {
  return Alone([&](auto& state) {
    state.world.has_velocities = reported != 0;
    return true;
  });
}

int omni_test_set_hand(const char* hand, int active, const float pose[7], const float velocity[6]) {
  const int index = omni::runtime::HandIndex(Text(hand));
  if (index < 0) return -1;
  return Alone([&](auto& state) {
    const Motion palm = pose == nullptr ? state.world.hands[index].palm : MotionOf(pose, velocity);
    return omni::runtime::SetHand(state, index, active != 0, palm);
  });
}

int omni_test_request_exit(void) {
  return Alone([](auto& state) { return omni::runtime::RequestExit(state); });
}

int omni_test_lose_session(void) {
  return Alone([](auto& state) { return omni::runtime::LoseSessions(state); });
}

int omni_test_lose_instance(void) {
  return Alone([](auto& state) { return omni::runtime::LoseInstances(state); });
}

int omni_test_kill_runtime(void) {
  return Alone([](auto& state) { return omni::runtime::KillRuntime(state); });
}

int omni_test_haptics(const char* hand, OmniTestHaptics* haptics) {
  const int index = omni::runtime::HandIndex(Text(hand));
  if (index < 0 || haptics == nullptr) return -1;
  return Alone([&](auto& state) {
    const omni::runtime::HapticRecord& record = state.world.devices[index].haptics;
    *haptics = {record.count,       record.stops,     record.amplitude, record.frequency_Hz,
                record.duration_ns, record.envelopes, record.pcms,      record.samples};
    return true;
  });
}

int omni_test_frame(OmniTestFrame* frame) {
  if (frame == nullptr) return -1;
  return Alone([&](auto&) {
    *frame = omni::runtime::RecordedFrame();
    return true;
  });
}

long omni_test_call_count(const char* function) {
  return function == nullptr ? -1 : omni::runtime::CallCount(function);
}

uint32_t omni_test_live_handles(void) {
  omni::runtime::State& state = TheState();
  const std::shared_lock lock(state.mutex);
  return state.handles.live();
}

#pragma GCC visibility pop
