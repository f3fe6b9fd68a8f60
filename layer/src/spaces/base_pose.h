// Where the base stands in the runtime's world, also while the runtime moves the origin of a reference space.
//
// [XrEventDataReferenceSpaceChangePending] A change applies to queries for `changeTime` and later; earlier times are
// answered with the origin as it was. The base does not move in the world: with X_LL' = poseInPreviousSpace,
// X_L'O = inverse(X_LL') * X_LO. Where that pose is not known, the base is somewhere near: VALID, not TRACKED.
//
// Below: where a base that something carries was, is or will be, from the service's ring of its poses.
#pragma once

#include <cstdint>
#include <shared_mutex>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"
#include "layer/src/spaces/pose_math.h"
#include "service/client/state_reader.h"

namespace omni::layer {

// Where the base stands before it is aligned: in front of the user of LOCAL, below the eyes, its +y away from
// the user. O: base, z up; L: LOCAL, y up.
Pose DefaultBasePose();

struct BasePose {
  XrReferenceSpaceType space = XR_REFERENCE_SPACE_TYPE_LOCAL;  // L
  Pose X_LO = DefaultBasePose();  // base in the natural frame of L: no offset of any application
  bool valid = true;              // false: it is not known where the base stands; the pen has no pose
  bool tracked = true;            // false: the pen's poses are VALID, not TRACKED
  bool follows = false;           // the base moves: BaseMotionAt has where it is, this is for want of that
};

// The base pose of one session over time. Any thread may call anything; nothing blocks for long.
class BasePoseHistory {
 public:
  // Older changes are forgotten: enough for a second of queries about the past.
  static constexpr std::size_t kMostEpochs = 16;

  // Replaces what was known, for every time. Changes of L that were announced and come after `now` still apply.
  void Set(const BasePose& base_pose, XrTime now);

  // Call once per event. False: the origin of L moves to an unknown place, so tracking ends at `changeTime`.
  bool OnChange(const XrEventDataReferenceSpaceChangePending& change);

  // The base pose at `time`.
  BasePose At(XrTime time) const;

 private:
  struct Epoch {
    XrTime since = 0;
    BasePose base_pose;
  };
  bool Append(const XrEventDataReferenceSpaceChangePending& change);

  mutable std::shared_mutex mutex_;
  std::vector<Epoch> epochs_{Epoch{}};  // in the order of arrival, never empty; the last one that has begun applies
  std::vector<XrEventDataReferenceSpaceChangePending> changes_;  // the last kMostEpochs, of any space
};

// A source whose newest pose is older than this is lost. Two frames of the slowest headset (45 Hz): in one the next
// pose is measured, in the other it is on its way. A source that says that it is lost is lost at once.
inline constexpr std::int64_t kBaseSilence_ns = 2'000'000'000 / 45;

// Prediction ends here; later times get the pose of this horizon. A base on an arc, with the speed v and the turn rate
// w, leaves the straight line of its velocity by v w t^2 / 2: 1 mm at 0.5 m/s, 90 degrees/s and 50 ms.
inline constexpr std::int64_t kMaxBasePrediction_ns = 50'000'000;

// A time between poses that are further apart than this was not measured.
inline constexpr std::int64_t kMaxBaseGap_ns = 50'000'000;

struct BaseMotion {
  bool valid = false;                                          // X_LO is a real (maybe not recent) pose
  bool tracked = false;                                        // seen at that time
  XrReferenceSpaceType space = XR_REFERENCE_SPACE_TYPE_LOCAL;  // L
  Motion X_LO;                                                 // base in L
};

// `now_ns`: CLOCK_MONOTONIC, decides whether the source is there at all. No system call, no lock, no allocation.
BaseMotion BaseMotionAt(const client::StateReader& reader, std::int64_t t_ns, std::int64_t now_ns) noexcept;

}  // namespace omni::layer
