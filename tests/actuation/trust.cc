// How much force may be requested of a base of limited accuracy.
#include <gtest/gtest.h>

#include <limits>

#include "service/actuation/force_map.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::actuation {
namespace test_actuation_trust {

TEST(ForceTrust, IsOneWithoutErrorAndFallsWithIt) {
  const base::DeviceGeometry device = support::NominalDevice();
  const ForceMap map = MakeForceMap(device);
  EXPECT_EQ(ForceTrust(map, device, 0.0), 1);
  double last = 1;
  for (const double error_mm : {0.1, 0.5, 1.0, 3.0, 10.0}) {
    const double trust = ForceTrust(map, device, 1e-3 * error_mm);
    EXPECT_LT(trust, last) << error_mm;
    last = trust;
  }
  EXPECT_NEAR(ForceTrust(map, device, 1e-3), 0.93, 0.01) << "7 % a millimetre at the hull";
  for (const double odd : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(ForceTrust(map, device, odd), 0) << odd;
  }
  EXPECT_EQ(ForceTrust(ForceMap{}, device, 0.0), 0) << "without a map";
}

TEST(ForceTrust, FollowsTheExpectedErrorOfTheCalibration) {
  const base::DeviceGeometry device = support::NominalDevice();
  const ForceMap map = MakeForceMap(device);
  const double drawn = ForceTrust(map, device);
  EXPECT_GT(drawn, 0.4);
  EXPECT_LT(drawn, 0.5);
  base::Calibration calibration;
  EXPECT_EQ(ForceTrust(map, device, calibration), drawn) << "it says nothing of itself";
  calibration.expected_error_m = 0.15e-3;
  EXPECT_GT(ForceTrust(map, device, calibration), 0.95);
  calibration.expected_error_m = 1e-3;
  EXPECT_NEAR(ForceTrust(map, device, calibration), 0.8, 0.02);
  calibration.expected_error_m = 1;
  EXPECT_EQ(ForceTrust(map, device, calibration), drawn) << "no worse than the drawing";
}

}  // namespace test_actuation_trust
}  // namespace omni::actuation
