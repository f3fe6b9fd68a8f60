// TickConfig from a device's geometry: everything the tick reads is prepared here, off the tick.
#pragma once

#include <algorithm>

#include "service/actuation/force_map.h"
#include "service/base/device_geometry.h"
#include "service/loop/tick.h"

namespace omni::loop {

// A pose that counts as tracked, to 3 mm (3 sigma), is fully trusted.
inline constexpr double kTrackedError_m = 3e-3;
// At the largest error that is trusted the force has faded out: when it ended abruptly, a pen leaning on it oscillated.
inline constexpr double kPoseErrorMax_m = 12e-3, kPoseErrorFade_m = 2e-3;
static_assert(kPoseErrorMax_m == kPoseError_step_m * (std::tuple_size_v<decltype(ForceLimiterConfig::pose_trust)> - 1));

// `force_trust`: how well the base is known, 0 to 1. The greatest force and its rise shrink with it.
inline TickConfig MakeTickConfig(const base::DeviceGeometry& device, const tracker::Config& tracker,
                                 const actuation::Config& actuation, double force_trust) {
  TickConfig config;
  config.tracker = tracker;
  config.actuation = actuation;
  config.actuation.force_max_N *= force_trust;
  config.limiter.rise_N_s = force_trust * config.haptics.force_slew_N_s;
  const double tracked = actuation::ForceTrust(actuation.map, device, kTrackedError_m);
  for (std::size_t i = 0; i < config.limiter.pose_trust.size() && tracked > 0; ++i) {
    const double error_m = kPoseError_step_m * static_cast<double>(i);
    const double fade = std::min(1.0, (kPoseErrorMax_m - error_m) / kPoseErrorFade_m);
    config.limiter.pose_trust[i] =
        fade * std::min(1.0, actuation::ForceTrust(actuation.map, device, error_m) / tracked);
  }
  config.applied.force_slew_N_s = config.haptics.force_slew_N_s;
  config.applied.force_max_N = config.actuation.force_max_N;
  const actuation::HeatConfig& heat = actuation.heat;
  for (std::size_t k = 0; k < config.cold_current_A.size(); ++k) {
    config.cold_current_A[k] = actuation::CurrentCeiling_A(heat, k, heat.nodes.air_C, heat.nodes.air_C);
  }
  return config;
}

// Nominal geometry.
inline TickConfig MakeTickConfig(const base::DeviceGeometry& device) {
  const actuation::Config actuation = actuation::MakeConfig(device);
  return MakeTickConfig(device, tracker::MakeConfig(device), actuation, actuation::ForceTrust(actuation.map, device));
}

// The same for a base that has been calibrated.
inline TickConfig MakeTickConfig(const base::DeviceGeometry& device, const base::Calibration& calibration) {
  const actuation::Config actuation = actuation::MakeConfig(device, calibration);
  return MakeTickConfig(device, tracker::MakeConfig(calibration), actuation,
                        actuation::ForceTrust(actuation.map, device, calibration));
}

}  // namespace omni::loop
