// The coils' temperatures by two estimates: by their resistance, wherever the current is large enough to measure, and
// by a heat model (two nodes: each coil's copper, one body). The hotter one counts. docs/theory/firmware.md (3.1) to
// (3.5)
#pragma once

#include "firmware/core/link/settings.h"

namespace omni::firmware {

// A coil's electrical means over a control step.
struct CoilSample {
  float current_A = 0;     // signed
  float voltage_V = 0;     // without sign
  bool is_usable = false;  // both were measured, driven, and voltage and current have the same sign
};

class CoilHeat {
 public:
  explicit CoilHeat(const Settings& settings) noexcept;

  // Every control step.
  void Step(const Settings& settings, const CoilSample (&samples)[wire::kCoils]) noexcept;

  // The self-test has measured all coils: initialises nodes that were only assumed so far.
  void Start(const Settings& settings, const float (&resistance_ohm)[wire::kCoils]) noexcept;

  float resistance_ohm(int coil) const noexcept { return resistance_ohm_[coil]; }
  // The hotter of both.
  float temperature_C(int coil) const noexcept;
  float hottest_C() const noexcept;
  float by_resistance_C(int coil) const noexcept { return static_cast<float>(by_resistance_C_[coil]); }
  float by_heat_C(int coil) const noexcept { return static_cast<float>(copper_C_[coil]); }
  float body_C() const noexcept { return static_cast<float>(body_C_); }

 private:
  struct Window {
    float current_sum_A = 0, voltage_sum_V = 0, square_sum_A2 = 0;
    float first_A = 0, last_A = 0;
    bool is_usable = true;
  };

  void Advance(const Settings& settings) noexcept;
  void FollowResistance(const Settings& settings, int coil, const Window& window) noexcept;

  Window windows_[wire::kCoils];
  int steps_ = 0;
  // In double: 10 ms changes them by less than the last digit of a float.
  double by_resistance_C_[wire::kCoils] = {};
  double copper_C_[wire::kCoils] = {};
  double body_C_ = 0;
  float resistance_ohm_[wire::kCoils] = {};
};

float ResistanceAt(const Settings& settings, int coil, float temperature_C) noexcept;

}  // namespace omni::firmware
