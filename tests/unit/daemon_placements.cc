// The service's record of where bases stand: kept, told, followed; a file that is not ours to lose.
#include "service/daemon/placements.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <sstream>
#include <tuple>

#include <nlohmann/json.hpp>

#include "service/alignment/rigid.h"
#include "service/base/clock.h"
#include "service/daemon/placement_writer.h"
#include "service/daemon/service.h"
#include "service/protocol/text.h"
#include "tests/support/temp_folder.h"

namespace omni::daemon {
namespace {

using protocol::kSpaceLocal;
using protocol::kSpaceStage;

protocol::HeadsetNames Headset(const std::string& runtime = "Monado(XRT)",
                               const std::string& system = "A \"quoted\" \\ HMD") {
  protocol::HeadsetNames names;
  protocol::SetField(names.runtime, runtime);
  protocol::SetField(names.system, system);
  return names;
}

protocol::PlacementRequest Request(std::initializer_list<std::int32_t> spaces) {
  protocol::PlacementRequest request;
  request.headset = Headset();
  for (const std::int32_t space : spaces) request.spaces[request.space_count++] = space;
  return request;
}

protocol::PlacementCommand Store(std::int32_t space, double x = 0.1) {
  protocol::PlacementCommand command;
  command.headset = Headset();
  command.space = space;
  command.base_space = {.position_m = {x, 0.7, -0.5}, .orientation_wxyz = {0.6, -0.6, 0.4, 0.346410161513775}};
  command.rms_m = 1.1e-3;
  command.expected_error_m = 0.9e-3;
  command.samples = 5;
  protocol::SetField(command.method, "touch");
  return command;
}

std::string Read(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

struct Listener {
  std::map<ipc::ClientId, std::vector<protocol::Placement>> told;
  void Listen(Placements& placements) {
    placements.Tell([this](ipc::ClientId id, const protocol::Placement& placement) {
      told[id].push_back(placement);
      return true;
    });
  }
};

constexpr std::int64_t kNow_ns = 4'900'000'000;
constexpr std::int64_t kDate_s = 1'790'000'000;

TEST(DaemonPlacements, WhatIsStoredIsToldAtOnceAndAfterARestart) {
  const test::TempFolder temp;
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
  const test::TempFolder temp;
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

alignment::Rigid PoseOf(const protocol::PlacementPose& pose) {
  const auto& q = pose.orientation_wxyz;
  const auto& p = pose.position_m;
  return {.orientation = {q[0], q[1], q[2], q[3]}, .position_m = {p[0], p[1], p[2]}};
}

// The base does not move in the world: X_WL X_LB before is X_WL' X_L'B after, for any recentring; once for all clients.
TEST(DaemonPlacements, RecentringIsFollowedOnceHoweverManyTell) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 50; ++i) {
    const test::TempFolder temp;
    const std::string path = temp.Path("a.toml");
    Placements placements(path);
    ASSERT_TRUE(placements.Do(Store(kSpaceLocal), kDate_s).ok);
    for (const ipc::ClientId id : {1, 2}) placements.Ask(id, Request({kSpaceLocal}));
    Listener listener;
    listener.Listen(placements);
    const alignment::Rigid before = PoseOf(listener.told[1].back().base_space);
    protocol::SpaceChange change;
    change.pose_valid = 1;
    change.changes_at_ns = 5'000'000'000;
    const double half_yaw = 3 * any(random);  // these spaces have gravity along -y: they are turned about y only
    change.new_in_previous = {.position_m = {any(random), any(random), any(random)},
                              .orientation_wxyz = {std::cos(half_yaw), 0, std::sin(half_yaw), 0}};
    placements.Change(1, change, kNow_ns);
    change.changes_at_ns += 3'000'000;  // another application's idea of the same time
    placements.Change(2, change, kNow_ns);
    listener.Listen(placements);
    EXPECT_EQ(listener.told[1].size(), 1U) << "they know";
    Placements again(path);
    again.Ask(3, Request({kSpaceLocal}));
    listener.Listen(again);
    const alignment::Rigid after = PoseOf(listener.told[3].back().base_space);
    const alignment::Rigid in_previous = alignment::Compose(PoseOf(change.new_in_previous), after);
    EXPECT_LT(alignment::Distance_m(in_previous, before, {0.1, 0.1, 0.1}), 1e-12);
    EXPECT_LT(alignment::Angle_rad(in_previous, before), 1e-7);
    EXPECT_EQ(again.file().entries[0].recentred, 1);
    change.changes_at_ns += 2'000'000'000;
    placements.Change(2, change, kNow_ns);
    EXPECT_EQ(placements.file().entries[0].recentred, 2) << "a second one, later";
  }
}

// An update of the runtime is no other runtime: Monado puts its git tag into its name.
TEST(DaemonPlacements, AnAlignmentSurvivesAnUpdateOfTheRuntime) {
  const test::TempFolder temp;
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
  const test::TempFolder temp;
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

protocol::SpaceChange Moved(double x, std::int64_t changes_at_ns) {
  protocol::SpaceChange change;
  change.pose_valid = 1;
  change.changes_at_ns = changes_at_ns;
  change.new_in_previous.position_m = {x, 0, 0};
  return change;
}

// Nobody recentres a headset by 20 m: what an application says of that costs TRACKED, and moves nothing.
TEST(DaemonPlacements, WhatNoRecentringDoesMovesNothing) {
  const test::TempFolder temp;
  Placements placements(temp.Path("a.toml"));
  ASSERT_TRUE(placements.Do(Store(kSpaceLocal), kDate_s).ok);
  placements.Ask(1, Request({kSpaceLocal}));
  Listener listener;
  listener.Listen(placements);
  for (int i = 1; i <= 5; ++i) {
    const std::int64_t now_ns = kNow_ns + i * std::int64_t{1'000'000'000};
    placements.Change(1, Moved(20, now_ns), now_ns);
  }
  const double moved_m = std::abs(Placements(temp.Path("a.toml")).file().entries[0].position_space_m.x - 0.1);
  std::printf("[ figure   ] five changes of 20 m have moved the alignment by %.1f m\n", moved_m);
  EXPECT_EQ(moved_m, 0);
  EXPECT_FALSE(placements.Aligned(1));
  listener.Listen(placements);
  EXPECT_EQ(listener.told[1].back().doubtful, 1U) << "who is connected hears of it";
  placements.Change(1, Moved(1, kNow_ns + 5'000'000'000), kNow_ns + 5'000'000'000);
  EXPECT_EQ(placements.file().entries[0].recentred, 1) << "it hides no real recentring at the same time";
}

// The bound holds against the pose as measured: many steps lead no further than one.
TEST(DaemonPlacements, ManyStepsLeadNoFurtherThanOne) {
  const test::TempFolder temp;
  Placements placements(temp.Path("a.toml"));
  ASSERT_TRUE(placements.Do(Store(kSpaceLocal), kDate_s).ok);
  placements.Ask(1, Request({kSpaceLocal}));
  std::int64_t now_ns = kNow_ns;
  for (int i = 0; i < 40; ++i) {
    now_ns += 1'000'000'000;
    placements.Change(1, Moved(-0.9, now_ns), now_ns);
  }
  const config::AlignmentEntry& entry = placements.file().entries[0];
  EXPECT_LE(entry.position_space_m.x - entry.measured_position_space_m.x, protocol::kFarthestRecentring_m);
  EXPECT_TRUE(entry.doubtful);
}

// A space that tips over is none that OpenXR has.
TEST(DaemonPlacements, ATiltIsNoRecentring) {
  const auto doubtful_after = [](double angle_rad) {
    const test::TempFolder temp;
    Placements placements(temp.Path("a.toml"));
    EXPECT_TRUE(placements.Do(Store(kSpaceLocal), kDate_s).ok);
    placements.Ask(1, Request({kSpaceLocal}));
    protocol::SpaceChange change = Moved(0, kNow_ns);
    change.new_in_previous.orientation_wxyz = {std::cos(angle_rad / 2), 0, 0, std::sin(angle_rad / 2)};
    placements.Change(1, change, kNow_ns);
    return placements.file().entries[0].doubtful;
  };
  EXPECT_FALSE(doubtful_after(0.9 * protocol::kMostRecentringTilt_rad));
  EXPECT_TRUE(doubtful_after(1.1 * protocol::kMostRecentringTilt_rad));
}

TEST(DaemonPlacements, TheMeasuredPoseComesBack) {
  const test::TempFolder temp;
  const std::string path = temp.Path("a.toml");
  protocol::PlacementCommand restore = Store(kSpaceLocal);
  restore.action = protocol::PlacementAction::kRestore;
  {
    Placements placements(path);
    EXPECT_FALSE(placements.Do(restore, kDate_s).ok) << "there is none";
    ASSERT_TRUE(placements.Do(Store(kSpaceLocal), kDate_s).ok);
    EXPECT_FALSE(placements.Do(restore, kDate_s).ok) << "it has not moved";
    placements.Ask(1, Request({kSpaceLocal}));
    placements.Change(1, Moved(3, kNow_ns), kNow_ns);
    placements.Change(1, Moved(50, kNow_ns + 1'000'000'000), kNow_ns + 1'000'000'000);
    EXPECT_NEAR(placements.file().entries[0].position_space_m.x, -2.9, 1e-12);
    EXPECT_FALSE(placements.Aligned(1));
  }
  Placements placements(path);
  placements.Ask(1, Request({kSpaceLocal}));
  Listener listener;
  listener.Listen(placements);
  ASSERT_TRUE(placements.Do(restore, kDate_s).ok);
  EXPECT_TRUE(placements.Aligned(1));
  listener.Listen(placements);
  EXPECT_EQ(listener.told[1].back().base_space.position_m[0], 0.1) << "who is connected hears of it";
  const config::AlignmentEntry entry = Placements(path).file().entries[0];
  EXPECT_EQ(entry.position_space_m.x, 0.1);
  EXPECT_EQ(entry.recentred, 0);
  EXPECT_FALSE(entry.doubtful);
}

TEST(DaemonPlacements, AChangeToNobodyKnowsWhereLeavesItDoubtful) {
  const test::TempFolder temp;
  Placements placements(temp.Path("a.toml"));
  ASSERT_TRUE(placements.Do(Store(kSpaceLocal), kDate_s).ok);
  placements.Ask(1, Request({kSpaceLocal}));
  protocol::SpaceChange change;
  change.changes_at_ns = 1;
  placements.Change(1, change, kNow_ns);
  EXPECT_FALSE(placements.Aligned(1));
  Placements again(temp.Path("a.toml"));
  again.Ask(2, Request({kSpaceLocal}));
  Listener listener;
  listener.Listen(again);
  EXPECT_EQ(listener.told[2].back().known, 1U);
  EXPECT_EQ(listener.told[2].back().doubtful, 1U);
  ASSERT_TRUE(again.Do(Store(kSpaceLocal), kDate_s).ok);
  EXPECT_TRUE(again.Aligned(2)) << "measured anew";
}

TEST(DaemonPlacements, OfOtherSpacesAndStrangersNothingFollows) {
  const test::TempFolder temp;
  Placements placements(temp.Path("a.toml"));
  ASSERT_TRUE(placements.Do(Store(kSpaceStage), kDate_s).ok);
  placements.Ask(1, Request({kSpaceStage, kSpaceLocal}));
  protocol::SpaceChange change;
  change.pose_valid = 1;
  change.changes_at_ns = 1;
  change.new_in_previous.position_m = {1, 2, 3};
  placements.Change(1, change, kNow_ns);   // LOCAL
  placements.Change(99, change, kNow_ns);  // never asked
  EXPECT_EQ(placements.file().entries[0].recentred, 0);
  EXPECT_EQ(placements.file().entries[0].position_space_m.x, 0.1);
}

TEST(DaemonPlacements, ATimeInTheFarFutureHidesNoLaterChange) {
  const test::TempFolder temp;
  Placements placements(temp.Path("a.toml"));
  ASSERT_TRUE(placements.Do(Store(kSpaceLocal), kDate_s).ok);
  placements.Ask(1, Request({kSpaceLocal}));
  protocol::SpaceChange change;
  change.pose_valid = 1;
  change.changes_at_ns = std::numeric_limits<std::int64_t>::max();
  placements.Change(1, change, kNow_ns);
  change.changes_at_ns = kNow_ns + 30'000'000'000;
  placements.Change(1, change, kNow_ns + 30'000'000'000);
  EXPECT_EQ(placements.file().entries[0].recentred, 2);
}

TEST(DaemonPlacements, ForgetOneOrAll) {
  const test::TempFolder temp;
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
  const test::TempFolder temp;
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

// Garbage is named, by file and key, and never written over.
TEST(DaemonPlacements, AFileThatCannotBeReadIsLeftAlone) {
  const test::TempFolder temp;
  const std::string good = [&] {
    Placements placements(temp.Path("good.toml"));
    EXPECT_TRUE(placements.Do(Store(kSpaceLocal), kDate_s).ok);
    return Read(temp.Path("good.toml"));
  }();
  const auto broken = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::pair<std::string, std::string> cases[] = {
      {"\x01\x02 garbage", "TOML syntax"},
      {broken("format = 1", "format = 2"), "format = 2 is not known"},
      {broken("space = 2", "space = \"x\""), "alignments[0].space"},
      {broken("[0.10000000000000001", "[nan"), "alignments[0].position_space_m[0]"},
      {broken("rms_mm", "rms"), "alignments[0].rms_mm is missing"},
      {broken("wxyz = [", "wxyz = [0.9, 0.9, 0.9, 0.9] # "), "unit quaternion"}};
  for (const auto& [text, says] : cases) {
    const std::string path = temp.Write("bad.toml", text);
    Placements placements(path);
    EXPECT_NE(placements.problem().find("bad.toml"), std::string::npos);
    EXPECT_NE(placements.problem().find(says), std::string::npos) << placements.problem();
    const auto done = placements.Do(Store(kSpaceStage), kDate_s);
    EXPECT_FALSE(done.ok);
    EXPECT_NE(done.text.find("move it away"), std::string::npos) << done.text;
    protocol::PlacementCommand forget;
    forget.action = protocol::PlacementAction::kForget;
    EXPECT_FALSE(placements.Do(forget, kDate_s).ok);
    EXPECT_EQ(Read(path), text);
  }
}

TEST(DaemonPlacements, WhatCannotBeWrittenIsNotPretended) {
  const test::TempFolder temp;
  temp.Write("file", "");
  Placements placements(temp.Path("file/alignments.toml"));
  const auto done = placements.Do(Store(kSpaceLocal), kDate_s);
  EXPECT_FALSE(done.ok);
  EXPECT_TRUE(placements.file().entries.empty());
  Placements homeless("");
  EXPECT_NE(homeless.Do(Store(kSpaceLocal), kDate_s).text.find("XDG_CONFIG_HOME"), std::string::npos);
}

TEST(DaemonPlacements, SixtyFourHeadsetsAndNoMore) {
  const test::TempFolder temp;
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

// An answer says what has become of the file; only a refusal comes at once.
TEST(DaemonPlacements, AnAnswerComesWhenTheFileIsWritten) {
  const test::TempFolder temp;
  const std::string path = temp.Path("a.toml");
  struct Answer {
    std::uint32_t number;
    bool done;
    std::string text;
  };
  std::vector<Answer> answers;
  PlacementWriter writer([&](ipc::ClientId, std::uint32_t number, bool done, const std::string& text) {
    answers.push_back({number, done, text});
  });
  Placements placements(path, writer.write());
  const auto execute = [&](std::uint32_t number, const protocol::PlacementCommand& command) {
    writer.Answer(1, number, placements.Do(command, kDate_s));
  };
  const auto take = [&](std::size_t count) {
    while (answers.size() < count) writer.TakeWritten(placements);
  };
  execute(1, Store(kSpaceLocal));
  EXPECT_TRUE(answers.empty());
  EXPECT_EQ(placements.file().entries.size(), 1U) << "in use at once";
  protocol::PlacementCommand forget = Store(kSpaceStage);
  forget.action = protocol::PlacementAction::kForget;
  execute(2, forget);
  ASSERT_EQ(answers.size(), 1U) << "nothing to wait for: no such alignment is stored";
  EXPECT_FALSE(answers[0].done);
  take(2);
  EXPECT_TRUE(answers[1].done && answers[1].number == 1);
  EXPECT_EQ(Placements(path).file().entries.size(), 1U);

  std::filesystem::remove(path);
  std::filesystem::create_directory(path);
  execute(3, Store(kSpaceStage));
  take(3);
  EXPECT_FALSE(answers[2].done);
  EXPECT_NE(answers[2].text.find("a.toml: cannot be written: it is a folder"), std::string::npos) << answers[2].text;
  EXPECT_NE(placements.problem().find("it is a folder"), std::string::npos);
  std::filesystem::remove(path);
  execute(4, Store(kSpaceStage));
  take(4);
  EXPECT_TRUE(answers[3].done);
  EXPECT_EQ(placements.problem(), "");
  EXPECT_EQ(Placements(path).file().entries.size(), 2U);
}

// The flag of every sample and the status are about the headset of whoever owns the force.
TEST(DaemonPlacements, TheServiceSaysWhetherTheOwnerIsAligned) {
  const test::TempFolder temp;
  bool aligned = false;
  Service service({.version = "test",
                   .instance = 1,
                   .hull_radius_m = 0.0375,
                   .alignment_path = temp.Path("a.toml"),
                   .on_aligned = [&aligned](bool now) { aligned = now; }});
  const auto join = [&service](ipc::ClientId id, const protocol::PlacementRequest& request) {
    service.OnClient(
        {.id = id, .role = protocol::ClientRole::kApplication, .pid = 1, .application = "a", .engine = ""});
    service.OnSession(id, protocol::SessionState::kFocused);
    service.OnPlacementRequest(id, request);
  };
  const auto status = [&service] { return nlohmann::json::parse(service.StatusJson()); };
  join(1, Request({kSpaceLocal}));
  EXPECT_FALSE(aligned);
  service.OnPlacementCommand(9, Store(kSpaceLocal));
  EXPECT_TRUE(aligned);
  EXPECT_EQ(status()["aligned"], true);
  EXPECT_EQ(status()["alignments"]["stored"].size(), 1U);
  EXPECT_EQ(status()["clients"][0]["runtime"], "Monado(XRT)");
  protocol::PlacementRequest other = Request({kSpaceLocal});
  other.headset = Headset("another runtime");
  join(2, other);
  EXPECT_FALSE(aligned) << "it owns the force now, and its headset is not aligned";
  EXPECT_EQ(status()["clients"][0]["aligned"], true);
  service.OnGone(2);
  service.OnPeriod(1);
  EXPECT_TRUE(aligned);
  service.OnGone(1);
  service.OnPeriod(2);
  EXPECT_FALSE(aligned) << "nobody is there whose headset could be";
}

// A change of a space is believed of an application whose session has begun, and of its own spaces only.
TEST(DaemonPlacements, TheServiceBelievesOnlyASessionThatHasBegun) {
  const test::TempFolder temp;
  const std::string path = temp.Path("a.toml");
  Service service({.version = "test", .instance = 1, .hull_radius_m = 0.0375, .alignment_path = path});
  service.OnPlacementCommand(9, Store(kSpaceLocal));
  const auto recentred = [&service] {
    return nlohmann::json::parse(service.StatusJson())["alignments"]["stored"][0]["recentred"].get<int>();
  };
  const auto now_ns = [] { return base::MonotonicNow_ns(); };
  service.OnClient({.id = 1, .role = protocol::ClientRole::kApplication, .pid = 1, .application = "a", .engine = ""});
  service.OnPlacementRequest(1, Request({kSpaceLocal}));
  service.OnSpaceChange(1, Moved(0.5, now_ns()));
  EXPECT_EQ(recentred(), 0) << "no session has begun";
  service.OnSession(1, protocol::SessionState::kBegun);
  service.OnSpaceChange(1, Moved(0.5, now_ns() + 1'000'000'000));
  EXPECT_EQ(recentred(), 1);
  service.OnSession(1, protocol::SessionState::kNone);
  service.OnSpaceChange(1, Moved(0.5, now_ns() + 2'000'000'000));
  EXPECT_EQ(recentred(), 2) << "the headset was taken off: the runtime still tells this application";
  service.OnClient({.id = 2, .role = protocol::ClientRole::kApplication, .pid = 1, .application = "b", .engine = ""});
  service.OnSession(2, protocol::SessionState::kFocused);
  service.OnPlacementRequest(2, Request({kSpaceStage}));
  service.OnSpaceChange(2, Moved(0.5, now_ns() + 3'000'000'000));
  EXPECT_EQ(recentred(), 2) << "it has no LOCAL";
}

}  // namespace
}  // namespace omni::daemon
