// A scene that comes back is as it was left.
#include <gtest/gtest.h>

#include <memory>

#include "service/loop/scene_memory.h"
#include "tests/support/alloc_probe.h"

namespace omni::loop {
namespace test_loop_scene_memory {

std::unique_ptr<haptics::State> Formed(double offset_m, haptics::ExtrudePhase phase) {
  auto state = std::make_unique<haptics::State>();
  state->regions[3] = {.phase = phase,
                       .offset_m = offset_m,
                       .step = 2,
                       .timer_s = 0.3,
                       .grab_offset_m = 1e-3,
                       .edits = 5,
                       .last_offset_m = offset_m - 1e-4};
  return state;
}

std::unique_ptr<haptics::State> Recalled(const SceneMemory& memory, std::uint64_t build) {
  auto state = std::make_unique<haptics::State>();
  memory.RestoreState(build, *state);
  return state;
}

TEST(SceneMemory, FacesKeepTheirOffsetAndHeldOnesAreReleased) {
  const auto memory = std::make_unique<SceneMemory>();
  memory->SaveState(1, *Formed(0.008, haptics::ExtrudePhase::kFree));
  memory->SaveState(2, *Formed(0.007, haptics::ExtrudePhase::kHeld));
  const haptics::RegionState rests = Recalled(*memory, 1)->regions[3];
  EXPECT_EQ(rests.phase, haptics::ExtrudePhase::kFree);
  EXPECT_EQ(rests.offset_m, 0.008);
  EXPECT_EQ(rests.last_offset_m, 0.008) << "it does not sweep over a tip that is there";
  EXPECT_EQ(rests.step, 2);
  EXPECT_EQ(rests.edits, 5U);
  const haptics::RegionState held = Recalled(*memory, 2)->regions[3];
  EXPECT_EQ(held.phase, haptics::ExtrudePhase::kSettling);
  EXPECT_EQ(held.offset_m, 0.007);
  EXPECT_EQ(held.timer_s, 0);
  EXPECT_EQ(Recalled(*memory, 1)->regions[2].offset_m, 0);
}

TEST(SceneMemory, CarStopsAndKeepsItsLap) {
  const auto memory = std::make_unique<SceneMemory>();
  auto state = std::make_unique<haptics::State>();
  state->vehicle.started = true;
  state->vehicle.position_base_m = {0.01, 0.02, 0.05};
  state->vehicle.velocity_base_m_s = {0.3, 0, 0};
  state->vehicle.heading_rad = 1;
  state->vehicle.yaw_rate_rad_s = 2;
  state->vehicle.pulses[0].time_s = 0.01;
  state->vehicle.lap = {.running = true, .next = 2, .laps = 3, .time_s = 4.5, .best_s = 9};
  memory->SaveState(7, *state);
  const haptics::VehicleState car = Recalled(*memory, 7)->vehicle;
  EXPECT_TRUE(car.started);
  EXPECT_EQ(car.position_base_m.y, 0.02);
  EXPECT_EQ(car.heading_rad, 1);
  EXPECT_EQ(car.velocity_base_m_s.x, 0);
  EXPECT_EQ(car.yaw_rate_rad_s, 0);
  EXPECT_LT(car.pulses[0].time_s, 0) << "no pulse of a hit continues";
  EXPECT_TRUE(car.lap.running);
  EXPECT_EQ(car.lap.next, 2U);
  EXPECT_EQ(car.lap.laps, 3U);
  EXPECT_EQ(car.lap.time_s, 4.5);
}

TEST(SceneMemory, ForgetsTheSceneThatWasLeftFirst) {
  const auto memory = std::make_unique<SceneMemory>();
  for (std::uint64_t build = 1; build <= kRememberedScenes; ++build) {
    memory->SaveState(build, *Formed(1e-3 * static_cast<double>(build), haptics::ExtrudePhase::kFree));
  }
  memory->SaveState(1, *Formed(0.009, haptics::ExtrudePhase::kFree));  // kept again: now it is the newest
  memory->SaveState(50, *Formed(0.005, haptics::ExtrudePhase::kFree));
  EXPECT_EQ(Recalled(*memory, 1)->regions[3].offset_m, 0.009);
  EXPECT_EQ(Recalled(*memory, 2)->regions[3].offset_m, 0);
  EXPECT_EQ(Recalled(*memory, 3)->regions[3].offset_m, 0.003);
  EXPECT_EQ(Recalled(*memory, 50)->regions[3].offset_m, 0.005);
}

TEST(SceneMemory, IgnoresBuildZeroAndNeverAllocates) {
  const auto memory = std::make_unique<SceneMemory>();
  const auto formed = Formed(0.004, haptics::ExtrudePhase::kFree);
  const auto state = std::make_unique<haptics::State>();
  const AllocProbe probe;
  memory->SaveState(0, *formed);
  memory->RestoreState(0, *state);
  EXPECT_EQ(state->regions[3].offset_m, 0);
  memory->SaveState(1, *formed);
  memory->RestoreState(1, *state);
  EXPECT_EQ(state->regions[3].offset_m, 0.004);
  EXPECT_EQ(probe.count(), 0U);
}

}  // namespace test_loop_scene_memory
}  // namespace omni::loop
