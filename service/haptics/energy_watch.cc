#include "service/haptics/energy_watch.h"

#include "service/base/limits.h"

namespace omni::haptics {
namespace {

constexpr double kLeak_J = 5e-3;  // a stable press gives less than 1 mJ, a limit cycle 100 mJ in seconds
constexpr double kForget_s = 2;   // an old leak fades, so that small errors do not add up for hours
constexpr double kFall_s = 0.05, kRise_s = 5;
constexpr double kGainMin = 0.1;

// The force sent `lag_s` before the middle of the last tick, between the two ticks around that instant.
Vec3 ForceThen(const EnergyState& state, double lag_s) noexcept {
  const double ticks = std::clamp(lag_s / base::kTickPeriod_s - 0.5, 0.0, static_cast<double>(kEnergyHistory - 2));
  const auto whole = static_cast<std::uint32_t>(ticks);
  const double share = ticks - whole;
  const auto sent = [&state](std::uint32_t ago) {  // 0: in the tick before this one
    return state.sent_N[(state.next + kEnergyHistory - 1 - ago) % kEnergyHistory];
  };
  return (1 - share) * sent(whole) + share * sent(whole + 1);
}

}  // namespace

// E(t) = sum F . dx: what the coils have given to the hand; with what the springs still hold, a passive surface keeps
// E + U <= 0. What is over is a leak   (3.9).
double WatchEnergy(const ContactTick& tick, EnergyState& state) noexcept {
  if (state.has_tip && tick.passive && tick.lag_s >= 0) {
    state.given_J += Dot(ForceThen(state, tick.lag_s), tick.tip - state.tip);
  }
  state.tip = tick.tip;
  state.has_tip = true;
  const double stored_J = state.gain * tick.stored_J;
  state.given_J -= std::min(1.0, tick.dt_s / kForget_s) * (state.given_J + stored_J);
  if (!tick.passive) state.given_J = -stored_J;
  const double leak_J = state.given_J + stored_J;
  if (leak_J > kLeak_J) {
    state.gain = std::max(kGainMin, state.gain * (1 - std::min(0.5, tick.dt_s / kFall_s)));
    ++state.leaking_ticks;
  } else if (state.gain < 1 && leak_J < 0.5 * kLeak_J) {
    state.gain = std::min(1.0, state.gain + tick.dt_s / kRise_s);
  }
  return state.gain;
}

void RememberForce(const Vec3& force_N, EnergyState& state) noexcept {
  state.sent_N[state.next] = force_N;
  state.next = (state.next + 1) % kEnergyHistory;
}

}  // namespace omni::haptics
