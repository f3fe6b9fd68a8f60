// Forces of clients: claims, owners, signs of life; and the reported force properties of a device.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>

#include "service/config/files/device_file.h"
#include "service/daemon/clients/force_clients.h"
#include "service/loop/tick_config.h"
#include "service/magnetics/nominal.h"

namespace omni::daemon {
namespace test_daemon_force {

using protocol::ForceStanding;

constexpr std::int64_t kNow_ns = 5'000'000'000;
constexpr std::int64_t kMs_ns = 1'000'000;

class ForceClientsTest : public testing::Test {
 protected:
  ForceClientsTest()
      : table_({.owner =
                    [this](ipc::ClientId id, const protocol::ForceOwner& owner) {
                      if (deaf_) return false;
                      standing_[id] = owner.standing;
                      return true;
                    },
                .properties =
                    [this](ipc::ClientId id, const protocol::ForceProperties& properties) {
                      if (deaf_) return false;
                      ++reported_[id];
                      available_[id] = properties.available;
                      return true;
                    }}) {
    table_.Add(1);
    table_.Add(2);
  }

  void Claim(ipc::ClientId id, bool wanted = true) {
    protocol::ForceClaim claim;
    claim.wanted = wanted ? 1 : 0;
    table_.HandleRequest(id, claim, kNow_ns);
  }
  static protocol::ForceApply Push(std::int64_t t_ns = kNow_ns, std::int64_t duration_ns = 100 * kMs_ns) {
    protocol::ForceApply apply;
    apply.t_ns = t_ns;
    apply.duration_ns = duration_ns;
    apply.force_base_N = {1, 0, 0};
    return apply;
  }
  static protocol::ForceConstraints TwoSprings() {
    protocol::ForceConstraints set;
    set.t_ns = kNow_ns;
    set.count = 2;
    return set;
  }

  std::map<ipc::ClientId, ForceStanding> standing_;
  std::map<ipc::ClientId, int> reported_;
  std::map<ipc::ClientId, std::uint32_t> available_;
  bool deaf_ = false;
  ForceClients table_;
};

TEST_F(ForceClientsTest, OnlyTheFocusedClientThatClaimedThePenCanPush) {
  EXPECT_FALSE(table_.HandleRequest(1, Push(), kNow_ns)) << "no claim, no focus";
  Claim(1);
  EXPECT_FALSE(table_.HandleRequest(1, Push(), kNow_ns)) << "no focus";
  table_.SetOwner(1);
  EXPECT_TRUE(table_.HandleRequest(1, Push(), kNow_ns));
  Claim(2);
  EXPECT_FALSE(table_.HandleRequest(2, Push(), kNow_ns)) << "another client is focused";
  EXPECT_FALSE(table_.HandleRequest(99, Push(), kNow_ns)) << "unknown client";
  EXPECT_TRUE(table_.MakeCommand(kNow_ns).open);
}

TEST_F(ForceClientsTest, ChangeOfOwnerClearsForcesAndConstraints) {
  Claim(1);
  Claim(2);
  table_.SetOwner(1);
  ASSERT_TRUE(table_.HandleRequest(1, Push(), kNow_ns));
  ASSERT_TRUE(table_.HandleRequest(1, TwoSprings(), kNow_ns));
  const haptics::AppliedCommand before = table_.MakeCommand(kNow_ns);
  EXPECT_EQ(before.constraint_count, 2U);
  EXPECT_GT(before.force_end_ns, kNow_ns);
  for (const ipc::ClientId owner : {ipc::ClientId{2}, ipc::ClientId{1}}) {
    table_.SetOwner(owner);
    const haptics::AppliedCommand after = table_.MakeCommand(kNow_ns);
    EXPECT_EQ(after.constraint_count, 0U);
    EXPECT_LT(after.force_end_ns, kNow_ns);
    EXPECT_NE(after.force_id, before.force_id);
    EXPECT_NE(after.constraints_id, before.constraints_id);
  }
}

TEST_F(ForceClientsTest, StopAndReleaseEndForcesAndConstraints) {
  Claim(1);
  table_.SetOwner(1);
  table_.HandleRequest(1, TwoSprings(), kNow_ns);
  table_.HandleRequest(1, protocol::ForceStop{}, kNow_ns);
  EXPECT_EQ(table_.MakeCommand(kNow_ns).constraint_count, 0U);
  table_.HandleRequest(1, TwoSprings(), kNow_ns);
  Claim(1, false);
  EXPECT_EQ(table_.MakeCommand(kNow_ns).constraint_count, 0U);
  EXPECT_FALSE(table_.MakeCommand(kNow_ns).open);
  Claim(1);
  table_.HandleRequest(1, TwoSprings(), kNow_ns);
  table_.Remove(1);
  EXPECT_EQ(table_.MakeCommand(kNow_ns).constraint_count, 0U);
}

TEST_F(ForceClientsTest, LateMessageIsShortenedByItsDelay) {
  Claim(1);
  table_.SetOwner(1);
  table_.HandleRequest(1, Push(kNow_ns - 30 * kMs_ns, 40 * kMs_ns), kNow_ns);
  EXPECT_EQ(table_.MakeCommand(kNow_ns).force_end_ns, kNow_ns + 10 * kMs_ns);
  table_.HandleRequest(1, Push(kNow_ns + 1'000'000 * kMs_ns, 40 * kMs_ns), kNow_ns);
  EXPECT_EQ(table_.MakeCommand(kNow_ns).force_end_ns, kNow_ns + 40 * kMs_ns) << "a time in the future counts as now";
  table_.HandleRequest(1, Push(std::numeric_limits<std::int64_t>::min(), 40 * kMs_ns), kNow_ns);
  EXPECT_LT(table_.MakeCommand(kNow_ns).force_end_ns, kNow_ns);
  table_.HandleRequest(1, Push(), kNow_ns);
  EXPECT_LT(table_.MakeCommand(kNow_ns + 100 * kMs_ns).force_end_ns, kNow_ns) << "by the service's own clock";
}

TEST_F(ForceClientsTest, NotifiesEachClientOncePerChange) {
  protocol::ForceProperties properties;
  properties.available = 1;
  deaf_ = true;
  table_.Notify(properties);
  EXPECT_TRUE(standing_.empty());
  deaf_ = false;
  for (int i = 0; i < 3; ++i) table_.Notify(properties);
  EXPECT_EQ(reported_[1], 1);
  EXPECT_EQ(available_[2], 1U);
  EXPECT_EQ(standing_[1], ForceStanding::kFree);
  Claim(1);
  table_.SetOwner(1);
  table_.Notify(properties);
  EXPECT_EQ(standing_[1], ForceStanding::kYours);
  EXPECT_EQ(standing_[2], ForceStanding::kTaken);
  table_.Notify({});
  EXPECT_EQ(reported_[1], 2) << "the device has gone";
  EXPECT_EQ(available_[1], 0U);
  table_.SetOwner(2);
  table_.Notify({});
  EXPECT_EQ(standing_[1], ForceStanding::kFree) << "the focused one has claimed nothing";
}

TEST(ForceProperties, NominalDeviceHasConsistentProperties) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const loop::TickConfig config = loop::MakeTickConfig(device);
  const protocol::ForceProperties can = DescribeForce(config, device);
  EXPECT_EQ(protocol::Problem(can), nullptr);
  EXPECT_EQ(can.available, 1U);
  EXPECT_DOUBLE_EQ(can.max_force_N, config.actuation.force_max_N);
  EXPECT_LT(can.max_force_N, device.force_max_N) << "it is not calibrated";
  EXPECT_DOUBLE_EQ(can.update_rate_Hz, 1000);
  EXPECT_GE(can.inner_radius_m, device.hull_radius_m);
  EXPECT_GT(can.outer_radius_m, can.inner_radius_m);
  EXPECT_GT(can.continuous_force_N, 0);
  EXPECT_LT(can.continuous_force_N, can.reach[0].force_N + 1e-9);
  for (std::uint32_t i = 1; i < can.reach_count; ++i) {
    EXPECT_GT(can.reach[i].distance_m, can.reach[i - 1].distance_m);
    EXPECT_LE(can.reach[i].force_N, can.reach[i - 1].force_N + 1e-3) << i;
  }
  EXPECT_GT(can.reach[0].force_N, 0.5);
}

TEST(ForceProperties, ReachFollowsTheMeasuredTip) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  base::Calibration calibration = magnetics::NominalCalibration(device);
  const auto outer_m = [&] { return DescribeForce(loop::MakeTickConfig(device, calibration), device).outer_radius_m; };
  const double drawn_m = outer_m();
  calibration.magnet.tip_offset_m += 1e-3;
  EXPECT_NEAR(outer_m(), drawn_m - 1e-3, 1e-12) << "a longer pen's tip is nearer for the same magnet";
}

