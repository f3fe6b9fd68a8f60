#include "service/sim/effects.h"
#include "service/sim/constants.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace omni::sim {
namespace {

constexpr double kSlowest_Hz = 0.0316;  // of the eddy poles, two per decade from here to 10 kHz

Vec3 DrawDirection(Random& random) noexcept {
  const double z = random.Uniform(-1, 1);
  const double angle = 2 * std::numbers::pi * random.Uniform();
  const double rho = std::sqrt(1 - z * z);
  return {rho * std::cos(angle), rho * std::sin(angle), z};
}

// Share of the time from `begin` to `end` that has passed; equal: all of it from then on.
double Passed(double t_s, double begin_s, double end_s) noexcept {
  return end_s > begin_s ? std::clamp((t_s - begin_s) / (end_s - begin_s), 0.0, 1.0) : t_s >= end_s ? 1.0 : 0.0;
}

// The earth's field stays where it is while the base turns under it. What was taken at start-up has been removed.
Vec3 EarthField(const base::TruthEffects& effects, double t_s) noexcept {
  const base::RoomEffects& room = effects.room;
  const double turned_rad =
      room.turn_rate_rad_s * room.turn_s * Passed(t_s, room.turn_from_s, room.turn_from_s + room.turn_s);
  const Vec3 now_T = Rotated(effects.earth_field_base_T, Vec3{0, 0, -turned_rad});
  return effects.background_known ? now_T - effects.earth_field_base_T : now_T;
}

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

Environment::Environment(const base::TruthEffects& effects, Random& random) : effects_(effects) {
  drift_base_T_ = effects.ambient_drift_T * DrawDirection(random);
  mains_base_ = DrawDirection(random);
  for (double& phase_rad : mains_phase_rad_) phase_rad = 2 * std::numbers::pi * random.Uniform();
}

Surroundings Environment::At(double t_s) const noexcept {
  const double ramp = std::clamp(t_s / effects_.run_s, 0.0, 1.0);
  const base::RoomEffects& room = effects_.room;
  Surroundings now;
  now.background_base_T = ramp * drift_base_T_ + EarthField(effects_, t_s);
  for (const base::FieldStep& step : room.steps) {
    now.background_base_T += Passed(t_s, step.at_s, step.at_s + step.over_s) * step.change_base_T;
  }
  now.magnet_scale = 1 + effects_.magnet_per_K * effects_.magnet_warming_K * ramp;
  now.sensor_warming_K = effects_.sensor_warming_K * ramp;
  for (std::size_t j = 0; j < room.steel.size(); ++j) {
    if (t_s >= room.steel[j].from_s) now.steel_mask |= 1U << j;
  }
  now.magnet_count = room.magnets.size();
  for (std::size_t j = 0; j < room.magnets.size(); ++j) {
    const base::OtherMagnet& magnet = room.magnets[j];
    const double share = Passed(t_s, magnet.leaves_s, magnet.arrives_s);
    now.magnets[j] = {magnet.from_base_m + share * (magnet.to_base_m - magnet.from_base_m), magnet.moment_Am2};
  }
  return now;
}

Vec3 Environment::Mains(double t_s) const noexcept {
  const base::RoomEffects& room = effects_.room;
  if (room.mains_T == 0) return {};
  const std::array<double, 3> share{1, room.mains_third, room.mains_fifth};
  double sum_T = 0;
  for (std::size_t h = 0; h < share.size(); ++h) {
    const double order = 2 * static_cast<double>(h) + 1;
    sum_T +=
        room.mains_T * share[h] * std::sin(2 * std::numbers::pi * order * room.mains_Hz * t_s + mains_phase_rad_[h]);
  }
  return sum_T * mains_base_;
}

const base::SensorFault* Environment::FaultOf(std::size_t sensor, double t_s) const noexcept {
  for (const base::SensorFault& fault : effects_.room.faults) {
    const bool is_other =
        fault.kind == base::SensorFaultKind::kSwapped && static_cast<std::size_t>(fault.other) == sensor;
    if (t_s >= fault.from_s && (static_cast<std::size_t>(fault.sensor) == sensor || is_other)) return &fault;
  }
  return nullptr;
}

// dI = V D (1 - D) / (f L), D the share of time that the supply is on the coil.
double RipplePeakToPeak(double current_A, double supply_V, double resistance_ohm, double inductance_H,
                        double frequency_Hz) noexcept {
  const double duty = std::min(1.0, std::abs(current_A) * resistance_ohm / supply_V);
  return supply_V * duty * (1 - duty) / (frequency_Hz * inductance_H);
}

}  // namespace omni::sim
