// Pure rules of action states: edges that must not be lost, several sources of one action, what "changed" means.
#pragma once

#include <cstdint>

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::layer {

// Analog to boolean with hysteresis [input-suggested-bindings].
inline constexpr float kPressThreshold = 0.5f;
inline constexpr float kReleaseThreshold = 0.4f;

// One physical component as the application's syncs see it. At most one edge per sync, and no press is lost: one that
// came and went between two syncs is pressed for one sync.
struct EdgeTracker {
  bool pressed = false;
  std::uint32_t seen_press = 0;
  std::uint32_t seen_release = 0;

  // Counts from now on; earlier edges are ignored.
  void Start(std::uint32_t press_count, std::uint32_t release_count);
  void StepDigital(bool now_pressed, std::uint32_t press_count, std::uint32_t release_count);
  // Pressed from `on`, released below `off`. `press_count` counts the edges over 0.5, which say something only of
  // thresholds up to there.
  void StepAnalog(float value, std::uint32_t press_count, float on = kPressThreshold, float off = kReleaseThreshold);
};

// One contribution to an action. Booleans and floats use value.x.
struct StatePart {
  bool active = false;
  XrVector2f value{0, 0};
  XrTime change_time = 0;
};

// boolean: or; float: largest magnitude; vector: longest [input-multiple].
StatePart Merge(XrActionType type, const StatePart& a, const StatePart& b);

struct ActionState {
  bool active = false;
  bool changed = false;
  XrVector2f value{0, 0};
  XrTime last_change = 0;
  StatePart runtime;  // contributions of this sync, to see which of them changed
  StatePart pen;
};

// The state of this sync from that of the last one and the present contributions.
ActionState Advance(XrActionType type, const ActionState& previous, const StatePart& runtime, const StatePart& pen,
                    XrTime now);

}  // namespace omni::layer
