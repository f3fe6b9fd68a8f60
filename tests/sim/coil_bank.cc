// The twin's coils as circuits and heaters, alone.
#include <gtest/gtest.h>

#include <cmath>

#include "service/sim/coils/coil_bank.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::sim {
namespace test_sim_coil_bank {

TEST(SimCoilBank, CurrentLagsByLOverR) {
  const base::DeviceGeometry device = support::NominalDevice();
  CoilBank coils(device, ThermalConfig{});
  const double tau_s = device.coils[1].inductance_H / coils.Resistance(1);
  const double final_A = 6 / coils.Resistance(1);
  double sum_A = 0;
  for (int i = 0; i < 8; ++i) sum_A += coils.Step(1, 6, 0, 250e-6);
  EXPECT_NEAR(coils.current_A()[1], final_A * (1 - std::exp(-2e-3 / tau_s)), 1e-9);
  EXPECT_NEAR(sum_A / 8, final_A * (1 - tau_s / 2e-3 * (1 - std::exp(-2e-3 / tau_s))), 1e-9) << "means of the steps";
  EXPECT_EQ(coils.current_A()[0], 0);
}

// One coil at 5 A: its copper settles at 65.4 C, the body at 47 C. (y coil, air 24 C.)
TEST(SimCoilBank, WarmsUpAsMeasured) {
  CoilBank coils(support::NominalDevice(), ThermalConfig{});
  coils.SetCurrents({0, 5, 0});
  for (int i = 0; i < 90000; ++i) coils.StepHeat(10e-3);
  EXPECT_NEAR(coils.temperature_C()[1], 65.4, 1.0);
  EXPECT_NEAR(coils.temperature_C()[0], 47.0, 1.0) << "an idle coil takes the body's temperature";
}

}  // namespace test_sim_coil_bank
}  // namespace omni::sim
