// The sweep in real conditions: an iron core with remanence and lag. Both pass for a weaker coil unless they are
// separated from it.
#include <gtest/gtest.h>

#include <cmath>

#include "service/calibration/checks/coil_sweep.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/device/transport.h"
#include "service/sim/twin/twin.h"
#include "tests/support/rig/rig.h"

namespace omni::calibration {
namespace test_calibration_sweep {

// Scale of map column k against the exact one, less the current sensor's gain (which tracking needs to be in it).
std::array<double, base::kCoilCount> ScaleErrors(std::uint64_t seed) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const base::TruthParameters& truth = config::IdealTwin();
  sim::Rig rig(device, {.seed = seed,
                        .sizes = truth.imperfections,
                        .noise = sim::NoiseMode::kLowPower,
                        .effects = truth.effects,
                        .sensor = truth.sensor});
  const sim::HandScript away{.waypoints = {{.tip_base_m = {0, 0, 0.3}, .present = false}}};
  const auto twin = sim::MakeVirtualTwin(device, {.seed = seed, .script = away, .truth = truth}, 60);
  CoilSweep sweep;
  base::HallScan scan;
  for (const SweepStep& step : MakeSweep({})) {
    for (int i = 0; i < step.scans; ++i) {
      EXPECT_EQ(twin->Read(scan, 0), device::ReadStatus::kScan);
      sweep.Add(scan, step.rest);
      twin->Write({step.current_A});
    }
  }
  const auto responses = sweep.Finish();
  EXPECT_TRUE(responses.ok());
  const base::Calibration exact = rig.ExactCalibration();
  std::array<double, base::kCoilCount> errors{};
  for (std::size_t k = 0; k < errors.size() && responses.ok(); ++k) {
    double product = 0, square = 0;
    for (std::size_t i = 0; i < responses->size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double wanted = exact.sensors[i].current_map_T_A[3 * axis + k];
        product += wanted * (*responses)[i].map_sensor_T_A[3 * axis + k];
        square += wanted * wanted;
      }
    }
    errors[k] = product / square * rig.imperfections().current_gain[k] - 1;
  }
  return errors;
}

TEST(CalibrationSweep, RemanentCoreIsNotMistakenForAWeakerCoil) {
  for (const std::uint64_t seed : {61, 62, 63}) {
    for (const double error : ScaleErrors(seed)) EXPECT_LT(std::abs(error), 1e-3) << seed;
  }
}

}  // namespace test_calibration_sweep
}  // namespace omni::calibration
