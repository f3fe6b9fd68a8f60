// A bundle adjustment ready to start: an uncalibrated simulated base, its recording, poses from the cold start with the
// nominal geometry, no current maps. For comparisons of solvers.
#pragma once

#include <cstdint>
#include <vector>

#include "service/base/result.h"
#include "service/calibration/fit/start.h"
#include "service/calibration/fit/system.h"
#include "service/magnetics/nominal.h"
#include "tests/support/rig/rig_recording.h"

namespace omni::test {

struct AdjustmentStart {
  calibration::Problem problem;
  calibration::Parameters parameters;
  std::vector<calibration::Instant> instants;
};

inline base::Result<AdjustmentStart> MakeAdjustmentStart(const base::DeviceGeometry& device, std::uint64_t seed,
                                                         const RigRecordingOptions& options) {
  sim::Rig rig(device, {.seed = seed, .sizes = sim::UncalibratedImperfections()});
  const calibration::Recording recording = MakeRecording(rig, options);
  const calibration::Tolerances tolerances;
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  const calibration::Problem measured(nominal, {}, {{}, recording.responses}, tolerances);
  const auto cold = calibration::ColdStart::Make(measured.nominal(), tolerances);
  if (!cold.ok()) return base::Error{cold.error()};
  calibration::Recording found{{}, recording.responses};
  std::vector<calibration::Instant> instants;
  for (const calibration::Sample& sample : recording.samples) {
    const calibration::ColdPose pose = cold->FindPose(sample);
    if (!pose.found) continue;
    found.samples.push_back(sample);
    instants.push_back({pose.position_base_m, pose.axis_base});
  }
  calibration::Problem problem(nominal, {}, found, tolerances);
  calibration::Parameters parameters(problem.nominal(), tolerances);
  problem.FollowCore(parameters, instants);
  return AdjustmentStart{std::move(problem), std::move(parameters), std::move(instants)};
}

}  // namespace omni::test
