// The last check of the duties: errors inside the core do not reach the bridges.
#include <gtest/gtest.h>

#include <cstring>
#include <type_traits>

#include "tests/support/chips/firmware_bench.h"
#include "tests/support/rig/core_tamper.h"

namespace omni::firmware {
namespace test_firmware_outputs {

using wire::State;

bool Drives(const Outputs& outputs) { return outputs.duty[0] != 0 || outputs.duty[1] != 0 || outputs.duty[2] != 0; }

// Steps with a duty, and the largest current, over so many milliseconds.
struct Driven {
  int steps = 0;
  double largest_A = 0;
};
Driven Watch(FirmwareBench& bench, double milliseconds) {
  Driven driven;
  bench.each_step = [&] {
    driven.steps += Drives(bench.outputs) ? 1 : 0;
    driven.largest_A = std::max(driven.largest_A, bench.plant.largest_A());
  };
  bench.RunMs(milliseconds);
  bench.each_step = nullptr;
  return driven;
}

void ExpectTripped(const FirmwareBench& bench) {
  EXPECT_EQ(bench.core.state(), State::kFault);
  EXPECT_EQ(bench.core.faults() & wire::kFaultInternal, wire::kFaultInternal);
  EXPECT_EQ(bench.outputs.awake, 0);
}

TEST(FirmwareOutputs, BridgeDrivenWhileIdleIsStoppedInTheSameStep) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  CoreTamper::DriveOf(bench.core).Wake();
  const Driven driven = Watch(bench, 50);
  EXPECT_EQ(driven.steps, 0);
  EXPECT_LT(driven.largest_A, 0.01);
  ExpectTripped(bench);
}

// The state alone does not arm: it was never entered.
TEST(FirmwareOutputs, OverwrittenStateDoesNotDrive) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  CoreTamper::SetState(bench.core, State::kArmed);
  CoreTamper::SetPoints(bench.core, 5);
  CoreTamper::DriveOf(bench.core).Wake();
  bench.SetAll(5);
  const Driven driven = Watch(bench, 50);
  EXPECT_EQ(driven.steps, 0);
  EXPECT_LT(driven.largest_A, 0.01);
  ExpectTripped(bench);
}

TEST(FirmwareOutputs, EndlessRampIsCutOff) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.SetAll(5);
  bench.RunMs(50);
  const Drive driving = CoreTamper::DriveOf(bench.core);
  bench.Send(wire::Estop{});
  bench.host_speaks = false;
  Driven driven;
  for (int step = 0; step < 200; ++step) {
    CoreTamper::DriveOf(bench.core) = driving;  // again and again
    bench.Step();
    driven.steps += Drives(bench.outputs) ? 1 : 0;
  }
  EXPECT_LE(driven.steps, 20) << "5 ms";
  EXPECT_LT(bench.plant.largest_A(), 0.05);
  EXPECT_EQ(bench.core.faults() & wire::kFaultInternal, wire::kFaultInternal);
}

TEST(FirmwareOutputs, RearmingRequiresTheSelfTest) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  CoreTamper::DriveOf(bench.core).Wake();
  bench.RunMs(50);
  wire::Arm answer = bench.Arm();
  EXPECT_EQ(answer.step, wire::ArmStep::kRefused);
  EXPECT_EQ(answer.faults, wire::kFaultSelfTest);
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  EXPECT_EQ(bench.Arm().step, wire::ArmStep::kArmed);
  bench.SetAll(2);
  bench.RunMs(50);
  EXPECT_NEAR(bench.plant.current_A(0), 2, 0.02) << "allowed outputs still pass";
}

// Every single bit of Drive's state, in an idle base.
TEST(FirmwareOutputs, FlippedDriveBitNeverDrivesAnIdleBase) {
  static_assert(std::is_trivially_copyable<Drive>::value, "its bits are all there is");
  FirmwareBench idle;
  ASSERT_TRUE(idle.RunUntil(State::kIdle, 1000));
  idle.RunMs(100);
  int driven = 0, stopped = 0;
  for (std::size_t bit = 0; bit < 8 * sizeof(Drive); ++bit) {
    Core core = idle.core;
    FirmwarePlant plant = idle.plant;
    Outputs outputs = idle.outputs;
    unsigned char bytes[sizeof(Drive)];
    std::memcpy(bytes, &CoreTamper::DriveOf(core), sizeof bytes);
    bytes[bit / 8] ^= static_cast<unsigned char>(1U << bit % 8);
    std::memcpy(static_cast<void*>(&CoreTamper::DriveOf(core)), bytes, sizeof bytes);
    bool drives = false;
    for (int step = 0; step < 30; ++step) {
      core.Step(plant.Step(outputs), outputs);
      drives = drives || Drives(outputs);
    }
    driven += drives ? 1 : 0;
    stopped += (core.faults() & wire::kFaultInternal) != 0 ? 1 : 0;
  }
  EXPECT_EQ(driven, 0);
  EXPECT_GE(stopped, 1);
}

}  // namespace test_firmware_outputs
}  // namespace omni::firmware