// At the continuous force, with the heat model run for an hour, no copper exceeds its target temperature.
TEST(ForceProperties, ContinuousForceNeverOverheatsTheCoils) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const loop::TickConfig config = loop::MakeTickConfig(device);
  const protocol::ForceProperties can = DescribeForce(config, device);
  base::ToolState tool;
  tool.status = base::TrackingStatus::kTracking;
  tool.axis_base = {0, 0, -1};
  tool.position_base_m = {0, 0, can.inner_radius_m + 0.001 + device.magnet.tip_offset_m};
  tool.gap_m = tool.position_base_m.z - device.magnet.half_height_m - device.hull_radius_m;
  const std::array<double, 3> cold{config.actuation.heat.nodes.air_C, config.actuation.heat.nodes.air_C,
                                   config.actuation.heat.nodes.air_C};
  const base::ForceLimit limit = actuation::ComputeForceLimit(config.actuation, tool, cold);
  ASSERT_TRUE(limit.valid);
  for (const base::Vec3& d : {base::Vec3{0, 0, 1}, base::Vec3{0, 0, -1}, base::Vec3{1, 0, 0}, base::Vec3{0, -1, 0}}) {
    actuation::State state;
    base::CoilCurrents currents;
    const double f = can.continuous_force_N;
    actuation::Allocate(config.actuation, limit, {f * d.x, f * d.y, f * d.z}, 1, state, currents);
    actuation::Allocate(config.actuation, limit, {f * d.x, f * d.y, f * d.z}, 0.1, state, currents);
    actuation::HeatState heat{.started = true, .body_C = cold[0]};
    heat.copper_C.fill(cold[0]);
    for (int i = 0; i < 4 * 3600; ++i) actuation::AdvanceHeat(config.actuation.heat, currents.current_A, 0.25, heat);
    for (const double copper_C : heat.copper_C) {
      EXPECT_LE(copper_C, config.actuation.heat.temperature_aim_C + 0.1);
      EXPECT_GT(copper_C, cold[0]);
    }
  }
}

}  // namespace test_daemon_force
}  // namespace omni::daemon
