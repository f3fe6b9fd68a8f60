#include "layer/src/actions/merge.h"

#include <algorithm>
#include <cmath>

namespace omni::layer {
namespace {

bool Same(const XrVector2f& a, const XrVector2f& b) { return !(a.x < b.x || a.x > b.x || a.y < b.y || a.y > b.y); }

bool Same(const StatePart& a, const StatePart& b) { return a.active == b.active && Same(a.value, b.value); }

}  // namespace

void EdgeTracker::Start(std::uint32_t press_count, std::uint32_t release_count) {
  pressed = false;
  seen_press = press_count;
  seen_release = release_count;
}

void EdgeTracker::StepDigital(bool now_pressed, std::uint32_t press_count, std::uint32_t release_count) {
  if (!pressed) {
    if (!now_pressed && press_count == seen_press) return;
    pressed = true;
    seen_press = press_count;
    seen_release = release_count;
    return;
  }
  // Released and pressed again since: one released sync now, the new press (still unseen) in the next one.
  if (now_pressed && release_count == seen_release) return;
  pressed = false;
  seen_release = release_count;
}

void EdgeTracker::StepAnalog(float value, std::uint32_t press_count, float on, float off) {
  if (pressed) {
    pressed = value >= off;
    if (pressed) seen_press = press_count;  // otherwise a later one is reported by the next sync
    return;
  }
  pressed = value >= on || (on <= kPressThreshold && press_count != seen_press);
  seen_press = press_count;
}

StatePart Merge(XrActionType type, const StatePart& a, const StatePart& b) {
  if (!a.active) return b;
  if (!b.active) return a;
  const auto size = [type](const XrVector2f& v) {
    return type == XR_ACTION_TYPE_VECTOR2F_INPUT ? std::hypot(v.x, v.y) : std::fabs(v.x);
  };
  StatePart out = size(b.value) > size(a.value) ? b : a;
  out.change_time = std::max(a.change_time, b.change_time);
  return out;
}

ActionState Advance(XrActionType type, const ActionState& previous, const StatePart& runtime, const StatePart& pen,
                    XrTime now) {
  ActionState state;
  state.runtime = runtime;
  state.pen = pen;
  const StatePart merged = Merge(type, runtime, pen);
  if (!merged.active) return state;  // inactive: value 0, unchanged, time 0
  state.active = true;
  state.value = merged.value;
  state.changed = previous.active && !Same(merged.value, previous.value);
  if (previous.active && !state.changed) {
    state.last_change = previous.last_change;
    return state;
  }
  // The physical time of those contributions that moved; a device that came or went moved now.
  XrTime moved = 0;
  const auto consider = [&](const StatePart& part, const StatePart& before) {
    if (state.changed && Same(part, before)) return;
    if (part.active) moved = std::max(moved, part.change_time);
    if (state.changed && part.active != before.active) moved = now;
  };
  consider(runtime, previous.runtime);
  consider(pen, previous.pen);
  state.last_change = std::max(moved > 0 ? std::min(moved, now) : now, previous.last_change);
  return state;
}

}  // namespace omni::layer
