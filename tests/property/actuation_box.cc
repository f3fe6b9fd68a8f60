// Box-limited least squares: optimal by the Karush-Kuhn-Tucker conditions and against brute force, continuous, robust.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "service/actuation/actuation.h"
#include "service/actuation/box_least_squares.h"
#include "service/base/eigen.h"
#include "tests/support/nominal_device.h"
#include "tests/support/numeric.h"

namespace omni::actuation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using support::RandomUnit;
using support::Rng;
using support::Uniform;

Matrix3d ToMatrix(const CurrentMetric& H) {
  Matrix3d M;
  M << H.xx, H.xy, H.xz, H.xy, H.yy, H.yz, H.xz, H.yz, H.zz;
  return M;
}
Vector3d ToVector(const CurrentArray& I) { return {I[0], I[1], I[2]}; }

struct Problem {
  std::array<double, 9> X{};
  base::Vec3 force_N;
  double weight = 1;
  CurrentArray wanted_A{}, max_A{};
};

Problem RandomProblem(Rng& rng) {
  Problem problem;
  for (double& entry : problem.X) entry = Uniform(rng, -0.3, 0.3);
  problem.force_N = base::FromEigen(Uniform(rng, 0, 3) * RandomUnit(rng));
  problem.weight = Uniform(rng, 1, 5);
  for (std::size_t k = 0; k < 3; ++k) {
    problem.wanted_A[k] = Uniform(rng, -40, 40);
    problem.max_A[k] = rng() % 10 == 0 ? 0 : Uniform(rng, 0.1, 15);
  }
  return problem;
}

double Cost(const Matrix3d& H, const Vector3d& d) { return d.dot(H * d); }

TEST(ActuationBox, MetricIsTheWeightedForceError) {
  Rng rng(21);
  for (int i = 0; i < 1000; ++i) {
    const Problem problem = RandomProblem(rng);
    const Matrix3d X = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(problem.X.data());
    const Vector3d d = ToVector(problem.wanted_A), error = X * d;
    const Vector3d f = base::ToEigen(problem.force_N).normalized();
    const double along = error.dot(f);
    const double across2 = (error - along * f).squaredNorm();
    const double expected = along * along + problem.weight * problem.weight * across2;
    const Matrix3d H = ToMatrix(MakeCurrentMetric(problem.X, problem.force_N, problem.weight));
    EXPECT_NEAR(Cost(H, d), expected, 1e-5 * H.trace() * d.squaredNorm());
    EXPECT_GE(Cost(H, d), expected);
  }
}

// Free coordinates: no slope. At a limit: the slope points outwards. For a convex cost that proves the minimum.
TEST(ActuationBox, MeetsTheOptimalityConditions) {
  Rng rng(22);
  int inside = 0, corner = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Problem problem = RandomProblem(rng);
    const CurrentMetric metric = MakeCurrentMetric(problem.X, problem.force_N, problem.weight);
    const CurrentArray found = NearestInBox(metric, problem.wanted_A, problem.max_A);
    const Matrix3d H = ToMatrix(metric);
    const Vector3d slope = 2 * H * (ToVector(found) - ToVector(problem.wanted_A));
    const double scale = H.trace() * 50;
    int free = 0;
    for (int k = 0; k < 3; ++k) {
      const double limit = problem.max_A[static_cast<std::size_t>(k)];
      const double current = found[static_cast<std::size_t>(k)];
      ASSERT_LE(std::abs(current), limit);
      const double sign = current > 0 ? 1 : -1;
      if (std::abs(current) < limit * (1 - 1e-9)) {
        ++free;
        ASSERT_LT(std::abs(slope[k]), 1e-9 * scale) << "problem " << i;
      } else if (limit > 0) {
        ASSERT_LT(slope[k] * sign, 1e-9 * scale) << "problem " << i;
      }
    }
    inside += free == 3;
    corner += free == 0;
  }
  EXPECT_GT(inside, 20);
  EXPECT_GT(corner, 1000);
}

