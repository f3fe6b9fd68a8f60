// Comparison of solvers: one scan of the comparison, and the interface of a method.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/hall_scan.h"
#include "service/tracker/solve/solver.h"
#include "service/tracker/tracker.h"
#include "tests/bench/peers/peer.h"
#include "tests/support/rig/rig.h"

namespace omni::bench {

struct SolverCase {
  sim::MagnetPose truth;
  base::HallScan scan;
  tracker::Measurement measurement;  // whitened once, with the sensors' noise alone, outside the timing
  tracker::Measurement product;      // with the product's error model
  peers::PeerScan peer;
  tracker::Pose warm;  // off by .3 mm per axis and .5 deg
};

struct SolverPoses {
  sim::PoseRange range;
  std::size_t count = 0;
  std::uint64_t seed = 0;
};

// Scans at rest of the twin, 0 A. `config`: the product's.
std::vector<SolverCase> DrawSolverCases(sim::Rig& rig, const tracker::Config& config, const SolverPoses& poses);

struct SolverAnswer {
  base::Vec3 position_base_m;
  base::Vec3 axis_base;
};

struct SolverMethod {
  const char* method = "";
  const char* model = "";
  const char* start = "";      // warm | cold
  const char* precision = "";  // float | double
  std::string variant;         // iterations, linear solver
  std::function<std::optional<SolverAnswer>(const SolverCase&)> solve;
};

// Ours: rungs, precisions, iterations, warm and cold. The first two, called default, are the product's warm and cold
// solve with its own error model; all others, like the peers, assume only the sensors' noise.
std::vector<SolverMethod> OmniSolvers(const base::Calibration& calibration, const tracker::Config& product);
// Ceres and TinySolver on our problem.
std::vector<SolverMethod> PeerSolvers(const base::Calibration& calibration);
// The paper's method.
std::vector<SolverMethod> PaperSolvers(const base::Calibration& calibration);

}  // namespace omni::bench
