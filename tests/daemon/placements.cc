// The service's record of where bases stand: kept, told, one for each headset.
#include <gtest/gtest.h>

#include <tuple>

#include "tests/daemon/placement_story.h"

namespace omni::daemon {
namespace test_daemon_placements {

TEST(DaemonPlacements, WhatIsStoredIsToldAtOnceAndAfterARestart) {
  const TempFolder temp;
  const std::string path = temp.Path("config/omni/alignments.toml");
  Listener listener;
  {
    Placements placements(path);
    placements.Ask(1, Request({kSpaceStage, kSpaceLocal}));
    listener.Listen(placements);
    ASSERT_EQ(listener.told[1].size(), 1U);
    EXPECT_EQ(listener.told[1][0].known, 0U);
    EXPECT_FALSE(placements.Aligned(1));
    const auto done = placements.Do(Store(kSpaceStage), kDate_s);
    ASSERT_TRUE(done.ok) << done.text;
    listener.Listen(placements);
    listener.Listen(placements);
    ASSERT_EQ(listener.told[1].size(), 2U) << "told once";
    EXPECT_TRUE(placements.Aligned(1));
  }
  Placements again(path);
  EXPECT_EQ(again.problem(), "");
  again.Ask(7, Request({kSpaceStage, kSpaceLocal}));
  listener.Listen(again);
  const protocol::Placement& placement = listener.told[7].back();
  EXPECT_EQ(placement.known, 1U);
  EXPECT_EQ(placement.space, kSpaceStage);
  EXPECT_EQ(placement.base_space.position_m[0], 0.1);
  EXPECT_NEAR(placement.expected_error_m, 0.9e-3, 1e-15);
  EXPECT_EQ(placement.measured_unix_s, kDate_s);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(placement.base_space.orientation_wxyz[i], listener.told[1].back().base_space.orientation_wxyz[i],
                1e-15);
  }
}

TEST(DaemonPlacements, TheFirstKnownSpaceOfTheHeadsetIsTheAnswer) {
  const TempFolder temp;
  Placements placements(temp.Path("a.toml"));
  ASSERT_TRUE(placements.Do(Store(kSpaceLocal, 0.2), kDate_s).ok);
  protocol::PlacementRequest other = Request({kSpaceStage, kSpaceLocal});
  other.headset = Headset("Monado(XRT)", "another headset");
  placements.Ask(1, Request({kSpaceStage, kSpaceLocal}));
  placements.Ask(2, other);
  placements.Ask(3, Request({kSpaceStage}));
  Listener listener;
  listener.Listen(placements);
  EXPECT_EQ(listener.told[1].back().space, kSpaceLocal);
  EXPECT_EQ(listener.told[2].back().known, 0U) << "an alignment belongs to the headset that it was made with";
  EXPECT_EQ(listener.told[3].back().known, 0U);
  ASSERT_TRUE(placements.Do(Store(kSpaceStage, 0.3), kDate_s).ok);
  listener.Listen(placements);
  EXPECT_EQ(listener.told[1].back().space, kSpaceStage);
  EXPECT_EQ(listener.told[1].back().base_space.position_m[0], 0.3);
}

// An update of the runtime is no other runtime: Monado puts its git tag into its name.
TEST(DaemonPlacements, AnAlignmentSurvivesAnUpdateOfTheRuntime) {
  const TempFolder temp;
  const std::string path = temp.Path("a.toml");
  const auto known_to = [&](const std::string& runtime) {
    Placements placements(path);
    protocol::PlacementRequest request = Request({kSpaceStage});
    request.headset = Headset(runtime);
    placements.Ask(1, request);
    Listener listener;
    listener.Listen(placements);
    return listener.told[1].back().known == 1;
  };
  protocol::PlacementCommand store = Store(kSpaceStage);
  store.headset = Headset("Monado(XRT) by Collabora et al '21.0.0-123-gabcdef'");
  {
    Placements placements(path);
    ASSERT_TRUE(placements.Do(store, kDate_s).ok);
  }
  EXPECT_TRUE(known_to("Monado(XRT) by Collabora et al '21.0.0-123-gabcdef'"));
  EXPECT_TRUE(known_to("Monado(XRT) by Collabora et al 'v25.1.0-7-g1234567'"));
  EXPECT_TRUE(known_to("Monado(XRT) by Collabora et al 'GIT-NOTFOUND'"));
  EXPECT_TRUE(known_to("Monado(XRT)")) << "as in docs/howto/align.md";
  EXPECT_FALSE(known_to("Pico(XRT) by Pico et al 'de86b93'"));
  EXPECT_FALSE(known_to("SteamVR/OpenXR"));
  Placements placements(path);
  store.headset = Headset("Monado(XRT) by Collabora et al 'v25.1.0-7-g1234567'");
  ASSERT_TRUE(placements.Do(store, kDate_s).ok);
  EXPECT_EQ(placements.file().entries.size(), 1U) << "measured again with the new build: it takes the old one's place";
}

// An older file, with an entry for every build that was ever aligned: the newest is the one that holds.
TEST(DaemonPlacements, OfSeveralBuildsOfARuntimeTheNewestAlignmentHolds) {
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
  Placements placements(path);
  protocol::PlacementRequest request = Request({kSpaceStage});
  request.headset = Headset("Monado(XRT) by Collabora et al 'v24.1.0'");
  placements.Ask(1, request);
  Listener listener;
  listener.Listen(placements);
  EXPECT_EQ(listener.told[1].back().base_space.position_m[0], 3.0);
  EXPECT_EQ(placements.file().entries.size(), 1U);
}

TEST(DaemonPlacements, ForgetOneOrAll) {
  const TempFolder temp;
  Placements placements(temp.Path("a.toml"));
  ASSERT_TRUE(placements.Do(Store(kSpaceStage), kDate_s).ok);
  ASSERT_TRUE(placements.Do(Store(kSpaceLocal), kDate_s).ok);
  protocol::PlacementCommand forget = Store(kSpaceStage);
  forget.action = protocol::PlacementAction::kForget;
  EXPECT_TRUE(placements.Do(forget, kDate_s).ok);
  ASSERT_EQ(placements.file().entries.size(), 1U);
  EXPECT_EQ(placements.file().entries[0].space, kSpaceLocal);
  EXPECT_FALSE(placements.Do(forget, kDate_s).ok) << "it is gone already";
  forget.headset = {};
  EXPECT_TRUE(placements.Do(forget, kDate_s).ok);
  EXPECT_TRUE(Placements(temp.Path("a.toml")).file().entries.empty());
}

TEST(DaemonPlacements, PolicyIsKeptAndTold) {
  const TempFolder temp;
  Placements placements(temp.Path("a.toml"));
  placements.Ask(1, Request({kSpaceLocal}));
  protocol::PlacementCommand policy;
  policy.action = protocol::PlacementAction::kPolicy;
  policy.uncalibrated = protocol::Uncalibrated::kOff;
  ASSERT_TRUE(placements.Do(policy, kDate_s).ok);
  Listener listener;
  listener.Listen(placements);
  EXPECT_EQ(listener.told[1].back().uncalibrated, protocol::Uncalibrated::kOff);
  EXPECT_EQ(Placements(temp.Path("a.toml")).file().uncalibrated, config::UncalibratedPolicy::kOff);
  ASSERT_TRUE(placements.Do(Store(kSpaceLocal), kDate_s).ok);
  EXPECT_FALSE(placements.Aligned(1)) << "the pen has no pose";
}

TEST(DaemonPlacements, SixtyFourHeadsetsAndNoMore) {
  const TempFolder temp;
  Placements placements(temp.Path("a.toml"));
  protocol::PlacementCommand command = Store(kSpaceLocal);
  for (std::size_t i = 0; i < config::kMaxAlignments; ++i) {
    command.headset = Headset("runtime " + std::to_string(i));
    ASSERT_TRUE(placements.Do(command, kDate_s).ok);
  }
  command.headset = Headset("one more");
  EXPECT_NE(placements.Do(command, kDate_s).text.find("the limit"), std::string::npos);
  EXPECT_EQ(Placements(temp.Path("a.toml")).file().entries.size(), config::kMaxAlignments);
}

}  // namespace test_daemon_placements
}  // namespace omni::daemon
