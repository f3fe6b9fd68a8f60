#pragma once
// What Debian's OpenXR 1.0.20 headers lack and this runtime has: values of the registry (xr.xml of OpenXR 1.1.62).
// Guarded, so that newer headers win.

#include <openxr/openxr.h>

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

namespace omni::runtime {
// XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR of OpenXR 1.1: an enumerator cannot be tested for.
inline constexpr XrReferenceSpaceType kLocalFloor = static_cast<XrReferenceSpaceType>(1000426000);
}  // namespace omni::runtime
