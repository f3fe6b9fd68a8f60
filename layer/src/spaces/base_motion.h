// Where a base that something carries was, is or will be, from the service's ring of its poses. No system call, no
// lock, no allocation.
#pragma once

#include <cstdint>

#include "layer/src/spaces/pose_math.h"
#include "service/client/state_reader.h"

namespace omni::layer {

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

// `now_ns`: CLOCK_MONOTONIC, decides whether the source is there at all.
BaseMotion BaseMotionAt(const client::StateReader& reader, std::int64_t t_ns, std::int64_t now_ns) noexcept;

}  // namespace omni::layer
