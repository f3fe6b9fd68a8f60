// The last limiter on the sum of all forces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "service/base/force_limit.h"
#include "service/base/vec.h"
#include "service/loop/force_limiter.h"
#include "service/sim/fields/random.h"
#include "tests/support/usual_limit.h"

namespace omni::loop {
namespace test_loop_force_limiter {

constexpr double kTick_s = 1e-3;
constexpr double kRise_N = 0.85;

base::ForceLimit Limit(double trust = 1, double growth_s = kTick_s) {
  base::ForceLimit limit = test::UsualLimit();
  NarrowLimit({}, trust, growth_s, limit);
  return limit;
}

TEST(ForceLimiter, ZeroIsAppliedAtOnce) {
  ForceLimiterState state{{0, 0, 2}};
  EXPECT_EQ(LimitForce(Limit(), {}, state), base::Vec3{});
  EXPECT_EQ(state.last_N, base::Vec3{});
}

TEST(ForceLimiter, FallsFreelyButRisesAtALimitedRate) {
  ForceLimiterState state{{0, 0, 2}};
  EXPECT_EQ(LimitForce(Limit(), {0, 0, 0.3}, state), (base::Vec3{0, 0, 0.3}));
  EXPECT_NEAR(LimitForce(Limit(), {0, 0, 2}, state).z, 0.3 + kRise_N, 1e-12);
  EXPECT_NEAR(LimitForce(Limit(), {0, 0, 2}, state).z, 2, 1e-12);
}

TEST(ForceLimiter, ForceWithinLimitsIsUnchanged) {
  ForceLimiterState state{{0.5, 0, 1}};
  const base::Vec3 wanted{0.7, -0.2, 1.3};
  EXPECT_EQ(LimitForce(Limit(), wanted, state), wanted) << "bit by bit";
}

// A limit on the magnitude alone would miss this: a turning force leaves the segment to zero sideways.
TEST(ForceLimiter, LimitsTheRiseOfATurningForce) {
  ForceLimiterState state{{1.5, 0, 0}};
  base::Vec3 f = LimitForce(Limit(), {0, 1.5, 0}, state);
  EXPECT_NEAR(f.x, 0, 1e-12);
  EXPECT_NEAR(f.y, kRise_N, 1e-12);
  state.last_N = {1.5, 0, 0};
  f = LimitForce(Limit(), {-1.5, 0, 0}, state);
  EXPECT_NEAR(f.x, -kRise_N, 1e-12);
}

TEST(ForceLimiter, NonFiniteForceBecomesZero) {
  for (const double odd : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity(), 1e300}) {
    ForceLimiterState state{{0, 0, 1}};
    const base::Vec3 f = LimitForce(Limit(), {0, odd, 0.5}, state);
    EXPECT_TRUE(Norm(f) <= 1 + kRise_N) << odd;
    EXPECT_TRUE(std::abs(odd) < 1e301 ? std::isfinite(f.y) : f == base::Vec3{}) << odd;
    EXPECT_EQ(LimitForce(Limit(), {}, state), base::Vec3{});
  }
}

TEST(ForceLimiter, WithoutAPoseThereIsNoForce) {
  ForceLimiterState state{{0, 0, 1}};
  base::ForceLimit nowhere;
  NarrowLimit({}, 1, kTick_s, nowhere);
  EXPECT_EQ(LimitForce(nowhere, {0, 0, 1}, state), base::Vec3{});
  EXPECT_LE(LimitForce(Limit(), {0, 0, 1}, state).z, kRise_N) << "and it grows from zero again";
}

TEST(ForceLimiter, TrustScalesSizeAndRise) {
  const base::ForceLimit half = Limit(0.5);
  EXPECT_NEAR(half.force_max_N, 1, 1e-12);
  EXPECT_NEAR(half.force_rise_N, kRise_N / 2, 1e-12);
  for (const double none : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    ForceLimiterState state;
    EXPECT_EQ(LimitForce(Limit(none), {0, 0, 1}, state), base::Vec3{}) << none;
  }
  EXPECT_NEAR(Limit(7).force_max_N, test::UsualLimit().force_max_N, 1e-12);
}

TEST(ForceLimiter, RiseAfterLostScansIsThatOfOneTick) {
  EXPECT_NEAR(Limit(1, 5e-3).force_rise_N, kRise_N, 1e-12);
  EXPECT_NEAR(Limit(1, 0.4e-3).force_rise_N, 0.4 * kRise_N, 1e-12);
  for (const double none : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(Limit(1, none).force_rise_N, 0) << none;
  }
}

// Any requests in any order: within the limit, and no further than the rise from the segment to zero.
TEST(ForceLimiter, RandomRequestsStayWithinForceAndRiseLimits) {
  sim::Random random(5);
  ForceLimiterState state;
  for (int i = 0; i < 200'000; ++i) {
    base::ForceLimit limit = Limit(random.Uniform(0.2, 1), random.Uniform(0, 2e-3));
    limit.force_max_N = random.Uniform(0, 2);
    const base::Vec3 last = state.last_N;
    const base::Vec3 wanted = random.Uniform(0, 4) * random.NormalVector(1);
    const base::Vec3 f = LimitForce(limit, wanted, state);
    const double whole = Dot(last, last);
    const double kept = whole > 0 ? std::clamp(Dot(f, last) / whole, 0.0, 1.0) : 0.0;
    ASSERT_LE(Norm(f), limit.force_max_N + 1e-12) << i;
    ASSERT_LE(Norm(f - kept * last), limit.force_rise_N + 1e-12) << i;
    ASSERT_GE(Dot(f, wanted), -1e-12) << "never away from what is wanted " << i;
  }
}

}  // namespace test_loop_force_limiter
}  // namespace omni::loop
