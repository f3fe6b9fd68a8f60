// The exact cylinder obeys Maxwell, meets charged faces, and is what the multipoles approach.
#include <gtest/gtest.h>

#include <cmath>

#include "service/magnetics/dipole.h"
#include "service/magnetics/disc_magnet.h"
#include "service/magnetics/zonal.h"
#include "tests/support/chips/hall_sensor.h"
#include "tests/support/numeric.h"
#include "tests/support/rig/magnet_truth.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::magnetics {
namespace test_magnetics_cylinder_property {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using support::NumericJacobian;
using support::RandomUnit;
using support::RelativeError;
using support::Rng;
using support::Uniform;

// Flat, balanced, long; off the nominal tool on purpose.
base::MagnetGeometry RandomMagnet(Rng& rng) {
  return {.radius_m = Uniform(rng, 0.002, 0.02),
          .half_height_m = Uniform(rng, 0.002, 0.02),
          .remanence_T = Uniform(rng, 1.0, 1.4)};
}

double Reach(const base::MagnetGeometry& magnet) { return std::hypot(magnet.radius_m, magnet.half_height_m); }

TEST(MagneticsCylinderLaws, FieldIsFreeOfSourcesAndCurrents) {
  Rng rng(101);
  for (int i = 0; i < 1000; ++i) {
    const base::MagnetGeometry magnet = RandomMagnet(rng);
    const Vector3d u = RandomUnit(rng);
    // From 10 % beyond the smallest sphere; every tenth on the axis, where the formulas change.
    const double r = Uniform(rng, 1.1, 8) * Reach(magnet);
    const Vector3d d = r * (i % 10 == 0   ? u
                            : i % 10 == 1 ? (u + 1e-5 * RandomUnit(rng)).normalized()
                                          : RandomUnit(rng));
    const auto field = [&](const Vector3d& x) { return CylinderField(magnet, u, x); };
    const Matrix3d G = NumericJacobian(field, d, 1e-3 * (r - 0.9 * Reach(magnet)));
    EXPECT_LT(std::abs(G.trace()), 1e-6 * G.norm());
    EXPECT_LT((G - G.transpose()).norm(), 1e-6 * G.norm());
  }
}

TEST(MagneticsCylinderLaws, FieldMatchesChargedFaces) {
  Rng rng(102);
  for (int i = 0; i < 20; ++i) {
    const base::MagnetGeometry magnet = RandomMagnet(rng);
    const auto charges = support::DiscCharges(magnet, 60, 96);
    const Vector3d u = RandomUnit(rng), d = Uniform(rng, 2, 5) * Reach(magnet) * RandomUnit(rng);
    Vector3d sum = Vector3d::Zero();
    for (const auto& charge : charges) {
      sum += ChargeField(charge.q, d - support::ChargePosition(charge, Vector3d::Zero(), u));
    }
    EXPECT_LT(RelativeError(CylinderField(magnet, u, d), sum), 1e-4);  // equal areas: second order in the ring's width
  }
}

TEST(MagneticsCylinderLaws, MultipoleErrorShrinksWithEachOrder) {
  // Each further order gains two powers of extent / distance.
  Rng rng(103);
  for (int i = 0; i < 300; ++i) {
    const base::MagnetGeometry magnet = RandomMagnet(rng);
    const DiscMagnet disc = MakeDiscMagnet(magnet);
    const Vector3d u = RandomUnit(rng), n = RandomUnit(rng);
    for (std::size_t orders = 1; orders <= 3; ++orders) {
      const std::span<const double> q(disc.zonal.data(), orders);
      const auto error = [&](double r) {
        return RelativeError(ZonalField(q, u, r * n), CylinderField(magnet, u, r * n));
      };
      const double left_out = static_cast<double>(orders);
      EXPECT_LT(error(10 * Reach(magnet)), 6 * (left_out + 1) * std::pow(0.1, 2 * left_out));
    }
  }
}

TEST(MagneticsCylinderLaws, DipoleAndCylinderForcesAreOpposite) {
  // A dipole in the cylinder's field feels the opposite of what the cylinder's charges feel in the dipole's.
  Rng rng(105);
  for (int i = 0; i < 20; ++i) {
    const base::MagnetGeometry magnet = RandomMagnet(rng);
    const auto charges = support::DiscCharges(magnet, 60, 96);
    const Vector3d u = RandomUnit(rng), m = RandomUnit(rng), d = Uniform(rng, 2, 5) * Reach(magnet) * RandomUnit(rng);
    Vector3d on_cylinder = Vector3d::Zero();
    for (const auto& charge : charges) {
      on_cylinder += charge.q * DipoleField(m, support::ChargePosition(charge, Vector3d::Zero(), u) - d);
    }
    const auto field = [&](const Vector3d& x) { return CylinderField(magnet, u, x); };
    const Matrix3d G = NumericJacobian(field, d, 1e-3 * d.norm());
    EXPECT_LT(RelativeError(G * m, -on_cylinder), 3e-4);
  }
}

TEST(MagneticsHallLaws, JacobianMatchesFiniteDifferences) {
  Rng rng(106);
  for (int i = 0; i < 200; ++i) {
    HallSensor sensor;
    sensor.lsb_T = 0;
    for (double& entry : sensor.gain_sensor_base) entry += Uniform(rng, -0.2, 0.2);
    const Vector3d B = 1e-4 * RandomUnit(rng);
    const auto reading = [&](const Vector3d& x) { return ReadHall(sensor, x, Vector3d::Zero(), 0).field_sensor_T; };
    EXPECT_LT(RelativeError(HallJacobian(sensor, 0), NumericJacobian(reading, B, 1e-6)), 1e-9);
  }
}

TEST(MagneticsHallLaws, RoundingAddsTheVarianceOfAUniformStep) {
  Rng rng(107);
  std::normal_distribution<double> normal;
  HallSensor sensor;
  const double noise_T = 0.8 * sensor.lsb_T;
  double square = 0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double truth = Uniform(rng, -1e-4, 1e-4);
    const double read = ReadHall(sensor, {truth + noise_T * normal(rng), 0, 0}, Vector3d::Zero(), 0).field_sensor_T.x();
    square += (read - truth) * (read - truth) / n;
  }
  EXPECT_NEAR(std::sqrt(square) / QuantisedNoise_T(noise_T, sensor.lsb_T), 1, 0.01);
}

}  // namespace test_magnetics_cylinder_property
}  // namespace omni::magnetics
