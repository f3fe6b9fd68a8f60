// What the coils are said to be able to do, against what they can: the largest force along a direction is searched for
// in currents, each within its limit and the heat of all within the total, by bisection on the force that currents
// make. Copper: R = R20 (1 + 0.00393 (T - 20)), docs/theory/thermal.md (3).
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <numbers>

#include "service/actuation/actuation.h"
#include "service/base/eigen.h"
#include "tests/support/numeric.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::actuation {
namespace test_actuation_feasible {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using support::RandomUnit;
using support::Rng;
using support::Uniform;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
using Temperatures = std::array<double, 3>;

base::ToolState ToolAt(const Vector3d& position_m, const Vector3d& axis) {
  base::ToolState tool;
  tool.status = base::TrackingStatus::kTracking;
  tool.position_base_m = base::FromEigen(position_m);
  tool.axis_base = base::FromEigen(axis);
  tool.gap_m = position_m.norm() - 0.041;
  return tool;
}

// Axis within `tilt_rad` of the radius, either sense.
base::ToolState RandomTool(Rng& rng, double r_min_m, double r_max_m, double tilt_rad) {
  Vector3d n = RandomUnit(rng), u;
  n.z() = std::abs(n.z());
  do {
    u = RandomUnit(rng);
  } while (std::acos(std::min(1.0, std::abs(u.dot(n)))) > tilt_rad);
  return ToolAt(Uniform(rng, r_min_m, r_max_m) * n, u);
}

// The device as its file describes it, and the force that currents make at one pose.
class Coils {
 public:
  Coils(const Config& config, const base::ToolState& tool, const Temperatures& coil_C)
      : fade_N_(config.bias_fade_N), power_max_W_(config.power_max_W), force_max_N_(config.force_max_N) {
    pull_N_ = base::ToEigen(ForceFromCurrents(config.map, tool, {}));
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<double, 3> one_A{};
      one_A[k] = 1;
      per_ampere_.col(static_cast<int>(k)) = base::ToEigen(ForceFromCurrents(config.map, tool, one_A)) - pull_N_;
      max_A_[k] = std::min(config.current_max_A, CurrentCeiling_A(config.heat, k, coil_C[k], coil_C[k]));
      ohm_[k] = support::NominalDevice().coils[k].resistance_20C_ohm * (1 + 0.00393 * (coil_C[k] - 20));
    }
    solver_.compute(per_ampere_);
  }

  // Request `f` along `d`: the net force is f, or below 0.5 N the core's pull is cancelled by its share only.
  bool Can(const Vector3d& d, double f) const {
    const double t = std::min(1.0, f / fade_N_);
    const Vector3d I = solver_.solve(f * d - t * t * (3 - 2 * t) * pull_N_);
    double heat_W = 0;
    for (int k = 0; k < 3; ++k) {
      if (!(std::abs(I[k]) <= max_A_[static_cast<std::size_t>(k)])) return false;
      heat_W += ohm_[static_cast<std::size_t>(k)] * I[k] * I[k];
    }
    return heat_W <= power_max_W_ && f <= force_max_N_;
  }

  // From above in steps of a thousandth, then halving.
  double Most_N(const Vector3d& d) const {
    double f = 1.001 * force_max_N_;
    while (f > 1e-7 && !Can(d, f)) f *= 0.999;
    double more = f / 0.999;
    for (int i = 0; i < 50; ++i) (Can(d, 0.5 * (f + more)) ? f : more) = 0.5 * (f + more);
    return f;
  }

  // What the currents make of a request `f` along `d`.
  Vector3d Made_N(const std::array<double, 3>& current_A, double f) const {
    const double t = std::min(1.0, f / fade_N_);
    return per_ampere_ * Eigen::Map<const Vector3d>(current_A.data()) + t * t * (3 - 2 * t) * pull_N_;
  }

  const Vector3d& pull_N() const { return pull_N_; }

