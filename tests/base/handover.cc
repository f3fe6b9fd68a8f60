// Latest and SpscRing between two threads; the rule of feasible force.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <thread>

#include "service/base/force_limit.h"
#include "service/base/latest.h"
#include "service/base/spsc_ring.h"

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
