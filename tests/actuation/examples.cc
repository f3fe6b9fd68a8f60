// Forces of the exact geometry from an independent study, and examples of limits and allocation.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "service/actuation/actuation.h"
#include "service/base/eigen.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::actuation {
namespace test_actuation_examples {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<double, 3> kCold_C{25, 25, 25};

base::ToolState ToolAt(const base::Vec3& position_base_m, const base::Vec3& axis_base) {
  base::ToolState tool;
  tool.status = base::TrackingStatus::kTracking;
  tool.position_base_m = position_base_m;
  tool.axis_base = axis_base;
  tool.gap_m = base::ToEigen(position_base_m).norm() - 0.041;
  return tool;
}

const Config& Nominal() {
  static const Config config = MakeConfig(support::NominalDevice());
  return config;
}

struct RadialCase {
  double distance_m;
  std::array<double, 3> radial_N_A;  // coil x, y, z with the magnet on that coil's axis, moment outwards
  double snapping_N;
};

TEST(ActuationExamples, RadialAndSnappingForcesMatchExactGeometry) {
  const RadialCase cases[] = {{0.041, {0.230, 0.235, 0.240}, -0.469},
                              {0.046, {0.161, 0.165, 0.169}, -0.218},
                              {0.051, {0.115, 0.119, 0.122}, -0.109}};
  for (const RadialCase& c : cases) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d axis = Eigen::Vector3d::Unit(static_cast<int>(k));
      const ForceAtPose force =
          EvaluateForceMap(Nominal().map, base::FromEigen(c.distance_m * axis), base::FromEigen(axis));
      ASSERT_TRUE(force.valid);
      // Parallel moments attract: towards the core.
      EXPECT_NEAR(-force.newton_per_ampere[4 * k], c.radial_N_A[k], 0.01 * c.radial_N_A[k]);
      EXPECT_NEAR(base::ToEigen(force.snapping_N).dot(axis), c.snapping_N, 0.03 * std::abs(c.snapping_N));
    }
  }
}

TEST(ActuationExamples, CoilXPushesAlongXWithTheMagnetOnTop) {
  // Magnet on top, moment up: coil x pushes along x.
  const ForceAtPose force = EvaluateForceMap(Nominal().map, {0, 0, 0.041}, {0, 0, 1});
  EXPECT_NEAR(force.newton_per_ampere[0], 0.199, 0.006);
  EXPECT_NEAR(force.newton_per_ampere[1], 0, 1e-3);
}

TEST(ActuationExamples, ForceMapIsInvalidInsideWindingsAndForNonFinitePoses) {
  for (const base::Vec3& p : {base::Vec3{0, 0, 0.02}, base::Vec3{0, 0, 0}, base::Vec3{kNaN, 0, 0.05},
                              base::Vec3{0, 0, std::numeric_limits<double>::infinity()}}) {
    EXPECT_FALSE(EvaluateForceMap(Nominal().map, p, {0, 0, 1}).valid);
    const base::Vec3 force = ForceFromCurrents(Nominal().map, ToolAt(p, {0, 0, 1}), {1, 1, 1});
    EXPECT_EQ(force, base::Vec3{});
  }
  EXPECT_FALSE(EvaluateForceMap(Nominal().map, {0, 0, 0.05}, {0, 0, kNaN}).valid);
}

TEST(ActuationExamples, LimitIsInvalidUnlessTrackingAndInReach) {
  base::ToolState tool = ToolAt({0, 0, 0.05}, {0, 0, -1});
  EXPECT_TRUE(ComputeForceLimit(Nominal(), tool, kCold_C).valid);
  tool.status = base::TrackingStatus::kLost;
  EXPECT_FALSE(ComputeForceLimit(Nominal(), tool, kCold_C).valid);
  EXPECT_FALSE(ComputeForceLimit(Nominal(), ToolAt({0, 0, 0.2}, {0, 0, -1}), kCold_C).valid);
  tool = ToolAt({0, 0, 0.05}, {0, 0, -1});
  tool.gap_m = kNaN;
  EXPECT_FALSE(ComputeForceLimit(Nominal(), tool, kCold_C).valid);
  // Just inside the reach the available force is already small: no jump at the border.
  EXPECT_LT(ComputeForceLimit(Nominal(), ToolAt({0, 0, 0.1605}, {0, 0, -1}), kCold_C).force_max_N, 0.06);
}

