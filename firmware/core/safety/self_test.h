// Before any coil is driven: checks that the Hall sensors show their own test field with the right sign, and that every
// coil has its resistance and the right sign of the current. docs/theory/firmware.md (5.1), (5.2)
#pragma once

#include "firmware/core/safety/coil_heat.h"
#include "firmware/core/safety/hall_watch.h"

namespace omni::firmware {

class SelfTest {
 public:
  enum class Result : std::uint8_t { kRunning, kPassed, kRefused };

  struct Step {
    Result result = Result::kRunning;
    bool test_field = false;
    bool awake = false;                  // bridges brake or drive
    float voltage_V[wire::kCoils] = {};  // open loop: a wrong sign must not run away
    std::uint32_t fault = 0;             // kRefused: beside kFaultSelfTest
    std::uint8_t part = 0;               // of the fault
    float value = 0;                     // T or ohm
  };

  // `parts`: kRetestHall, kRetestCoils or both. Coils come last.
  void Start(std::uint8_t parts) noexcept;

  Step Advance(const Settings& settings, const HallWatch& hall, const HallVerdict& verdict,
               const CoilSample (&coils)[wire::kCoils]) noexcept;

  bool drives_coils() const noexcept { return phase_ >= Phase::kCoilWake && phase_ < Phase::kDone; }
  // Valid after it has passed with kRetestCoils.
  const float (&resistance_ohm() const noexcept)[wire::kCoils] { return resistance_ohm_; }

 private:
  enum class Phase : std::uint8_t {
    kHallRest,     // samples without the test field
    kHallSettle,   // it is switched on
    kHallField,    // samples with it
    kHallRelease,  // it is switched off
    kHallAgain,    // samples without it: the drift meanwhile
    kCoilWake,     // bridges wake up, braking
    kCoilDrive,    // about an ampere
    kCoilRest,     // brake
    kDone
  };
  struct Sums {
    std::int32_t sum[wire::kSensors][3] = {};
    std::uint8_t count[wire::kSensors] = {};
    std::uint32_t saturated_mask = 0;
  };

  void Enter(Phase phase) noexcept;
  void AfterHall() noexcept;
  bool Collect(const Settings& settings, const HallWatch& hall, const HallVerdict& verdict, Sums& sums) noexcept;
  void JudgeHall(const Settings& settings, Step& step) noexcept;
  void HallPhases(const Settings& settings, const HallWatch& hall, const HallVerdict& verdict, Step& step) noexcept;
  void CoilPhases(const Settings& settings, const CoilSample (&coils)[wire::kCoils], Step& step) noexcept;
  void JudgeCoil(const Settings& settings, Step& step) noexcept;

  Phase phase_ = Phase::kDone;
  std::uint8_t parts_ = 0;
  int in_phase_ = 0;  // steps
  int attempt_ = 0;
  int coil_ = 0;
  Sums rest_, field_, again_;
  float current_sum_A_ = 0, voltage_sum_V_ = 0;
  float resistance_ohm_[wire::kCoils] = {};
};

}  // namespace omni::firmware
