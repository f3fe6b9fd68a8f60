#include "service/haptics/stability/contact_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace omni::haptics {
namespace {

constexpr double kLeak_J = 5e-3;     // a stable press gives less than 1 mJ, a limit cycle 100 mJ in seconds
constexpr double kLeakForget_s = 2;  // an old leak fades, so that small errors do not add up for hours
constexpr double kLeakFall_s = 0.05, kLeakRise_s = 5;
constexpr double kLeakGainMin = 0.1;

}  // namespace

// E(t) = sum F . dx - c v_n^2 dt: what the coils have given to the hand beyond c of its damping. With what the springs
// still hold, a surface within the rule of stability.h keeps E + U <= 0. What is over is a leak   (3.9).
double WatchEnergy(const ContactTick& tick, EnergyState& state) noexcept {
  const bool counts = tick.passive && tick.acting.known;
  if (counts && state.has_tip && state.acting.known) {
    state.given_J += Dot(0.5 * (state.acting.force_N + tick.acting.force_N), tick.tip - state.tip);
    const double speed_m_s = Dot(tick.velocity_m_s, Normalized(tick.force_N));
    if (tick.force_N != Vec3{}) {
      const double noise_m2_s2 = tick.velocity_noise_m_s * tick.velocity_noise_m_s;
      state.given_J -= kMayTake_Ns_m * (speed_m_s * speed_m_s - noise_m2_s2) * tick.dt_s;
    }
  }
  state.tip = tick.tip;
  state.acting = tick.acting;
  state.has_tip = true;
  const double stored_J = state.gain * tick.stored_J;
  state.given_J -= std::min(1.0, tick.dt_s / kLeakForget_s) * (state.given_J + stored_J);
  if (!counts) state.given_J = -stored_J;
  const double leak_J = state.given_J + stored_J;
  if (leak_J > kLeak_J) {
    state.gain = std::max(kLeakGainMin, state.gain * (1 - std::min(0.5, tick.dt_s / kLeakFall_s)));
    ++state.leaking_ticks;
  } else if (state.gain < 1 && leak_J < 0.5 * kLeak_J) {
    state.gain = std::min(1.0, state.gain + tick.dt_s / kLeakRise_s);
  }
  return state.gain;
}