 private:
  Matrix3d per_ampere_;
  Vector3d pull_N_;
  Eigen::ColPivHouseholderQR<Matrix3d> solver_;
  Temperatures max_A_{}, ohm_{};
  double fade_N_, power_max_W_, force_max_N_;
};

std::array<double, 3> Settled(const Config& config, const base::ForceLimit& limit, const Vector3d& force_N) {
  State state;
  base::CoilCurrents currents;
  for (int i = 0; i < 20; ++i) Allocate(config, limit, base::FromEigen(force_N), 1e-3, state, currents);
  return currents.current_A;
}

TEST(FeasibleForce, WhatIsPromisedIsMadeAndATenthOfAPercentMoreIsNotPossible) {
  Rng rng(50);
  const Config config = MakeConfig(support::NominalDevice());
  int judged = 0, small = 0, broken = 0;
  double most_promised = 0;
  for (int i = 0; i < 3000; ++i) {
    const base::ToolState tool = RandomTool(rng, 0.0415, 0.1, 1.2);
    const double hot = i % 3 == 0 ? 68 : 55;
    const Temperatures coil_C{Uniform(rng, 20, hot), Uniform(rng, 20, hot), Uniform(rng, 20, hot)};
    const base::ForceLimit limit = ComputeForceLimit(config, tool, coil_C);
    if (!limit.valid || limit.near_singular) continue;  // a disc that cuts the windings, or the test below
    const Coils coils(config, tool, coil_C);
    const Vector3d d = RandomUnit(rng);
    const double promised_N = base::ForceMax_N(limit, base::FromEigen(d));
    const double most_N = coils.Most_N(d);
    ++judged;
    if (promised_N < config.bias_fade_N) ++small;
    if (most_N < 1e-6) {
      EXPECT_LT(promised_N, 1e-6);
      continue;
    }
    most_promised = std::max(most_promised, promised_N / most_N);
    const Vector3d made_N = coils.Made_N(Settled(config, limit, promised_N * d), promised_N);
    const bool good = promised_N >= 0.999 * most_N && promised_N <= 1.001 * most_N &&
                      (made_N - promised_N * d).norm() <= 1e-3 * promised_N;
    broken += good ? 0 : 1;
    if (!good && broken < 10) {
      ADD_FAILURE() << i << ": promised " << promised_N << " N, possible " << most_N << " N, made " << made_N.norm();
    }
  }
  EXPECT_EQ(broken, 0) << "of " << judged << ", up to " << most_promised << " of what is possible";
  EXPECT_GT(judged, 2000);
  EXPECT_GT(small, 200);
}

// A request that is too large is made as far as possible, and one that is feasible is never cut.
TEST(FeasibleForce, FeasibleRequestsAreMadeAsTheyAre) {
  Rng rng(51);
  const Config config = MakeConfig(support::NominalDevice());
  int whole = 0, cut = 0;
  for (int i = 0; i < 3000; ++i) {
    const base::ToolState tool = RandomTool(rng, 0.0415, 0.1, 1.2);
    const Temperatures coil_C{Uniform(rng, 20, 60), Uniform(rng, 20, 60), Uniform(rng, 20, 60)};
    const base::ForceLimit limit = ComputeForceLimit(config, tool, coil_C);
    if (!limit.valid || limit.near_singular) continue;
    const Vector3d request_N = Uniform(rng, 0.01, 3) * RandomUnit(rng);
    const double scale = base::FeasibleScale(limit, base::FromEigen(request_N));
    const Coils coils(config, tool, coil_C);
    const double f = scale * request_N.norm();
    const Vector3d made_N = coils.Made_N(Settled(config, limit, request_N), f);
    ASSERT_LT((made_N - scale * request_N).norm(), 1e-6 + 1e-3 * f) << i << " of " << request_N.norm();
    (scale < 1 ? cut : whole) += 1;
  }
  EXPECT_GT(whole, 500);
  EXPECT_GT(cut, 500);
}

