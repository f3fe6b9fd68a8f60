// Aims of the twin's hand: only complete ones in range are accepted.
#include "service/protocol/hand_aim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace omni::protocol {
namespace test_protocol_hand_aim {

bool Passes(const HandAim& aim) {
  HandAim read;
  return ReadHandAim(&aim, sizeof(aim), read);
}

TEST(HandAim, ReadReturnsTheAimThatWasSent) {
  const HandAim sent{.present = 0, .tip_base_m = {0.01, -0.02, 0.06}, .axis_base = {0, 0.6, -0.8}};
  HandAim read;
  ASSERT_TRUE(ReadHandAim(&sent, sizeof(sent), read));
  EXPECT_EQ(std::memcmp(&sent, &read, sizeof(sent)), 0);
}

TEST(HandAim, RejectsInvalidFields) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(Passes({}));
  EXPECT_FALSE(Passes({.magic = 1}));
  EXPECT_FALSE(Passes({.version = kHandVersion + 1}));
  EXPECT_FALSE(Passes({.present = 2}));
  for (const double bad : {nan, infinity, -infinity, 1.01, -1e300}) {
    for (std::size_t i = 0; i < 3; ++i) {
      HandAim aim;
      aim.tip_base_m[i] = bad;
      EXPECT_FALSE(Passes(aim)) << bad;
      aim = {};
      aim.axis_base[i] = bad;
      EXPECT_FALSE(Passes(aim)) << bad;
    }
  }
  EXPECT_FALSE(Passes({.axis_base = {0, 0, 0}}));
  EXPECT_FALSE(Passes({.axis_base = {0, 0, -1.1}}));
}

TEST(HandAim, RejectsEveryOtherSize) {
  const std::vector<unsigned char> zeros(256);
  std::vector<unsigned char> bytes(256);
  const HandAim good;
  std::memcpy(bytes.data(), &good, sizeof(good));
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    HandAim aim;
    EXPECT_EQ(ReadHandAim(bytes.data(), size, aim), size == sizeof(HandAim)) << size;
    EXPECT_FALSE(ReadHandAim(zeros.data(), size, aim)) << size;
  }
}

TEST(HandAim, AcceptedRandomBytesAreInRange) {
  std::mt19937_64 random(1);
  int passed = 0;
  for (int i = 0; i < 200'000; ++i) {
    HandAim aim;
    unsigned char bytes[sizeof(HandAim)];
    std::memcpy(bytes, &aim, sizeof(aim));
    for (int k = 0; k < 3; ++k) bytes[random() % sizeof(bytes)] = static_cast<unsigned char>(random());
    HandAim read;
    if (!ReadHandAim(bytes, sizeof(bytes), read)) continue;
    ++passed;
    for (const double x : read.tip_base_m) ASSERT_LE(std::abs(x), kHandReach_m);
    ASSERT_LE(read.present, 1U);
    ASSERT_NEAR(std::hypot(read.axis_base[0], read.axis_base[1], read.axis_base[2]), 1, 0.01);
  }
  EXPECT_GT(passed, 1000);
}

}  // namespace test_protocol_hand_aim
}  // namespace omni::protocol