namespace {

constexpr double kPi = std::numbers::pi;

enum class Cause : std::uint8_t {
  kFast,   // no hand moves like that
  kLight,  // the swing of a hand too light for its damping to be relied on
  kFed,    // a hand can move like that: a swing if the surface feeds it
};

// Half swings of a kind: slower motion than `corner_Hz` is no swing; two last at most `period_max_s` (where the tip
// leaves the surface one is longer than the other) and each reaches `least_N`. Of the gain a cut leaves `falls_to`: at
// least, if the swing is fed, else at most.
struct Band {
  double corner_Hz, period_max_s, least_N, falls_to;
  Cause cause;
  bool in_touch;  // what leaves the surface in between is a hand that taps
};
constexpr std::array<Band, kSwingBands> kBands{{
    {16, 0.062, 0.005, 0.20, Cause::kFast, false},
    {6, 0.120, 0.100, 0.20, Cause::kLight, false},
    {6, 0.120, 0.100, 0.20, Cause::kFed, false},
    {3, 0.340, 0.100, 0.55, Cause::kFed, true},  // slow enough to wait for the next half swing
}};
constexpr std::size_t kSlowest = kSwingBands - 1;
constexpr double kNoises = 3;     // standard deviations that are no swing
constexpr double kFedNoises = 5;  // from fewer, what the surface feeds is not known well enough
constexpr int kHalves = 3;
// A light hand that takes more than any tremor does: its half swings may be longer, as late replies make them, and of
// two that no tremor is fast enough for one less is enough.
constexpr double kSure_Ns_m = 0.45, kSureHalf = 1.1, kSurePair_s = 0.070;
constexpr double kPressing = 1.2;  // of the longest half swing of a light hand: of the one that presses
constexpr double kLasts = 0.95;    // of the half swing before: less is one that dies away

// The heaviest light hand and its softest spring: nothing lighter swings slower.
constexpr double kLightMass_kg = 0.0525, kLightStiffness_N_m = 130;
constexpr double kLightDamping_Ns_m = 0.04;  // of which a surface may take so much, less than the least that it has
constexpr double kLeastDamping_Ns_m = 0.1;   // of any hand: what takes less does not make it swing
// More than kMayTake_Ns_m by what noise adds: ordinary hands reach 0.71 (tests/haptics/swing.cc).
constexpr double kFed_Ns_m = 0.8;
constexpr double kKeep = 0.85;      // of the work of earlier half swings
constexpr double kStep_s = 4.5e-3;  // the speed over less is mostly noise
// A light hand keeps this share of the stiffness, and at most b / (2 D) = 5 N/m: a hand of b = 0.1 Ns/m holds that
// still against replies that take D = 10 ms.
constexpr double kGainMin = 0.01, kLeft_N_m = 5;
constexpr double kHeld = 0.08;   // and gets back at most this share while it touches
constexpr double kLeft_s = 0.1;  // in the air: forgotten
constexpr double kIdle_s = 0.5, kIdle_N = 0.05, kRise_s = 0.3, kForget_s = 500;
// After a cut, a swing that was fed has died away by the second window to less than this share of the first.
constexpr double kFirst_s[] = {0.3, 0.8}, kSecond_s[] = {1.5, 2.0}, kGoesOn = 0.6;
constexpr double kGrows = 2;  // the hand's own motion does not, when the surface is hard again

// T = 2 pi sqrt(m / (g K + k))
double LightPeriod_s(double stiffness_N_m) noexcept {
  return 2 * kPi * std::sqrt(kLightMass_kg / (stiffness_N_m + kLightStiffness_N_m));
}

// What a tick adds to the swing.
struct Change {
  double stiffness_N_m, dt_s;
  double moved_N;   // K dx . n
  double acting_N;  // of the acting force along n
};

// s <- (s + K dx . n) (1 - 2 pi f dt), and likewise the acting force; W = sum F dx over both, V = sum v^2 dt.
void FollowMotion(const Band& band, const Change& change, SwingBandState& state) noexcept {
  const double keep = std::max(0.0, 1 - 2 * kPi * band.corner_Hz * change.dt_s);
  const double swing_N = (state.swing_N + change.moved_N) * keep, acting_N = (state.acting_N + change.acting_N) * keep;
  const double moved_m = (swing_N - state.swing_N) / change.stiffness_N_m;
  state.fed_J += 0.5 * (acting_N + state.acting_N) * moved_m;
  state.step_m += moved_m;
  state.step_s += change.dt_s;
  if (state.step_s >= kStep_s) {
    state.motion_m2_s += state.step_m * state.step_m / state.step_s;
    state.step_m = state.step_s = 0;
  }
  state.swing_N = swing_N;
  state.acting_N = acting_N;
  state.half_s += change.dt_s;
  state.peak_N = std::max(state.peak_N, std::abs(swing_N));
}

// True: too many half swings did not die away, and another has not.
bool FollowBand(const Band& band, double half_max_s, const Change& change, double least_N,
                SwingBandState& state) noexcept {
  FollowMotion(band, change, state);
  if (state.half_s > band.period_max_s) state.halves = 0;
  const int side = state.swing_N > least_N ? 1 : state.swing_N < -least_N ? -1 : 0;
  if (side == 0 || side == state.side) return false;
  state.damping_Ns_m = state.motion_m2_s > 0 ? state.fed_J / state.motion_m2_s : 0;
  const bool sure = band.cause == Cause::kLight && state.damping_Ns_m > kSure_Ns_m;
  if (sure) half_max_s *= kSureHalf;
  const double pressing_s = state.side < 0 ? state.half_s : state.last_half_s;
  const double pair_s = state.half_s + state.last_half_s;
  const bool fast = pair_s <= band.period_max_s && std::min(state.half_s, state.last_half_s) <= half_max_s &&
                    pressing_s <= kPressing * half_max_s;
  const bool lasts = fast && state.last_peak_N > 0 && state.peak_N > kLasts * state.last_peak_N;
  state.halves = std::clamp(state.halves + (lasts ? 1 : -1), 0, kHalves);
  const int enough = sure && pair_s <= kSurePair_s ? kHalves - 1 : kHalves;
  state.last_half_s = state.half_s;
  state.last_peak_N = state.peak_N;
  state.peak_N = std::abs(state.swing_N);
  state.side = side;
  state.half_s = 0;
  state.fed_J *= kKeep;
  state.motion_m2_s *= kKeep;
  return lasts && state.halves >= enough;
}

// The work W = c V that a swing took from the hand is proportional to the gain: c g' / g of damping is taken at g'.
// `known`: the acting force was, from which c comes.
void Cut(const Band& band, bool known, double taken_Ns_m, SwingState& state) noexcept {
  if (band.cause == Cause::kLight && known && !(taken_Ns_m > kLeastDamping_Ns_m)) return;
  if (band.cause == Cause::kFed) {
    if (!(taken_Ns_m > kFed_Ns_m)) return;
    state.gain *= std::max(band.falls_to, kMayTake_Ns_m / taken_Ns_m);
    state.held = std::min(state.held, state.gain);
  } else {
    const double share = taken_Ns_m > 0 ? std::min(kHeld, kLightDamping_Ns_m / taken_Ns_m) : kHeld;
    state.held = std::min(state.held, share * state.gain);
    state.gain = std::min(band.falls_to * state.gain, kLeft_N_m / state.stiffness_N_m);
  }
  state.gain = std::max(kGainMin, state.gain);
  state.held = std::max(kGainMin, state.held);
  state.cut_s = state.idle_s = state.first_peak_N = state.last_peak_N = 0;
}

// The gain comes back to what the hand holds once nothing moves; and wholly if what moves has gone on without the
// surface, a tremor of the hand's own, unless it then grows: a light hand swings on for long as well.
void Recover(double idle_N, double dt_s, SwingState& state) noexcept {
  const double moves_N = std::abs(state.bands[kSlowest].swing_N);
  const auto during = [&state](const double(&window_s)[2]) {
    return state.cut_s > window_s[0] && state.cut_s < window_s[1];
  };
  state.cut_s += dt_s;
  state.idle_s = moves_N > idle_N ? 0 : state.idle_s + dt_s;
  const bool idle = state.idle_s >= kIdle_s;
  if (during(kFirst_s)) state.first_peak_N = std::max(state.first_peak_N, moves_N);
  if (during(kSecond_s)) state.last_peak_N = std::max(state.last_peak_N, moves_N);
  if (idle) state.first_peak_N = std::numeric_limits<double>::infinity();
  if (!state.fed && state.cut_s >= kSecond_s[1] && state.last_peak_N > kGoesOn * state.first_peak_N) {
    if (!state.own) {
      state.own = true;
      state.own_N = state.last_peak_N;
      state.held_before = state.held;
    }
    state.held = 1;
  }
  if (state.own && moves_N > kGrows * state.own_N) {
    state.own = false;
    state.fed = true;
    state.held = std::min(state.held, state.held_before);
    state.gain = std::min(state.gain, state.held);
  }
  if (!idle && !state.own) return;
  state.held = std::min(1.0, state.held + dt_s / kForget_s);
  state.gain = std::min(state.held, state.gain + dt_s / kRise_s);
}

}  // namespace

