#pragma once
// What exists outside any session: the two simulated controllers, the head, the hands, the origins of LOCAL and STAGE.
// Tests change it through hooks.h; sessions read it. Everything is in the frame that STAGE has at load, called the
// world here.

#include <openxr/openxr.h>

#include <string_view>
#include <vector>

#include "tests/runtime/actions/profiles.h"
#include "tests/runtime/spaces/motion.h"

namespace omni::runtime {

struct Value {
  float x = 0;
  float y = 0;
  XrTime change_time = 0;  // when the physical input last changed
  Motion motion;           // poses only: as of change_time
};

struct HapticRecord {
  uint32_t count = 0;
  uint32_t stops = 0;
  float amplitude = 0;
  float frequency_Hz = 0;
  XrDuration duration_ns = 0;
  uint32_t envelopes = 0;
  uint32_t pcms = 0;
  uint32_t samples = 0;  // of the last of these
};

struct Device {
  bool present = false;
  bool valid = true;    // false: never seen by the cameras
  bool tracked = true;  // false: seen before, now guessed
  int profile = 0;      // index into Profiles()
  // Changes whenever the profile does; a source that remembers an older one is dead.
  uint32_t epoch = 0;
  std::vector<Value> values;  // one per component of the profile
  HapticRecord haptics;
};

// One component of one device, as it was when a binding was resolved.
struct Source {
  int hand = -1;
  int component = -1;
  uint32_t epoch = 0;
  bool operator==(const Source&) const = default;
};

// Where the origin of a reference space is in the world, from a time on.
struct Origin {
  XrTime since = 0;
  XrPosef pose = kIdentity;
};
using Origins = std::vector<Origin>;  // in order of arrival, never empty

// A hand that cameras see, apart from any controller.
struct Hand {
  bool active = false;
  Motion palm;  // as of change_time
  XrTime change_time = 0;
};

struct World {
  Device devices[kHands];
  Motion head;
  XrTime head_time = 0;
  Hand hands[kHands];
  Origins local_origins;
  Origins stage_origins;
  bool has_stage = true;       // false: there is no STAGE
  bool has_shapes = false;     // vibrations with a shape: XR_FB_haptic_amplitude_envelope, XR_FB_haptic_pcm
  bool has_timespec = true;    // false: new instances cannot convert times
  bool has_models = true;      // false: new instances cannot enable XR_EXT_render_model
  uint64_t first_model = 1;    // the least id of render models from now on
  bool has_velocities = true;  // false: no XrSpaceVelocity is ever valid
  bool holds_images = false;   // true: the display keeps reading every swapchain image
  bool user_present = true;    // the headset is worn
  bool focus = true;
  XrResult creation = XR_SUCCESS;  // what xrCreateInstance returns, if it is an error
  uint32_t next_epoch = 1;

  World();
  // Left: touch controller at a fixed place. Right: none. Head and LOCAL 1.6 m above the floor. Focus available.
  void Reset();

  bool SetDevice(int hand, bool present, std::string_view profile);
  // The same, and every component at rest.
  bool RenewDevice(int hand, bool present, std::string_view profile);
  // `path` is a full component path of the device's profile; false if there is none of that type.
  bool SetBool(std::string_view path, bool value);
  bool SetFloat(std::string_view path, float value);
  bool SetVector2(std::string_view path, float x, float y);
  bool SetPose(std::string_view path, const Motion& motion);
  void SetHead(const Motion& motion);
  void SetHand(int hand, bool active, const Motion& palm);
  // LOCAL or STAGE moves to `pose`, given in where it is now, from `when` on.
  void Recenter(XrReferenceSpaceType space, const XrPosef& pose, XrTime when);

  // Natural origin of LOCAL, LOCAL_FLOOR or STAGE.
  XrPosef OriginAt(XrReferenceSpaceType space, XrTime time) const;
  Motion PalmAt(int hand, XrTime time) const;
  Motion HeadAt(XrTime time) const;
  bool IsLive(const Source& source) const;
  const Component& ComponentOf(const Source& source) const;
  // Reads of a live source. A vector's halves read from the vector.
  Value Read(const Source& source) const;
  Motion PoseAt(const Source& source, XrTime time) const;

 private:
  Value* Find(std::string_view path, ComponentType type);
  void ApplyProfile(int hand, int profile);
};

}  // namespace omni::runtime