// Where one direction cannot be pushed, requests with a part in it make less: the promise is what is made along them,
// and never more than the coils could do at best.
TEST(FeasibleForce, NearSingularPosesPromiseWhatIsMadeAlongTheDirection) {
  Rng rng(52);
  const Config config = MakeConfig(support::NominalDevice());
  int near = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d n = i % 4 == 0 ? Vector3d(Vector3d::Unit(i / 4 % 3)) : RandomUnit(rng);
    Vector3d u = n.cross(RandomUnit(rng)).normalized();
    if (i % 2 == 0) u = (u + Uniform(rng, 0, 0.2) * n).normalized();
    const base::ToolState tool = ToolAt(Uniform(rng, 0.053, 0.09) * n, u);
    const base::ForceLimit limit = ComputeForceLimit(config, tool, {25, 25, 25});
    ASSERT_TRUE(limit.valid);
    if (!limit.near_singular) continue;
    ++near;
    const Coils coils(config, tool, {25, 25, 25});
    const Vector3d d = i % 5 == 0 ? Vector3d(n.cross(u).normalized()) : RandomUnit(rng);
    const double promised_N = base::ForceMax_N(limit, base::FromEigen(d));
    const std::array<double, 3> current_A = Settled(config, limit, 10 * d);
    const Vector3d no_bias_A = Eigen::Map<const Vector3d>(limit.bias_A.data());
    const double asked_N = 10 * base::FeasibleScale(limit, base::FromEigen(10 * d));
    const double share = asked_N >= 0.5 ? 1 : std::pow(asked_N / 0.5, 2) * (3 - 2 * asked_N / 0.5);
    const Vector3d push_A = Eigen::Map<const Vector3d>(current_A.data()) - share * no_bias_A;
    const Vector3d pushed_N =
        base::ToEigen(ForceFromCurrents(config.map, tool, {push_A.x(), push_A.y(), push_A.z()})) - coils.pull_N();
    EXPECT_NEAR(pushed_N.dot(d), promised_N, 1e-3 * promised_N + 1e-6) << i;
    EXPECT_LE(promised_N, asked_N + 1e-12);
  }
  EXPECT_GT(near, 1000);
  // Pen flat above the base: nothing is promised across it.
  const base::ForceLimit flat = ComputeForceLimit(config, ToolAt({0, 0, 0.06}, {1, 0, 0}), {25, 25, 25});
  EXPECT_LT(base::ForceMax_N(flat, {0, 1, 0}), 0.02);
  EXPECT_GT(base::ForceMax_N(flat, {0, 0, 1}), 0.2);
}

// On a coil's axis one coil alone pushes along it, whatever the other two may carry.
TEST(FeasibleForce, OneCoilPushesWhileTheOthersAreTooHot) {
  Config config = MakeConfig(support::NominalDevice());
  config.compensate_snapping = false;
  const base::ToolState tool = ToolAt({0, 0, 0.05}, {0, 0, -1});
  const base::ForceLimit cold = ComputeForceLimit(config, tool, {25, 25, 25});
  base::ForceLimit hot = cold;
  hot.current_max_A = {1e-6, 1e-6, cold.current_max_A[2]};
  const double up_N = base::ForceMax_N(hot, {0, 0, 1});
  EXPECT_NEAR(up_N, base::ForceMax_N(cold, {0, 0, 1}), 1e-6);
  EXPECT_GT(std::abs(Settled(config, hot, {0, 0, 9})[2]), 10);
  EXPECT_LT(base::ForceMax_N(hot, {1, 0, 0}), 1e-5);
}

