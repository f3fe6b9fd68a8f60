// Stamps may be anything: differences and sums saturate, and are exact where they fit.
#include "service/base/clock.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace omni::base {
namespace test_base_stamp {

constexpr std::int64_t kLowest = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kHighest = std::numeric_limits<std::int64_t>::max();

TEST(Stamp, DifferencesAndSumsAreExactOrSaturate) {
  std::mt19937_64 random(20);
  for (int i = 0; i < 100000; ++i) {
    const auto a = static_cast<std::int64_t>(random()) >> (random() % 64);
    const auto b = static_cast<std::int64_t>(random()) >> (random() % 64);
    const __int128 difference = static_cast<__int128>(a) - b;
    const __int128 sum = static_cast<__int128>(a) + b;
    const auto clamped = [](__int128 x) {
      return static_cast<std::int64_t>(x < kLowest ? kLowest : x > kHighest ? kHighest : x);
    };
    ASSERT_EQ(StampDifference_ns(a, b), clamped(difference)) << a << " " << b;
    ASSERT_EQ(StampAfter_ns(a, b), clamped(sum)) << a << " " << b;
  }
}

TEST(Stamp, ElapsedHasTheSignOfTheOrder) {
  EXPECT_DOUBLE_EQ(Elapsed_s(1'500'000'000, 1'000'000'000), 0.5);
  EXPECT_LT(Elapsed_s(kLowest, kHighest), -9e9);
  EXPECT_GT(Elapsed_s(kHighest, kLowest), 9e9);
}

}  // namespace test_base_stamp
}  // namespace omni::base
