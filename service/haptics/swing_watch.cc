#include "service/haptics/swing_watch.h"

#include <algorithm>
#include <cmath>

namespace omni::haptics {
namespace {

// Half swings of a kind: slower motion than `corner_Hz` is no swing; two last at most `period_max_s` (where the tip
// leaves the surface one is longer than the other) and each reaches `least_N`.
struct Band {
  double corner_Hz, period_max_s, least_N;
  bool in_touch;  // what leaves the surface in between is a hand that taps
};
constexpr std::array<Band, kSwingBands> kBands{{
    {16, 0.062, 0.005, false},  // no hand moves like that ...
    {6, 0.120, 0.100, false},   // ... nor so far so fast
    {3, 0.340, 0.100, true},    // more than any tremor
}};
constexpr double kNoises = 3;  // standard deviations that are no swing
constexpr int kHalves = 3;
constexpr double kLasts = 0.95;  // of the half swing before: less is one that dies away
// A swinging contact keeps this share of its stiffness, and at most b / (2 D) = 5 N/m: a hand of b = 0.1 Ns/m holds
// that still against replies that take D = 10 ms.
constexpr double kFall = 0.2, kGainMin = 0.01, kLeft_N_m = 5;
constexpr double kLeft_s = 0.1;  // in the air: forgotten

// True: too many half swings did not die away, and another has not.
bool FollowBand(const Band& band, double change_N, double least_N, double dt_s, SwingBandState& state) noexcept {
  state.swing_N += change_N;
  state.swing_N *= std::max(0.0, 1 - 2 * 3.14159265358979 * band.corner_Hz * dt_s);
  state.half_s += dt_s;
  state.peak_N = std::max(state.peak_N, std::abs(state.swing_N));
  if (state.half_s > band.period_max_s) state.halves = 0;
  const int side = state.swing_N > least_N ? 1 : state.swing_N < -least_N ? -1 : 0;
  if (side == 0 || side == state.side) return false;
  const bool fast = state.half_s + state.last_half_s <= band.period_max_s;
  const bool lasts = fast && state.last_peak_N > 0 && state.peak_N > kLasts * state.last_peak_N;
  state.last_half_s = state.half_s;
  state.halves = std::clamp(state.halves + (lasts ? 1 : -1), 0, kHalves);
  state.last_peak_N = state.peak_N;
  state.peak_N = std::abs(state.swing_N);
  state.side = side;
  state.half_s = 0;
  return lasts && state.halves == kHalves;
}

}  // namespace

//   s <- (s + K dx . n) (1 - 2 pi f dt)
double WatchSwings(const ContactTick& tick, SwingState& state) noexcept {
  const double force_N = Norm(tick.force_N);
  const bool touches = force_N > 0 && tick.stiffness_N_m > 0;
  if (!touches && !state.has_tip && state.gain == 1) return 1;  // a far tip costs nothing
  state.left_s = touches ? 0 : state.left_s + tick.dt_s;
  if (state.left_s > kLeft_s || !tick.judged) {
    const double gain = tick.judged ? 1 : state.gain;
    state = {};
    state.gain = gain;
    return gain;
  }
  if (touches) {
    const double sign = Dot(tick.force_N, state.direction) < 0 ? -1 : 1;  // a spring's force turns round
    state.direction = (sign / force_N) * tick.force_N;
    state.stiffness_N_m = tick.stiffness_N_m;
  }
  const double change_N = state.has_tip ? state.stiffness_N_m * Dot(tick.tip - state.tip, state.direction) : 0;
  state.tip = tick.tip;
  state.has_tip = true;
  for (std::size_t b = 0; b < kSwingBands; ++b) {
    if (!touches && kBands[b].in_touch) state.bands[b] = {};
    const double noise_N = kNoises * state.stiffness_N_m * tick.noise_m;
    const double least_N = std::max(kBands[b].least_N / state.gain, noise_N);
    if (FollowBand(kBands[b], change_N, least_N, tick.dt_s, state.bands[b])) {
      state.gain = std::max(kGainMin, std::min(kFall * state.gain, kLeft_N_m / state.stiffness_N_m));
    }
  }
  return state.gain;
}

double WatchContacts(const ContactTick& tick, SwingState& swing, EnergyState& energy) noexcept {
  const double gain = WatchSwings(tick, swing);
  ContactTick left = tick;
  left.stored_J *= gain;
  return gain * WatchEnergy(left, energy);
}

}  // namespace omni::haptics