// Coils and body soaked at these temperatures; how derating behaves in time: tests/actuation/heat.cc.
TEST(ActuationExamples, HotCoilsAreDerated) {
  const base::ToolState tool = ToolAt({0, 0, 0.05}, {0, 0, -1});
  const base::ForceLimit limit = ComputeForceLimit(Nominal(), tool, {45, 62, 70});
  EXPECT_DOUBLE_EQ(limit.current_max_A[0], 15);
  EXPECT_GT(limit.current_max_A[1], 5);
  EXPECT_LT(limit.current_max_A[1], 10);
  EXPECT_DOUBLE_EQ(limit.current_max_A[2], 0);
  EXPECT_EQ(ComputeForceLimit(Nominal(), tool, {kNaN, 1e9, -40}).current_max_A[0], 0);
}

TEST(ActuationExamples, LargestForceDependsOnDirectionAndTemperature) {
  const base::ToolState tool = ToolAt({0, 0, 0.05}, {0, 0, -1});
  const base::Vec3 up{0, 0, 1}, side{1, 0, 0};
  const double cold_N = ForceMax_N(Nominal(), tool, up, kCold_C);
  EXPECT_GT(cold_N, 1.2);
  EXPECT_LE(cold_N, 2);
  EXPECT_DOUBLE_EQ(ForceMax_N(Nominal(), tool, {0, 0, 7}, kCold_C), cold_N) << "only the direction counts";
  EXPECT_LT(ForceMax_N(Nominal(), tool, up, {62, 62, 62}), cold_N);
  EXPECT_GT(ForceMax_N(Nominal(), tool, side, {62, 62, 62}), 0);
  EXPECT_EQ(ForceMax_N(Nominal(), tool, up, {70, 70, 70}), 0);
  EXPECT_EQ(ForceMax_N(Nominal(), tool, {0, 0, 0}, kCold_C), 0);
  EXPECT_EQ(ForceMax_N(Nominal(), tool, {kNaN, 0, 1}, kCold_C), 0);
  // It is the border: just within it a request is met, beyond it is cut.
  const base::ForceLimit limit = ComputeForceLimit(Nominal(), tool, {62, 62, 62});
  const double most_N = base::ForceMax_N(limit, up);
  EXPECT_EQ(base::FeasibleScale(limit, {0, 0, 0.999 * most_N}), 1);
  EXPECT_LT(base::FeasibleScale(limit, {0, 0, 1.001 * most_N}), 1);
}

TEST(ActuationExamples, CurrentsCauseTorqueButNoneAboutTheMagnetAxis) {
  const base::ToolState tool = ToolAt({0.025, 0, 0.045}, {0, 0, -1});
  const base::ForceLimit limit = ComputeForceLimit(Nominal(), tool, kCold_C);
  State state;
  base::CoilCurrents currents;
  for (int i = 0; i < 10; ++i) Allocate(Nominal(), limit, {0.5, 0, 0.8}, 1e-3, state, currents);
  const base::Vec3 torque_Nm = base::TorqueOf_Nm(limit, currents.current_A);
  const double size_Nm = base::ToEigen(torque_Nm).norm();
  EXPECT_GT(size_Nm, 1e-3);
  EXPECT_LT(size_Nm, 0.1);
  // A moment along the axis of a symmetric magnet feels no torque about that axis.
  EXPECT_NEAR(torque_Nm.z, 0, 1e-4 * size_Nm);
  EXPECT_EQ(base::TorqueOf_Nm(base::ForceLimit{}, {1, 1, 1}), base::Vec3{});
}

