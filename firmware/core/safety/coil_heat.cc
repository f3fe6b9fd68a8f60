#include "firmware/core/safety/coil_heat.h"

#include "firmware/core/numbers.h"

namespace omni::firmware {
namespace {

constexpr int kWindow_steps = 40;  // 10 ms: a sliding mean smooths both readings; heat is far slower
constexpr double kWindow_s = 10e-3;
static_assert(kWindow_steps == 10 * kStepsPerMs, "both describe the same window");
constexpr float kMeasurable_A = 1;      // 1.25 mA and 2 mA of offset then amount to less than a kelvin
constexpr float kInducedShare = 0.02F;  // of the voltage: the inductance is known to 15 %, so 0.3 % or 0.8 K
// Share per window. Up at once, or the current, which shrinks with the temperature, is too small to measure before the
// trip; down slowly, because the two readings differ by the inductance's error.
constexpr double kFollowUp = kWindow_s / 0.05;
constexpr double kFollowDown = kWindow_s / 0.5;
constexpr double kReference_C = 20;  // of Settings' resistances

}  // namespace

float ResistanceAt(const Settings& settings, int coil, float temperature_C) noexcept {
  return settings.coils[coil].resistance_20C_ohm *
         (1 + settings.resistance_per_K * (temperature_C - static_cast<float>(kReference_C)));
}

CoilHeat::CoilHeat(const Settings& settings) noexcept : body_C_(static_cast<double>(settings.air_C)) {
  for (int k = 0; k < wire::kCoils; ++k) {
    by_resistance_C_[k] = copper_C_[k] = body_C_;
    resistance_ohm_[k] = ResistanceAt(settings, k, settings.air_C);
  }
}

// (3.5): after a start everything is as warm as the warmest coil, and at least as warm as the air.
void CoilHeat::Start(const Settings& settings, const float (&resistance_ohm)[wire::kCoils]) noexcept {
  double warmest_C = static_cast<double>(settings.air_C);
  for (int k = 0; k < wire::kCoils; ++k) {
    const float ratio = resistance_ohm[k] / settings.coils[k].resistance_20C_ohm;
    by_resistance_C_[k] = kReference_C + static_cast<double>((ratio - 1) / settings.resistance_per_K);
    resistance_ohm_[k] = resistance_ohm[k];
    warmest_C = by_resistance_C_[k] > warmest_C ? by_resistance_C_[k] : warmest_C;
  }
  for (double& copper_C : copper_C_) copper_C = copper_C > warmest_C ? copper_C : warmest_C;
  body_C_ = body_C_ > warmest_C ? body_C_ : warmest_C;
}

void CoilHeat::Step(const Settings& settings, const CoilSample (&samples)[wire::kCoils]) noexcept {
  for (int k = 0; k < wire::kCoils; ++k) {
    Window& window = windows_[k];
    const float current_A = Abs(samples[k].current_A);
    if (steps_ == 0) {
      window = Window{};
      window.first_A = current_A;
    }
    window.last_A = current_A;
    window.current_sum_A += current_A;
    window.voltage_sum_V += samples[k].voltage_V;
    window.square_sum_A2 += current_A * current_A;
    window.is_usable = window.is_usable && samples[k].is_usable && current_A >= kMeasurable_A;
  }
  if (++steps_ < kWindow_steps) return;
  steps_ = 0;
  Advance(settings);
}

// (3.3), (3.4): two nodes. The temperature by resistance follows their change and is corrected where there is a
// measurement, so that it lags neither in a heating nor in a cooling coil.
void CoilHeat::Advance(const Settings& settings) noexcept {
  const double to_body_W_K = static_cast<double>(settings.copper_to_body_W_K);
  double into_body_W = -static_cast<double>(settings.body_to_air_W_K) * (body_C_ - static_cast<double>(settings.air_C));
  for (int k = 0; k < wire::kCoils; ++k) {
    const Window& window = windows_[k];
    const double square_A2 = static_cast<double>(window.square_sum_A2) / kWindow_steps;
    const double resistance_ohm = static_cast<double>(ResistanceAt(settings, k, temperature_C(k)));
    const double flow_W = to_body_W_K * (copper_C_[k] - body_C_);
    const double change_K =
        (square_A2 * resistance_ohm - flow_W) * kWindow_s / static_cast<double>(settings.copper_J_K);
    copper_C_[k] += change_K;
    by_resistance_C_[k] += change_K;
    into_body_W += flow_W;
    if (window.is_usable) FollowResistance(settings, k, window);
    resistance_ohm_[k] = ResistanceAt(settings, k, by_resistance_C(k));
  }
  body_C_ += into_body_W * kWindow_s / static_cast<double>(settings.body_J_K);
}

// (3.1), (3.2): V = R I + L dI/dt, summed over the window; changes in between cancel.
void CoilHeat::FollowResistance(const Settings& settings, int coil, const Window& window) noexcept {
  const float induced_V = settings.coils[coil].inductance_H * (window.last_A - window.first_A) / kStep_s;
  if (!(Abs(induced_V) <= kInducedShare * window.voltage_sum_V)) return;
  const float resistance_ohm = (window.voltage_sum_V - induced_V) / window.current_sum_A;
  const float ratio = resistance_ohm / settings.coils[coil].resistance_20C_ohm;
  const double measured_C = kReference_C + static_cast<double>((ratio - 1) / settings.resistance_per_K);
  const double higher_K = measured_C - by_resistance_C_[coil];
  by_resistance_C_[coil] += (higher_K > 0 ? kFollowUp : kFollowDown) * higher_K;
}

float CoilHeat::temperature_C(int coil) const noexcept { return Max(by_resistance_C(coil), by_heat_C(coil)); }

float CoilHeat::hottest_C() const noexcept {
  float hottest_C = temperature_C(0);
  for (int k = 1; k < wire::kCoils; ++k) hottest_C = Max(hottest_C, temperature_C(k));
  return hottest_C;
}

}  // namespace omni::firmware
