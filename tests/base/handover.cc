// Latest and SpscRing between two threads; the rule of feasible force.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <thread>

#include "service/base/force_limit.h"
#include "service/base/handover.h"

namespace omni::base {
namespace test_base_handover {

struct Pair {
  std::uint64_t a = 0, b = 0;
};

TEST(Latest, ReaderStartsWithTheDefault) {
  Latest<Pair> latest;
  EXPECT_EQ(latest.Read().a, 0U);
}

TEST(Latest, ReaderSeesTheNewestAndKeepsIt) {
  Latest<Pair> latest;
  latest.Write({1, 1});
  latest.Write({2, 2});
  EXPECT_EQ(latest.Read().a, 2U);
  EXPECT_EQ(latest.Read().a, 2U);
  latest.Write({3, 3});
  EXPECT_EQ(latest.Read().a, 3U);
}

TEST(Latest, ValuesAreNeverTornOrOutOfOrder) {
  Latest<Pair> latest;
  constexpr std::uint64_t kWrites = 200'000;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kWrites; ++i) latest.Write({i, ~i});
  });
  std::uint64_t last = 0;
  while (last < kWrites) {
    const Pair seen = latest.Read();
    if (seen.a == 0) continue;
    ASSERT_EQ(seen.b, ~seen.a);
    ASSERT_GE(seen.a, last);
    last = seen.a;
  }
  writer.join();
}

TEST(SpscRing, RejectsPushWhenFullAndKeepsOrder) {
  SpscRing<int, 4> ring;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.TryPush(i));
  EXPECT_FALSE(ring.TryPush(4));
  int value = -1;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(ring.TryPop(value));
    EXPECT_EQ(value, i);
  }
  EXPECT_FALSE(ring.TryPop(value));
}

TEST(SpscRing, LosesNothingBetweenThreads) {
  auto ring = std::make_unique<SpscRing<int, 64>>();
  constexpr int kCount = 100'000;
  std::thread producer([&] {
    for (int i = 0; i < kCount;) i += ring->TryPush(i) ? 1 : 0;
  });
  for (int expected = 0; expected < kCount;) {
    int value = -1;
    if (!ring->TryPop(value)) continue;
    ASSERT_EQ(value, expected++);
  }
  producer.join();
}

ForceLimit Limit(double max_A, double bias_A, double force_max_N) {
  return {.valid = true,
          .ampere_per_newton = {4, 0, 0, 0, 4, 0, 0, 0, 5},
          .bias_A = {0, 0, bias_A},
          .current_max_A = {max_A, max_A, max_A},
          .force_max_N = force_max_N};
}

TEST(FeasibleScale, ScalesToTheTightestLimit) {
  EXPECT_DOUBLE_EQ(FeasibleScale(Limit(15, 0, 10), {1, 0, 0}), 1.0);
  EXPECT_DOUBLE_EQ(FeasibleScale(Limit(15, 0, 10), {7.5, 0, 0}), 0.5);
  EXPECT_DOUBLE_EQ(FeasibleScale(Limit(15, 0, 2), {4, 0, 0}), 0.5);
  EXPECT_DOUBLE_EQ(FeasibleScale(Limit(15, 5, 10), {0, 0, 4}), 0.5);   // bias eats headroom upwards ...
  EXPECT_DOUBLE_EQ(FeasibleScale(Limit(15, 5, 10), {0, 0, -4}), 1.0);  // ... and adds it downwards
}