double WatchSwings(const ContactTick& tick, double other_gain, SwingState& state) noexcept {
  const double force_N = Norm(tick.force_N);
  const bool touches = force_N > 0 && tick.stiffness_N_m > 0;
  if (!touches && !state.has_tip && state.gain == 1) return 1;  // a far tip costs nothing
  state.left_s = touches ? 0 : state.left_s + tick.dt_s;
  if (state.left_s > kLeft_s || !tick.judged) {
    const double gain = tick.judged ? 1 : state.gain;
    state = {};
    state.gain = state.held = gain;
    return gain;
  }
  if (touches) {
    const double sign = Dot(tick.force_N, state.direction) < 0 ? -1 : 1;  // a spring's force turns round
    state.direction = (sign / force_N) * tick.force_N;
    state.stiffness_N_m = tick.stiffness_N_m;
  }
  Change change{state.stiffness_N_m, tick.dt_s, 0, 0};
  if (state.has_tip) change.moved_N = state.stiffness_N_m * Dot(tick.tip - state.tip, state.direction);
  if (state.has_tip && tick.acting.known && state.acting.known) {
    change.acting_N = Dot(tick.acting.force_N - state.acting.force_N, state.direction);
  }
  state.tip = tick.tip;
  state.acting = tick.acting;
  state.has_tip = true;
  const double noise_N = state.stiffness_N_m * tick.noise_m;
  for (std::size_t b = 0; b < kSwingBands; ++b) {
    const Band& band = kBands[b];
    if (!touches && band.in_touch) state.bands[b] = {};
    if (band.cause == Cause::kLight && state.own) continue;
    const double half_max_s = band.cause == Cause::kLight
                                  ? 0.5 * LightPeriod_s(other_gain * state.gain * state.stiffness_N_m)
                                  : band.period_max_s;
    const double noises = band.cause == Cause::kFed ? kFedNoises : kNoises;
    const double least_N = std::max(band.least_N / state.gain, noises * noise_N);
    if (FollowBand(band, half_max_s, change, least_N, state.bands[b])) {
      Cut(band, tick.acting.known, state.bands[b].damping_Ns_m, state);
    }
  }
  if (state.gain < 1 || state.own) Recover(std::max(kIdle_N, kNoises * noise_N), tick.dt_s, state);
  return state.gain;
}

double WatchContacts(const ContactTick& tick, SwingState& swing, EnergyState& energy) noexcept {
  const double gain = WatchSwings(tick, energy.gain, swing);
  ContactTick left = tick;
  left.stored_J *= gain;
  return gain * WatchEnergy(left, energy);
}

}  // namespace omni::haptics
