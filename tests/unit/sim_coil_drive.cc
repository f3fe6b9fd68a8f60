// Coils and driver: delay, lag, limits, watchdog, heat.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "firmware/wire/messages.h"
#include "service/sim/coil_drive.h"
#include "tests/support/nominal_device.h"

namespace omni::sim {
namespace {

// A drive with its clock; commands every tick unless told to be silent.
struct Story {
  base::DeviceGeometry device = support::NominalDevice();
  DriveConfig config;
  CoilDrive drive{device, config, ThermalConfig{}, Imperfections{}};
  std::int64_t t_ns = 0;
  double silence_s = 0;

  void Command(const CoilArray& set_point_A, double time_to_live_s = 0.020) {
    drive.Command(set_point_A, time_to_live_s, t_ns);
    silence_s = 0;
  }
  void Tick() {
    drive.Watch(silence_s);
    for (int i = 0; i < 4; ++i) {
      t_ns += 250'000;
      drive.Step(t_ns, 250e-6);
    }
    drive.Heat(1e-3);
    silence_s += 1e-3;
  }
  void Drive(const CoilArray& set_point_A, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      Command(set_point_A);
      Tick();
    }
  }
};

TEST(SimDrive, StartsAtZeroAndSaysThatTheHostIsSilent) {
  Story story;
  for (int i = 0; i < 5; ++i) story.Tick();
  EXPECT_EQ(story.drive.faults(), wire::kFaultHostSilent);
  EXPECT_EQ(story.drive.current_A(), CoilArray{});
}

TEST(SimDrive, SetPointActsAfterTheDelayAndLagsByLOverR) {
  Story story;
  story.Command({0, 4, 0});
  story.Tick();
  EXPECT_LT(story.drive.current_A()[1], 0.6)
      << "acts 1 ms after the command, so at the end of this tick at the earliest";
  const double start_A = story.drive.current_A()[1];
  const double tau_s = story.device.coils[1].inductance_H / (0.666 * (1 + 0.00393 * 4));
  story.Drive({0, 4, 0}, 2);
  EXPECT_NEAR(story.drive.current_A()[1], 4 - (4 - start_A) * std::exp(-2e-3 / tau_s), 0.01);
  story.Drive({0, 4, 0}, 30);
  EXPECT_NEAR(story.drive.current_A()[1], 4, 1e-6);
  EXPECT_EQ(story.drive.current_A()[0], 0);
  EXPECT_EQ(story.drive.faults(), 0U);
}

TEST(SimDrive, CurrentNeverExceedsTheLimitOrTheSupply) {
  Story story;
  for (int i = 0; i < 100; ++i) {
    story.Command({100, -100, 15});
    story.Tick();
    for (const double current_A : story.drive.current_A()) ASSERT_LE(std::abs(current_A), 15 + 1e-9);
  }
  EXPECT_NEAR(story.drive.current_A()[0], 15, 1e-3);
  Story weak;
  weak.device.supply_V = 6;
  weak.drive = CoilDrive(weak.device, weak.config, ThermalConfig{}, Imperfections{});
  weak.Drive({15, 0, 0}, 50);
  EXPECT_NEAR(weak.drive.current_A()[0], 6 / (0.633 * (1 + 0.00393 * (weak.drive.temperature_C()[0] - 20))), 0.01);
}

// Held for 20 ms, then down within 5 ms (set-point) and the coil's own lag; comes back with the next command.
TEST(SimDrive, WatchdogZeroesTheCoilsOfASilentHost) {
  Story story;
  story.Drive({3, -15, 1}, 50);
  for (int silent_ms = 1; silent_ms <= 19; ++silent_ms) {
    story.Tick();
    ASSERT_EQ(story.drive.faults(), 0U) << silent_ms;
    ASSERT_NEAR(story.drive.current_A()[1], -15, 1e-3) << silent_ms;
  }
  for (int i = 0; i < 7; ++i) story.Tick();
  EXPECT_EQ(story.drive.faults(), wire::kFaultHostSilent);
  EXPECT_EQ(story.drive.set_point_A(), CoilArray{}) << "26 ms after the last command";
  for (int i = 0; i < 14; ++i) story.Tick();
  for (const double current_A : story.drive.current_A()) EXPECT_LT(std::abs(current_A), 0.01) << "40 ms";
  story.Drive({1, 1, 1}, 10);
  EXPECT_EQ(story.drive.faults(), 0U);
  EXPECT_GT(story.drive.current_A()[0], 0.9);
}

TEST(SimDrive, ShorterTimeToLiveIsKept) {
  Story story;
  story.Drive({1, 1, 1}, 30);
  story.Command({1, 1, 1}, 0.005);
  for (int i = 0; i < 5; ++i) story.Tick();
  EXPECT_EQ(story.drive.faults(), 0U);
  story.Tick();
  EXPECT_EQ(story.drive.faults(), wire::kFaultHostSilent);
}

TEST(SimDrive, NotANumberAsSilenceIsSilence) {
  Story story;
  story.Drive({1, 1, 1}, 5);
  story.drive.Watch(std::nan(""));
  EXPECT_EQ(story.drive.faults(), wire::kFaultHostSilent);
}

TEST(SimDrive, FullQueueKeepsTheNewestCommand) {
  Story story;
  for (int i = 0; i < 1000; ++i) story.Command({0.01 * (i % 100), 0, 0});
  story.Drive({2, 0, 0}, 30);
  EXPECT_NEAR(story.drive.current_A()[0], 2, 1e-6);
}

// One coil at 5 A for 15 minutes: body 47 C, copper 54.5 C; steady state 49.1 and 56.8 C. (y coil, air 24 C.)
TEST(SimDrive, WarmsUpAsMeasured) {
  Story story;
  for (int i = 0; i < 2000; ++i) {  // currents only
    story.Command({0, 5, 0});
    story.drive.Watch(0);
    story.t_ns += 1'000'000;
    story.drive.Step(story.t_ns, 1e-3);
  }
  for (int i = 0; i < 90000; ++i) story.drive.Heat(10e-3);
  EXPECT_NEAR(story.drive.temperature_C()[1], 65.4, 1.0);
  EXPECT_NEAR(story.drive.temperature_C()[0], 47.0, 1.0) << "an idle coil takes the body's temperature";
}

TEST(SimDrive, OverheatingTripsAndEndsAfterCooling) {
  Story story;
  int ticks = 0;
  while (story.drive.faults() != wire::kFaultOverTemperature && ticks < 60000) {
    story.Drive({15, 15, 15}, 1);
    ++ticks;
  }
  ASSERT_LT(ticks, 60000);
  EXPECT_GT(*std::max_element(story.drive.temperature_C().begin(), story.drive.temperature_C().end()), 69.9);
  story.Drive({15, 15, 15}, 50);
  EXPECT_NEAR(story.drive.current_A()[0], 0, 0.01);
  for (int i = 0; i < 60000 && story.drive.faults() != 0; ++i) story.Drive({0, 0, 0}, 1);
  EXPECT_EQ(story.drive.faults(), 0U);
}

TEST(SimDrive, CurrentSensorHasItsErrors) {
  Imperfections imperfections;
  imperfections.current_gain = {1.01, 1, 1};
  imperfections.current_offset_A = {0, 0.005, 0};
  const CoilDrive drive(support::NominalDevice(), DriveConfig{}, ThermalConfig{}, imperfections);
  const CoilArray measured_A = drive.Measured({10, 0, -3});
  EXPECT_NEAR(measured_A[0], 10.1, 1e-12);
  EXPECT_NEAR(measured_A[1], 0.005, 1e-12);
  EXPECT_NEAR(measured_A[2], -3, 1e-12);
}

}  // namespace
}  // namespace omni::sim
