#include "service/sim/effects.h"
#include "service/sim/constants.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace omni::sim {
namespace {

constexpr double kSlowest_Hz = 0.0316;  // of the eddy poles, two per decade from here to 10 kHz

}  // namespace

// H(s) = (1 - sqrt(s/wc) / 2) / (1 + sqrt(s/wc)) = 1 + 3/2 (F - 1), F = 1 / (1 + sqrt(s/wc)),
// F = 1/pi int sqrt(u) / (1 + u) / (1 + s / (u wc)) d ln u: poles at u wc. Two per decade, each with the integral about
// itself; those faster than 10 kHz act at once, so that H stays exact at low frequency.
CoreMemory::CoreMemory(const base::TruthEffects& effects, double core_radius_m) noexcept
    : remanence_Am2_(effects.remanence_Am2), eddies_(effects.core_conductivity_S_m > 0) {
  if (!eddies_) return;
  const double corner_rad_s =
      effects.core_permeability / (kMu0 * effects.core_conductivity_S_m * core_radius_m * core_radius_m);
  const auto below = [](double u) { return 2 / std::numbers::pi * std::atan(std::sqrt(u)); };  // int_0^u
  const double spacing = std::sqrt(10.0);
  double rate_rad_s = 2 * std::numbers::pi * kSlowest_Hz;
  double from = 0;  // the slowest pole stands for all below it
  for (Pole& pole : poles_) {
    const double to = below(std::sqrt(spacing) * rate_rad_s / corner_rad_s);
    pole.time_s = 1 / rate_rad_s;
    pole.weight = 1.5 * (to - from);
    from = to;
    rate_rad_s *= spacing;
  }
}

void CoreMemory::Start(const Vec3& induced_Am2) noexcept {
  induced_Am2_ = induced_Am2;
  played_Am2_.fill(induced_Am2);
  for (Pole& pole : poles_) pole.lagged_Am2 = induced_Am2;
}

// Lag: T dx/dt = m - x, exact for m linear in time. Play: x follows m at the end of a string of length r.
void CoreMemory::Step(const Vec3& induced_Am2, double dt_s) noexcept {
  if (eddies_) {
    const Vec3 slope = (1 / dt_s) * (induced_Am2 - induced_Am2_);
    for (Pole& pole : poles_) {
      const Vec3 before = pole.lagged_Am2 - induced_Am2_ + pole.time_s * slope;
      pole.lagged_Am2 = induced_Am2 - pole.time_s * slope + std::exp(-dt_s / pole.time_s) * before;
    }
  }
  for (std::size_t i = 0; i < kPlay.size(); ++i) {
    const Vec3 string = played_Am2_[i] - induced_Am2;
    const double length = Norm(string);
    const double most = kPlay[i] * remanence_Am2_;
    if (length > most) played_Am2_[i] = induced_Am2 + (most / length) * string;
  }
  induced_Am2_ = induced_Am2;
}

Vec3 CoreMemory::moment_Am2() const noexcept {
  Vec3 moment;
  for (const Vec3& played : played_Am2_) moment += (1.0 / kPlay.size()) * (played - induced_Am2_);
  if (!eddies_) return moment;
  for (const Pole& pole : poles_) moment += pole.weight * (pole.lagged_Am2 - induced_Am2_);
  return moment;
}

std::array<double, 2> CoreMemory::EddyResponse(double frequency_Hz) const noexcept {
  std::complex<double> h = 1;
  const std::complex<double> s(0, 2 * std::numbers::pi * frequency_Hz);
  for (const Pole& pole : poles_) h += pole.weight * (1.0 / (1.0 + s * pole.time_s) - 1.0);
  return {h.real(), h.imag()};
}

Environment::Environment(const base::TruthEffects& effects, Random& random) noexcept : effects_(effects) {
  const double z = random.Uniform(-1, 1);
  const double angle = 2 * std::numbers::pi * random.Uniform();
  const double rho = std::sqrt(1 - z * z);
  drift_base_T_ = effects.ambient_drift_T * Vec3{rho * std::cos(angle), rho * std::sin(angle), z};
}

Surroundings Environment::At(double t_s) const noexcept {
  const double ramp = std::clamp(t_s / effects_.run_s, 0.0, 1.0);
  Surroundings now;
  now.background_base_T = ramp * drift_base_T_;
  if (!effects_.background_known) now.background_base_T += effects_.earth_field_base_T;
  now.magnet_scale = 1 + effects_.magnet_per_K * effects_.magnet_warming_K * ramp;
  return now;
}

// dI = V D (1 - D) / (f L), D the share of time that the supply is on the coil.
double RipplePeakToPeak(double current_A, double supply_V, double resistance_ohm, double inductance_H,
                        double frequency_Hz) noexcept {
  const double duty = std::min(1.0, std::abs(current_A) * resistance_ohm / supply_V);
  return supply_V * duty * (1 - duty) / (frequency_Hz * inductance_H);
}

}  // namespace omni::sim