TEST(FeasibleForce, TotalPowerOfZeroOrNoNumberMakesNoForce) {
  const base::ToolState tool = ToolAt({0, 0, 0.05}, {0, 0, -1});
  for (const double power_W : {0.0, kNaN, -1.0, -std::numeric_limits<double>::infinity()}) {
    Config config = MakeConfig(support::NominalDevice());
    config.power_max_W = power_W;
    const base::ForceLimit limit = ComputeForceLimit(config, tool, {25, 25, 25});
    EXPECT_EQ(base::ForceMax_N(limit, {0, 0, 1}), 0) << power_W;
    EXPECT_EQ(base::FeasibleScale(limit, {0, 0, 0.1}), 0) << power_W;
    State state{.last_current_A = {3, -4, 5}};
    base::CoilCurrents currents;
    for (int i = 0; i < 3; ++i) {
      Allocate(config, limit, {0.3, 0.1, 1}, 1e-3, state, currents);
      EXPECT_EQ(currents.current_A, (std::array<double, 3>{})) << power_W;
    }
  }
  Config config = MakeConfig(support::NominalDevice());
  config.power_max_W = std::numeric_limits<double>::infinity();  // only the coils' own limits are left
  const base::ForceLimit free = ComputeForceLimit(config, tool, {25, 25, 25});
  EXPECT_EQ(base::FeasibleScale(free, {0, 0, 0.1}), 1);
  EXPECT_LT(base::FeasibleScale(free, {0, 0, 9}), 1);
}

// Far away a coil's gain is tiny: the limit goes to zero evenly, and so do the currents.
TEST(FeasibleForce, FadesEvenlyOutOfReach) {
  const Config config = MakeConfig(support::NominalDevice());
  double last_N = 10;
  for (int i = 0; i <= 200; ++i) {
    const base::ToolState tool = ToolAt({0, 0, 0.141 + 1e-4 * i}, {0, 0, -1});
    const base::ForceLimit limit = ComputeForceLimit(config, tool, {25, 25, 25});
    const double most_N = base::ForceMax_N(limit, {0, 0.6, 0.8});
    EXPECT_LE(most_N, last_N);
    if (i > 0) {
      EXPECT_LT(last_N - most_N, 0.011) << i;  // 2 N over 20 mm
    }
    last_N = most_N;
  }
  EXPECT_LT(last_N, 1e-9);
}

// Full load from cold for two minutes: as the copper warms up the force shrinks without a kick, and is always what the
// limit of that tick promises.
TEST(FeasibleForce, ShrinksSmoothlyAsTheCopperWarmsUp) {
  const Config config = MakeConfig(support::NominalDevice());
  const Vector3d d = Vector3d(0.5, 0.4, 0.7).normalized();
  const base::ToolState tool = ToolAt({0.004, 0.003, 0.047}, Vector3d(0.1, 0, -1).normalized());
  State state;
  base::CoilCurrents currents;
  base::HallScan scan;
  scan.coil_temperature_C = {24, 24, 24};
  double first_N = 0, last_N = 0, largest_step_N = 0, largest_gap = 0;
  for (int ms = 0; ms < 120'000; ++ms) {
    scan.t_ns = 1'000'000'000 + ms * 1'000'000LL;
    scan.coil_current_A = currents.current_A;
    UpdateHeat(config, scan, state);
    const base::ForceLimit limit = ComputeDeratedLimit(config, tool, state.heat);
    Allocate(config, limit, base::FromEigen(5 * d), 1e-3, state, currents);
    const Vector3d force_N = base::ToEigen(ForceFromCurrents(config.map, tool, currents.current_A));
    const double promised_N = base::ForceMax_N(limit, base::FromEigen(d));
    if (ms == 100) first_N = promised_N;
    if (ms > 100 && promised_N > config.bias_fade_N) {
      largest_gap = std::max(largest_gap, (force_N - promised_N * d).norm() / promised_N);
      largest_step_N = std::max(largest_step_N, std::abs(promised_N - last_N));
    }
    last_N = promised_N;
  }
  EXPECT_LT(last_N, 0.8 * first_N);
  EXPECT_LT(largest_gap, 1e-3);
  EXPECT_LT(largest_step_N, 5e-3);
}

}  // namespace test_actuation_feasible
}  // namespace omni::actuation
