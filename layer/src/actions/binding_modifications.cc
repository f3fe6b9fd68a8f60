#include "layer/src/actions/binding_modifications.h"

#include <algorithm>
#include <cstring>

namespace omni::layer {
namespace {

std::optional<Pulse> ReadPulse(const XrHapticBaseHeader* haptic) {
  if (!haptic || haptic->type != XR_TYPE_HAPTIC_VIBRATION) return std::nullopt;
  XrHapticVibration v;
  std::memcpy(&v, haptic, sizeof(v));
  return ToPulse(v);
}

template <class Header>
void ReadThreshold(const Header* header, std::vector<BindingThreshold>& out) {
  if (!header || header->type != XR_TYPE_INTERACTION_PROFILE_ANALOG_THRESHOLD_VALVE) return;
  XrInteractionProfileAnalogThresholdVALVE v;
  std::memcpy(&v, header, sizeof(v));
  out.push_back({v.action, v.binding, {v.onThreshold, v.offThreshold, ReadPulse(v.onHaptic), ReadPulse(v.offHaptic)}});
}

}  // namespace

// NaN fails the comparisons.
Pulse ToPulse(const XrHapticVibration& vibration) {
  return {std::max<XrDuration>(vibration.duration, XR_MIN_HAPTIC_DURATION),
          vibration.frequency >= 0 ? vibration.frequency : 0.0f,
          vibration.amplitude >= 0 ? std::min(vibration.amplitude, 1.0f) : 0.0f};
}

std::vector<BindingThreshold> ReadThresholds(const XrInteractionProfileSuggestedBinding& suggested,
                                             const ModificationExtensions& enabled) {
  std::vector<BindingThreshold> out;
  if (!enabled.analog_threshold) return out;
  const auto* chain = static_cast<const XrBaseInStructure*>(suggested.next);
  for (; chain; chain = chain->next) {
    ReadThreshold(chain, out);
    if (chain->type != XR_TYPE_BINDING_MODIFICATIONS_KHR || !enabled.binding_modification) continue;
    XrBindingModificationsKHR modifications;
    std::memcpy(&modifications, chain, sizeof(modifications));
    for (std::uint32_t i = 0; modifications.bindingModifications && i < modifications.bindingModificationCount; ++i)
      ReadThreshold(modifications.bindingModifications[i], out);
  }
  return out;
}

XrResult CheckThresholds(const XrInteractionProfileSuggestedBinding& suggested,
                         const std::vector<BindingThreshold>& thresholds) {
  const auto* begin = suggested.suggestedBindings;
  const auto* end = begin + suggested.countSuggestedBindings;
  for (const BindingThreshold& t : thresholds) {
    const bool in_range =
        t.threshold.on >= 0 && t.threshold.on <= 1 && t.threshold.off >= 0 && t.threshold.off <= t.threshold.on;
    if (!in_range) return XR_ERROR_VALIDATION_FAILURE;
    const bool suggested_too = std::any_of(begin, end, [&](const XrActionSuggestedBinding& binding) {
      return binding.action == t.action && binding.binding == t.binding;
    });
    if (!suggested_too) return XR_ERROR_PATH_UNSUPPORTED;
  }
  return XR_SUCCESS;
}

}  // namespace omni::layer
