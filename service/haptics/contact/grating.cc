#include "service/haptics/contact/grating.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace omni::haptics {
namespace {

constexpr double kMost_N = 0.1;
constexpr double kPace_s = 0.08;                          // of the speed that decides whether the tip moves
constexpr double kRests_m_s = 1.5e-3, kMoves_m_s = 4e-3;  // nothing below, full above: what is left of a tremor
constexpr double kTurned = 0.94;                          // cosine, 20 degrees: another direction
constexpr double kTurn_m = 1e-3;
constexpr double kJump_m = 5e-3;  // another place
constexpr double kRate_s = 0.02;  // of the speed that decides how closely the place is followed
constexpr double kWay_m = 2e-3;   // of the tip, in which the place is drawn to the measured one ...
constexpr double kSlowest_rad_s = 12, kFastest_rad_s = 90;  // ... within these bounds
constexpr double kShiftBack = 0.05;                         // of the frequency
// Of the force behind the coil's current, which the core's eddy currents delay, and of samples behind their scan's
// stamp; `omni-bench texture` has the greatest correlation with .8 to 1.5 ms.
constexpr double kLate_s = 1e-3;
constexpr double kMostBoost = 1.5;

// Turns, to the nearest whole one.
double Wrapped(double turns) noexcept { return turns - std::round(turns); }

// The nearest of a fixed set of lines, about 14 degrees apart; of its two directions always the same one.
Vec3 NearestLine(const Vec3& direction) noexcept {
  const double largest = std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
  if (!(largest > 0)) return {};
  const auto step = [&](double c) noexcept { return std::round(4 * c / largest); };
  const Vec3 line = Normalized(Vec3{step(direction.x), step(direction.y), step(direction.z)});
  const double sign = line.x != 0 ? line.x : (line.y != 0 ? line.y : line.z);
  return sign < 0 ? -1 * line : line;
}

}  // namespace

// The place is filtered by a second order of frequency w and damping 1 / sqrt(2). The faster the tip, the closer it is
// followed: noise counts less there, and what a stroke's acceleration a delays, a / w^2, more.   (6.1)
void FollowPlace(const SlidingTip& tip, GratingState& state) noexcept {
  state.rate_m_s = state.rate_m_s + std::min(1.0, tip.dt_s / kRate_s) * (tip.slip_m_s - state.rate_m_s);
  const Vec3 ran = state.place_m + tip.dt_s * state.slip_m_s;
  const Vec3 off = tip.place_m - ran;
  if (!state.started || !(SquaredNorm(off) < kJump_m * kJump_m)) {
    state.started = true;
    state.place_m = tip.place_m;
    state.slip_m_s = state.rate_m_s;
    return;
  }
  const double w = std::clamp(Norm(state.rate_m_s) / kWay_m, kSlowest_rad_s, kFastest_rad_s);
  state.place_m = ran + (std::numbers::sqrt2 * w * tip.dt_s) * off;
  state.slip_m_s = state.slip_m_s + (tip.dt_s * w * w) * off;
  state.pace_m_s = state.pace_m_s + std::min(1.0, tip.dt_s / kPace_s) * (state.slip_m_s - state.pace_m_s);
}

Vec3 PlaceOfForce(const SlidingTip& tip, const GratingState& state) noexcept {
  return state.place_m + (tip.ahead_s + kLate_s) * state.slip_m_s;
}

namespace {

// Turns at the place, across the ridges.
double TurnsAt(double wavelength_m, const GratingState& state) noexcept {
  return Dot(state.place_m, state.across) / wavelength_m + state.shift;
}

// The ridges lie across the stroke. A tip that is slow, and feels little of them yet, gets those of the place at once.
// Later, where the stroke has turned for a wavelength, the phase goes on as it is and then drifts to that of the place,
// too slowly to notice.
void TurnRidges(double wavelength_m, double dt_s, bool slow, GratingState& state) noexcept {
  const double speed_m_s = Norm(state.pace_m_s);
  if (slow) state.shift = 0;
  if (!(speed_m_s > 0)) return;
  const Vec3 direction = (1 / speed_m_s) * state.pace_m_s;
  if (std::abs(Dot(direction, state.across)) > kTurned) {
    state.turned_m = 0;
  } else if (slow || (state.turned_m += speed_m_s * dt_s) > std::max(wavelength_m, kTurn_m)) {
    const double turns = TurnsAt(wavelength_m, state);
    state.across = NearestLine(direction);
    if (!slow) state.shift = Wrapped(turns - Dot(state.place_m, state.across) / wavelength_m);
    state.turned_m = 0;
  }
  const double most = kShiftBack * speed_m_s * dt_s / wavelength_m;
  state.shift -= std::clamp(state.shift, -most, most);
}

// 1 / |H| of the first order lags of coil and core, and of a force that is held for a tick.
double BoostAt(double frequency_Hz, const SlidingTip& tip) noexcept {
  const double turn = 2 * std::numbers::pi * frequency_Hz;
  const double half = 0.5 * turn * tip.dt_s;
  const double held = half > 1e-6 ? half / std::sin(std::min(half, 1.5)) : 1;
  return std::min(kMostBoost, held * std::hypot(1, turn * tip.coil_lag_s) * std::hypot(1, turn * kLate_s));
}

}  // namespace

// F = gain K a cos(2 pi x . e / lambda), at most 0.1 N and half the normal force   (6.1)
double Grating::ForceOn(const SlidingTip& tip, double stiffness_N_m, double normal_force_N,
                        GratingState& state) const noexcept {
  if (!IsFelt() || !(tip.dt_s > 0)) return 0;
  FollowPlace(tip, state);
  const double moves = std::clamp((Norm(state.pace_m_s) - kRests_m_s) / (kMoves_m_s - kRests_m_s), 0.0, 1.0);
  TurnRidges(wavelength_m, tip.dt_s, moves < 1, state);
  if (!(moves > 0)) return 0;
  const double along_m_s = Dot(state.slip_m_s, state.across);
  const double frequency_Hz = std::abs(along_m_s) / wavelength_m;
  const double follows = std::clamp((kRippleStop_Hz - frequency_Hz) / (kRippleStop_Hz - kRippleFade_Hz), 0.0, 1.0);
  const double amplitude_N = std::min({gain * stiffness_N_m * amplitude_m, kMost_N, 0.5 * normal_force_N});
  const double turns = TurnsAt(wavelength_m, state) + (tip.ahead_s + kLate_s) * along_m_s / wavelength_m;
  return moves * follows * BoostAt(frequency_Hz, tip) * amplitude_N * std::cos(2 * std::numbers::pi * Wrapped(turns));
}

}  // namespace omni::haptics
