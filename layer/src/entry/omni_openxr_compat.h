// OpenXR as this layer sees it: Debian 12's 1.0.20 headers plus the registry's values for what they lack
// (xr.xml of OpenXR 1.1.62). Every entry is guarded, so that newer headers win.
#pragma once

#include <stddef.h>
#include <time.h>

#ifndef XR_USE_TIMESPEC
#define XR_USE_TIMESPEC
#endif
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#ifndef XR_LOGITECH_MX_INK_STYLUS_INTERACTION_EXTENSION_NAME
#define XR_LOGITECH_mx_ink_stylus_interaction 1
#define XR_LOGITECH_mx_ink_stylus_interaction_SPEC_VERSION 1
#define XR_LOGITECH_MX_INK_STYLUS_INTERACTION_EXTENSION_NAME "XR_LOGITECH_mx_ink_stylus_interaction"
#endif

#ifndef XR_KHR_generic_controller
#define XR_KHR_generic_controller 1
#define XR_KHR_generic_controller_SPEC_VERSION 1
#define XR_KHR_GENERIC_CONTROLLER_EXTENSION_NAME "XR_KHR_generic_controller"
#endif

#ifndef XR_EXT_active_action_set_priority
#define XR_EXT_active_action_set_priority 1
#define XR_EXT_ACTIVE_ACTION_SET_PRIORITY_EXTENSION_NAME "XR_EXT_active_action_set_priority"
#define XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT (static_cast<XrStructureType>(1000373000))
typedef struct XrActiveActionSetPriorityEXT {
  XrActionSet actionSet;
  uint32_t priorityOverride;
} XrActiveActionSetPriorityEXT;
typedef struct XrActiveActionSetPrioritiesEXT {
  XrStructureType type;
  const void* next;
  uint32_t actionSetPriorityCount;
  const XrActiveActionSetPriorityEXT* actionSetPriorities;
} XrActiveActionSetPrioritiesEXT;
#endif

#ifndef XR_EXT_user_presence
#define XR_EXT_user_presence 1
#define XR_EXT_USER_PRESENCE_EXTENSION_NAME "XR_EXT_user_presence"
#define XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT (static_cast<XrStructureType>(1000470000))
#define XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT (static_cast<XrStructureType>(1000470001))
typedef struct XrEventDataUserPresenceChangedEXT {
  XrStructureType type;
  const void* next;
  XrSession session;
  XrBool32 isUserPresent;
} XrEventDataUserPresenceChangedEXT;
typedef struct XrSystemUserPresencePropertiesEXT {
  XrStructureType type;
  void* next;
  XrBool32 supportsUserPresence;
} XrSystemUserPresencePropertiesEXT;
#endif

#ifndef XR_FB_haptic_amplitude_envelope
#define XR_FB_haptic_amplitude_envelope 1
#define XR_FB_HAPTIC_AMPLITUDE_ENVELOPE_EXTENSION_NAME "XR_FB_haptic_amplitude_envelope"
#define XR_TYPE_HAPTIC_AMPLITUDE_ENVELOPE_VIBRATION_FB (static_cast<XrStructureType>(1000173001))
#define XR_MAX_HAPTIC_AMPLITUDE_ENVELOPE_SAMPLES_FB 4000u
typedef struct XrHapticAmplitudeEnvelopeVibrationFB {
  XrStructureType type;
  const void* next;
  XrDuration duration;
  uint32_t amplitudeCount;
  const float* amplitudes;
} XrHapticAmplitudeEnvelopeVibrationFB;
#endif

#ifndef XR_FB_haptic_pcm
#define XR_FB_haptic_pcm 1
#define XR_FB_HAPTIC_PCM_EXTENSION_NAME "XR_FB_haptic_pcm"
#define XR_TYPE_HAPTIC_PCM_VIBRATION_FB (static_cast<XrStructureType>(1000209001))
#define XR_TYPE_DEVICE_PCM_SAMPLE_RATE_STATE_FB (static_cast<XrStructureType>(1000209002))
#define XR_MAX_HAPTIC_PCM_BUFFER_SIZE_FB 4000
typedef struct XrHapticPcmVibrationFB {
  XrStructureType type;
  const void* next;
  uint32_t bufferSize;
  const float* buffer;
  float sampleRate;
  XrBool32 append;
  uint32_t* samplesConsumed;
} XrHapticPcmVibrationFB;
typedef struct XrDevicePcmSampleRateStateFB {
  XrStructureType type;
  void* next;
  float sampleRate;
} XrDevicePcmSampleRateStateFB;
typedef XrDevicePcmSampleRateStateFB XrDevicePcmSampleRateGetInfoFB;
typedef XrResult(XRAPI_PTR* PFN_xrGetDeviceSampleRateFB)(XrSession session, const XrHapticActionInfo* hapticActionInfo,
                                                         XrDevicePcmSampleRateGetInfoFB* deviceSampleRate);
