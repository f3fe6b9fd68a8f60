// The twin is a sensitive reference: a magnet one percent larger than the tracker assumes shows in the error.
#include <gtest/gtest.h>

#include <cmath>

#include "service/base/eigen.h"
#include "service/config/files/device_file.h"
#include "service/tracker/solve/static_solve.h"
#include "tests/support/rig/rig.h"

namespace omni::peers {
namespace test_peers_magnet_size {

sim::Rig NoiseFree(const base::DeviceGeometry& device) {
  return {device, {.seed = 1, .sizes = sim::NoImperfections(), .noise = sim::NoiseMode::kNone, .saturation = false}};
}

double MeanError_mm(const base::DeviceGeometry& device, const tracker::StaticSolver& solver) {
  sim::Rig rig = NoiseFree(device);
  sim::Random random(77);
  constexpr int kPoses = 100;
  double sum = 0;
  for (int i = 0; i < kPoses; ++i) {
    const sim::MagnetPose pose = rig.DrawPose({}, random);
    const base::HallScan scan = rig.Scan(&pose, {}, random);
    std::array<tracker::ArrayReading, base::kSensorCount> readings;
    for (std::size_t s = 0; s < readings.size(); ++s) readings[s] = {scan.field_sensor_T[s], 0};
    const tracker::StaticPose solved = solver.Solve(readings, {});
    EXPECT_TRUE(solved.status == tracker::StaticStatus::kFound || solved.status == tracker::StaticStatus::kPoorFit);
    sum += (solved.pose.position_base_m - base::ToEigen(pose.centre_base_m)).norm();
  }
  return 1e3 * sum / kPoses;
}

TEST(PeersMagnetSize, OnePercentRadiusErrorIncreasesPoseError) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  base::Calibration calibration = NoiseFree(device).ExactCalibration();
  calibration.sensor_noise_T = sim::NoiseOf_T(sim::NoiseMode::kUltraHigh);
  const auto solver = tracker::StaticSolver::Make(calibration, {});
  ASSERT_TRUE(solver.ok()) << solver.error();
  const double as_drawn_mm = MeanError_mm(device, *solver);
  base::DeviceGeometry larger = device;
  larger.magnet.radius_m *= 1.01;
  const double larger_mm = MeanError_mm(larger, *solver);
  EXPECT_LT(as_drawn_mm, 0.02);
  EXPECT_GT(larger_mm, 0.3);  // 2 % of the moment alone costs 1 mm
}

}  // namespace test_peers_magnet_size
}  // namespace omni::peers
