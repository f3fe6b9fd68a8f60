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

namespace omni::runtime {
// XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR of OpenXR 1.1: an enumerator cannot be tested for.
inline constexpr XrReferenceSpaceType kLocalFloor = static_cast<XrReferenceSpaceType>(1000426000);
}  // namespace omni::runtime