#endif

// XR_ERROR_EXTENSION_DEPENDENCY_NOT_ENABLED (OpenXR 1.1, XR_KHR_maintenance1): likewise.
inline constexpr XrResult kErrorExtensionDependencyNotEnabled = static_cast<XrResult>(-1000710001);

// XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR (OpenXR 1.1): a macro of our own name, since an enumerator cannot be tested for.
inline constexpr int kReferenceSpaceTypeLocalFloor = 1000426000;

#ifndef XR_KHR_locate_spaces
#define XR_KHR_locate_spaces 1
#define XR_KHR_locate_spaces_SPEC_VERSION 1
#define XR_KHR_LOCATE_SPACES_EXTENSION_NAME "XR_KHR_locate_spaces"
#define XR_TYPE_SPACES_LOCATE_INFO (static_cast<XrStructureType>(1000471000))
#define XR_TYPE_SPACE_LOCATIONS (static_cast<XrStructureType>(1000471001))
#define XR_TYPE_SPACE_VELOCITIES (static_cast<XrStructureType>(1000471002))
typedef struct XrSpacesLocateInfo {
  XrStructureType type;
  const void* next;
  XrSpace baseSpace;
  XrTime time;
  uint32_t spaceCount;
  const XrSpace* spaces;
} XrSpacesLocateInfo;
typedef struct XrSpaceLocationData {
  XrSpaceLocationFlags locationFlags;
  XrPosef pose;
} XrSpaceLocationData;
typedef struct XrSpaceLocations {
  XrStructureType type;
  void* next;
  uint32_t locationCount;
  XrSpaceLocationData* locations;
} XrSpaceLocations;
typedef struct XrSpaceVelocityData {
  XrSpaceVelocityFlags velocityFlags;
  XrVector3f linearVelocity;
  XrVector3f angularVelocity;
} XrSpaceVelocityData;
// Extends XrSpaceLocations.
typedef struct XrSpaceVelocities {
  XrStructureType type;
  void* next;
  uint32_t velocityCount;
  XrSpaceVelocityData* velocities;
} XrSpaceVelocities;
typedef XrResult(XRAPI_PTR* PFN_xrLocateSpaces)(XrSession session, const XrSpacesLocateInfo* locateInfo,
                                                XrSpaceLocations* spaceLocations);
typedef PFN_xrLocateSpaces PFN_xrLocateSpacesKHR;
#endif

#ifndef XR_FB_render_model
#define XR_FB_render_model 1
#define XR_FB_RENDER_MODEL_EXTENSION_NAME "XR_FB_render_model"
#define XR_TYPE_RENDER_MODEL_PATH_INFO_FB (static_cast<XrStructureType>(1000119000))
#define XR_TYPE_RENDER_MODEL_PROPERTIES_FB (static_cast<XrStructureType>(1000119001))
#define XR_RENDER_MODEL_UNAVAILABLE_FB (static_cast<XrResult>(1000119020))
#define XR_MAX_RENDER_MODEL_NAME_SIZE_FB 64
XR_DEFINE_ATOM(XrRenderModelKeyFB)
typedef XrFlags64 XrRenderModelFlagsFB;
typedef struct XrRenderModelPathInfoFB {
  XrStructureType type;
  void* next;
  XrPath path;
} XrRenderModelPathInfoFB;
typedef struct XrRenderModelPropertiesFB {
  XrStructureType type;
  void* next;
  uint32_t vendorId;
  char modelName[XR_MAX_RENDER_MODEL_NAME_SIZE_FB];
  XrRenderModelKeyFB modelKey;
  uint32_t modelVersion;
  XrRenderModelFlagsFB flags;
} XrRenderModelPropertiesFB;
typedef XrResult(XRAPI_PTR* PFN_xrEnumerateRenderModelPathsFB)(XrSession session, uint32_t pathCapacityInput,
                                                               uint32_t* pathCountOutput,
                                                               XrRenderModelPathInfoFB* paths);
typedef XrResult(XRAPI_PTR* PFN_xrGetRenderModelPropertiesFB)(XrSession session, XrPath path,
                                                              XrRenderModelPropertiesFB* properties);
#endif
static_assert(sizeof(XrRenderModelPathInfoFB) == 24);
static_assert(sizeof(XrRenderModelPropertiesFB) == 112 && offsetof(XrRenderModelPropertiesFB, modelKey) == 88 &&
              offsetof(XrRenderModelPropertiesFB, flags) == 104);

#include "layer/src/entry/render_model_compat.h"
