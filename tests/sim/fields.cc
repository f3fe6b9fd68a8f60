// The twin's fields and forces against closed forms and against independent figures of the same geometry.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "service/sim/fields/truth_model.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::sim {
namespace test_sim_fields {

constexpr double kMu0 = 4e-7 * std::numbers::pi;

base::DeviceGeometry IdealCore() {
  base::DeviceGeometry device = support::NominalDevice();
  device.core_kappa = 1;
  return device;
}

Charges Magnet(const base::DeviceGeometry& device, const MagnetPose& pose, int rings, int spokes) {
  const MagnetFaces faces(device.magnet, rings, spokes);
  Charges charges;
  charges.Resize(faces.charge_count());
  faces.PlaceCharges(pose, charges);
  return charges;
}

Charges Images(const base::DeviceGeometry& device, const Charges& magnet) {
  const CoreImages core(device.core_radius_m, device.core_kappa);
  Charges images;
  images.Resize(core.image_count(magnet.size()));
  core.PlaceImages(magnet, images);
  return images;
}

double RelativeError(const Vec3& value, const Vec3& reference) { return Norm(value - reference) / Norm(reference); }

// B_z = Br/2 [(z+h)/sqrt((z+h)^2+R^2) - (z-h)/sqrt((z-h)^2+R^2)] on the axis of a cylinder.
TEST(SimMagnet, MatchesTheClosedFormOnItsAxis) {
  const base::DeviceGeometry device = support::NominalDevice();
  const base::MagnetGeometry& m = device.magnet;
  const Charges charges = Magnet(device, {{0, 0, 0}, {0, 0, 1}}, 6, 16);
  EXPECT_GE(charges.size(), 192U);
  for (const double z : {0.02, 0.04, 0.06, 0.1, 0.15}) {
    const auto face = [&](double d) { return d / std::sqrt(d * d + m.radius_m * m.radius_m); };
    const double exact = 0.5 * m.remanence_T * (face(z + m.half_height_m) - face(z - m.half_height_m));
    EXPECT_LT(RelativeError(FieldOf(charges, {0, 0, z}), {0, 0, exact}), 1e-6) << z;
  }
}

TEST(SimMagnet, FarFieldMatchesItsDipoleMoment) {
  const base::DeviceGeometry device = support::NominalDevice();
  const double volume =
      std::numbers::pi * device.magnet.radius_m * device.magnet.radius_m * 2 * device.magnet.half_height_m;
  const double moment = device.magnet.remanence_T / kMu0 * volume;
  EXPECT_NEAR(moment, 5.119, 0.002);
  const Vec3 axis = base::Normalized({1, 2, -2});
  const Charges charges = Magnet(device, {{0, 0, 0}, axis}, 6, 16);
  const Vec3 p{1.5, -2, 1};
  const double r = Norm(p);
  const Vec3 n = (1 / r) * p;
  const Vec3 dipole = (1e-7 * moment / (r * r * r)) * (3 * Dot(axis, n) * n - axis);
  EXPECT_LT(RelativeError(FieldOf(charges, p), dipole), 2e-4);
}

// An infinitely permeable core has no tangential field on its surface, and no net charge.
TEST(SimCore, ToolFieldIsNormalToTheSurface) {
  const base::DeviceGeometry device = IdealCore();
  const Charges magnet = Magnet(device, {{0.02, -0.01, 0.045}, base::Normalized({0.3, 0.2, -1})}, 6, 16);
  const Charges images = Images(device, magnet);
  double net = 0;
  for (const double q : images.q) net += q;
  EXPECT_LT(std::abs(net), 1e-9 * std::abs(magnet.q[0]));
  for (int i = 0; i < 50; ++i) {
    const Vec3 n = base::Normalized({std::sin(1.0 * i), std::cos(2.0 * i), std::sin(3.0 * i + 1)});
    const Vec3 p = device.core_radius_m * n;
    const Vec3 b = FieldOf(magnet, p) + FieldOf(images, p);
    EXPECT_LT(Norm(b - Dot(b, n) * n), 1e-9 * Norm(b));
  }
}

TEST(SimCore, CoilFieldIsNormalToTheSurface) {
  const double core_m = 0.015;
  const std::vector<Turn> turns{{0.028, 0.009}, {0.028, -0.009}};
  const ZonalSeries core(ZonalSeries::Expand(turns, core_m, 1.0).core, {0, 0, 1});
  for (const double theta : {0.3, 0.8, 1.2, 1.5, 2.4}) {
    const Vec3 n{std::sin(theta), 0, std::cos(theta)};
    const Vec3 p = core_m * n;
    Vec3 b = core.Field(p);
    for (const Turn& turn : turns) {
      const CylinderField field = TurnField(turn.radius_m, p.x, p.z - turn.height_m);
      b += Vec3{field.rho_T, 0, field.z_T};
    }
    EXPECT_LT(Norm(b - Dot(b, n) * n), 1e-6 * Norm(b)) << theta;
  }
}

TEST(SimCoil, EllipticIntegralsMatchAbramowitzStegun) {
  // Abramowitz, Stegun, table 17.1.
  EXPECT_NEAR(EllipticIntegrals(0.5).k, 1.854074677301372, 1e-14);
  EXPECT_NEAR(EllipticIntegrals(0.5).e, 1.350643881047675, 1e-14);
  EXPECT_NEAR(EllipticIntegrals(0).k, std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR(EllipticIntegrals(0).e, std::numbers::pi / 2, 1e-15);
}

TEST(SimCoil, TurnFieldMatchesOnAxisAndIsContinuousBesideIt) {
  const double a = 0.03;
  for (const double z : {-0.05, 0.0, 0.02}) {
    EXPECT_NEAR(TurnField(a, 0, z).z_T, 0.5 * kMu0 * a * a / std::pow(a * a + z * z, 1.5), 1e-18);
  }
  // The linear term near the axis joins the elliptic form.
  const double below = TurnField(a, 0.99e-4 * a, 0.02).rho_T / 0.99e-4;
  const double above = TurnField(a, 1.01e-4 * a, 0.02).rho_T / 1.01e-4;
  EXPECT_NEAR(below / above, 1, 1e-6);
}

// Figures of an independent model of the same windings: wire length, B(0), moments.
TEST(SimCoil, WindingsHaveTheDocumentedFigures) {
  const base::DeviceGeometry device = IdealCore();
  const std::array<double, 3> wire_m{21.33, 22.66, 23.97}, centre_mT{4.06, 3.97, 3.88};
  const std::array<double, 3> core{0.137, 0.134, 0.131}, total{0.383, 0.406, 0.431};
  for (int k = 0; k < 3; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const base::CoilGeometry& coil = device.coils[at];
    const std::vector<Turn> turns = WindTurns(coil, k);
    EXPECT_EQ(static_cast<int>(turns.size()), coil.turns);
    double length = 0;
    double b = 0;
    for (const Turn& turn : turns) {
      length += 2 * std::numbers::pi * turn.radius_m;
      b += TurnField(turn.radius_m, 0, -turn.height_m).z_T;
    }
    EXPECT_NEAR(length / wire_m[at], 1, 0.004) << k;
    EXPECT_NEAR(1e3 * b / centre_mT[at], 1, 0.005) << k;
    const CoilTruth truth(coil, k, coil.axis_base, 1, device.core_radius_m, device.core_kappa);
    EXPECT_NEAR(truth.core_moment_Am2() / core[at], 1, 0.006) << k;
    EXPECT_NEAR(truth.moment_Am2() / total[at], 1, 0.005) << k;
    EXPECT_NEAR(truth.core_moment_Am2(), std::pow(device.core_radius_m, 3) * 1e7 * b, 1e-6) << "m = a^3 B(0) 1e7";
  }
}

TEST(SimCoil, SeriesFieldMatchesTurnsOutsideTheHull) {
  const base::DeviceGeometry device = support::NominalDevice();
  for (int k = 0; k < 3; ++k) {
    const base::CoilGeometry& coil = device.coils[static_cast<std::size_t>(k)];
    const CoilTruth truth(coil, k, coil.axis_base, 1, device.core_radius_m, device.core_kappa);
    for (const double r : {0.0375, 0.041, 0.06, 0.11}) {
      for (int i = 0; i < 30; ++i) {
        const Vec3 p = r * base::Normalized({std::sin(1.1 * i), std::cos(2.3 * i), std::sin(0.7 * i + 1)});
        const double limit = r < 0.04 ? 1e-3 : r < 0.05 ? 1e-4 : 1e-7;
        EXPECT_LT(RelativeError(truth.FieldBySeries(p), truth.FieldByTurns(p)), limit) << k << " at " << r;
      }
    }
  }
}

// With the magnet's moment radial, on each coil's own axis and beside it.
TEST(SimForce, ForcePerAmpereMatchesDocumentedFigures) {
  TruthModel truth(IdealCore(), Imperfections{}, false);
  const std::array<double, 3> radial{0.230, 0.235, 0.240};
  const std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  for (std::size_t k = 0; k < 3; ++k) {
    const ForceMap map = truth.ForcesAt({0.041 * axes[k], axes[k]});
    EXPECT_NEAR(-Dot(map.coil[k].force_N, axes[k]) / radial[k], 1, 0.02) << k;  // parallel moments attract
    const Vec3 across = axes[(k + 1) % 3];  // beside the coil's axis: half as strong, the other way
    const double sideways = Dot(map.coil[(k + 1) % 3].force_N, across);
    EXPECT_TRUE(sideways > 0.19 && sideways < 0.25) << k << ": " << sideways;
  }
  EXPECT_NEAR(truth.ForcesAt({{0, 0, 0.041}, {0, 0, 1}}).coil[0].force_N.x, 0.199, 0.002);
  EXPECT_NEAR(truth.ForcesAt({{0, 0, 0.071}, {0, 0, 1}}).coil[2].force_N.z, -0.0398, 0.0008);
}

TEST(SimForce, SnappingForceOfAnIdealCoreMatchesKnownFigures) {
  TruthModel truth(IdealCore(), Imperfections{}, false);
  EXPECT_NEAR(truth.ForcesAt({{0, 0, 0.041}, {0, 0, 1}}).core.force_N.z / -0.469, 1, 0.01);
  EXPECT_NEAR(truth.ForcesAt({{0, 0, 0.046}, {0, 0, -1}}).core.force_N.z / -0.218, 1, 0.01);
  EXPECT_NEAR(truth.ForcesAt({{0, 0.051, 0}, {0, 1, 0}}).core.force_N.y / -0.109, 1, 0.01);
}

// The reduced node sets and the truncated series against turns and dense charges.
TEST(SimForce, SamplingErrorIsBelowOneInTenThousand) {
  const base::DeviceGeometry device = IdealCore();
  TruthModel truth(device, Imperfections{}, false);
  for (const MagnetPose& pose :
       {MagnetPose{{0, 0, 0.041}, {0, 0, 1}}, MagnetPose{{0.029, 0, 0.029}, base::Normalized({0.7, 0.02, 0.7})},
        MagnetPose{{0, 0.03, 0.05}, base::Normalized({0.3, 0.5, 0.7})}}) {
    const Charges dense = Magnet(device, pose, 12, 36);
    const Charges images = Images(device, dense);
    const ForceMap map = truth.ForcesAt(pose);
    Vec3 core;
    std::array<Vec3, 3> coil;
    for (std::size_t i = 0; i < dense.size(); ++i) {
      core += dense.q[i] * FieldOf(images, dense.position(i));
      for (std::size_t k = 0; k < 3; ++k) coil[k] += dense.q[i] * truth.coils()[k].FieldByTurns(dense.position(i));
    }
    EXPECT_LT(RelativeError(map.core.force_N, core), 1e-5);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_LT(RelativeError(map.coil[k].force_N, coil[k]), 1e-4) << k;
  }
}

TEST(SimForce, FlippedCoilPushesTheOtherWay) {
  const base::DeviceGeometry device = support::NominalDevice();
  TruthModel right(device, Imperfections{}, false);
  TruthModel flipped(device, Imperfections{}, true);
  const MagnetPose pose{{0.01, 0, 0.05}, {0, 0, -1}};
  EXPECT_EQ(right.ForcesAt(pose).coil[2].force_N, -flipped.ForcesAt(pose).coil[2].force_N);
  EXPECT_EQ(right.ForcesAt(pose).coil[0].force_N, flipped.ForcesAt(pose).coil[0].force_N);
  EXPECT_EQ(right.SensorField(3, nullptr, {0, 0, 1}), -flipped.SensorField(3, nullptr, {0, 0, 1}));
}

// Geometry E: one coil at 15 A stays below the 16 gauss of the sensors, at about 10 gauss.
TEST(SimSensor, OneCoilAtFullCurrentDoesNotSaturate) {
  TruthModel truth(support::NominalDevice(), Imperfections{}, false);
  double worst_T = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    CoilArray current_A{};
    current_A[k] = 15;
    for (std::size_t i = 0; i < base::kSensorCount; ++i) {
      const Vec3 b = truth.SensorField(i, nullptr, current_A);
      worst_T = std::max({worst_T, std::abs(b.x), std::abs(b.y), std::abs(b.z)});
    }
  }
  EXPECT_NEAR(worst_T, 10.3e-4, 0.5e-4);
  EXPECT_LT(worst_T, support::NominalDevice().sensor_range_T);
}

TEST(SimSensor, ReadsInItsOwnFrame) {
  base::DeviceGeometry device = support::NominalDevice();
  TruthModel aligned(device, Imperfections{}, false);
  const double half = std::sqrt(0.5);
  device.sensors[2].orientation_base_sensor = {half, 0, 0, half};  // S turned by +90 deg about z: x_S = y_B
  TruthModel turned(device, Imperfections{}, false);
  const MagnetPose pose{{0.01, 0.02, 0.05}, {0, 0.6, -0.8}};
  const Vec3 b = aligned.SensorField(2, &pose, {1, 2, 3});
  const Vec3 s = turned.SensorField(2, &pose, {1, 2, 3});
  EXPECT_LT(Norm(s - Vec3{b.y, -b.x, b.z}), 1e-12 * Norm(b) + 1e-18);
}

TEST(SimHull, DiscGapMatchesKnownPoses) {
  const base::DeviceGeometry device = support::NominalDevice();
  const auto gap = [&](const MagnetPose& pose) { return GapToHull(device.magnet, device.hull_radius_m, pose).gap_m; };
  EXPECT_NEAR(gap({{0, 0, 0.041}, {0, 0, -1}}), 0, 1e-15);
  EXPECT_NEAR(gap({{0, 0.05, 0}, {0, 1, 0}}), 0.009, 1e-15);
  EXPECT_NEAR(gap({{0, 0, 0.0525}, {1, 0, 0}}), 0, 1e-15);                 // on edge: its rim touches
  EXPECT_NEAR(gap({{0, 0, 0}, {0, 0, 1}}), -device.hull_radius_m, 1e-15);  // origin inside the magnet
}

}  // namespace test_sim_fields
}  // namespace omni::sim
