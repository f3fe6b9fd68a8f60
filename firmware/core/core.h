// The control core: one piece of code that runs in the micro-controller, in an emulated one, in unit tests and inside
// the twin. No hardware, no heap, no clock of its own, no libm: inputs of a control step in, outputs out, frames in and
// out. Equal inputs give equal bits on every target (only + - * / and sqrt of float, nothing fused).
//
//   boot -> self-test -> idle <-> armed, any -> fault
//
// Coils are driven in kArmed only, and by the self-test with about an ampere. On any fault currents ramp to zero within
// 5 ms, or the bridges brake at once where control is no longer possible; 10 ms later they sleep (brake before sleep,
// so that the supply is not pumped up). docs/theory/firmware.md, docs/protocol/faults.md
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/core/board_io.h"
#include "firmware/core/drive.h"
#include "firmware/core/link/log_line.h"
#include "firmware/core/link/outbox.h"
#include "firmware/core/link/settings.h"
#include "firmware/core/link/tick_report.h"
#include "firmware/core/safety/fault_latch.h"
#include "firmware/core/safety/gates.h"
#include "firmware/core/safety/safety_monitor.h"
#include "firmware/core/safety/self_test.h"

namespace omni::firmware {

class Core {
 public:
  // `record`: from before the reset, or random memory. `nonce_seed` need not be random, but must differ at every reset.
  Core(const Settings& settings, ResetCause cause, std::uint32_t nonce_seed, FaultRecord& record) noexcept;

  // One whole frame received since the previous step. An invalid frame is counted and has no effect.
  void Receive(const std::uint8_t* frame, std::size_t size) noexcept;

  // Every kStepPeriod_us.
  void Step(const Inputs& inputs, Outputs& outputs) noexcept;

  // Frames to send after a Step, until 0: answers, and telemetry after every kStepsPerTick-th. A frame that does not
  // fit `capacity` is lost.
  std::size_t NextFrame(std::uint8_t* frame, std::size_t capacity) noexcept;

  wire::State state() const noexcept { return state_; }
  // Latched faults, and kFaultNotArmed in every state but kArmed.
  std::uint32_t faults() const noexcept;

  // The settings in force; for tests and boards.
  const Settings& settings() const noexcept { return settings_; }
  const CoilHeat& heat() const noexcept { return heat_; }

 private:
  friend struct CoreTamper;  // tests: corrupts the members below

  // Signs of life: the watchdog is fed only when all are set.
  struct Proof {
    bool sensors = false, currents = false, control = false;
  };

  // core.cc: a step
  void ReadClock(const Inputs& inputs) noexcept;
  void Observe(const Inputs& inputs, Observation& seen) noexcept;
  float EndCurrent(const Observation& seen, int coil) const noexcept;
  void Watch(const Observation& seen) noexcept;
  void Advance(const Inputs& inputs, const Observation& seen) noexcept;
  void AdvanceBoot(const Observation& seen) noexcept;
  void AdvanceSelfTest() noexcept;
  void DriveCoils(const Observation& seen, Outputs& outputs) noexcept;
  void CheckOutputs(Outputs& outputs) noexcept;
  void FinishTick(const Inputs& inputs) noexcept;
  std::uint8_t FanSpeed(const Observation& seen) const noexcept;
  void StartSelfTest() noexcept;
  void Enter(wire::State state) noexcept;
  bool Note(wire::Fault fault, std::uint8_t part, float value) noexcept;
  void Raise(wire::Fault fault, std::uint8_t part, float value) noexcept;

  // core_link.cc: frames
  void Reject() noexcept { ++rejected_; }
  void OnHello(const wire::FrameView& view, std::uint8_t version) noexcept;
  void OnCommand(const wire::FrameView& view) noexcept;
  void OnConfig(const wire::FrameView& view) noexcept;
  void OnArm(const wire::FrameView& view) noexcept;
  void OnEstop(const wire::FrameView& view) noexcept;
  void OnFaultRequest(const wire::FrameView& view) noexcept;
  wire::Arm AnswerArm(const wire::Arm& asked) noexcept;
  wire::Arm RefuseArm(std::uint32_t faults) noexcept;
  std::uint32_t ArmObstacles() noexcept;
  wire::Hello Identity() const noexcept;
  void Say(const LogLine& line) noexcept;

  Settings built_;     // as constructed: the range of what CONFIG may set
  Settings settings_;  // in force
  bool settings_are_valid_;
  FaultLatch latch_;
  Arming arming_;
  HallWatch hall_;
  CoilHeat heat_;
  SelfTest self_test_;
  SelfTest::Step test_step_;
  SafetyMonitor monitor_;
  Drive drive_;
  OutputCheck output_check_;
  CommandGate gate_;
  Outbox outbox_;
  TickReport tick_;
  LogRate log_rate_;

  wire::State state_ = wire::State::kBoot;
  int in_state_ = 0;  // steps
  std::uint8_t retest_ = kRetestHall | kRetestCoils;
  float set_point_A_[wire::kCoils] = {};
  HallVerdict hall_verdict_;
  CoilSample samples_[wire::kCoils];
  float end_A_[wire::kCoils] = {};  // currents at the end of the step before, docs/theory/firmware.md (1.5)
  Proof proof_;

  std::uint64_t now_us_ = 0;
  std::uint64_t tick_us_ = 0;  // of the newest telemetry
  bool has_stepped_ = false;
  bool clock_advances_ = true;
  int steps_to_tick_ = kStepsPerTick;
  std::uint8_t fan_ = 0;

  bool host_is_compatible_ = true;
  bool has_config_seq_ = false;
  std::uint16_t config_seq_ = 0;
  std::uint16_t rejected_ = 0;
  std::uint16_t missed_ticks_ = 0;
};

}  // namespace omni::firmware
