// BasePoses follow a space that is recentred, and reject changes that recentring cannot cause.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "service/alignment/rigid.h"
#include "tests/daemon/base_pose_scenario.h"

namespace omni::daemon {
namespace test_daemon_recentring {

alignment::Rigid PoseOf(const protocol::WirePose& pose) {
  const auto& q = pose.orientation_wxyz;
  const auto& p = pose.position_m;
  return {.orientation = {q[0], q[1], q[2], q[3]}, .position_m = {p[0], p[1], p[2]}};
}

// An alignment in LOCAL is stored, and client 1 has requested it.
struct AlignedInLocal {
  AlignedInLocal() {
    EXPECT_TRUE(base_poses.Execute(Store(kSpaceLocal), kDate_s).ok);
    base_poses.HandleRequest(1, Request({kSpaceLocal}), kDate_s);
  }
  const TempFolder temp;
  BasePoses base_poses{temp.Path("a.toml")};
};

// The base does not move in the world: X_WL X_LB before is X_WL' X_L'B after, for any recentring; once for all clients.
TEST(DaemonRecentring, RecentringReportedByManyClientsIsAppliedOnce) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 50; ++i) {
    const TempFolder temp;
    const std::string path = temp.Path("a.toml");
    BasePoses base_poses(path);
    ASSERT_TRUE(base_poses.Execute(Store(kSpaceLocal), kDate_s).ok);
    for (const ipc::ClientId id : {1, 2}) base_poses.HandleRequest(id, Request({kSpaceLocal}), kDate_s);
    Listener listener;
    listener.Listen(base_poses);
    const alignment::Rigid before = PoseOf(listener.reported[1].back().base_space);
    protocol::SpaceChange change;
    change.pose_valid = 1;
    change.changes_at_ns = 5'000'000'000;
    const double half_yaw = 3 * any(random);  // these spaces have gravity along -y: they are turned about y only
    change.new_in_previous = {.position_m = {any(random), any(random), any(random)},
                              .orientation_wxyz = {std::cos(half_yaw), 0, std::sin(half_yaw), 0}};
    base_poses.HandleSpaceChange(1, change, kNow_ns);
    change.changes_at_ns += 3'000'000;  // another application's estimate of the same time
    base_poses.HandleSpaceChange(2, change, kNow_ns);
    listener.Listen(base_poses);
    EXPECT_EQ(listener.reported[1].size(), 1U) << "they moved the base themselves";
    BasePoses again(path);
    again.HandleRequest(3, Request({kSpaceLocal}), kDate_s);
    listener.Listen(again);
    const alignment::Rigid after = PoseOf(listener.reported[3].back().base_space);
    const alignment::Rigid in_previous = alignment::Compose(PoseOf(change.new_in_previous), after);
    EXPECT_LT(alignment::Distance_m(in_previous, before, {0.1, 0.1, 0.1}), 1e-12);
    EXPECT_LT(alignment::Angle_rad(in_previous, before), 1e-7);
    EXPECT_EQ(again.file().entries[0].recentred, 1);
    change.changes_at_ns += 2'000'000'000;
    base_poses.HandleSpaceChange(2, change, kNow_ns);
    EXPECT_EQ(base_poses.file().entries[0].recentred, 2) << "a second one, later";
  }
}

