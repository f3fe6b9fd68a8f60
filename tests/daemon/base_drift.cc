// A headset that finds its room again at each start, some millimetres elsewhere.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/daemon/base_pose_scenario.h"

namespace omni::daemon {
namespace test_daemon_base_drift {

constexpr std::int64_t kDay_s = 86'400;

protocol::BasePoseCommand CheckAt(double x, bool correct = false) {
  protocol::BasePoseCommand command = Store(kSpaceLocal, x);
  command.action = protocol::BasePoseAction::kCheck;
  command.correct = correct ? 1 : 0;
  return command;
}

// A disk is slow.
base::Status WriteNothing(const std::string&, const std::string&) { return base::Ok{}; }

struct Days {
  TempFolder temp;
  std::string path = temp.Path("a.toml");
  BasePoses base_poses;
  std::int64_t now_s = kDate_s;

  explicit Days(const BasePoses::Write& write = config::WriteTextFile) : base_poses(path, write) {
    EXPECT_TRUE(base_poses.Execute(Store(kSpaceLocal), now_s).ok);
  }
  const config::AlignmentEntry& entry() const { return base_poses.file().entries[0]; }
  // An application for an hour, on the next day.
  bool Start() {
    now_s += kDay_s;
    base_poses.HandleRequest(1, Request({kSpaceLocal}), now_s);
    const bool aligned = base_poses.IsAligned(1);
    base_poses.Remove(1, now_s + 3600);
    now_s += 3600;
    return aligned;
  }
};

TEST(DaemonBaseDrift, ErrorGrowsWithStartsUntilThePenIsNotTracked) {
  Days days;
  double last_mm = days.entry().ErrorNow_mm();
  EXPECT_NEAR(last_mm, 0.9, 1e-9);
  int tracked = 0;
  for (; days.Start(); ++tracked) {
    EXPECT_GT(days.entry().ErrorNow_mm(), last_mm);
    last_mm = days.entry().ErrorNow_mm();
    ASSERT_LT(tracked, 100);
  }
  EXPECT_GE(tracked, 1) << "one start is borne";
  EXPECT_GT(days.entry().ErrorNow_mm(), 10);
  BasePoses again(days.path);
  again.HandleRequest(1, Request({kSpaceLocal}), days.now_s);
  EXPECT_FALSE(again.IsAligned(1)) << "also after a restart of omnid";
  Listener listener;
  listener.Listen(again);
  EXPECT_EQ(listener.reported[1].back().doubtful, 1U) << "applications clear TRACKED";
  EXPECT_GT(listener.reported[1].back().expected_error_m, 10e-3);
  // One touch finds it near: trusted again.
  ASSERT_TRUE(again.Execute(CheckAt(0.103), days.now_s).ok);
  EXPECT_TRUE(again.IsAligned(1));
  listener.Listen(again);
  EXPECT_EQ(listener.reported[1].back().doubtful, 0U);
}

// Applications come and go while the headset stays on; two run at once; omnid is restarted: no start.
TEST(DaemonBaseDrift, ApplicationsThatComeAndGoAreNoStarts) {
  Days days;
  for (int i = 0; i < 50; ++i) {
    days.base_poses.HandleRequest(1, Request({kSpaceLocal}), days.now_s += 600);
    days.base_poses.HandleRequest(2, Request({kSpaceLocal}), days.now_s += 3 * 3600);
    days.base_poses.Remove(1, days.now_s += 3600);
    days.base_poses.Remove(2, days.now_s += 3600);
  }
  EXPECT_EQ(days.entry().drift.starts, 0);
  BasePoses again(days.path);
  again.HandleRequest(1, Request({kSpaceLocal}), days.now_s + 60);
  EXPECT_EQ(again.file().entries[0].drift.starts, 0);
  again.HandleRequest(1, Request({kSpaceLocal}), days.now_s + 120);
  EXPECT_EQ(again.file().entries[0].drift.starts, 0);
}

TEST(DaemonBaseDrift, CheckThatFindsItFarOffIsBelieved) {
  Days days;
  days.Start();
  const auto found = days.base_poses.Execute(CheckAt(0.113), days.now_s);
  ASSERT_TRUE(found.ok);
  EXPECT_NE(found.text.find("13.0 mm"), std::string::npos) << found.text;
  days.base_poses.HandleRequest(1, Request({kSpaceLocal}), days.now_s);
  EXPECT_FALSE(days.base_poses.IsAligned(1));
  EXPECT_EQ(days.entry().position_space_m.x, 0.1) << "a check moves nothing";
  ASSERT_TRUE(days.base_poses.Execute(CheckAt(0.113, true), days.now_s).ok);
  EXPECT_TRUE(days.base_poses.IsAligned(1));
  EXPECT_EQ(days.entry().position_space_m.x, 0.113);
  EXPECT_EQ(config::LoadAlignmentFile(days.path)->entries[0].drift.per_start_m, days.entry().drift.per_start_m);
  protocol::BasePoseCommand restore = Store(kSpaceLocal);
  restore.action = protocol::BasePoseAction::kRestore;
  ASSERT_TRUE(days.base_poses.Execute(restore, days.now_s).ok);
  EXPECT_EQ(days.entry().position_space_m.x, 0.1) << "as it was measured";
  EXPECT_FALSE(days.base_poses.Execute(CheckAt(20, true), days.now_s).ok) << "a wrong mark, 20 m away";
}

TEST(DaemonBaseDrift, CheckOfNothingIsRefused) {
  BasePoses base_poses{""};
  EXPECT_FALSE(base_poses.Execute(CheckAt(0.1), kDate_s).ok);
}

// A headset with base stations comes back where it was. Three checks show it, and for weeks nothing fires.
TEST(DaemonBaseDrift, HeadsetThatStaysIsLeftAlone) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> touch_m(0, 1e-3);
    Days days(WriteNothing);
    for (int i = 0; i < 3; ++i) {
      days.Start();
      ASSERT_TRUE(days.base_poses.Execute(CheckAt(0.1 + touch_m(random), true), days.now_s).ok);
    }
    for (int i = 0; i < 12; ++i) EXPECT_TRUE(days.Start()) << "seed " << seed << ", day " << i;
  }
}

