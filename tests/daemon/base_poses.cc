// The service's record of where bases stand: stored, sent to clients, one per headset.
#include <gtest/gtest.h>

#include <tuple>

#include "tests/daemon/base_pose_scenario.h"

namespace omni::daemon {
namespace test_daemon_base_poses {

TEST(DaemonBasePoses, StoredBasePoseIsSentAtOnceAndAfterARestart) {
  const TempFolder temp;
  const std::string path = temp.Path("config/omni/alignments.toml");
  Listener listener;
  {
    BasePoses base_poses(path);
    base_poses.HandleRequest(1, Request({kSpaceStage, kSpaceLocal}), kDate_s);
    listener.Listen(base_poses);
    ASSERT_EQ(listener.reported[1].size(), 1U);
    EXPECT_EQ(listener.reported[1][0].known, 0U);
    EXPECT_FALSE(base_poses.IsAligned(1));
    const auto done = base_poses.Execute(Store(kSpaceStage), kDate_s);
    ASSERT_TRUE(done.ok) << done.text;
    listener.Listen(base_poses);
    listener.Listen(base_poses);
    ASSERT_EQ(listener.reported[1].size(), 2U) << "sent once";
    EXPECT_TRUE(base_poses.IsAligned(1));
  }
  BasePoses again(path);
  EXPECT_EQ(again.problem(), "");
  again.HandleRequest(7, Request({kSpaceStage, kSpaceLocal}), kDate_s);
  listener.Listen(again);
  const protocol::BasePose& base_pose = listener.reported[7].back();
  EXPECT_EQ(base_pose.known, 1U);
  EXPECT_EQ(base_pose.space, kSpaceStage);
  EXPECT_EQ(base_pose.base_space.position_m[0], 0.1);
  EXPECT_NEAR(base_pose.expected_error_m, 0.9e-3, 1e-15);
  EXPECT_EQ(base_pose.measured_unix_s, kDate_s);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(base_pose.base_space.orientation_wxyz[i], listener.reported[1].back().base_space.orientation_wxyz[i],
                1e-15);
  }
}

TEST(DaemonBasePoses, AnswersWithTheFirstKnownSpaceOfTheHeadset) {
  const TempFolder temp;
  BasePoses base_poses(temp.Path("a.toml"));
  ASSERT_TRUE(base_poses.Execute(Store(kSpaceLocal, 0.2), kDate_s).ok);
  protocol::BasePoseRequest other = Request({kSpaceStage, kSpaceLocal});
  other.headset = Headset("Monado(XRT)", "another headset");
  base_poses.HandleRequest(1, Request({kSpaceStage, kSpaceLocal}), kDate_s);
  base_poses.HandleRequest(2, other, kDate_s);
  base_poses.HandleRequest(3, Request({kSpaceStage}), kDate_s);
  Listener listener;
  listener.Listen(base_poses);
  EXPECT_EQ(listener.reported[1].back().space, kSpaceLocal);
  EXPECT_EQ(listener.reported[2].back().known, 0U) << "an alignment belongs to the headset that it was made with";
  EXPECT_EQ(listener.reported[3].back().known, 0U);
  ASSERT_TRUE(base_poses.Execute(Store(kSpaceStage, 0.3), kDate_s).ok);
  listener.Listen(base_poses);
  EXPECT_EQ(listener.reported[1].back().space, kSpaceStage);
  EXPECT_EQ(listener.reported[1].back().base_space.position_m[0], 0.3);
}

// An updated runtime is not another runtime: Monado puts its git tag into its name.
TEST(DaemonBasePoses, AlignmentSurvivesARuntimeUpdate) {
  const TempFolder temp;
  const std::string path = temp.Path("a.toml");
  const auto known_to = [&](const std::string& runtime) {
    BasePoses base_poses(path);
    protocol::BasePoseRequest request = Request({kSpaceStage});
    request.headset = Headset(runtime);
    base_poses.HandleRequest(1, request, kDate_s);
    Listener listener;
    listener.Listen(base_poses);
    return listener.reported[1].back().known == 1;
  };
  protocol::BasePoseCommand store = Store(kSpaceStage);
  store.headset = Headset("Monado(XRT) by Collabora et al '21.0.0-123-gabcdef'");
  {
    BasePoses base_poses(path);
    ASSERT_TRUE(base_poses.Execute(store, kDate_s).ok);
  }
  EXPECT_TRUE(known_to("Monado(XRT) by Collabora et al '21.0.0-123-gabcdef'"));
  EXPECT_TRUE(known_to("Monado(XRT) by Collabora et al 'v25.1.0-7-g1234567'"));
  EXPECT_TRUE(known_to("Monado(XRT) by Collabora et al 'GIT-NOTFOUND'"));
  EXPECT_TRUE(known_to("Monado(XRT)")) << "as in docs/howto/align.md";
  EXPECT_FALSE(known_to("Pico(XRT) by Pico et al 'de86b93'"));
  EXPECT_FALSE(known_to("SteamVR/OpenXR"));
  BasePoses base_poses(path);
  store.headset = Headset("Monado(XRT) by Collabora et al 'v25.1.0-7-g1234567'");
  ASSERT_TRUE(base_poses.Execute(store, kDate_s).ok);
  EXPECT_EQ(base_poses.file().entries.size(), 1U) << "measured again with the new build: it takes the old one's place";
}

// An older file, with an entry for every build that was ever aligned: the newest one is used.
TEST(DaemonBasePoses, NewestAlignmentOfSeveralRuntimeBuildsIsUsed) {
  const TempFolder temp;
  config::AlignmentFile file;
  for (const auto& [build, date, x] :
       {std::tuple{"'v24.0.0'", "2026-03-01T10:00:00Z", 1.0}, std::tuple{"'v25.0.0'", "2026-09-01T10:00:00Z", 3.0},
        std::tuple{"'v24.1.0'", "2026-06-01T10:00:00Z", 2.0}}) {
    file.entries.push_back({.runtime = std::string("Monado(XRT) by Collabora et al ") + build,
                            .system = "A \"quoted\" \\ HMD",
                            .space = kSpaceStage,
                            .orientation_space = {1, 0, 0, 0},
                            .position_space_m = {x, 0, 0},
                            .method = "touch",
                            .date = date});
  }
  const std::string path = temp.Write("a.toml", config::WriteAlignments(file));
  BasePoses base_poses(path);
  protocol::BasePoseRequest request = Request({kSpaceStage});
  request.headset = Headset("Monado(XRT) by Collabora et al 'v24.1.0'");
  base_poses.HandleRequest(1, request, kDate_s);
  Listener listener;
  listener.Listen(base_poses);
  EXPECT_EQ(listener.reported[1].back().base_space.position_m[0], 3.0);
  EXPECT_EQ(base_poses.file().entries.size(), 1U);
}

TEST(DaemonBasePoses, ForgetsOneAlignmentOrAll) {
  const TempFolder temp;
  BasePoses base_poses(temp.Path("a.toml"));
  ASSERT_TRUE(base_poses.Execute(Store(kSpaceStage), kDate_s).ok);
  ASSERT_TRUE(base_poses.Execute(Store(kSpaceLocal), kDate_s).ok);
  protocol::BasePoseCommand forget = Store(kSpaceStage);
  forget.action = protocol::BasePoseAction::kForget;
  EXPECT_TRUE(base_poses.Execute(forget, kDate_s).ok);
  ASSERT_EQ(base_poses.file().entries.size(), 1U);
  EXPECT_EQ(base_poses.file().entries[0].space, kSpaceLocal);
  EXPECT_FALSE(base_poses.Execute(forget, kDate_s).ok) << "it is gone already";
  forget.headset = {};
  EXPECT_TRUE(base_poses.Execute(forget, kDate_s).ok);
  EXPECT_TRUE(BasePoses(temp.Path("a.toml")).file().entries.empty());
}

TEST(DaemonBasePoses, PolicyIsStoredAndSent) {
  const TempFolder temp;
  BasePoses base_poses(temp.Path("a.toml"));
  base_poses.HandleRequest(1, Request({kSpaceLocal}), kDate_s);
  protocol::BasePoseCommand policy;
  policy.action = protocol::BasePoseAction::kPolicy;
  policy.uncalibrated = protocol::Uncalibrated::kOff;
  ASSERT_TRUE(base_poses.Execute(policy, kDate_s).ok);
  Listener listener;
  listener.Listen(base_poses);
  EXPECT_EQ(listener.reported[1].back().uncalibrated, protocol::Uncalibrated::kOff);
  EXPECT_EQ(BasePoses(temp.Path("a.toml")).file().uncalibrated, config::UncalibratedPolicy::kOff);
  ASSERT_TRUE(base_poses.Execute(Store(kSpaceLocal), kDate_s).ok);
  EXPECT_FALSE(base_poses.IsAligned(1)) << "the pen has no pose";
}

TEST(DaemonBasePoses, RejectsMoreThan64Alignments) {
  const TempFolder temp;
  BasePoses base_poses(temp.Path("a.toml"));
  protocol::BasePoseCommand command = Store(kSpaceLocal);
  for (std::size_t i = 0; i < config::kMaxAlignments; ++i) {
    command.headset = Headset("runtime " + std::to_string(i));
    ASSERT_TRUE(base_poses.Execute(command, kDate_s).ok);
  }
  command.headset = Headset("one more");
  EXPECT_NE(base_poses.Execute(command, kDate_s).text.find("the limit"), std::string::npos);
  EXPECT_EQ(BasePoses(temp.Path("a.toml")).file().entries.size(), config::kMaxAlignments);
}

}  // namespace test_daemon_base_poses
}  // namespace omni::daemon