// No person recentres a headset by 20 m: such a change clears TRACKED, and moves nothing.
TEST(DaemonRecentring, ImplausibleRecentringIsNotApplied) {
  AlignedInLocal aligned;
  Listener listener;
  listener.Listen(aligned.base_poses);
  for (int i = 1; i <= 5; ++i) {
    const std::int64_t now_ns = kNow_ns + i * std::int64_t{1'000'000'000};
    aligned.base_poses.HandleSpaceChange(1, Moved(20, now_ns), now_ns);
  }
  const double moved_m = std::abs(BasePoses(aligned.temp.Path("a.toml")).file().entries[0].position_space_m.x - 0.1);
  std::printf("[ figure   ] five changes of 20 m have moved the alignment by %.1f m\n", moved_m);
  EXPECT_EQ(moved_m, 0);
  EXPECT_FALSE(aligned.base_poses.IsAligned(1));
  listener.Listen(aligned.base_poses);
  EXPECT_EQ(listener.reported[1].back().doubtful, 1U) << "connected clients are notified";
  aligned.base_poses.HandleSpaceChange(1, Moved(1, kNow_ns + 5'000'000'000), kNow_ns + 5'000'000'000);
  EXPECT_EQ(aligned.base_poses.file().entries[0].recentred, 1) << "it hides no real recentring at the same time";
}

// The bound is relative to the measured pose: many steps lead no further than one.
TEST(DaemonRecentring, TotalRecentringIsBounded) {
  AlignedInLocal aligned;
  std::int64_t now_ns = kNow_ns;
  for (int i = 0; i < 40; ++i) {
    now_ns += 1'000'000'000;
    aligned.base_poses.HandleSpaceChange(1, Moved(-0.9, now_ns), now_ns);
  }
  const config::AlignmentEntry& entry = aligned.base_poses.file().entries[0];
  EXPECT_LE(entry.position_space_m.x - entry.measured_position_space_m.x, protocol::kFarthestRecentring_m);
  EXPECT_TRUE(entry.doubtful);
}

// Spaces of OpenXR do not tip over.
TEST(DaemonRecentring, LargeTiltMakesTheAlignmentDoubtful) {
  const auto doubtful_after = [](double angle_rad) {
    AlignedInLocal aligned;
    protocol::SpaceChange change = Moved(0, kNow_ns);
    change.new_in_previous.orientation_wxyz = {std::cos(angle_rad / 2), 0, 0, std::sin(angle_rad / 2)};
    aligned.base_poses.HandleSpaceChange(1, change, kNow_ns);
    return aligned.base_poses.file().entries[0].doubtful;
  };
  EXPECT_FALSE(doubtful_after(0.9 * protocol::kMostRecentringTilt_rad));
  EXPECT_TRUE(doubtful_after(1.1 * protocol::kMostRecentringTilt_rad));
}

TEST(DaemonRecentring, RestoreReturnsTheMeasuredPose) {
  const TempFolder temp;
  const std::string path = temp.Path("a.toml");
  protocol::BasePoseCommand restore = Store(kSpaceLocal);
  restore.action = protocol::BasePoseAction::kRestore;
  {
    BasePoses base_poses(path);
    EXPECT_FALSE(base_poses.Execute(restore, kDate_s).ok) << "there is none";
    ASSERT_TRUE(base_poses.Execute(Store(kSpaceLocal), kDate_s).ok);
    EXPECT_FALSE(base_poses.Execute(restore, kDate_s).ok) << "it has not moved";
    base_poses.HandleRequest(1, Request({kSpaceLocal}), kDate_s);
    base_poses.HandleSpaceChange(1, Moved(3, kNow_ns), kNow_ns);
    base_poses.HandleSpaceChange(1, Moved(50, kNow_ns + 1'000'000'000), kNow_ns + 1'000'000'000);
    EXPECT_NEAR(base_poses.file().entries[0].position_space_m.x, -2.9, 1e-12);
    EXPECT_FALSE(base_poses.IsAligned(1));
  }
  BasePoses base_poses(path);
  base_poses.HandleRequest(1, Request({kSpaceLocal}), kDate_s);
  Listener listener;
  listener.Listen(base_poses);
  ASSERT_TRUE(base_poses.Execute(restore, kDate_s).ok);
  EXPECT_TRUE(base_poses.IsAligned(1));
  listener.Listen(base_poses);
  EXPECT_EQ(listener.reported[1].back().base_space.position_m[0], 0.1) << "connected clients are notified";
  const config::AlignmentEntry entry = BasePoses(path).file().entries[0];
  EXPECT_EQ(entry.position_space_m.x, 0.1);
  EXPECT_EQ(entry.recentred, 0);
  EXPECT_FALSE(entry.doubtful);
}

TEST(DaemonRecentring, ChangeToAnUnknownOriginMakesTheAlignmentDoubtful) {
  AlignedInLocal aligned;
  protocol::SpaceChange change;
  change.changes_at_ns = 1;
  aligned.base_poses.HandleSpaceChange(1, change, kNow_ns);
  EXPECT_FALSE(aligned.base_poses.IsAligned(1));
  BasePoses again(aligned.temp.Path("a.toml"));
  again.HandleRequest(2, Request({kSpaceLocal}), kDate_s);
  Listener listener;
  listener.Listen(again);
  EXPECT_EQ(listener.reported[2].back().known, 1U);
  EXPECT_EQ(listener.reported[2].back().doubtful, 1U);
  ASSERT_TRUE(again.Execute(Store(kSpaceLocal), kDate_s).ok);
  EXPECT_TRUE(again.IsAligned(2)) << "measured again";
}

TEST(DaemonRecentring, IgnoresChangesOfOtherSpacesAndUnknownClients) {
  const TempFolder temp;
  BasePoses base_poses(temp.Path("a.toml"));
  ASSERT_TRUE(base_poses.Execute(Store(kSpaceStage), kDate_s).ok);
  base_poses.HandleRequest(1, Request({kSpaceStage, kSpaceLocal}), kDate_s);
  protocol::SpaceChange change;
  change.pose_valid = 1;
  change.changes_at_ns = 1;
  change.new_in_previous.position_m = {1, 2, 3};
  base_poses.HandleSpaceChange(1, change, kNow_ns);   // LOCAL
  base_poses.HandleSpaceChange(99, change, kNow_ns);  // sent no request
  EXPECT_EQ(base_poses.file().entries[0].recentred, 0);
  EXPECT_EQ(base_poses.file().entries[0].position_space_m.x, 0.1);
}

TEST(DaemonRecentring, ChangeInTheFarFutureDoesNotHideLaterOnes) {
  AlignedInLocal aligned;
  protocol::SpaceChange change;
  change.pose_valid = 1;
  change.changes_at_ns = std::numeric_limits<std::int64_t>::max();
  aligned.base_poses.HandleSpaceChange(1, change, kNow_ns);
  change.changes_at_ns = kNow_ns + 30'000'000'000;
  aligned.base_poses.HandleSpaceChange(1, change, kNow_ns + 30'000'000'000);
  EXPECT_EQ(aligned.base_poses.file().entries[0].recentred, 2);
}

}  // namespace test_daemon_recentring
}  // namespace omni::daemon
