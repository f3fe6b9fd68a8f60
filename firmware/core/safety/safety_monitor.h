// One detector for every fault that the base itself can see; thresholds in fault_rules.h and Settings. It reports its
// findings and what refuses ARM; the reaction is the core's.
#pragma once

#include "firmware/core/drive.h"
#include "firmware/core/safety/hall_watch.h"

namespace omni::firmware {

// A control step in SI units, before any processing.
struct Observation {
  wire::State state = wire::State::kBoot;
  HallVerdict hall;
  float current_A[wire::kCoils] = {};
  float voltage_V[wire::kCoils] = {};  // without sign
  std::uint8_t measured_mask = 0;      // bit k: current sensor k answered
  std::uint8_t driver_fault = 0;       // bit k
  float supply_V = 0;
  float board_C = 0;
  float fan_rpm = 0;
  std::uint8_t fan = 0;  // as commanded in the previous step
  bool emergency_stop = false;
  bool clock_advances = true;
  bool drives_test = false;  // the self-test is driving coils
};

struct Finding {
  wire::Fault fault = wire::kFaultInternal;
  std::uint8_t part = kWholeBase;
  float value = 0;
};

class SafetyMonitor {
 public:
  void Step(const Settings& settings, const Observation& seen, const CoilHeat& heat, const Drive& drive) noexcept;

  // Of this step. A persistent fault is found in every step.
  int count() const noexcept { return count_; }
  const Finding& finding(int i) const noexcept { return findings_[i]; }
  // Fault bits whose cause is, or was until recently, present by ARM's stricter limits.
  std::uint32_t causes() const noexcept { return causes_ | causes_before_; }

 private:
  static constexpr int kParts = wire::kSensors + 1;  // the last: the whole base
  static constexpr int kFindingsMax = 16;            // further ones are found again in the next step

  // Reports a condition once it has held for as long as the rule says.
  void Check(wire::Fault fault, int part, bool holds, float value) noexcept;
  void Report(wire::Fault fault, int part, float value) noexcept;
  void Block(wire::Fault fault, bool holds) noexcept {
    if (holds) causes_ |= fault;
  }
  void ForgetCauses() noexcept;
  void CheckCoils(const Settings& settings, const Observation& seen, const Drive& drive) noexcept;
  void CheckModel(int coil, const Settings& settings, const Observation& seen, const CoilHeat& heat,
                  const Drive& drive) noexcept;
  void CheckSupply(const Settings& settings, const Observation& seen) noexcept;
  void CheckHeat(const Settings& settings, const Observation& seen, const CoilHeat& heat) noexcept;
  void CheckHall(const Observation& seen) noexcept;

  std::uint16_t held_[kFaultCount][kParts] = {};
  Finding findings_[kFindingsMax];
  int count_ = 0;
  std::uint32_t causes_ = 0;
  std::uint32_t causes_before_ = 0;  // of the kCauseGone_steps before these
  int cause_steps_ = 0;
  float model_A_[wire::kCoils] = {};  // current that the measured voltage produces
  float power_W_ = 0;
};

}  // namespace omni::firmware