// Brute force: a grid over the box, narrowed again and again around its best point.
TEST(ActuationBox, EqualsBruteForce) {
  Rng rng(23);
  for (int i = 0; i < 60; ++i) {
    const Problem problem = RandomProblem(rng);
    const CurrentMetric metric = MakeCurrentMetric(problem.X, problem.force_N, problem.weight);
    const Matrix3d H = ToMatrix(metric);
    const Vector3d wanted = ToVector(problem.wanted_A), limit = ToVector(problem.max_A);
    Vector3d best = Vector3d::Zero(), half = limit;
    for (int round = 0; round < 200; ++round) {
      const Vector3d centre = best;
      for (int x = -3; x <= 3; ++x) {
        for (int y = -3; y <= 3; ++y) {
          for (int z = -3; z <= 3; ++z) {
            const Vector3d I = (centre + Vector3d(x, y, z).cwiseProduct(half) / 3).cwiseMax(-limit).cwiseMin(limit);
            if (Cost(H, I - wanted) < Cost(H, best - wanted)) best = I;
          }
        }
      }
      half *= 0.9;
    }
    const Vector3d found = ToVector(NearestInBox(metric, problem.wanted_A, problem.max_A));
    const double brute = Cost(H, best - wanted), exact = Cost(H, found - wanted);
    EXPECT_LE(exact, brute * (1 + 1e-12));
    EXPECT_GE(exact, brute * (1 - 1e-4) - 1e-12);
  }
}

TEST(ActuationBox, WhatFitsIsNotTouched) {
  Rng rng(24);
  for (int i = 0; i < 1000; ++i) {
    Problem problem = RandomProblem(rng);
    for (std::size_t k = 0; k < 3; ++k) problem.wanted_A[k] = Uniform(rng, -1, 1) * problem.max_A[k];
    const CurrentMetric metric = MakeCurrentMetric(problem.X, problem.force_N, problem.weight);
    EXPECT_EQ(NearestInBox(metric, problem.wanted_A, problem.max_A), problem.wanted_A);
  }
}

base::ToolState ToolAt(const Vector3d& p, const Vector3d& u) {
  base::ToolState tool;
  tool.status = base::TrackingStatus::kTracking;
  tool.position_base_m = base::FromEigen(p);
  tool.axis_base = base::FromEigen(u);
  tool.gap_m = p.norm() - 0.041;
  return tool;
}

Config NearestConfig() {
  Config config = MakeConfig(support::NominalDevice());
  config.infeasible = Infeasible::kNearest;
  config.current_slew_A_s = 1e9;
  config.force_max_N = 10;
  config.power_max_W = 1e6;
  return config;
}

Vector3d Made(const Config& config, const base::ForceLimit& limit, const Vector3d& force_N) {
  State state;
  base::CoilCurrents currents;
  Allocate(config, limit, base::FromEigen(force_N), 1e-3, state, currents);
  return ToVector(currents.current_A);
}

Vector3d ForceOf(const base::ForceLimit& limit, const Vector3d& I) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(limit.newton_per_ampere.data()) * I +
         base::ToEigen(limit.snapping_N);
}

// The force error of the nearest force is never above the scaled one's; a heavy weight keeps the direction.
TEST(ActuationBox, NearestForceIsNearerThanTheScaledOne) {
  Rng rng(25);
  Config nearest = NearestConfig();
  nearest.direction_weight = 1;
  Config heavy = nearest;
  heavy.direction_weight = 300;
  Config scaled = nearest;
  scaled.infeasible = Infeasible::kKeepDirection;
  int infeasible = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d n = RandomUnit(rng);
    Vector3d u;
    do {
      u = RandomUnit(rng);
    } while (std::abs(u.dot(n)) < 0.6);
    const base::ToolState tool = ToolAt(Uniform(rng, 0.048, 0.07) * n, u);
    const Vector3d wanted = 2.5 * RandomUnit(rng);
    const base::ForceLimit limit = ComputeForceLimit(nearest, tool, {25, 25, 25});
    const base::ForceLimit strict = ComputeForceLimit(scaled, tool, {25, 25, 25});
    ASSERT_FALSE(limit.keeps_direction);
    if (base::FeasibleScale(strict, base::FromEigen(wanted)) >= 1) continue;
    ++infeasible;
    const Vector3d by_nearest = ForceOf(limit, Made(nearest, limit, wanted));
    const Vector3d by_scale = ForceOf(strict, Made(scaled, strict, wanted));
    EXPECT_LE((by_nearest - wanted).norm(), (by_scale - wanted).norm() + 1e-3);
    const Vector3d by_heavy = ForceOf(limit, Made(heavy, limit, wanted));
    if (by_heavy.norm() > 0.5) {
      EXPECT_LT(by_heavy.cross(wanted).norm(), 0.02 * by_heavy.norm() * wanted.norm());
    }
  }
  EXPECT_GT(infeasible, 500);
}

