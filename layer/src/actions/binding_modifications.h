// What an application specifies for a suggested binding besides its path: the structures chained to
// XrInteractionProfileSuggestedBinding (XR_KHR_binding_modification, XR_VALVE_analog_threshold).
//
// XrInteractionProfileDpadBindingEXT (XR_EXT_dpad_binding) is passed on like everything in the chain; the pen has no
// dpad, so a binding to a dpad path is inactive, like any binding that a device cannot serve.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::layer {

// A vibration played at an edge.
struct Pulse {
  XrDuration duration_ns = 0;
  float frequency_Hz = 0;  // 0: the device's best
  float amplitude = 0;     // 0..1
};

// Within their ranges: XR_MIN_HAPTIC_DURATION is -1, as in the protocol; NaN becomes 0.
Pulse ToPulse(const XrHapticVibration& vibration);

// An analog source read as a boolean: true from `on`, false again below `off`.
struct AnalogThreshold {
  float on = 0;
  float off = 0;
  std::optional<Pulse> on_pulse;
  std::optional<Pulse> off_pulse;
};

struct BindingThreshold {
  XrAction action = XR_NULL_HANDLE;
  XrPath binding = XR_NULL_PATH;
  AnalogThreshold threshold;
};

// Which extensions the application enabled; structures of others are unknown and skipped.
struct ModificationExtensions {
  bool binding_modification = false;  // XR_KHR_binding_modification: several structures, in an array
  bool analog_threshold = false;      // XR_VALVE_analog_threshold
};

// Thresholds of the chain in its order; null entries are skipped.
std::vector<BindingThreshold> ReadThresholds(const XrInteractionProfileSuggestedBinding& suggested,
                                             const ModificationExtensions& enabled);

// What XR_VALVE_analog_threshold requires of a threshold: XR_ERROR_VALIDATION_FAILURE for values out of 0..1 or on
// below off, XR_ERROR_PATH_UNSUPPORTED for an (action, path) that is not among the suggested ones.
XrResult CheckThresholds(const XrInteractionProfileSuggestedBinding& suggested,
                         const std::vector<BindingThreshold>& thresholds);

}  // namespace omni::layer
