// Inputs of the passive pen. Sources (tip force, gestures, keys, the scene's joystick) are detected here and in
// gestures.h; a base::InputMapping says which of them feed which component. Edges are counted, times are physical.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/input_mapping.h"
#include "service/base/tool_state.h"
#include "service/base/vec.h"
#include "service/haptics/haptics.h"
#include "service/loop/gestures.h"

namespace omni::loop {

struct InputConfig {
  double force_filter_s = 0.010;  // time constant on the tip force: tracking noise times stiffness must not click
  double value_resolution = 1.0 / 1024;  // smaller changes of analogue values are not changes
};

// What one tick knows.
struct InputSample {
  std::int64_t t_ns = 0;  // of the Hall sample
  bool live = false;      // tracked and the gate open; else everything of the pen but "away" goes to rest
  bool owned = false;     // an application owns the force: only then do keys count
  bool tracked = false;   // `tool` has a place
  base::Vec3 tip_base_m;  // device point
  base::Vec3 axis_base{0, 0, -1};
};

struct SourceState {
  float value = 0;  // 0..1, thumbstick axes -1..1; digital ones 0 or 1
  std::int64_t t_change_ns = 0;
};

struct KeyFollower {
  bool on = false;
  std::uint32_t seen_press = 0;  // presses that have been passed on
};

struct InputTracker {
  base::InputState inputs;
  std::array<SourceState, base::kSourceCount> sources{};
  base::SourceMask on = 0;  // sources over 0.5
  GestureState gestures;
  std::array<KeyFollower, base::kMaxKeys> keys{};
  double tip_force_N = 0;  // filtered
  std::int64_t t_ns = 0;   // of the last update
};
static_assert(std::is_trivially_copyable_v<InputTracker>);

// `keys` null: there are none. A key that was down before an application owned the force does not count as pressed. At
// most one edge per key and tick: further ones follow in the next ticks, none is lost.
void UpdateInputs(const InputConfig& config, const base::InputMapping& mapping, const InputSample& sample,
                  const haptics::Output& haptics, const base::KeyStates* keys, InputTracker& tracker) noexcept;

// The pulse that renders a detent click: when the force passes its threshold the surface yields for a moment, and it
// returns when the force has fallen. Half a sine along the contact's normal, added to the contact force under its
// limits.
inline constexpr double kDetentPulse_s = 0.012;  // 42 Hz: the coils follow it
inline constexpr double kDetentReturn = 0.5;     // of the pulse, when it comes back

struct DetentState {
  bool on = false;
  double time_s = kDetentPulse_s;  // of the pulse that is running
  double amplitude_N = 0;
  base::Vec3 normal_base;  // of the contact that was pressed
};
static_assert(std::is_trivially_copyable_v<DetentState>);

// Force of this tick. Zero while no component is mapped to the detent.
base::Vec3 DetentForce_N(const base::InputMapping& mapping, const InputTracker& tracker, const haptics::Output& haptics,
                         double dt_s, DetentState& state) noexcept;

}  // namespace omni::loop
