// Independently computed or measured values: tables, closed forms, the paper's coils.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "service/base/eigen.h"
#include "service/magnetics/coil.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/disc_magnet.h"
#include "service/magnetics/zonal.h"
#include "tests/support/core_image.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::magnetics {
namespace test_magnetics_examples {

using Eigen::Vector3d;

TEST(MagneticsExamples, DipoleFieldOnAxisIsTwiceTheEquatorialAndOpposite) {
  const Vector3d m(0, 0, 2);
  EXPECT_NEAR(DipoleField(m, {0, 0, 0.1}).z(), 1e-7 * 2 * 2 / 1e-3, 1e-18);
  EXPECT_NEAR(DipoleField(m, {0.1, 0, 0}).z(), -1e-7 * 2 / 1e-3, 1e-18);
}

TEST(MagneticsExamples, EllipticIntegralsMatchAbramowitzStegun) {
  // Abramowitz & Stegun, table 17.1
  EXPECT_NEAR(CompleteElliptic(0).K, std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR(CompleteElliptic(0).E, std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR(CompleteElliptic(0.5).K, 1.854074677301372, 1e-14);
  EXPECT_NEAR(CompleteElliptic(0.5).E, 1.350643881047675, 1e-14);
  EXPECT_NEAR(CompleteElliptic(0.99).K, 3.695637362989875, 1e-13);
  EXPECT_NEAR(CompleteElliptic(0.99).E, 1.015993545025224, 1e-13);
}

TEST(MagneticsExamples, LoopFieldOnAxisMatchesTheClosedForm) {
  for (const double z : {-0.03, 0.0, 0.01, 0.2}) {
    const double a = 0.02;
    const double expected = kMu0 * a * a / (2 * std::pow(a * a + z * z, 1.5));
    EXPECT_NEAR(FieldOfLoop(a, 0, z).z_T_A, expected, 1e-13 * expected);
    EXPECT_EQ(FieldOfLoop(a, 0, z).rho_T_A, 0);
  }
}

TEST(MagneticsExamples, LoopFieldIsContinuousAtTheNearAxisSwitch) {
  const double a = 0.02, z = 0.015;
  const double edge = 1e-4 * std::hypot(a, z);
  const double below = FieldOfLoop(a, edge * (1 - 1e-9), z).rho_T_A;
  const double above = FieldOfLoop(a, edge * (1 + 1e-9), z).rho_T_A;
  EXPECT_GT(below, 0);  // field lines open up above the loop
  EXPECT_NEAR(above, below, 1e-7 * below);
}

TEST(MagneticsExamples, ToolDiscMagnetHasKnownMomentAndRing) {
  const DiscMagnet magnet = MakeDiscMagnet(support::NominalDevice().magnet);
  EXPECT_NEAR(magnet.moment_Am2, 5.119, 5e-4);
  EXPECT_NEAR(magnet.zonal[1] / magnet.moment_Am2, -1.565e-4, 1e-10);
  ASSERT_EQ(magnet.point_count, 5);
  EXPECT_NEAR(std::hypot(magnet.points[3].ring_1_m, magnet.points[3].ring_2_m), 10.2e-3, 0.03e-3);
}

TEST(MagneticsExamples, LongMagnetIsTwoAxialPointsAndBalancedHasNoOctupole) {
  base::MagnetGeometry rod{.radius_m = 0.003, .half_height_m = 0.010, .remanence_T = 1.3};
  const DiscMagnet magnet = MakeDiscMagnet(rod);
  ASSERT_EQ(magnet.point_count, 2);
  EXPECT_GT(magnet.points[0].axial_m, 0);
  EXPECT_EQ(magnet.points[0].axial_m, -magnet.points[1].axial_m);
  rod.radius_m = 0.01;
  rod.half_height_m = std::sqrt(0.75) * rod.radius_m;
  EXPECT_LE(std::abs(MakeDiscMagnet(rod).zonal[1]), 1e-18);
}

TEST(MagneticsExamples, WindingsMatchThePublishedFigures) {
  const base::DeviceGeometry device = support::NominalDevice();
  const double wire_m[] = {21.33, 22.66, 23.97};
  const double moment[] = {0.246, 0.273, 0.300};
  const double core_moment[] = {0.137, 0.134, 0.131};
  const double ratio_mm2[] = {-228, -260, -292};
  for (int k = 0; k < 3; ++k) {
    const auto winding = MakeWinding(device.coils[static_cast<std::size_t>(k)], k);
    double length_m = 0;
    for (const Turn& turn : winding) length_m += 2 * std::numbers::pi * turn.radius_m;
    const CoilMoments coil = WindingMoments(winding);
    const CoilMoments core = CoreMoments(winding, device.core_radius_m, 1.0);
    EXPECT_EQ(winding.size(), static_cast<std::size_t>(device.coils[static_cast<std::size_t>(k)].turns));
    EXPECT_NEAR(length_m, wire_m[k], 0.04);
    EXPECT_NEAR(coil[0], moment[k], 0.0005);
    EXPECT_NEAR(core[0], core_moment[k], 0.0005);
    EXPECT_NEAR((coil[1] + core[1]) / (coil[0] + core[0]) * 1e6, ratio_mm2[k], 1.5);
  }
}

TEST(MagneticsExamples, FieldOfFullCurrentStaysWithinTheSensorRange) {
  // 15 A in one coil: 10.3 G at the worst sensor of this geometry.
  const base::DeviceGeometry device = support::NominalDevice();
  double worst_T = 0;
  for (int k = 0; k < 3; ++k) {
    const auto winding = MakeWinding(device.coils[static_cast<std::size_t>(k)], k);
    const CoilMoments core = CoreMoments(winding, device.core_radius_m, device.core_kappa);
    for (const auto& sensor : device.sensors) {
      const Vector3d B = CoilField(winding, core, base::ToEigen(device.coils[static_cast<std::size_t>(k)].axis_base),
                                   base::ToEigen(sensor.position_base_m));
      worst_T = std::max(worst_T, 15 * B.cwiseAbs().maxCoeff());
    }
  }
  EXPECT_NEAR(worst_T, 10.3e-4, 0.3e-4);
  EXPECT_LT(worst_T, device.sensor_range_T);
}

TEST(MagneticsExamples, RadialDipoleHasItsImageOnTheSameRadius) {
  const support::CoreImage image = support::ImageInCore({0, 0, 2}, {0, 0, 0.05}, 0.015, 1.0);
  EXPECT_NEAR(image.position.z(), 0.015 * 0.015 / 0.05, 1e-15);
  EXPECT_NEAR(image.moment.z(), std::pow(0.3, 3) * 2, 1e-15);  // same sense: attraction
  EXPECT_NEAR(image.charge, 0.015 * 2 / (0.05 * 0.05), 1e-12);
}

}  // namespace test_magnetics_examples
}  // namespace omni::magnetics
