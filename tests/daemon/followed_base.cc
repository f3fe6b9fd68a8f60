// A base that something carries: whose poses count, what is published of them, and what applications are notified of.
#include "service/daemon/clients/followed_base.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/daemon/service.h"
#include "tests/daemon/base_pose_scenario.h"

namespace omni::daemon {
namespace test_daemon_followed_base {

using protocol::BaseMotion;
using protocol::BaseSample;
using protocol::BaseState;
using protocol::kBaseLeapt;
using protocol::kBaseSeen;

constexpr std::int64_t kMs_ns = 1'000'000;
constexpr ipc::ClientId kTool = 7, kOther = 8;

BaseMotion PoseAt(std::int64_t t_ns, double x_m = 0, BaseState state = BaseState::kSeen) {
  BaseMotion motion;
  motion.state = state;
  motion.t_ns = t_ns;
  motion.headset = Headset();
  motion.base_space.position_m = {x_m, 0.7, -0.5};
  return motion;
}

// The flags of what is published; -1: nothing is.
int FlagsOf(const std::optional<BaseSample>& sample) { return sample ? static_cast<int>(sample->flags) : -1; }

TEST(DaemonFollowedBase, PlausibleMotionIsPublishedAsItIs) {
  FollowedBase base;
  std::mt19937 random(5);
  std::uniform_real_distribution<> acceleration_m_s2(-20, 20);
  double x_m = 0, v_m_s = 0;
  for (std::int64_t t_ns = kNow_ns; t_ns < kNow_ns + 5000 * kMs_ns; t_ns += 11 * kMs_ns) {
    v_m_s = std::clamp(v_m_s + 0.011 * acceleration_m_s2(random), -3.0, 3.0);  // as fast as a person waves
    x_m += 0.011 * v_m_s;
    BaseMotion motion = PoseAt(t_ns, x_m);
    motion.linear_velocity_m_s = {v_m_s, 0, 0};
    motion.base_space.orientation_wxyz = {1.004, 0, 0, 0};
    const FollowedBase::Taken taken = base.HandleMotion(kTool, motion, t_ns + 2 * kMs_ns);
    ASSERT_EQ(FlagsOf(taken.sample), static_cast<int>(kBaseSeen));
    EXPECT_EQ(taken.sample->t_ns, t_ns);
    EXPECT_EQ(taken.sample->position_space_m[0], x_m);
    EXPECT_EQ(taken.sample->linear_velocity_space_m_s[0], v_m_s);
    EXPECT_NEAR(taken.sample->orientation_space_wxyz[0], 1, 1e-12);
  }
}

// A tracker that jumps 1 m: that pose is marked, without a velocity; the next ones hold there.
TEST(DaemonFollowedBase, LeapOfAMetreIsMarkedAndItsNewPlaceHolds) {
  FollowedBase base;
  std::int64_t t_ns = kNow_ns;
  const auto flags = [&](double x_m, double v_m_s = 0) {
    BaseMotion motion = PoseAt(t_ns += 11 * kMs_ns, x_m);
    motion.linear_velocity_m_s = {v_m_s, 0, 0};
    return FlagsOf(base.HandleMotion(kTool, motion, t_ns).sample);
  };
  constexpr int kSeen = kBaseSeen, kLeapt = kBaseSeen | kBaseLeapt;
  EXPECT_EQ(flags(0), kSeen);
  EXPECT_EQ(flags(0), kSeen);
  EXPECT_EQ(flags(1), kLeapt);
  EXPECT_EQ(flags(1.001), kSeen);
  EXPECT_EQ(flags(0), kLeapt) << "and back";
  EXPECT_EQ(flags(0, 90), kLeapt) << "a velocity that no base has";
  t_ns += 11 * kMs_ns;
  BaseMotion fast = PoseAt(t_ns, 1);
  fast.linear_velocity_m_s = {2, 0, 0};
  EXPECT_EQ(base.HandleMotion(kTool, fast, t_ns).sample->linear_velocity_space_m_s[0], 0)
      << "where it went to, not how";
  t_ns += 11 * kMs_ns;
  BaseMotion turned = PoseAt(t_ns, 1);
  turned.base_space.orientation_wxyz = {0, 1, 0, 0};
  EXPECT_EQ(FlagsOf(base.HandleMotion(kTool, turned, t_ns).sample), kLeapt) << "turned by 180 degrees";
  t_ns += 11 * kMs_ns;
  turned.t_ns = t_ns;
  turned.space = kSpaceStage;
  EXPECT_EQ(FlagsOf(base.HandleMotion(kTool, turned, t_ns).sample), kLeapt) << "in another space";
}

TEST(DaemonFollowedBase, LostSourceLeavesTheLastPoseUnseen) {
  FollowedBase base;
  EXPECT_EQ(FlagsOf(base.HandleMotion(kTool, PoseAt(kNow_ns, 0, BaseState::kLost), kNow_ns).sample), -1)
      << "no pose yet";
  EXPECT_TRUE(base.headset().has_value()) << "but where it was measured holds no longer";
  base.HandleMotion(kTool, PoseAt(kNow_ns, 0.3), kNow_ns);
  const auto lost =
      base.HandleMotion(kTool, PoseAt(kNow_ns + 9 * kMs_ns, 5, BaseState::kLost), kNow_ns + 10 * kMs_ns).sample;
  ASSERT_EQ(FlagsOf(lost), 0);
  EXPECT_EQ(lost->position_space_m[0], 0.3);
  EXPECT_EQ(lost->t_ns, kNow_ns + 10 * kMs_ns) << "at once";
  EXPECT_EQ(FlagsOf(base.HandleMotion(kTool, PoseAt(0, 0, BaseState::kLost), kNow_ns + 20 * kMs_ns).sample), -1)
      << "known";
  EXPECT_EQ(FlagsOf(base.HandleMotion(kTool, PoseAt(kNow_ns + 30 * kMs_ns, 0.31), kNow_ns + 30 * kMs_ns).sample),
            static_cast<int>(kBaseSeen))
      << "it is back";
  EXPECT_EQ(FlagsOf(base.Remove(kOther, kNow_ns)), -1);
  EXPECT_EQ(FlagsOf(base.Remove(kTool, kNow_ns + 31 * kMs_ns)), 0) << "its process ended";
  EXPECT_TRUE(base.headset().has_value());
}

TEST(DaemonFollowedBase, OnePoseOutOfTimeOrOrderIsNotUsed) {
  FollowedBase base;
  EXPECT_EQ(FlagsOf(base.HandleMotion(kTool, PoseAt(kNow_ns, 0.1), kNow_ns).sample), static_cast<int>(kBaseSeen));
  EXPECT_EQ(FlagsOf(base.HandleMotion(kTool, PoseAt(kNow_ns, 0.1), kNow_ns).sample), -1) << "the same again";
  EXPECT_EQ(FlagsOf(base.HandleMotion(kTool, PoseAt(kNow_ns - kMs_ns), kNow_ns).sample), -1) << "older";
  for (const std::int64_t off_ns : {-FollowedBase::kOldest_ns - 1, FollowedBase::kLatest_ns + 1}) {
    FollowedBase other;
    const auto pose = PoseAt(kNow_ns + off_ns);
    const FollowedBase::Taken taken = other.HandleMotion(kTool, pose, kNow_ns);
    EXPECT_EQ(FlagsOf(taken.sample), -1) << off_ns;
    EXPECT_NE(taken.problem, nullptr);
    EXPECT_EQ(other.HandleMotion(kTool, pose, kNow_ns).problem, nullptr) << "said once";
  }
}

TEST(DaemonFollowedBase, SecondSourceWaitsUntilTheFirstIsGoneOrSilent) {
  FollowedBase base;
  base.HandleMotion(kTool, PoseAt(kNow_ns), kNow_ns);
  const FollowedBase::Taken refused = base.HandleMotion(kOther, PoseAt(kNow_ns + kMs_ns, 2), kNow_ns + kMs_ns);
  EXPECT_EQ(FlagsOf(refused.sample), -1);
  EXPECT_NE(refused.problem, nullptr);
  const std::int64_t later_ns = kNow_ns + FollowedBase::kHandOver_ns;
  EXPECT_NE(FlagsOf(base.HandleMotion(kOther, PoseAt(later_ns), later_ns).sample), -1) << "the first is silent";
  base.Remove(kOther, later_ns);
  EXPECT_NE(FlagsOf(base.HandleMotion(kTool, PoseAt(later_ns + 2), later_ns + 2).sample), -1);
}

// Applications of that headset, and no others, are notified that their base moves, and that it no longer does.
TEST(DaemonFollowedBase, ApplicationsOfThatHeadsetAreNotified) {
  const TempFolder temp;
  BasePoses base_poses(temp.Path("a.toml"));
  base_poses.HandleRequest(1, Request({kSpaceLocal}), kDate_s);
  protocol::BasePoseRequest elsewhere = Request({kSpaceLocal});
  elsewhere.headset = Headset("another runtime");
  base_poses.HandleRequest(2, elsewhere, kDate_s);
  Listener listener;
  const auto follows = [&](ipc::ClientId id) {
    listener.Listen(base_poses);
    return listener.reported[id].back().follows;
  };
  EXPECT_EQ(follows(1), 0U);
  FollowedBase base;
  for (int i = 0; i < 3; ++i) {
    base.HandleMotion(kTool, PoseAt(kNow_ns + i * kMs_ns), kNow_ns + i * kMs_ns);
    base_poses.SetFollowed(base.headset(), base.seen());
  }
  EXPECT_EQ(follows(1), 1U);
  EXPECT_EQ(follows(2), 0U);
  EXPECT_EQ(listener.reported[1].size(), 2U) << "not with every pose";
  EXPECT_TRUE(base_poses.IsAligned(1));
  EXPECT_FALSE(base_poses.IsAligned(2));
  base.HandleMotion(kTool, PoseAt(0, 0, BaseState::kStands), kNow_ns + 9 * kMs_ns);
  base_poses.SetFollowed(base.headset(), base.seen());
  EXPECT_EQ(follows(1), 0U);
}

// A base that was mounted on something follows it from omnid's start on, though nothing reports it yet.
TEST(DaemonFollowedBase, MountedBaseFollowsFromTheStart) {
  const FollowedBase base(true);
  const TempFolder temp;
  BasePoses base_poses(temp.Path("a.toml"));
  base_poses.SetFollowed(base.headset(), base.seen());
  base_poses.HandleRequest(1, Request({kSpaceLocal}), kDate_s);
  Listener listener;
  listener.Listen(base_poses);
  EXPECT_EQ(listener.reported[1].back().follows, 1U);
  EXPECT_FALSE(base_poses.IsAligned(1)) << "it is not known where it is";
}

// A base that moves turns in the earth's field on purpose.
TEST(DaemonFollowedBase, FieldDoesNotMakeItsAlignmentDoubtful) {
  constexpr base::Vec3 kNorth_T{20e-6, 0, -42e-6}, kSouth_T{-20e-6, 0, -42e-6};
  const TempFolder temp;
  BasePoses base_poses(temp.Path("a.toml"));
  base_poses.HandleRequest(1, Request({kSpaceLocal}), kDate_s);
  ASSERT_TRUE(base_poses.Execute(Store(kSpaceLocal), kDate_s).ok);
  const auto feel = [&](const base::Vec3& field_T) {
    for (int i = 0; i < 2 * BasePoses::kSteady_s; ++i) base_poses.UpdateField(field_T);
  };
  feel(kNorth_T);
  base_poses.SetFollowed(Headset(), true);
  feel(kSouth_T);
  EXPECT_FALSE(base_poses.file().entries[0].base_moved);
  base_poses.SetFollowed({}, false);
  feel(kSouth_T);
  EXPECT_TRUE(base_poses.file().entries[0].base_moved) << "it stands, and not as it did";
}

// Through the service: poses of a tool are published, and its end is.
TEST(DaemonFollowedBase, ServicePublishesPosesAndTheEndOfTheirSource) {
  const TempFolder temp;
  std::vector<BaseSample> published;
  Service service({.version = "test",
                   .instance = 1,
                   .hull_radius_m = 0.0375,
                   .alignment_path = temp.Path("a.toml"),
                   .on_base = [&](const BaseSample& sample) { published.push_back(sample); }});
  service.OnClient({.id = kTool, .role = protocol::ClientRole::kTool, .pid = 1, .application = "arm", .engine = ""});
  service.OnRequest(kTool, PoseAt(base::MonotonicNow_ns(), 0.2), {});
  ASSERT_EQ(published.size(), 1U);
  EXPECT_EQ(published[0].position_space_m[0], 0.2);
  service.OnRequest(kTool, PoseAt(1, 0.2), {});
  EXPECT_NE(service.StatusJson().find("1 s late"), std::string::npos);
  service.OnRequest(kTool, PoseAt(base::MonotonicNow_ns(), 0.2), {});
  service.OnGone(kTool);
  EXPECT_EQ(published.back().flags, 0U);
  EXPECT_NE(service.StatusJson().find("omni follow"), std::string::npos) << "says what to do";
}

}  // namespace test_daemon_followed_base
}  // namespace omni::daemon