TEST(ActuationExamples, SingularPoseIsReported) {
  const base::ForceLimit good = ComputeForceLimit(Nominal(), ToolAt({0, 0, 0.06}, {0, 0, -1}), kCold_C);
  EXPECT_FALSE(good.near_singular);
  EXPECT_GT(good.conditioning, 0.4);
  const base::ForceLimit flat = ComputeForceLimit(Nominal(), ToolAt({0, 0, 0.06}, {1, 0, 0}), kCold_C);
  EXPECT_TRUE(flat.near_singular);
  EXPECT_LT(flat.conditioning, 0.02);
}

TEST(ActuationExamples, BiasCurrentsCancelTheSnappingForce) {
  const base::ToolState tool = ToolAt({0.005, 0, 0.046}, base::FromEigen(Eigen::Vector3d(0.1, 0, -1).normalized()));
  const base::ForceLimit limit = ComputeForceLimit(Nominal(), tool, kCold_C);
  const base::Vec3 left = ForceFromCurrents(Nominal().map, tool, limit.bias_A);
  EXPECT_LT(base::ToEigen(left).norm(), 1e-9);
  Config without = Nominal();
  without.compensate_snapping = false;
  EXPECT_EQ(ComputeForceLimit(without, tool, kCold_C).bias_A, (std::array<double, 3>{}));
}

TEST(ActuationExamples, ZeroRequestGivesNoCurrentAndOthersAreSlewLimited) {
  const base::ToolState tool = ToolAt({0, 0, 0.046}, {0, 0, -1});
  const base::ForceLimit limit = ComputeForceLimit(Nominal(), tool, kCold_C);
  State state;
  base::CoilCurrents currents;
  Allocate(Nominal(), limit, {}, 1e-3, state, currents);
  EXPECT_EQ(currents.current_A, (std::array<double, 3>{}));
  int ticks = 0;
  for (; ticks < 20; ++ticks) {
    const auto before = currents.current_A;
    Allocate(Nominal(), limit, {0, 0, 1.5}, 1e-3, state, currents);
    if (currents.current_A == before) break;
    for (std::size_t k = 0; k < 3; ++k) EXPECT_LE(std::abs(currents.current_A[k] - before[k]), 5 + 1e-12);
  }
  EXPECT_LE(ticks, 4);
  const base::Vec3 force = ForceFromCurrents(Nominal().map, tool, currents.current_A);
  EXPECT_NEAR(force.z, 1.5, 1e-6);  // net of the core's pull
  EXPECT_NEAR(std::hypot(force.x, force.y), 0, 1e-6);
}

TEST(ActuationExamples, InvalidLimitOrRequestZeroesTheCurrentsAtOnce) {
  const base::ToolState tool = ToolAt({0, 0, 0.046}, {0, 0, -1});
  const base::ForceLimit good = ComputeForceLimit(Nominal(), tool, kCold_C);
  base::ForceLimit broken = good;
  broken.ampere_per_newton.fill(kNaN);
  const std::pair<base::ForceLimit, base::Vec3> doubts[] = {
      {base::ForceLimit{}, {0, 0, 1}}, {good, {0, kNaN, 1}}, {good, {0, 0, 1e300}}, {broken, {0, 0, 1}}};
  for (const auto& [limit, force] : doubts) {
    State state{{10, -10, 2}};
    base::CoilCurrents currents;
    Allocate(Nominal(), limit, force, 1e-3, state, currents);
    EXPECT_EQ(currents.current_A, (std::array<double, 3>{}));
  }
  State state{{kNaN, 1, 1}};
  base::CoilCurrents currents;
  Allocate(Nominal(), good, {}, kNaN, state, currents);
  EXPECT_EQ(currents.current_A, (std::array<double, 3>{}));
}

}  // namespace test_actuation_examples
}  // namespace omni::actuation
