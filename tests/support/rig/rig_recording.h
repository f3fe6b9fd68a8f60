// Recording of a simulated base as by a person: pen held at random places and on the hull, coils swept.
#pragma once

#include <cmath>
#include <vector>

#include "service/calibration/types.h"
#include "tests/support/rig/rig.h"

namespace omni::test {

struct RigRecordingOptions {
  int waves = 200;
  int touches = 60;
  double touch_sigma_m = 0;  // true distance of a "touch" from the hull
  bool responses = true;
  std::uint64_t seed = 1;  // of poses and noise
};

// The pose moved along its radius until the magnet is `gap_m` from the hull.
inline sim::MagnetPose OnHull(const sim::Rig& rig, sim::MagnetPose pose, double gap_m) {
  const base::Vec3 outwards = base::Normalized(pose.centre_base_m);
  const base::DeviceGeometry made = sim::TrueSizes(rig.device(), rig.imperfections());
  double low_m = 0, high_m = 0.2;
  for (int i = 0; i < 60; ++i) {
    const double middle_m = 0.5 * (low_m + high_m);
    pose.centre_base_m = middle_m * outwards;
    (sim::GapToHull(made.magnet, made.hull_radius_m, pose).gap_m < gap_m ? low_m : high_m) = middle_m;
  }
  return pose;
}

// One scan; saturated axes become NaN.
inline calibration::Sample TakeSample(sim::Rig& rig, const sim::MagnetPose& pose, double t_s, sim::Random& random) {
  const base::HallScan scan = rig.Scan(&pose, {}, random);
  calibration::Sample sample;
  sample.t_s = t_s;
  sample.field_sensor_T.assign(scan.field_sensor_T.begin(), scan.field_sensor_T.end());
  for (std::size_t i = 0; i < sample.field_sensor_T.size(); ++i) {
    double* axes[3] = {&sample.field_sensor_T[i].x, &sample.field_sensor_T[i].y, &sample.field_sensor_T[i].z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (((scan.saturated_mask >> (3 * i + axis)) & 1U) != 0) *axes[axis] = std::nan("");
    }
  }
  return sample;
}

inline calibration::Recording MakeRecording(sim::Rig& rig, const RigRecordingOptions& options) {
  constexpr double kWave_s = 0.04, kTouch_s = 0.5;  // from one to the next
  constexpr double kMapError_T_A = 5e-9;            // of a sweep to 4 A in low-power noise
  sim::Random random(options.seed);
  calibration::Recording recording;
  double t_s = 0;
  for (int i = 0; i < options.waves; ++i, t_s += kWave_s) {
    recording.samples.push_back(TakeSample(rig, rig.DrawPose({}, random), t_s, random));
  }
  for (int i = 0; i < options.touches; ++i, t_s += kTouch_s) {
    const sim::MagnetPose pose = rig.DrawPose({.tilt_max_rad = 0.35}, random);
    const sim::MagnetPose touching = OnHull(rig, pose, options.touch_sigma_m * random.Normal());
    recording.samples.push_back(TakeSample(rig, touching, t_s, random));
    recording.samples.back().touches_hull = true;
  }
  if (!options.responses) return recording;
  const sim::SensorFields rest = rig.Readings(nullptr, {});
  const std::array<sim::SensorFields, 3> coils{rig.Readings(nullptr, {1, 0, 0}), rig.Readings(nullptr, {0, 1, 0}),
                                               rig.Readings(nullptr, {0, 0, 1})};
  for (std::size_t i = 0; i < rest.size(); ++i) {
    calibration::CoilResponse response;
    response.background_sensor_T = rest[i];
    response.map_error_T_A = kMapError_T_A;
    for (std::size_t e = 0; e < 9; ++e) {
      const base::Vec3 &with = coils[e % 3][i], &without = rest[i];
      const std::array<double, 3> T_A{with.x - without.x, with.y - without.y, with.z - without.z};
      response.map_sensor_T_A[e] = T_A[e / 3] + kMapError_T_A * random.Normal();
    }
    recording.responses.push_back(response);
  }
  return recording;
}

}  // namespace omni::test
