#include "service/haptics/stability/energy_watch.h"

#include <algorithm>

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

}  // namespace omni::haptics
