#include "service/loop/detent.h"

#include <cmath>
#include <numbers>

namespace omni::loop {
namespace {

constexpr base::SourceMask kDetent = base::Bit(base::InputSource::kDetent);

void StartPulse(double amplitude_N, DetentState& state) noexcept {
  state.time_s = 0;
  state.amplitude_N = amplitude_N;
}

}  // namespace

base::Vec3 DetentForce_N(const base::InputMapping& mapping, const InputTracker& tracker, const haptics::Output& haptics,
                         double dt_s, DetentState& state) noexcept {
  const bool on = (tracker.on & kDetent & mapping.used()) != 0;
  if (on && haptics.contact_count > 0) state.normal_base = haptics.contacts[0].normal_base;
  if (on != state.on) StartPulse((on ? -1 : kDetentReturn) * mapping.thresholds.detent_pulse_N, state);
  state.on = on;
  if (!(state.time_s < kDetentPulse_s)) return {};
  state.time_s += dt_s;
  const double force_N = state.amplitude_N * std::sin(std::numbers::pi * std::fmin(state.time_s / kDetentPulse_s, 1));
  const base::Vec3& n = state.normal_base;
  return {force_N * n.x, force_N * n.y, force_N * n.z};
}

}  // namespace omni::loop
