// The exact cylinder and the Hall sensor against closed forms and tables.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "service/magnetics/coil.h"
#include "service/magnetics/disc_magnet.h"
#include "service/magnetics/nominal.h"
#include "tests/support/chips/hall_sensor.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::magnetics {
namespace test_magnetics_cylinder_unit {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(MagneticsCylinder, BulirschCelMatchesCompleteEllipticIntegrals) {
  // K = cel(k, 1, 1, 1), E = cel(k, 1, 1, k^2), k complementary.
  for (const double k2 : {1.0, 0.9, 0.5, 0.1, 1e-3, 1e-8}) {
    const EllipticIntegrals e = CompleteElliptic(1 - k2);
    const double tolerance = 1e-13 + 1e-16 / k2;  // 1 - k2 itself is rounded
    EXPECT_NEAR(BulirschCel(std::sqrt(k2), 1, 1, 1), e.K, tolerance * e.K) << k2;
    EXPECT_NEAR(BulirschCel(std::sqrt(k2), 1, 1, k2), e.E, tolerance * e.E) << k2;
  }
}

TEST(MagneticsCylinder, BulirschCelMatchesNumericalIntegration) {
  // Midpoint sums of a periodic integrand converge faster than any power.
  for (const double k : {0.2, 0.7, 1.0}) {
    for (const double p : {0.01, 0.3, 1.0, 4.0}) {
      const int n = 4000;
      double sum = 0;
      for (int i = 0; i < n; ++i) {
        const double t = (i + 0.5) * std::numbers::pi / (2 * n);
        const double c2 = std::cos(t) * std::cos(t), s2 = 1 - c2;
        sum += (0.7 * c2 - 0.2 * s2) / ((c2 + p * s2) * std::sqrt(c2 + k * k * s2));
      }
      sum *= std::numbers::pi / (2 * n);
      EXPECT_NEAR(BulirschCel(k, p, 0.7, -0.2), sum, 1e-12 * std::abs(sum)) << k << " " << p;
    }
  }
}

TEST(MagneticsCylinder, FieldOnAxisMatchesTheClosedForm) {
  // Bz = Br/2 [ (z+b)/sqrt((z+b)^2+R^2) - (z-b)/sqrt((z-b)^2+R^2) ], inside and outside.
  const base::MagnetGeometry magnet = support::NominalDevice().magnet;
  const Vector3d u = Vector3d(1, 2, -0.5).normalized();
  for (const double z : {-0.1, -0.004, 0.0, 0.002, 0.01, 0.05}) {
    const double R = magnet.radius_m, near = z + magnet.half_height_m, far = z - magnet.half_height_m;
    const double expected = magnet.remanence_T / 2 * (near / std::hypot(near, R) - far / std::hypot(far, R));
    const Vector3d B = CylinderField(magnet, u, z * u);
    EXPECT_NEAR(B.dot(u), expected, 1e-13 * std::abs(expected)) << z;
    EXPECT_LT((B - B.dot(u) * u).norm(), 1e-13 * std::abs(expected)) << z;
  }
}

TEST(MagneticsCylinder, AxialFieldJumpsByRemanenceAcrossTheMantle) {
  const base::MagnetGeometry magnet = support::NominalDevice().magnet;
  const Vector3d u = Vector3d::UnitZ();
  const double R = magnet.radius_m;
  const Vector3d inside = CylinderField(magnet, u, {R * (1 - 1e-8), 0, 0.001});
  const Vector3d outside = CylinderField(magnet, u, {R * (1 + 1e-8), 0, 0.001});
  EXPECT_NEAR(inside.z() - outside.z(), magnet.remanence_T, 1e-5);
  EXPECT_NEAR(inside.x(), outside.x(), 1e-5);
  EXPECT_TRUE(CylinderField(magnet, u, {R, 0, 0.02}).allFinite());  // above the mantle: g = 0
  EXPECT_NEAR(CylinderField(magnet, u, {R, 0, 0.02}).z(), CylinderField(magnet, u, {R * (1 + 1e-7), 0, 0.02}).z(),
              1e-7);
}

TEST(MagneticsHall, NoiseGrowsWithTheSampleRate) {
  const auto quiet = HallNoise_T(HallMode::kUltraHigh155Hz);
  EXPECT_EQ(quiet[0], 3.2e-7);
  EXPECT_EQ(quiet[2], 4.1e-7);
  const auto fast = HallNoise_T(HallMode::kLow1000Hz);
  EXPECT_NEAR(fast[0] / quiet[0], 2.54, 0.005);
  EXPECT_LT(HallNoise_T(HallMode::kHigh300Hz)[1], HallNoise_T(HallMode::kMedium560Hz)[1]);
}

TEST(MagneticsHall, ReadingIsRoundedClippedAndMarkedSaturated) {
  HallSensor sensor;
  sensor.background_sensor_T = {1e-6, 0, 0};
  const HallReading reading = ReadHall(sensor, {1e-4, -2e-3, 1.6e-3}, {0, 0, 1.0}, 1e-4);
  EXPECT_NEAR(reading.field_sensor_T.x(), 1.01e-4, 0.51 * sensor.lsb_T);
  EXPECT_NEAR(reading.field_sensor_T.y(), -1.6e-3, 0.51 * sensor.lsb_T);
  EXPECT_NEAR(reading.field_sensor_T.z(), 1.5e-3, 0.51 * sensor.lsb_T);  // 0.1 ms ago it was 0.1 mT weaker
  EXPECT_EQ(reading.saturated, 0b010);
  EXPECT_EQ(HallJacobian(sensor, reading.saturated).row(1).norm(), 0);
  EXPECT_EQ(HallJacobian(sensor, reading.saturated).row(0), Matrix3d::Identity().row(0));
  EXPECT_EQ(ReadHall(sensor, {std::nan(""), 0, 0}, Vector3d::Zero(), 0).saturated & 1, 1);
}

TEST(MagneticsArray, WindingsReproduceTheNominalCurrentMaps) {
  const base::DeviceGeometry device = support::NominalDevice();
  const base::Calibration drawn = NominalCalibration(device);
  base::Calibration array = drawn;
  for (base::SensorCalibration& sensor : array.sensors) sensor.current_map_T_A = {};
  AddWindings({device.coils.begin(), device.coils.end()}, array);
  for (std::size_t i = 0; i < array.sensors.size(); ++i) {
    for (std::size_t e = 0; e < 9; ++e) {
      EXPECT_NEAR(array.sensors[i].current_map_T_A[e], drawn.sensors[i].current_map_T_A[e], 1e-16);
    }
  }
  EXPECT_EQ(MomentOf(device.magnet), drawn.moment_Am2);
  base::MagnetGeometry ball{.shape = base::MagnetShape::kSphere, .radius_m = 0.01, .remanence_T = 1.2};
  EXPECT_NEAR(MomentOf(ball), 1.2 * 4 / 3 * std::numbers::pi * 1e-6 / (4e-7 * std::numbers::pi), 1e-12);
}

}  // namespace test_magnetics_cylinder_unit
}  // namespace omni::magnetics
