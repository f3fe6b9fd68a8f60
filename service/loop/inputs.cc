#include "service/loop/inputs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/base/clock.h"

namespace omni::loop {
namespace {

using base::InputComponent;
using base::InputSource;
using base::SourceBit;
using base::SourceMask;

constexpr SourceMask kGestures = SourceBit(InputSource::kTap) | SourceBit(InputSource::kDoubleTap) |
                                 SourceBit(InputSource::kDwell) | SourceBit(InputSource::kHoverDwell) |
                                 SourceBit(InputSource::kDetent) | SourceBit(InputSource::kFlick) |
                                 SourceBit(InputSource::kFlickAxial) | SourceBit(InputSource::kAway);

std::size_t Index(InputSource source) noexcept { return static_cast<std::size_t>(source); }

// False: a change too small to be one.
bool Changed(const InputConfig& config, float wanted, float held) noexcept {
  const bool at_rest_or_full = wanted == 0.0F || std::abs(wanted) == 1.0F;
  return wanted != held && (at_rest_or_full || std::abs(wanted - held) >= config.value_resolution);
}

void SetSource(const InputConfig& config, InputSource source, double value, std::int64_t t_ns,
               InputTracker& tracker) noexcept {
  SourceState& held = tracker.sources[Index(source)];
  const auto wanted = static_cast<float>(std::isfinite(value) ? value : 0.0);
  if (!Changed(config, wanted, held.value)) return;
  held = {.value = wanted, .t_change_ns = t_ns};
  const bool on = std::abs(wanted) > 0.5F;
  tracker.on = on ? tracker.on | SourceBit(source) : tracker.on & ~SourceBit(source);
}

// First-order low-pass; goes to rest at once when nothing is live.
double FilterForce(const InputConfig& config, double force_N, bool live, std::int64_t t_ns,
                   InputTracker& tracker) noexcept {
  const double dt_s = std::clamp(base::Elapsed_s(t_ns, tracker.t_ns), 0.0, 0.1);
  const double share = config.force_filter_s > 0 ? dt_s / (config.force_filter_s + dt_s) : 1.0;
  tracker.tip_force_N = live ? tracker.tip_force_N + share * (force_N - tracker.tip_force_N) : 0;
  tracker.t_ns = t_ns;
  return tracker.tip_force_N;
}

const haptics::Contact* Deepest(const haptics::Output& haptics) noexcept {
  const haptics::Contact* deepest = nullptr;
  for (int i = 0; i < haptics.contact_count; ++i) {
    const haptics::Contact& contact = haptics.contacts[static_cast<std::size_t>(i)];
    if (deepest == nullptr || contact.gap_m < deepest->gap_m) deepest = &contact;
  }
  return deepest;
}

void FollowPen(const InputConfig& config, const base::InputThresholds& thresholds, const InputSample& sample,
               const haptics::Output& haptics, InputTracker& tracker) noexcept {
  const double asked_N = std::isfinite(haptics.tip_normal_force_N) ? haptics.tip_normal_force_N : 0;
  const double force_N = FilterForce(config, asked_N, sample.live, sample.t_ns, tracker);
  const bool pressed = (tracker.on & SourceBit(InputSource::kPress)) != 0;
  const bool press = pressed ? force_N > thresholds.release_N : force_N >= thresholds.press_N;
  const bool stick = sample.live && haptics.joystick;
  const auto set = [&](InputSource source, double value) { SetSource(config, source, value, sample.t_ns, tracker); };
  set(InputSource::kTipForce, std::clamp(force_N / thresholds.tip_force_full_N, 0.0, 1.0));
  set(InputSource::kPress, press ? 1 : 0);
  set(InputSource::kThumbstickX, stick ? std::clamp(haptics.thumbstick_x, -1.0, 1.0) : 0);
  set(InputSource::kThumbstickY, stick ? std::clamp(haptics.thumbstick_y, -1.0, 1.0) : 0);

  const haptics::Contact* contact = Deepest(haptics);
  const GestureInput gesture{.t_ns = sample.t_ns,
                             .tracked = sample.tracked,
                             .live = sample.live,
                             .tip_base_m = sample.tip_base_m,
                             .axis_base = sample.axis_base,
                             .force_N = asked_N,
                             .steady_force_N = force_N,
                             .normal_base = contact == nullptr ? base::Vec3{} : contact->normal_base};
  const SourceMask on = UpdateGestures(thresholds, gesture, tracker.gestures);
  for (unsigned i = 0; i < static_cast<unsigned>(InputSource::kFirstKey); ++i) {
    if (((kGestures >> i) & 1) != 0) set(static_cast<InputSource>(i), ((on >> i) & 1) != 0 ? 1 : 0);
  }
}

// The n-th press ends when n releases have been counted.
void FollowKey(const InputConfig& config, bool owned, const base::KeyState& key, InputSource source, std::int64_t t_ns,
               InputTracker& tracker, KeyFollower& follower) noexcept {
  if (!owned) {
    follower = {.on = false, .seen_press = key.press_count};
    SetSource(config, source, 0, t_ns, tracker);
    return;
  }
  if (follower.on) {
    if (static_cast<std::int32_t>(key.release_count - follower.seen_press) < 0) return;
    follower.on = false;
    SetSource(config, source, 0, key.t_release_ns, tracker);
  } else if (key.press_count != follower.seen_press) {
    follower = {.on = true, .seen_press = follower.seen_press + 1};
    SetSource(config, source, 1, key.t_press_ns, tracker);
  }
}

struct Sum {
  double value = 0;
  std::int64_t t_ns = 0;  // newest change of what feeds it
};

// The largest magnitude of the sources in `mask`, with its sign.
Sum Largest(SourceMask mask, const InputTracker& tracker) noexcept {
  Sum sum;
  for (; mask != 0; mask &= mask - 1) {
    const SourceState& source = tracker.sources[static_cast<std::size_t>(__builtin_ctzll(mask))];
    if (std::abs(source.value) > std::abs(sum.value)) sum.value = static_cast<double>(source.value);
    sum.t_ns = std::max(sum.t_ns, source.t_change_ns);
  }
  return sum;
}

// Edges are crossings of 0.5. The time is that of the source which changed; it never goes back.
void SetComponent(const InputConfig& config, double value, std::int64_t t_ns, base::InputValue& held) noexcept {
  const auto wanted = static_cast<float>(value);
  if (!Changed(config, wanted, held.value)) return;
  if (held.value <= 0.5F && wanted > 0.5F) ++held.press_count;
  if (held.value > 0.5F && wanted <= 0.5F) ++held.release_count;
  held.value = wanted;
  held.t_change_ns = std::max(held.t_change_ns, t_ns);
}

constexpr base::SourceMask kDetent = base::SourceBit(base::InputSource::kDetent);

void StartPulse(double amplitude_N, DetentState& state) noexcept {
  state.time_s = 0;
  state.amplitude_N = amplitude_N;
}

}  // namespace

void UpdateInputs(const InputConfig& config, const base::InputMapping& mapping, const InputSample& sample,
                  const haptics::Output& haptics, const base::KeyStates* keys, InputTracker& tracker) noexcept {
  FollowPen(config, mapping.thresholds, sample, haptics, tracker);
  if (keys != nullptr) {
    for (int slot = 0; slot < base::kMaxKeys; ++slot) {
      const auto source = static_cast<InputSource>(static_cast<int>(InputSource::kFirstKey) + slot);
      FollowKey(config, sample.owned, keys->slots[static_cast<std::size_t>(slot)], source, sample.t_ns, tracker,
                tracker.keys[static_cast<std::size_t>(slot)]);
    }
  }
  for (std::size_t i = 0; i < tracker.inputs.components.size(); ++i) {
    const base::ComponentSources& sources = mapping.components[i];
    const Sum plus = Largest(sources.plus, tracker);
    const Sum minus = Largest(sources.minus, tracker);
    const std::int64_t t_ns = std::max(plus.t_ns, minus.t_ns);
    SetComponent(config, std::clamp(plus.value - minus.value, -1.0, 1.0), t_ns > 0 ? t_ns : sample.t_ns,
                 tracker.inputs.components[i]);
  }
}

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
