#pragma once
// How a test in the same process moves the simulated world. Link with omni_test_runtime (the loader then opens the very
// library the test already has), or dlsym these names. Every function takes effect at once and is safe from any thread.
// int results: 0 done, -1 rejected (unknown hand, path, type or an argument out of range).
//
// Hands are "left" and "right". Input paths are full component paths of the profile that the device has at the moment:
// "/user/hand/left/input/trigger/value". Poses are {x, y, z, qx, qy, qz, qw} in STAGE, velocities {vx, vy, vz, wx, wy,
// wz} in STAGE axes, NULL for rest; a moving pose is carried on at that velocity from the moment it was set. One-word
// commands of the script (OMNI_TEST_RUNTIME_SCRIPT) do the same from outside: docs/howto/test-runtime.md.

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct OmniTestHaptics {
  uint32_t count;  // xrApplyHapticFeedback that reached this hand's device
  uint32_t stops;
  float last_amplitude;
  float last_frequency_Hz;
  int64_t last_duration_ns;
  uint32_t envelopes;  // vibrations with a shape, where they are offered
  uint32_t pcms;
  uint32_t last_samples;  // amplitudes of the last envelope, or samples that were taken of the last PCM
};

#define OMNI_TEST_MAX_LAYERS 16
#define OMNI_TEST_MAX_VIEWS 2

struct OmniTestLayer {
  const void* structure;  // as it came; may be gone by now
  const void* next;
  uint64_t space;
  int type;
  float pose[7];  // identity for projections; a cube has an orientation only
  uint32_t views;
  float view_pose[OMNI_TEST_MAX_VIEWS][7];
  const void* view_next[OMNI_TEST_MAX_VIEWS];
};

struct OmniTestFrame {
  const void* info;  // as it came
  const void* next;
  int64_t display_time;
  int blend_mode;
  uint32_t layer_count;
  struct OmniTestLayer layers[OMNI_TEST_MAX_LAYERS];
};

// The world as at load: left touch controller present, right absent, focus available. Sessions stay as they are.
int omni_test_reset(void);
// profile: "/interaction_profiles/oculus/touch_controller", ".../khr/simple_controller", or NULL to keep it.
int omni_test_set_device(const char* hand, int present, const char* profile);
int omni_test_set_tracking(const char* hand, int valid, int tracked);
int omni_test_set_bool(const char* path, int value);
int omni_test_set_float(const char* path, float value);
int omni_test_set_vector2(const char* path, float x, float y);
int omni_test_set_pose(const char* path, const float pose[7], const float velocity[6]);
int omni_test_set_head(const float pose[7], const float velocity[6]);
// 0: focused sessions drop to VISIBLE at once, 1: they come back.
int omni_test_set_focus(int focus);
// The headset is taken off (0) or put on: an event where XR_EXT_user_presence is enabled.
int omni_test_set_user_presence(int present);
// LOCAL (and LOCAL_FLOOR with it) moves to `pose`, given in the present LOCAL, after delay_ns; the event is queued now.
int omni_test_recenter(const float pose[7], int64_t delay_ns);
// The same for "local" or "stage". reported = 0: the event does not contain the new origin (poseValid is false).
int omni_test_move_space(const char* space, const float pose[7], int64_t delay_ns, int reported);
// 0: sessions have no STAGE from now on.
int omni_test_offer_stage(int offered);
// 0: new instances cannot enable XR_KHR_convert_timespec_time.
int omni_test_offer_timespec(int offered);
// 1: new instances may have XR_FB_haptic_amplitude_envelope and XR_FB_haptic_pcm (of one call 1000 samples are taken).
int omni_test_offer_shapes(int offered);
// 0: new instances cannot enable XR_EXT_uuid, XR_EXT_render_model, XR_EXT_interaction_render_model.
int omni_test_offer_models(int offered);
// Ids of render models that come from now on are at least this.
int omni_test_number_models(uint64_t first);
// What every xrCreateInstance returns from now on: an error, or XR_SUCCESS for no such whim.
int omni_test_refuse_instances(int result);
// 0: no velocity is ever valid, as with runtimes that do not know them.
int omni_test_report_velocities(int reported);
// 1: the display keeps reading every swapchain image, so that xrWaitSwapchainImage times out; 0: it is done.
int omni_test_hold_images(int held);
// The hand that XR_EXT_hand_tracking sees; `pose` of the palm in STAGE, null to keep it.
int omni_test_set_hand(const char* hand, int active, const float pose[7], const float velocity[6]);
// The user quits the application: every running session goes to STOPPING.
int omni_test_request_exit(void);
// Every session: LOSS_PENDING is queued, and all its functions but destruction return XR_ERROR_SESSION_LOST.
int omni_test_lose_session(void);
// Every instance: the loss event is queued; once it has been polled, all functions return XR_ERROR_INSTANCE_LOST.
int omni_test_lose_instance(void);
// The runtime dies without an event: every instance is lost at once.
int omni_test_kill_runtime(void);

int omni_test_haptics(const char* hand, struct OmniTestHaptics* haptics);
// The newest xrEndFrame that came down, accepted or not; info is null before the first.
int omni_test_frame(struct OmniTestFrame* frame);
// Calls of "xrLocateSpace" ... that reached the runtime since it was loaded; -1 for a function it does not have.
long omni_test_call_count(const char* function);
// Handles that are alive, of all types.
uint32_t omni_test_live_handles(void);

#ifdef __cplusplus
}
#endif
