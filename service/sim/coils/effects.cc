#include "service/sim/coils/effects.h"
#include "service/sim/fields/vec3.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace omni::sim {
namespace {

constexpr std::size_t kSinglePoles = 8;  // the slowest; the faster ones in groups, each a fifth as many again
constexpr double kGroupGrows = 1.2;

// The nth pole of a sphere is where tan y = (mu - 1) y / (mu - 1 + y^2), n pi < y < (n + 1) pi.
double EddyRoot(std::size_t n, double permeability) noexcept {
  const double whole = std::numbers::pi * static_cast<double>(n);
  double y = whole + 1;
  for (int i = 0; i < 20; ++i) {
    const double next = whole + std::atan((permeability - 1) * y / (permeability - 1 + y * y));
    if (std::abs(next - y) < 1e-12 * y) break;
    y = next;
  }
  return y;
}

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

// The earth's field stays where it is while the base turns under it. The field at start-up has been removed.
Vec3 EarthField(const base::TruthEffects& effects, double t_s) noexcept {
  const base::RoomEffects& room = effects.room;
  const double turned_rad =
      room.turn_rate_rad_s * room.turn_s * Passed(t_s, room.turn_from_s, room.turn_from_s + room.turn_s);
  const Vec3 now_T = Rotated(effects.earth_field_base_T, Vec3{0, 0, -turned_rad});
  return effects.background_known ? now_T - effects.earth_field_base_T : now_T;
}

}  // namespace

// A solid sphere of permeability mu and conductivity sigma in a uniform field [Wait 1951]: with p = s mu0 mu sigma a^2
// its moment is D(p) / D(0) of the static one,
//   D = (2 mu - g) / (mu + g),   g = 1 + x i1'(x) / i1(x),   x = sqrt(p),   i1: the modified spherical Bessel function,
//   D(p) / D(0) = 1 + sum_n w_n (1 / (1 + p / y_n^2) - 1),   w_n = 6 mu / (y_n^2 + (mu - 1) (mu + 2)) / D(0)
// Poles of a group become one of the same weight and mean time.
CoreMemory::CoreMemory(const base::TruthEffects& effects, double core_radius_m) noexcept
    : remanence_Am2_(effects.remanence_Am2),
      eddies_(effects.core_conductivity_S_m > 0 && effects.core_permeability > 1) {
  if (!eddies_) return;
  const double mu = effects.core_permeability;
  const double unit_s = kMu0 * mu * effects.core_conductivity_S_m * core_radius_m * core_radius_m;
  const double static_answer = 2 * (mu - 1) / (mu + 2);
  std::size_t n = 1;
  for (Pole& pole : poles_) {
    const std::size_t end =
        n <= kSinglePoles ? n + 1 : static_cast<std::size_t>(std::ceil(kGroupGrows * static_cast<double>(n)));
    double time_s = 0;
    for (; n < end; ++n) {
      const double y = EddyRoot(n, mu);
      const double weight = 6 * mu / (y * y + (mu - 1) * (mu + 2)) / static_answer;
      pole.weight += weight;
      time_s += weight * unit_s / (y * y);
    }
    pole.time_s = time_s / pole.weight;
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
  double pen_scale = 1;
  for (const base::OtherPen& pen : room.pens) {
    if (t_s >= pen.from_s) pen_scale = pen.moment_scale;
  }
  now.magnet_scale *= pen_scale;
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

Vec3 Environment::MainsField(double t_s) const noexcept {
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
