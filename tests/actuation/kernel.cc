// The kernel's variants against each other and against the formulas of service/magnetics; points keep the multipoles;
// the map against the twin's charges.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "service/actuation/force_map.h"
#include "service/base/eigen.h"
#include "service/magnetics/disc_magnet.h"
#include "service/magnetics/zonal.h"
#include "service/sim/fields/truth_model.h"
#include "tests/support/core_image.h"
#include "tests/support/numeric.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::actuation {
namespace test_actuation_kernel {

using Eigen::Vector3d;
using support::RandomUnit;
using support::RelativeError;
using support::Rng;
using support::Uniform;

struct Pose {
  Vector3d p, u;
};

// Clear of the windings whatever the axis.
Pose RandomPose(Rng& rng) { return {Uniform(rng, 0.05, 0.15) * RandomUnit(rng), RandomUnit(rng)}; }

// The magnet keeps `gap_m` to the hull; tilt up to 60 degrees.
sim::MagnetPose AtGap(const base::DeviceGeometry& device, double gap_m, Rng& rng) {
  const Vector3d n = RandomUnit(rng);
  Vector3d u;
  do {
    u = RandomUnit(rng);
  } while (std::abs(u.dot(n)) < 0.5);
  sim::MagnetPose pose;
  pose.axis_base = base::FromEigen(u);
  double near_m = 0.03, far_m = 0.2;
  for (int i = 0; i < 60; ++i) {
    const double r = 0.5 * (near_m + far_m);
    pose.centre_base_m = base::FromEigen(r * n);
    (sim::GapToHull(device.magnet, device.hull_radius_m, pose).gap_m < gap_m ? near_m : far_m) = r;
  }
  return pose;
}

ForceAtPose Evaluate(const ForceMap& map, const Pose& at) {
  return EvaluateForceMap(map, base::FromEigen(at.p), base::FromEigen(at.u));
}

TEST(ActuationKernel, AllInstructionSetsAreBitIdentical) {
  Rng rng(11);
  ForceMap baseline = MakeForceMap(support::NominalDevice());
  baseline.kernel = ForceKernelOf(ForceKernelLevel::kBaseline);
  ASSERT_NE(baseline.kernel, nullptr);
  for (int level = 1; level < kForceKernelLevels; ++level) {
    ForceMap wide = baseline;
    wide.kernel = ForceKernelOf(static_cast<ForceKernelLevel>(level));
    if (wide.kernel == nullptr) continue;  // not on this processor
    for (int i = 0; i < 2000; ++i) {
      const Pose at = RandomPose(rng);
      const ForceAtPose a = Evaluate(baseline, at), b = Evaluate(wide, at);
      ASSERT_TRUE(a.valid && b.valid);
      ASSERT_EQ(a.newton_per_ampere, b.newton_per_ampere);
      ASSERT_EQ(a.newton_metre_per_ampere, b.newton_metre_per_ampere);
      ASSERT_EQ(a.snapping_N, b.snapping_N);
      ASSERT_EQ(a.snapping_Nm, b.snapping_Nm);
    }
  }
}

// Sums of docs/theory/actuation.md (2.1), (2.4), (2.5) written out with the matrices of service/magnetics.
TEST(ActuationKernel, MatchesTheMagneticsFormulas) {
  Rng rng(12);
  const base::DeviceGeometry device = support::NominalDevice();
  const ForceMap map = MakeForceMap(device);
  const ForceTables& t = map.tables;
  for (int i = 0; i < 300; ++i) {
    const Pose at = RandomPose(rng);
    const magnetics::TangentBasis e = magnetics::MakeTangentBasis(at.u);
    std::vector<Vector3d> points;
    points.reserve(kForcePoints);
    for (int s = 0; s < kForcePoints; ++s) {
      points.push_back(at.p + t.ring_1_m[s] * e.e1 + t.ring_2_m[s] * e.e2 + t.axial_m[s] * at.u);
    }
    Eigen::Matrix3d X = Eigen::Matrix3d::Zero(), Y = X;
    for (int k = 0; k < 3; ++k) {
      const Vector3d axis = Eigen::Map<const Vector3d>(t.axis_base[k]);
      for (int s = 0; s < kForcePoints; ++s) {
        const Vector3d& p = points[static_cast<std::size_t>(s)];
        const Vector3d m = t.moment_Am2[s] * at.u;
        const Vector3d force = magnetics::ZonalGradient(t.zonal[k], axis, p) * m;
        X.col(k) += force;
        Y.col(k) += m.cross(magnetics::ZonalField(t.zonal[k], axis, p)) + (p - at.p).cross(force);
      }
    }
    Vector3d pull = Vector3d::Zero(), twist = pull;
    for (int source = 0; source < kForcePoints; ++source) {
      const Vector3d m = t.moment_Am2[source] * at.u;
      const auto image =
          support::ImageInCore(m, points[static_cast<std::size_t>(source)], t.core_radius_m, t.core_kappa);
      for (int s = 0; s < kForcePoints; ++s) {
        const Vector3d& p = points[static_cast<std::size_t>(s)];
        const Vector3d felt = t.moment_Am2[s] * at.u;
        const Vector3d force = support::CoreImageGradient(image, p) * felt;
        pull += force;
        twist += felt.cross(support::CoreImageField(image, p)) + (p - at.p).cross(force);
      }
    }
    const ForceAtPose mapped = Evaluate(map, at);
    using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    ASSERT_LT(RelativeError(Eigen::Map<const RowMajor3d>(mapped.newton_per_ampere.data()), X), 1e-11);
    ASSERT_LT(RelativeError(Eigen::Map<const RowMajor3d>(mapped.newton_metre_per_ampere.data()), Y), 1e-11);
    ASSERT_LT(RelativeError(base::ToEigen(mapped.snapping_N), pull), 1e-11);
    // The pull's torque nearly cancels for a pen along the radius: compare on the scale of force times distance.
    ASSERT_LT((base::ToEigen(mapped.snapping_Nm) - twist).norm(), 1e-11 * pull.norm() * at.p.norm());
  }
}

// q1, q3, q5 of a set of axial dipoles at (rho, z): q_l = sum share l r^(l-1) P_(l-1)(z / r).
TEST(ActuationKernel, PointsPreserveTheMultipolesOfAnyCylinder) {
  Rng rng(13);
  for (int i = 0; i < 500; ++i) {
    base::MagnetGeometry magnet;
    magnet.radius_m = Uniform(rng, 2e-3, 2e-2);
    magnet.half_height_m = magnet.radius_m * std::exp(Uniform(rng, -2.5, 1.5));
    magnet.remanence_T = 1.3;
    const auto exact = magnetics::MakeDiscMagnet(magnet, 1.0).zonal;
    double q1 = 0, q3 = 0, q5 = 0, reach = 0;
    for (const WeightedPoint& point : MakeMagnetPoints(magnet, MagnetDetail::kFull)) {
      const double rho2 = point.ring_1_m * point.ring_1_m + point.ring_2_m * point.ring_2_m;
      const double z2 = point.axial_m * point.axial_m;
      q1 += point.share;
      q3 += point.share * 3 * (z2 - 0.5 * rho2);
      q5 += point.share * 5 * (z2 * z2 - 3 * z2 * rho2 + 0.375 * rho2 * rho2);
      reach = std::max(reach, std::sqrt(rho2 + z2));
    }
    const double size2 = magnet.radius_m * magnet.radius_m + magnet.half_height_m * magnet.half_height_m;
    EXPECT_NEAR(q1, 1, 1e-12);
    EXPECT_NEAR(q3, exact[1], 1e-10 * size2);
    EXPECT_NEAR(q5, exact[2], 1e-10 * size2 * size2);
    EXPECT_LE(reach * reach, 1.5 * size2);
  }
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// A tenth of what the product promises (2.5 % and 3 % at contact, 1 % from 10 mm, 1.5 % from 5 mm).
TEST(ActuationKernel, ForcesAndTorquesMatchTheTwin) {
  Rng rng(14);
  const base::DeviceGeometry device = support::NominalDevice();
  const ForceMap map = MakeForceMap(device);
  sim::TruthModel truth(device, sim::Imperfections{}, false);
  for (const double gap_m : {0.0, 0.005, 0.010, 0.030}) {
    std::vector<double> coils, torques, pulls;
    for (int i = 0; i < 40; ++i) {
      const sim::MagnetPose pose = AtGap(device, gap_m, rng);
      const sim::ForceMap exact = truth.ForcesAt(pose);
      const ForceAtPose mapped = EvaluateForceMap(map, pose.centre_base_m, pose.axis_base);
      ASSERT_TRUE(mapped.valid);
      Eigen::Matrix3d X, Y;
      for (int k = 0; k < 3; ++k) {
        const sim::ForceAndTorque& coil = exact.coil[static_cast<std::size_t>(k)];
        X.col(k) = base::ToEigen(coil.force_N);
        Y.col(k) = base::ToEigen(coil.torque_Nm);
      }
      using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
      coils.push_back(RelativeError(Eigen::Map<const RowMajor3d>(mapped.newton_per_ampere.data()), X));
      torques.push_back(RelativeError(Eigen::Map<const RowMajor3d>(mapped.newton_metre_per_ampere.data()), Y));
      pulls.push_back(RelativeError(base::ToEigen(mapped.snapping_N), base::ToEigen(exact.core.force_N)));
    }
    EXPECT_LT(Median(coils), gap_m < 0.009 ? 0.0025 : 0.001) << gap_m;
    EXPECT_LT(Median(torques), 0.004) << gap_m;
    EXPECT_LT(Median(pulls), gap_m < 0.004 ? 0.003 : 0.0015) << gap_m;
  }
}

TEST(ActuationKernel, CalibratedMomentAndCoreAreUsed) {
  const base::DeviceGeometry device = support::NominalDevice();
  base::Calibration calibration;
  calibration.magnet = device.magnet;
  calibration.moment_Am2 = 1.02 * magnetics::MakeDiscMagnet(device.magnet).moment_Am2;
  calibration.core_radius_m = device.core_radius_m;
  calibration.core_kappa = device.core_kappa;
  const Pose at{{0.01, 0.02, 0.05}, Vector3d(0.1, 0.2, -1).normalized()};
  const ForceAtPose drawn = Evaluate(MakeForceMap(device), at);
  const ForceAtPose measured = Evaluate(MakeForceMap(device, calibration), at);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(measured.newton_per_ampere[i], 1.02 * drawn.newton_per_ampere[i],
                1e-12 * std::abs(drawn.newton_per_ampere[i]));
  }
  EXPECT_NEAR(measured.snapping_N.z, 1.02 * 1.02 * drawn.snapping_N.z, 1e-12 * std::abs(drawn.snapping_N.z));
  calibration.core_kappa = 0.9;
  EXPECT_GT(measured.snapping_N.z / Evaluate(MakeForceMap(device, calibration), at).snapping_N.z, 1.05);
}

}  // namespace test_actuation_kernel
}  // namespace omni::actuation