// Coils of 2 ohm, 50 W for all: 5 A in one, 3.54 A in two.
TEST(FeasibleScale, ScalesToTheTotalPower) {
  ForceLimit limit = Limit(15, 0, 10);
  limit.resistance_ohm = {2, 2, 2};
  limit.power_max_W = 50;
  EXPECT_DOUBLE_EQ(FeasibleScale(limit, {1.2, 0, 0}), 1.0);
  EXPECT_DOUBLE_EQ(FeasibleScale(limit, {2.5, 0, 0}), 0.5);
  EXPECT_DOUBLE_EQ(FeasibleScale(limit, {2.5, 2.5, 0}), 0.5 / std::sqrt(2.0));
  limit.bias_A = {0, 0, 3};  // 18 W of 50: 4 A are left beside it
  EXPECT_NEAR(FeasibleScale(limit, {2, 0, 0}), 0.5, 1e-12);
  EXPECT_NEAR(FeasibleScale(limit, {0, 0, 0.8}), 0.5, 1e-12);   // 3 A + 2 A
  EXPECT_NEAR(FeasibleScale(limit, {0, 0, -3.2}), 0.5, 1e-12);  // 3 A - 8 A
  limit.bias_A = {0, 0, 6};                                     // more than there is, alone
  EXPECT_EQ(FeasibleScale(limit, {1, 0, 0}), 0);
  EXPECT_EQ(FeasibleScale(limit, {0, 0, -2}), 1);
}

// The bias grows with the request up to bias_fade_N: the largest scale is the root of a curve there.
TEST(FeasibleScale, CountsTheShareOfTheBiasThatASmallForceHas) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int cut = 0;
  for (int i = 0; i < 5000; ++i) {
    ForceLimit limit = Limit(3, 0, 2);
    limit.bias_A = {2 * uniform(random), 2 * uniform(random), 2 * uniform(random)};
    limit.bias_fade_N = 0.5;
    limit.ampere_per_newton = {30, 2, 1, 3, 30, 2, 1, 2, 30};
    limit.resistance_ohm = {1, 2, 0.5};
    limit.power_max_W = 4 + 3 * uniform(random);
    const Vec3 force = (0.5 + 0.4 * uniform(random)) * Normalized({uniform(random), uniform(random), uniform(random)});
    const double s = FeasibleScale(limit, force);
    const auto fits = [&](double scale) {
      const double size = std::min(1.0, Norm(scale * force) / 0.5), w = size * size * (3 - 2 * size);
      double power_W = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double* row = &limit.ampere_per_newton[3 * k];
        const double current = w * limit.bias_A[k] + scale * (row[0] * force.x + row[1] * force.y + row[2] * force.z);
        if (!(std::abs(current) <= 3)) return false;
        power_W += limit.resistance_ohm[k] * current * current;
      }
      return power_W <= limit.power_max_W;
    };
    ASSERT_TRUE(fits(s * (1 - 1e-9))) << i;
    if (s == 1) continue;
    ASSERT_FALSE(fits(s * (1 + 1e-6))) << i;
    ASSERT_NEAR(FeasibleScale(limit, s * force), 1, 1e-9) << i;
    ++cut;
  }
  EXPECT_GT(cut, 1000);
}

TEST(FeasibleScale, IsZeroForInvalidInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ForceLimit invalid = Limit(15, 0, 2);
  invalid.valid = false;
  EXPECT_EQ(FeasibleScale(invalid, {1, 0, 0}), 0);
  EXPECT_EQ(FeasibleScale(Limit(15, 0, 2), {nan, 0, 0}), 0);
  EXPECT_EQ(FeasibleScale(Limit(15, 0, 2), {std::numeric_limits<double>::infinity(), 0, 0}), 0);
  EXPECT_EQ(FeasibleScale(Limit(15, nan, 2), {0, 0, 1}), 0);
  EXPECT_EQ(FeasibleScale(Limit(0, 0, 2), {0, 0, 1}), 0);
}

TEST(FeasibleScale, ResultIsFeasible) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-6, 6);
  for (int i = 0; i < 10'000; ++i) {
    ForceLimit limit = Limit(10, uniform(random), 2);
    for (double& a : limit.ampere_per_newton) a = uniform(random);
    const Vec3 force{uniform(random), uniform(random), uniform(random)};
    const double s = FeasibleScale(limit, force);
    ASSERT_GE(s, 0);
    ASSERT_LE(s, 1);
    for (std::size_t k = 0; k < 3; ++k) {
      const double* row = &limit.ampere_per_newton[3 * k];
      const double current = limit.bias_A[k] + s * (row[0] * force.x + row[1] * force.y + row[2] * force.z);
      ASSERT_LE(std::abs(current), 10 * (1 + 1e-12));
    }
  }
}

}  // namespace test_base_handover
}  // namespace omni::base
