// One H bridge: Pololu G2 high-power motor driver 18v17 [pololu.com/product/2991: "Motor and control connections"].
//
//   PWM low brakes (both ends of the coil to ground), PWM high drives A to B (DIR low) or B to A (DIR high), SLP low
//   lets both ends float: the coil's energy then goes into the supply. FLT is open drain, low: a fault.
//
// So the order is: brake before a change of direction, brake before sleep, and brake when the calls stop.
// Time is counted in PWM periods (20 kHz: 50 us), by the same counter that makes the PWM.
//
// Pins policy:
//   void SetDuty(std::uint16_t duty) noexcept;        0 to 32767 of the period high, from the next period on; 0: low
//   void SetDirection(bool negative) noexcept;        at once
//   void SetAwake(bool awake) noexcept;               at once
//   bool FaultIsLow() noexcept;
//   std::uint32_t PwmPeriods() noexcept;              since start, wraps
#pragma once

#include <cstdint>

namespace omni::drivers {

struct G2Settings {
  std::uint32_t brake_before_sleep_periods = 200;  // 10 ms at 20 kHz: more than six time constants of a coil
  std::uint32_t wake_periods = 20;                 // FLT is not valid until 1 ms after SLP rises
  std::uint32_t dead_periods = 40;                 // 2 ms without Apply: brake
};

struct G2Counters {
  std::uint32_t rejected = 0;  // duties outside +-32767
  std::uint32_t dead = 0;      // times that the calls stopped
  std::uint32_t faults = 0;    // edges of FLT while awake
};

template <class Pins>
class G2Driver {
 public:
  explicit G2Driver(Pins& pins, const G2Settings& settings = G2Settings()) noexcept
      : pins_(pins), settings_(settings) {}

  // Asleep, PWM low. Before anything else, also before the PWM's pins are switched to the timer.
  void Start() noexcept {
    pins_.SetDuty(0);
    pins_.SetAwake(false);
    pins_.SetDirection(false);
    state_ = State::kAsleep;
    negative_ = false;
    duty_ = 0;
    awake_ = false;
    last_apply_ = pins_.PwmPeriods();
  }

  // Once per control step. `duty` is in -32767..32767 of the supply; not awake: brake, then sleep.
  void Apply(std::int16_t duty, bool awake) noexcept {
    const bool valid = duty >= -kDutyFull;
    if (!valid) ++counters_.rejected;
    duty_ = valid ? duty : 0;
    awake_ = awake;
    last_apply_ = pins_.PwmPeriods();
    dead_ = false;
    Advance();
  }

  // As often as desired; from another interrupt than Apply's if a failure of that one is to be detected (the two must
  // not interrupt each other).
  void Advance() noexcept {
    const std::uint32_t now = pins_.PwmPeriods();
    NoticeDeath(now);
    NoticeFault(now);
    const int duty = dead_ || fault_ || !awake_ ? 0 : duty_;
    if (state_ == State::kAsleep) {
      if (awake_ && !dead_) Wake(now);
      return;
    }
    if (duty != 0 && (duty < 0) == negative_ && state_ == State::kDriving) {
      pins_.SetDuty(Magnitude(duty));
      return;
    }
    Brake(now);
    const std::uint32_t braked = now - braking_since_;
    // Two counts: at least one whole period, wherever in a period braking began.
    if (duty != 0 && braked >= 2) Drive(duty);
    if (!awake_ && braked >= settings_.brake_before_sleep_periods) Sleep();
  }

  bool awake() const noexcept { return state_ != State::kAsleep; }
  bool driving() const noexcept { return state_ == State::kDriving; }
  // FLT is low and valid. Meanwhile the bridge brakes.
  bool fault() const noexcept { return fault_; }
  const G2Counters& counters() const noexcept { return counters_; }

 private:
  static constexpr std::int16_t kDutyFull = 32767;
  enum class State : std::uint8_t { kAsleep, kBraking, kDriving };

  static std::uint16_t Magnitude(int duty) noexcept { return static_cast<std::uint16_t>(duty < 0 ? -duty : duty); }

  void NoticeDeath(std::uint32_t now) noexcept {
    if (dead_ || now - last_apply_ <= settings_.dead_periods) return;
    dead_ = true;
    // While asleep, missing calls are not a failure.
    if (state_ != State::kAsleep) ++counters_.dead;
  }

  void NoticeFault(std::uint32_t now) noexcept {
    const bool settled = state_ != State::kAsleep && (settled_ || now - awake_since_ >= settings_.wake_periods);
    settled_ = settled;
    const bool low = settled && pins_.FaultIsLow();
    if (low && !fault_) ++counters_.faults;
    fault_ = low;
  }

  void Wake(std::uint32_t now) noexcept {
    pins_.SetDuty(0);
    pins_.SetAwake(true);
    state_ = State::kBraking;
    braking_since_ = awake_since_ = now;
    settled_ = false;
  }

  void Brake(std::uint32_t now) noexcept {
    pins_.SetDuty(0);
    if (state_ == State::kDriving) braking_since_ = now;
    state_ = State::kBraking;
  }

  void Drive(int duty) noexcept {
    negative_ = duty < 0;
    pins_.SetDirection(negative_);
    pins_.SetDuty(Magnitude(duty));
    state_ = State::kDriving;
  }

  void Sleep() noexcept {
    pins_.SetAwake(false);
    state_ = State::kAsleep;
  }

  Pins& pins_;
  G2Settings settings_;
  G2Counters counters_;
  State state_ = State::kAsleep;
  bool negative_ = false, awake_ = false, dead_ = false, fault_ = false, settled_ = false;
  std::int16_t duty_ = 0;
  std::uint32_t last_apply_ = 0, braking_since_ = 0, awake_since_ = 0;
};

}  // namespace omni::drivers
