// Where the pen was, is or will be, from the service's history ring. No system call, no lock, no allocation.
#pragma once

#include <cstdint>

#include "layer/src/spaces/pose_math.h"
#include "service/client/state_reader.h"

namespace omni::layer {

// A pen whose newest sample is older than this is gone.
inline constexpr std::int64_t kPresenceTimeout_ns = 100'000'000;

// Prediction ends here; later times get the pose of this horizon. Beyond it prediction of a hand adds more jitter than
// it removes lag.
inline constexpr std::int64_t kMaxPrediction_ns = 40'000'000;

// A hand at rest trembles at 8 to 12 Hz: its velocity at an instant says nothing about the next 40 ms, and following it
// shakes the pen. So the velocity is trusted as far as the pen has moved on in the last tenth of a second, which holds
// a whole period of tremor: with the mean speed m over that time, by the share m^2 / (m^2 + s^2). s: the m of a resting
// hand with the tracker's noise (`omni-bench layer` measures the result).
inline constexpr std::uint32_t kTrendSamples = 100;
inline constexpr std::int64_t kTrendMin_ns = 50'000'000, kTrendMax_ns = 200'000'000;
inline constexpr double kRestSpeed_m_s = 0.012;
inline constexpr double kRestTurn_rad_s = 0.1;

// A time that is further than this from the samples on both sides was not measured.
inline constexpr std::int64_t kMaxGap_ns = 50'000'000;

// A position that is less certain than this (1 sigma of the tracker, norm over the axes) is a guess: VALID, not
// TRACKED. Headsets know their own controllers to 1 to 2 mm.
inline constexpr double kMaxTrackedSigma_m = 3e-3;

struct ToolMotion {
  bool valid = false;    // X_BT is a real (maybe not recent) measurement
  bool tracked = false;  // measured at that time, and well
  Motion X_BT;           // tool in the base
};

// Between two motions, at t0_ns < t1_ns: as below.
Motion Interpolate(const Motion& m0, std::int64_t t0_ns, const Motion& m1, std::int64_t t1_ns,
                   std::int64_t t_ns) noexcept;

// Between two samples: cubic Hermite through positions and velocities, slerp between orientations; the samples' own
// velocities, linearly.
Motion Interpolate(const protocol::ToolSample& before, const protocol::ToolSample& after, std::int64_t t_ns) noexcept;

// How a pose is carried on past the newest sample. All but kTrusted are for comparison.
enum class Prediction { kHold, kConstantVelocity, kTrusted };

// From `newest` onwards; `earlier` is the sample kTrendSamples before it. Where that one has no pose, or is not from
// kTrendMin_ns to kTrendMax_ns older, the newest velocity stands for the mean. Velocities of the result are those at
// which its pose moves.
Motion Predict(const protocol::ToolSample& newest, const protocol::ToolSample& earlier, std::int64_t t_ns,
               Prediction method = Prediction::kTrusted) noexcept;

// `now_ns`: CLOCK_MONOTONIC, decides whether the pen is there at all.
ToolMotion ToolMotionAt(const client::StateReader& reader, std::int64_t t_ns, std::int64_t now_ns) noexcept;

}  // namespace omni::layer
