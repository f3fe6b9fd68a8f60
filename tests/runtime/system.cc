// The one system: a head-mounted display with two eyes that shows nothing.

#include <cstdio>
#include <shared_mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"
#include "tests/runtime/system.h"

namespace omni::runtime {
namespace {

constexpr XrEnvironmentBlendMode kBlendModes[] = {XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                                                  XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND};

XrResult CheckView(XrSystemId system, XrViewConfigurationType type) {
  OMNI_REQUIRE(system == kSystemId, XR_ERROR_SYSTEM_INVALID);
  return CheckViewConfiguration(type);
}

}  // namespace

XrResult CheckViewConfiguration(XrViewConfigurationType type) {
  switch (type) {
    case XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO:
      return XR_SUCCESS;
    case XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO:
    case kStereoWithFoveatedInset:
      return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
    default:
      return XR_ERROR_VALIDATION_FAILURE;
  }
}

bool IsSupportedBlendMode(XrEnvironmentBlendMode mode) {
  for (const XrEnvironmentBlendMode known : kBlendModes) {
    if (mode == known) return true;
  }
  return false;
}

XrResult GetSystem(XrInstance instance, const XrSystemGetInfo* info, XrSystemId* system) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(info, XR_TYPE_SYSTEM_GET_INFO) && system != nullptr, XR_ERROR_VALIDATION_FAILURE);
  *system = XR_NULL_SYSTEM_ID;
  switch (info->formFactor) {
    case XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY:
      *system = kSystemId;
      return XR_SUCCESS;
    default:
      return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
  }
}

XrResult GetSystemProperties(XrInstance instance, XrSystemId system, XrSystemProperties* properties) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(properties, XR_TYPE_SYSTEM_PROPERTIES), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(system == kSystemId, XR_ERROR_SYSTEM_INVALID);
  properties->systemId = system;
  properties->vendorId = 0x4f4d;
  std::snprintf(properties->systemName, sizeof(properties->systemName), "Omni test system");
  properties->graphicsProperties = {kEyeHeight, kEyeWidth, XR_MIN_COMPOSITION_LAYERS_SUPPORTED};
  properties->trackingProperties = {XR_TRUE, XR_TRUE};
  auto* const hands =
      InChain<XrSystemHandTrackingPropertiesEXT>(properties->next, XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT);
  if (hands != nullptr && owner->Enabled(XR_EXT_HAND_TRACKING_EXTENSION_NAME)) hands->supportsHandTracking = XR_TRUE;
  auto* const presence =
      InChain<XrSystemUserPresencePropertiesEXT>(properties->next, XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT);
  if (presence != nullptr && owner->Enabled(XR_EXT_USER_PRESENCE_EXTENSION_NAME)) {
    presence->supportsUserPresence = XR_TRUE;
  }
  return XR_SUCCESS;
}

XrResult EnumerateEnvironmentBlendModes(XrInstance instance, XrSystemId system, XrViewConfigurationType type,
                                        uint32_t capacity, uint32_t* count, XrEnvironmentBlendMode* modes) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  if (const XrResult check = CheckView(system, type); XR_FAILED(check)) return check;
  return TwoCall(std::size(kBlendModes), capacity, count, modes,
                 [](uint32_t i, XrEnvironmentBlendMode& out) { out = kBlendModes[i]; });
}

XrResult EnumerateViewConfigurations(XrInstance instance, XrSystemId system, uint32_t capacity, uint32_t* count,
                                     XrViewConfigurationType* types) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(system == kSystemId, XR_ERROR_SYSTEM_INVALID);
  return TwoCall(1, capacity, count, types,
                 [](uint32_t, XrViewConfigurationType& out) { out = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO; });
}

XrResult GetViewConfigurationProperties(XrInstance instance, XrSystemId system, XrViewConfigurationType type,
                                        XrViewConfigurationProperties* properties) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(properties, XR_TYPE_VIEW_CONFIGURATION_PROPERTIES), XR_ERROR_VALIDATION_FAILURE);
  if (const XrResult check = CheckView(system, type); XR_FAILED(check)) return check;
  properties->viewConfigurationType = type;
  properties->fovMutable = XR_FALSE;
  return XR_SUCCESS;
}

XrResult EnumerateViewConfigurationViews(XrInstance instance, XrSystemId system, XrViewConfigurationType type,
                                         uint32_t capacity, uint32_t* count, XrViewConfigurationView* views) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  if (const XrResult check = CheckView(system, type); XR_FAILED(check)) return check;
  for (uint32_t i = 0; views != nullptr && i < capacity; ++i) {
    OMNI_REQUIRE(Is(&views[i], XR_TYPE_VIEW_CONFIGURATION_VIEW), XR_ERROR_VALIDATION_FAILURE);
  }
  return TwoCall(kEyes, capacity, count, views, [](uint32_t, XrViewConfigurationView& out) {
    out.recommendedImageRectWidth = out.maxImageRectWidth = kEyeWidth;
    out.recommendedImageRectHeight = out.maxImageRectHeight = kEyeHeight;
    out.recommendedSwapchainSampleCount = out.maxSwapchainSampleCount = 1;
  });
}

}  // namespace omni::runtime
