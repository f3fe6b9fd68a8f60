#include "service/loop/inputs.h"

#include <algorithm>
#include <cmath>

#include "service/base/stamp.h"

namespace omni::loop {
namespace {

using base::InputComponent;

// Sets one component; edges are crossings of 0.5.
void Set(const InputConfig& config, InputComponent component, double value, std::int64_t t_ns,
         base::InputState& inputs) noexcept {
  base::InputValue& held = inputs.components[static_cast<std::size_t>(component)];
  const auto wanted = static_cast<float>(std::isfinite(value) ? value : 0.0);
  const bool at_rest_or_full = wanted == 0.0F || std::abs(wanted) == 1.0F;
  if (wanted == held.value) return;
  if (!at_rest_or_full && std::abs(wanted - held.value) < config.value_resolution) return;
  if (held.value <= 0.5F && wanted > 0.5F) ++held.press_count;
  if (held.value > 0.5F && wanted <= 0.5F) ++held.release_count;
  held.value = wanted;
  held.t_change_ns = t_ns;
}

bool SelectWithHysteresis(const InputConfig& config, double force_N, bool pressed) noexcept {
  return pressed ? force_N > config.select_release_N : force_N >= config.select_press_N;
}

// First-order low-pass; goes to rest at once when nothing is live.
double FilterForce(const InputConfig& config, double force_N, bool live, std::int64_t t_ns,
                   InputTracker& tracker) noexcept {
  const double dt_s = std::clamp(base::Elapsed_s(t_ns, tracker.t_ns), 0.0, 0.1);
  const double share = config.force_filter_s > 0 ? dt_s / (config.force_filter_s + dt_s) : 1.0;
  const double wanted_N = std::isfinite(force_N) ? force_N : 0;
  tracker.tip_force_N = live ? tracker.tip_force_N + share * (wanted_N - tracker.tip_force_N) : 0;
  tracker.t_ns = t_ns;
  return tracker.tip_force_N;
}

}  // namespace

void UpdateInputs(const InputConfig& config, const haptics::Output& haptics, bool live, std::int64_t t_ns,
                  InputTracker& tracker) noexcept {
  base::InputState& inputs = tracker.inputs;
  const double force_N = FilterForce(config, haptics.tip_normal_force_N, live, t_ns, tracker);
  const bool pressed = inputs.components[static_cast<std::size_t>(InputComponent::kSelect)].value > 0.5F;
  const bool joystick = live && haptics.joystick;
  Set(config, InputComponent::kTipForce, std::clamp(force_N / config.tip_force_full_N, 0.0, 1.0), t_ns, inputs);
  Set(config, InputComponent::kSelect, SelectWithHysteresis(config, force_N, pressed) ? 1 : 0, t_ns, inputs);
  Set(config, InputComponent::kThumbstickX, joystick ? std::clamp(haptics.thumbstick_x, -1.0, 1.0) : 0, t_ns, inputs);
  Set(config, InputComponent::kThumbstickY, joystick ? std::clamp(haptics.thumbstick_y, -1.0, 1.0) : 0, t_ns, inputs);
}

}  // namespace omni::loop