// What is claimed after some weeks is what a touch then finds, whatever the headset's drift is.
TEST(DaemonBaseDrift, ClaimedErrorIsTheTrueOne) {
  for (const double drift_m : {1e-3, 4e-3, 7e-3, 20e-3}) {
    double squares = 0, claimed = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      std::mt19937_64 random(seed);
      std::normal_distribution<double> axis_m(0, drift_m / std::sqrt(3.0));
      const auto jump = [&] { return base::Vec3{axis_m(random), axis_m(random), axis_m(random)}; };
      Days days(WriteNothing);
      base::Vec3 truth_m = days.entry().position_space_m;
      for (int week = 0; week < 16; ++week) {
        const int starts = 1 + static_cast<int>(random() % 3);
        for (int i = 0; i < starts; ++i) {
          days.Start();
          truth_m += jump();
        }
        const double off_m = base::Distance(truth_m, days.entry().position_space_m);
        if (week >= 8) {
          squares += off_m * off_m;
          claimed += 1e-6 * days.entry().ErrorNow_mm() * days.entry().ErrorNow_mm();
        }
        protocol::BasePoseCommand check = CheckAt(0, true);
        check.base_space.position_m = {truth_m.x, truth_m.y, truth_m.z};
        ASSERT_TRUE(days.base_poses.Execute(check, days.now_s).ok);
      }
    }
    const double ratio = std::sqrt(squares / claimed);
    EXPECT_GT(ratio, 0.5) << drift_m;
    EXPECT_LT(ratio, 1.3) << drift_m;
  }
}

}  // namespace test_daemon_base_drift
}  // namespace omni::daemon
