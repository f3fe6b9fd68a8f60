// The force map against charges in the field of every single turn; limits and continuity over random requests.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <numbers>

#include "service/actuation/actuation.h"
#include "service/base/eigen.h"
#include "service/magnetics/coil.h"
#include "tests/support/numeric.h"
#include "tests/support/rig/magnet_truth.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::actuation {
namespace test_actuation_forces {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using support::RandomUnit;
using support::Rng;
using support::Uniform;

// Axis within `tilt_rad` of the radius, either sense.
base::ToolState RandomTool(Rng& rng, double r_min_m, double r_max_m, double tilt_rad) {
  base::ToolState tool;
  tool.status = base::TrackingStatus::kTracking;
  Vector3d n = RandomUnit(rng);
  n.z() = std::abs(n.z());
  Vector3d u;
  do {
    u = RandomUnit(rng);
  } while (std::acos(std::min(1.0, std::abs(u.dot(n)))) > tilt_rad);
  const double r = Uniform(rng, r_min_m, r_max_m);
  tool.position_base_m = base::FromEigen(r * n);
  tool.axis_base = base::FromEigen(u);
  tool.gap_m = r - 0.041;
  return tool;
}

std::array<double, 3> ToArray(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

TEST(ActuationForces, ForceMapMatchesMagneticChargesInEachWindingsField) {
  Rng rng(1);
  const base::DeviceGeometry device = support::NominalDevice();
  const ForceMap map = MakeForceMap(device);
  const auto charges = support::DiscCharges(device.magnet, 4, 10);
  std::array<std::vector<magnetics::Turn>, 3> windings;
  std::array<magnetics::CoilMoments, 3> cores;
  for (std::size_t k = 0; k < 3; ++k) {
    windings[k] = magnetics::MakeWinding(device.coils[k], static_cast<int>(k));
    cores[k] = magnetics::CoreMoments(windings[k], device.core_radius_m, device.core_kappa);
  }
  double contact = 0, far = 0;
  constexpr int kPoses = 6;
  for (int i = 0; i < 2 * kPoses; ++i) {
    const bool near = i < kPoses;
    const double r = near ? 0.041 : 0.055;
    const base::ToolState tool = RandomTool(rng, r, r, near ? 0.06 : 0.9);
    const double moment_scale = Uniform(rng, 0.75, 1.25);  // of the pen in use
    Matrix3d exact;
    for (std::size_t k = 0; k < 3; ++k) {
      Vector3d force = Vector3d::Zero();
      for (const auto& charge : charges) {
        const Vector3d at =
            support::ChargePosition(charge, base::ToEigen(tool.position_base_m), base::ToEigen(tool.axis_base));
        force += charge.q * magnetics::CoilField(windings[k], cores[k], base::ToEigen(device.coils[k].axis_base), at);
      }
      exact.col(static_cast<int>(k)) = moment_scale * force;
    }
    const ForceAtPose mapped = EvaluateForceMap(map, tool.position_base_m, tool.axis_base, moment_scale);
    const Matrix3d X = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(mapped.newton_per_ampere.data());
    (near ? contact : far) += support::RelativeError(X, exact) / kPoses;
  }
  EXPECT_LT(contact, 0.025);
  EXPECT_LT(far, 0.005);
}

TEST(ActuationForces, CurrentsProduceTheRequestedForce) {
  Rng rng(2);
  const Config config = MakeConfig(support::NominalDevice());
  int within = 0;
  for (int i = 0; i < 5000; ++i) {
    const base::ToolState tool = RandomTool(rng, 0.045, 0.09, 0.7);
    const base::ForceLimit limit = ComputeForceLimit(config, tool, {25, 25, 25});
    ASSERT_TRUE(limit.valid);
    const Vector3d wanted = Uniform(rng, config.bias_fade_N, 2.0) * RandomUnit(rng);
    const double scale = base::FeasibleScale(limit, base::FromEigen(wanted));
    if (scale * wanted.norm() < config.bias_fade_N) continue;
    State state;
    base::CoilCurrents currents;
    for (int tick = 0; tick < 10; ++tick) Allocate(config, limit, base::FromEigen(wanted), 1e-3, state, currents);
    const Vector3d force = base::ToEigen(ForceFromCurrents(config.map, tool, currents.current_A));
    EXPECT_GT(force.dot(wanted), 0);
    EXPECT_LT(force.cross(wanted).norm(), 1e-6 * force.norm() * wanted.norm());  // direction kept
    EXPECT_NEAR(force.norm(), scale * wanted.norm(), 1e-9);  // what the limit promises, whichever limit it is
    ++within;
  }
  EXPECT_GT(within, 1000);
}

TEST(ActuationForces, UncompensatedForceKeepsTheRequestedDirection) {
  Rng rng(3);
  Config config = MakeConfig(support::NominalDevice());
  config.compensate_snapping = false;
  for (int i = 0; i < 3000; ++i) {
    const base::ToolState tool = RandomTool(rng, 0.045, 0.12, 0.7);
    const base::ForceLimit limit = ComputeForceLimit(config, tool, {25, 25, 25});
    const Vector3d wanted = Uniform(rng, 0, 10) * RandomUnit(rng);
    State state;
    base::CoilCurrents currents;
    for (int tick = 0; tick < 10; ++tick) Allocate(config, limit, base::FromEigen(wanted), 1e-3, state, currents);
    const Vector3d coils = base::ToEigen(ForceFromCurrents(config.map, tool, currents.current_A)) -
                           base::ToEigen(ForceFromCurrents(config.map, tool, {}));
    EXPECT_LE(coils.cross(wanted).norm(), 1e-8 * coils.norm() * wanted.norm() + 1e-15);
    EXPECT_GE(coils.dot(wanted), 0);
    EXPECT_LE(coils.norm(), config.force_max_N * (1 + 1e-9));
  }
}

// Every coil within `by_A` of `last` scaled by one common share in [0, 1], as by falling alone.
bool GrowsBy(const std::array<double, 3>& now, const std::array<double, 3>& last, double by_A) {
  double least = 0, most = 1;
  for (std::size_t k = 0; k < now.size(); ++k) {
    if (last[k] == 0) {
      if (std::abs(now[k]) > by_A) return false;
      continue;
    }
    const double a = (now[k] - by_A) / last[k], b = (now[k] + by_A) / last[k];
    least = std::max(least, std::min(a, b));
    most = std::min(most, std::max(a, b));
  }
  return least <= most + 1e-12;
}

double RandomDouble(Rng& rng) {
  switch (rng() % 12) {
    case 0:
      return std::numeric_limits<double>::quiet_NaN();
    case 1:
      return std::numeric_limits<double>::infinity();
    case 2:
      return -1e308;
    case 3:
      return 1e-310;
    default:
      return Uniform(rng, -5, 5);
  }
}

TEST(ActuationForces, LimitsHoldForAnyRequest) {
  Rng rng(4);
  const Config config = MakeConfig(support::NominalDevice());
  State state;
  base::CoilCurrents currents;
  base::ForceLimit limit;
  for (int i = 0; i < 100'000; ++i) {
    const auto last = state.last_current_A;
    if (i % 10 == 0) {
      base::ToolState tool = RandomTool(rng, 0.02, 0.2, 1.57);
      if (rng() % 20 == 0) tool.position_base_m.x = RandomDouble(rng);
      if (rng() % 20 == 0) tool.axis_base.y = RandomDouble(rng);
      if (rng() % 20 == 0) tool.status = base::TrackingStatus::kLost;
      limit = ComputeForceLimit(config, tool, {Uniform(rng, 20, 75), Uniform(rng, 20, 75), RandomDouble(rng) + 40});
      if (rng() % 20 == 0) limit.bias_A[rng() % 3] = RandomDouble(rng);
      if (rng() % 20 == 0) limit.current_max_A[rng() % 3] = RandomDouble(rng);
      if (rng() % 20 == 0) limit.ampere_per_newton[rng() % 9] = RandomDouble(rng);
    }
    const base::Vec3 force{RandomDouble(rng), RandomDouble(rng), RandomDouble(rng)};
    const double dt_s = rng() % 10 == 0 ? RandomDouble(rng) : 1e-3;
    Allocate(config, limit, force, dt_s, state, currents);
    double power_W = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double current = currents.current_A[k];
      ASSERT_TRUE(std::isfinite(current));
      ASSERT_LE(std::abs(current), config.current_max_A);
      if (limit.valid && limit.current_max_A[k] >= 0) {
        ASSERT_LE(std::abs(current), limit.current_max_A[k]);
      }
      power_W += config.heat.resistance_20C_ohm[k] * current * current;
    }
    ASSERT_LE(power_W, config.power_max_W);
    const double step_s = dt_s >= 0 && dt_s <= 0.1 ? dt_s : 1e-3;
    ASSERT_TRUE(GrowsBy(currents.current_A, last, config.current_slew_A_s * step_s * (1 + 1e-12))) << i;
  }
}

// The produced force never grows by more than allowed, nor beyond the limit, however the pen has jumped meanwhile; it
// starts from the previous tick's currents only.
TEST(ActuationForces, ProducedForceStaysWithinLimitsWhenThePoseJumps) {
  Rng rng(6);
  Config config = MakeConfig(support::NominalDevice());
  State state;
  base::CoilCurrents currents;
  Vector3d last = Vector3d::Zero();
  int driven = 0, compared = 0;
  for (int i = 0; i < 100'000; ++i) {
    const base::ToolState tool = RandomTool(rng, 0.041, 0.1, 1.5);
    base::ForceLimit limit = ComputeForceLimit(config, tool, {25, 25, 25});
    limit.force_rise_N = rng() % 10 == 0 ? 0 : Uniform(rng, 0, 0.85);
    if (rng() % 50 == 0) limit = {};
    const base::Vec3 wanted_N = base::FromEigen(Uniform(rng, 0, 4) * RandomUnit(rng));
    const Vector3d made = base::ToEigen(Allocate(config, limit, wanted_N, 1e-3, state, currents));
    const Vector3d pull = base::ToEigen(ForceFromCurrents(config.map, tool, {}));
    const Vector3d net = base::ToEigen(ForceFromCurrents(config.map, tool, currents.current_A));
    const Vector3d coils = limit.valid ? Vector3d(net - pull) : Vector3d::Zero();
    if (!limit.valid) {
      ASSERT_EQ(currents.current_A, (std::array<double, 3>{}));
    } else {
      ASSERT_LE(coils.norm(), last.norm() + limit.force_rise_N + 1e-9) << i;
      ASSERT_LE(net.norm(), std::max(limit.force_max_N, pull.norm()) + 1e-9) << i;
    }
    if (limit.valid && !limit.near_singular &&
        base::FeasibleScale(limit, wanted_N) * Norm(wanted_N) > limit.bias_fade_N) {
      ASSERT_LT((made - net).norm(), 1e-6 * (1 + pull.norm())) << i;  // the pull is compensated whole
      ++compared;
    }
    driven += coils.norm() > 0.1 ? 1 : 0;
    last = coils;
  }
  EXPECT_GT(driven, 30'000);
  EXPECT_GT(compared, 20'000);
}

TEST(ActuationForces, PowerLimitKeepsTheRatioOfTheCurrents) {
  Rng rng(5);
  Config config = MakeConfig(support::NominalDevice());
  config.compensate_snapping = false;
  Config tight = config;
  tight.power_max_W = 5;
  const base::ToolState tool = RandomTool(rng, 0.05, 0.05, 0.5);
  const base::ForceLimit limit = ComputeForceLimit(config, tool, {25, 25, 25});
  const base::ForceLimit tight_limit = ComputeForceLimit(tight, tool, {25, 25, 25});
  State wide_state, tight_state;
  base::CoilCurrents wide_currents, tight_currents;
  for (int i = 0; i < 10; ++i) {
    Allocate(config, limit, {0.9, -0.5, 0.8}, 1e-3, wide_state, wide_currents);
    Allocate(tight, tight_limit, {0.9, -0.5, 0.8}, 1e-3, tight_state, tight_currents);
  }
  const Vector3d a = Eigen::Map<const Vector3d>(wide_currents.current_A.data());
  const Vector3d b = Eigen::Map<const Vector3d>(tight_currents.current_A.data());
  EXPECT_LT(b.norm(), 0.9 * a.norm());
  EXPECT_LT(a.cross(b).norm(), 1e-9 * a.norm() * b.norm());
}

// Largest change of a current from step to step while request, distance and axis move at even speed over a half turn.
double LargestStep_A(const Config& config, std::uint64_t seed, int steps) {
  Rng rng(seed);
  const Vector3d f0 = 1.5 * RandomUnit(rng), f1 = 1.5 * RandomUnit(rng);
  const Vector3d n = RandomUnit(rng), u0 = RandomUnit(rng), u1 = u0.cross(RandomUnit(rng)).normalized();
  State state;
  base::CoilCurrents currents;
  double largest_A = 0;
  for (int i = 0; i <= steps; ++i) {
    const double s = static_cast<double>(i) / steps;
    base::ToolState tool;
    tool.status = base::TrackingStatus::kTracking;
    tool.position_base_m = base::FromEigen((0.06 + 0.01 * s) * n);
    tool.axis_base = base::FromEigen(std::cos(std::numbers::pi * s) * u0 + std::sin(std::numbers::pi * s) * u1);
    tool.gap_m = 0.02;
    const auto last = state.last_current_A;
    const base::Vec3 force_N = base::FromEigen((1 - s) * f0 + s * f1);
    Allocate(config, ComputeForceLimit(config, tool, {25, 25, 25}), force_N, 1e-3, state, currents);
    for (std::size_t k = 0; i > 0 && k < 3; ++k) {
      largest_A = std::max(largest_A, std::abs(currents.current_A[k] - last[k]));
    }
  }
  return largest_A;
}

// Through every singular pose on the way: half the step gives half the change. A jump would stay as large.
TEST(ActuationForces, CurrentsAreContinuousInRequestAndPose) {
  Config config = MakeConfig(support::NominalDevice());
  config.current_slew_A_s = 1e9;  // nothing hides behind the slew limit
  for (std::uint64_t path = 0; path < 12; ++path) {
    const double coarse_A = LargestStep_A(config, path, 2000);
    EXPECT_LT(coarse_A, 3.0) << "path " << path;
    EXPECT_LT(LargestStep_A(config, path, 4000), 0.6 * coarse_A) << "path " << path;
  }
}

TEST(ActuationForces, CompensationFadesInSmoothlyFromZero) {
  Rng rng(7);
  Config config = MakeConfig(support::NominalDevice());
  config.current_slew_A_s = 1e9;
  for (int i = 0; i < 100; ++i) {
    const base::ToolState tool = RandomTool(rng, 0.042, 0.06, 0.8);
    const base::ForceLimit limit = ComputeForceLimit(config, tool, {25, 25, 25});
    const Vector3d direction = RandomUnit(rng);
    Vector3d last = Vector3d::Zero();
    for (int millinewtons = 0; millinewtons < 600; ++millinewtons) {
      const double f = 1e-3 * millinewtons;
      State state;
      base::CoilCurrents currents;
      Allocate(config, limit, base::FromEigen(f * direction), 1e-3, state, currents);
      const Vector3d now = Eigen::Map<const Vector3d>(currents.current_A.data());
      if (millinewtons == 0) {
        EXPECT_EQ(now.norm(), 0);
      }
      EXPECT_LT((now - last).norm(), 0.3);
      last = now;
    }
  }
}

TEST(ActuationForces, SingularPoseGetsNoCurrentForUnreachableForce) {
  // Pen perpendicular to the radius: the force normal to the plane of pen and radius is out of reach.
  const Config config = MakeConfig(support::NominalDevice());
  base::ToolState tool;
  tool.status = base::TrackingStatus::kTracking;
  tool.position_base_m = {0, 0, 0.06};
  tool.axis_base = {1, 0, 0};
  tool.gap_m = 0.01;
  const base::ForceLimit limit = ComputeForceLimit(config, tool, {25, 25, 25});
  ASSERT_TRUE(limit.valid);
  Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> A(limit.ampere_per_newton.data());
  EXPECT_LT((A * Vector3d(0, 1, 0)).norm(), 0.1);
  const base::Vec3 up = ForceFromCurrents(config.map, tool, ToArray(A * Vector3d(0, 0, 1)));
  const base::Vec3 pull = ForceFromCurrents(config.map, tool, {});
  EXPECT_NEAR(up.z - pull.z, 1, 1e-6);
}

}  // namespace test_actuation_forces
}  // namespace omni::actuation
