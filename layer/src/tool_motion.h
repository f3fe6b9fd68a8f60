// Where the pen was, is or will be, from the service's history ring. No system call, no lock, no allocation.
#pragma once

#include <cstdint>

#include "layer/src/pose_math.h"
#include "service/client/state_reader.h"

namespace omni::layer {

// A pen whose newest sample is older than this is gone.
inline constexpr std::int64_t kPresenceTimeout_ns = 100'000'000;

// Constant-velocity prediction ends here; later times get the pose of this horizon. Beyond it prediction of a hand adds
// more jitter than it removes lag.
inline constexpr std::int64_t kMaxPrediction_ns = 40'000'000;

struct ToolMotion {
  bool valid = false;    // X_BT is a real (maybe not recent) measurement
  bool tracked = false;  // measured at that time
  Motion X_BT;           // tool in the base
};

// Between two samples: cubic Hermite through positions and velocities, slerp between orientations.
Motion Interpolate(const protocol::ToolSample& before, const protocol::ToolSample& after, std::int64_t t_ns) noexcept;

// From one sample onwards.
Motion Predict(const protocol::ToolSample& sample, std::int64_t t_ns) noexcept;

// `now_ns`: CLOCK_MONOTONIC, decides whether the pen is there at all.
ToolMotion ToolMotionAt(const client::StateReader& reader, std::int64_t t_ns, std::int64_t now_ns) noexcept;

}  // namespace omni::layer
