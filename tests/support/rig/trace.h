// A moving run held in memory: a waved pen, prescribed coil currents, and the device's reports, scan by scan, through
// the twin's own base: plant and control core. For benchmarks: every scan has its truth.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "service/base/hall_scan.h"
#include "tests/support/hand/free_motion.h"
#include "tests/support/rig/rig.h"

namespace omni::sim {

// Set-point offset + amplitude * (2 frac(t / period + phase) - 1): rises for a period, then falls at once. The current
// follows with the coil's own lag and the supply's limit. Amplitude 0: constant.
struct Sawtooth {
  double amplitude_A = 0;
  double period_s = 1;  // > 0
  double phase = 0;     // of a period
  double offset_A = 0;
};
using CurrentScript = std::array<Sawtooth, base::kCoilCount>;

// +-amplitude on every axis, the phases a third of a period apart.
CurrentScript StaggeredSawtooth(double amplitude_A, double period_s) noexcept;

struct TraceOptions {
  double duration_s = 20;
  double start_s = 0;      // since the start of the run: of drift and warming
  std::uint64_t seed = 1;  // of noise and sample instants
  MotionOptions motion;    // its own seed
  bool present = true;     // false: no pen
  CurrentScript currents;  // device_.current_max_A holds
};

// Of scan.t_ns, the instant of its newest sample; sensor i sampled at scan.t_ns - scan.age_ns[i].
struct TraceRow {
  base::HallScan scan;
  MagnetPose pose;
  Vec3 velocity_base_m_s;
  CoilArray current_A{};  // true, at scan.t_ns
  std::int64_t tick_end_ns = 0;
};

// One row per device tick. Noise, imperfections and effects are those of the rig's options (saturation always); drift
// and warming reach their size after effects.run_s. Equal options give equal bits. The rig's own time and memory do not
// change.
std::vector<TraceRow> RecordTrace(Rig& rig, const TraceOptions& options);

}  // namespace omni::sim
