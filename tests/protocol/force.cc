// Messages about forces: what is accepted, and the errors of the rest, with a seeded fuzz.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "service/protocol/messages.h"

namespace omni::protocol {
namespace test_protocol_force {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class T>
std::string ReasonOf(const T& message) {
  const Message result = Validate(&message, sizeof(message));
  const auto* invalid = std::get_if<Invalid>(&result);
  if (invalid == nullptr) return std::holds_alternative<T>(result) ? "accepted" : "taken for something else";
  return invalid->reason;
}

ForceConstraints One(const ForceConstraint& constraint) {
  ForceConstraints set;
  set.count = 1;
  set.constraints[0] = constraint;
  return set;
}

TEST(ForceMessages, DefaultsAreAccepted) {
  EXPECT_EQ(ReasonOf(ForceClaim{}), "accepted");
  EXPECT_EQ(ReasonOf(ForceApply{}), "accepted");
  EXPECT_EQ(ReasonOf(ForceConstraints{}), "accepted");
  EXPECT_EQ(ReasonOf(ForceStop{}), "accepted");
  EXPECT_EQ(ReasonOf(ForceOwner{}), "accepted");
  EXPECT_EQ(ReasonOf(ForceProperties{}), "accepted");
  EXPECT_EQ(ReasonOf(One({})), "accepted");
}

TEST(ForceMessages, RejectionNamesTheField) {
  ForceApply apply;
  apply.force_base_N = {0, kNaN, 0};
  EXPECT_NE(ReasonOf(apply).find("force_base_N"), std::string::npos);
  apply = {};
  apply.duration_ns = 0;
  EXPECT_NE(ReasonOf(apply).find("duration_ns"), std::string::npos);
  apply.duration_ns = kLongestForce_ns + 1;
  EXPECT_NE(ReasonOf(apply).find("duration_ns"), std::string::npos);
  apply = {};
  apply.ramp_ns = -1;
  EXPECT_NE(ReasonOf(apply).find("ramp_ns"), std::string::npos);
  ForceConstraints set;
  set.count = kMaxForceConstraints + 1;
  EXPECT_NE(ReasonOf(set).find("count"), std::string::npos);
  ForceConstraint c;
  c.shape = static_cast<ForceShape>(kForceShapes.size() + 1);
  EXPECT_NE(ReasonOf(One(c)).find("shape"), std::string::npos);
  c = {};
  c.stiffness_N_m = -1;
  EXPECT_NE(ReasonOf(One(c)).find("stiffness"), std::string::npos);
  c = {};
  c.direction_base = {0, 0, 1.1};
  EXPECT_NE(ReasonOf(One(c)).find("unit"), std::string::npos);
  c = {};
  c.shape = ForceShape::kSphere;
  EXPECT_NE(ReasonOf(One(c)).find("radius"), std::string::npos);
  c = {};
  c.angular_velocity_base_rad_s = {0, 0, 1e9};
  EXPECT_NE(ReasonOf(One(c)).find("velocity"), std::string::npos);
}

// Accepted messages are in range, whatever the bytes are.
TEST(ForceMessages, AcceptedRandomBytesAreInRange) {
  std::mt19937_64 random(31);
  const auto seeded = [](const auto& message) {
    std::vector<unsigned char> bytes(sizeof(message));
    std::memcpy(bytes.data(), &message, sizeof(message));
    return bytes;
  };
  ForceConstraints full;
  full.count = kMaxForceConstraints;
  ForceProperties properties;
  properties.available = 1;
  properties.reach_count = kMaxForceReach;
  const std::vector<std::vector<unsigned char>> seeds{seeded(ForceClaim{}), seeded(ForceApply{}), seeded(full),
                                                      seeded(ForceStop{}),  seeded(ForceOwner{}), seeded(properties)};
  const double nasty[] = {kNaN, std::numeric_limits<double>::infinity(), -1e300, -1, 1e7, 0};
  int accepted = 0;
  constexpr int kPackets = 60'000;
  for (int i = 0; i < kPackets; ++i) {
    std::vector<unsigned char> bytes = seeds[random() % seeds.size()];
    for (std::size_t k = random() % 3; k > 0; --k) {
      if (random() % 2 == 0) {
        bytes[random() % bytes.size()] = static_cast<unsigned char>(random());
      } else if (bytes.size() > 24) {
        const std::size_t at = 16 + 8 * (random() % ((bytes.size() - 16) / 8));
        std::memcpy(&bytes[at], &nasty[random() % 6], 8);
      }
    }
    const Message message = Validate(bytes.data(), bytes.size());
    accepted += message.index() != 0 ? 1 : 0;
    if (const auto* apply = std::get_if<ForceApply>(&message)) {
      ASSERT_TRUE(apply->duration_ns >= 1 && apply->duration_ns <= kLongestForce_ns);
      for (const double f : apply->force_base_N) ASSERT_TRUE(std::abs(f) <= kLargestForce_N);
    }
    if (const auto* set = std::get_if<ForceConstraints>(&message)) {
      ASSERT_LE(set->count, kMaxForceConstraints);
      for (std::uint32_t k = 0; k < set->count; ++k) {
        const ForceConstraint& c = set->constraints[k];
        ASSERT_TRUE(c.stiffness_N_m >= 0 && c.stiffness_N_m <= kLargestStiffness_N_m && c.damping_Ns_m >= 0);
        for (const double x : c.point_base_m) ASSERT_TRUE(std::abs(x) <= kFarthestConstraint_m);
      }
    }
    if (const auto* can = std::get_if<ForceProperties>(&message)) {
      ASSERT_TRUE(can->max_force_N >= 0 && can->reach_count <= kMaxForceReach);
    }
  }
  EXPECT_GT(accepted, kPackets / 10);
  EXPECT_LT(accepted, kPackets * 9 / 10);
}

}  // namespace test_protocol_force
}  // namespace omni::protocol