// Along a path of requests through zero and through the limits: half the step, half the change.
TEST(ActuationBox, NearestForceIsContinuousInTheRequest) {
  Rng rng(26);
  const Config config = NearestConfig();
  for (int path = 0; path < 20; ++path) {
    const Vector3d n = RandomUnit(rng);
    const base::ForceLimit limit =
        ComputeForceLimit(config, ToolAt(0.052 * n, (n + 0.8 * RandomUnit(rng)).normalized()), {25, 25, 55});
    ASSERT_TRUE(limit.valid);
    const Vector3d a = 4 * RandomUnit(rng), b = -4 * (a.normalized() + 0.3 * RandomUnit(rng));
    const auto largest = [&](int steps) {
      double step_A = 0;
      Vector3d last = Made(config, limit, a);
      for (int i = 1; i <= steps; ++i) {
        const double s = static_cast<double>(i) / steps;
        const Vector3d now = Made(config, limit, (1 - s) * a + s * b);
        step_A = std::max(step_A, (now - last).norm());
        last = now;
      }
      return step_A;
    };
    const double coarse_A = largest(1000);
    EXPECT_LT(coarse_A, 4) << path;
    EXPECT_LT(largest(2000), 0.65 * coarse_A) << path;
  }
}

double Nasty(Rng& rng) {
  switch (rng() % 8) {
    case 0:
      return std::numeric_limits<double>::quiet_NaN();
    case 1:
      return -std::numeric_limits<double>::infinity();
    case 2:
      return 1e308;
    case 3:
      return 1e-310;
    default:
      return Uniform(rng, -5, 5);
  }
}

TEST(ActuationBox, LimitsHoldWhateverIsAskedOfTheNearestForce) {
  Rng rng(27);
  Config config = NearestConfig();
  config.compensate_weight = true;
  config.power_max_W = 250;
  State state;
  base::CoilCurrents currents;
  base::ForceLimit limit;
  for (int i = 0; i < 50'000; ++i) {
    if (i % 10 == 0) {
      const base::ToolState tool = ToolAt(Uniform(rng, 0.03, 0.15) * RandomUnit(rng), RandomUnit(rng));
      limit = ComputeForceLimit(config, tool, {Uniform(rng, 20, 75), Uniform(rng, 20, 75), Nasty(rng) + 40});
      FadeWeight(Nasty(rng), limit);
      if (rng() % 10 == 0) limit.newton_per_ampere[rng() % 9] = Nasty(rng);
      if (rng() % 10 == 0) limit.ampere_per_newton[rng() % 9] = Nasty(rng);
      if (rng() % 10 == 0) limit.weight_A[rng() % 3] = Nasty(rng);
      if (rng() % 10 == 0) limit.bias_A[rng() % 3] = Nasty(rng);
      if (rng() % 10 == 0) limit.current_max_A[rng() % 3] = Nasty(rng);
    }
    Allocate(config, limit, {Nasty(rng), Nasty(rng), Nasty(rng)}, 1e-3, state, currents);
    double power_W = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_TRUE(std::isfinite(currents.current_A[k]));
      ASSERT_LE(std::abs(currents.current_A[k]), config.current_max_A);
      if (limit.valid && limit.current_max_A[k] >= 0) {
        ASSERT_LE(std::abs(currents.current_A[k]), limit.current_max_A[k]);
      }
      power_W += config.resistance_20C_ohm[k] * currents.current_A[k] * currents.current_A[k];
    }
    ASSERT_LE(power_W, config.power_max_W);
  }
}

}  // namespace
}  // namespace omni::actuation
