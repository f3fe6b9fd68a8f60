// Laps: counted once each, timed, and not earned by short cuts.
#include <gtest/gtest.h>

#include "service/haptics/vehicle/car_motion.h"
#include "tests/vehicle/scene.h"

namespace omni::haptics {
namespace test_vehicle_laps {

// Follows the ring until the car has turned by `turns` about its middle (negative: the wrong way).
void Round(Driver& driver, double turns) {
  double angle = 0;
  for (int k = 0; k < 60'000 && std::abs(angle) < 2 * std::numbers::pi * std::abs(turns); ++k) {
    const Vec3 before = driver.state.position_base_m;
    driver.Follow(0.7, turns > 0 ? 1 : -1);
    const Vec3 after = driver.state.position_base_m;
    angle += std::remainder(std::atan2(after.y, after.x) - std::atan2(before.y, before.x), 2 * std::numbers::pi);
  }
}

// Puts the car on the ring at `turns`, looking along it (or against it), at rest.
void TurnRound(Driver& driver) {
  driver.state.heading_rad = std::remainder(driver.state.heading_rad + std::numbers::pi, 2 * std::numbers::pi);
  driver.state.velocity_base_m_s = {};
  driver.state.yaw_rate_rad_s = 0;
}

TEST(Laps, AreCountedAndTimed) {
  for (const SceneInput& input : {Ring(), RingWithCheckpoints()}) {
    Driver driver(Built(input));
    double first_s = 0, second_s = 0;
    for (int k = 0; k < 20'000 && driver.state.lap.laps < 2; ++k) {
      driver.Follow(0.7);
      (driver.state.lap.laps == 0 ? first_s : second_s) += 1e-3;
    }
    const LapState& lap = driver.state.lap;
    ASSERT_EQ(lap.laps, 2U);
    EXPECT_EQ(driver.state.hits, 0U);
    EXPECT_NEAR(lap.last_s, second_s, 1.5e-3);
    EXPECT_EQ(lap.best_s, lap.last_s) << "the first one began at rest";
    EXPECT_GT(first_s, lap.best_s);
    // The same round again takes the same time to far less than a tick.
    const double last_s = lap.last_s;
    Round(driver, 3);
    EXPECT_NEAR(driver.state.lap.last_s, last_s, 2e-4);
  }
}

TEST(Laps, CrossingTimesAreExact) {
  VehicleInput car;
  LapState lap;
  const double speed_m_s = 0.7;
  double x = -0.01234;
  for (int k = 0; k < 100; ++k) {
    AdvanceLap(car, {x, 0, 0}, {x + speed_m_s * 1e-3, 0, 0}, 1e-3, lap);
    x += speed_m_s * 1e-3;
  }
  EXPECT_TRUE(lap.running);
  EXPECT_NEAR(lap.time_s, x / speed_m_s, 1e-12);
}

TEST(Laps, TurningRoundAtTheLineDoesNotCount) {
  for (const SceneInput& input : {Ring(), RingWithCheckpoints()}) {
    Driver driver(Built(input));
    Round(driver, 0.1);
    for (int k = 0; k < 5; ++k) {
      TurnRound(driver);
      Round(driver, -0.2);
      TurnRound(driver);
      Round(driver, 0.2);
    }
    EXPECT_EQ(driver.state.lap.laps, 0U);
    Round(driver, 1);
    EXPECT_EQ(driver.state.lap.laps, 1U) << "an honest one still does";
  }
}

TEST(Laps, TheWrongWayRoundDoesNotCount) {
  for (const SceneInput& input : {Ring(), RingWithCheckpoints()}) {
    Driver driver(Built(input));
    TurnRound(driver);
    Round(driver, -3.1);
    EXPECT_EQ(driver.state.lap.laps, 0U);
    TurnRound(driver);
    Round(driver, 3.2);
    EXPECT_EQ(driver.state.lap.laps, 0U) << "that only undid it";
    Round(driver, 1);
    EXPECT_EQ(driver.state.lap.laps, 1U);
  }
}

TEST(Laps, ReversingOverACheckpointUndoesIt) {
  Driver driver(Built(RingWithCheckpoints()));
  Round(driver, 0.3);
  EXPECT_EQ(driver.state.lap.next, 1U);
  TurnRound(driver);
  Round(driver, -0.1);
  EXPECT_EQ(driver.state.lap.next, 0U);
}

TEST(Laps, AShortCutDoesNotCount) {
  Driver driver(Built(RingWithCheckpoints()));
  Round(driver, 0.3);
  driver.state.position_base_m = {0.04, -0.008, 0.0015};  // lifted over to just before the line
  driver.state.heading_rad = std::numbers::pi / 2;
  driver.state.velocity_base_m_s = {0, 0.05, 0};
  driver.Go({0, 1}, 400);
  EXPECT_GT(driver.state.position_base_m.y, 0.005);
  EXPECT_EQ(driver.state.lap.laps, 0U);
}

}  // namespace test_vehicle_laps
}  // namespace omni::haptics
