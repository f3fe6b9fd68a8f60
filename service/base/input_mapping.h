// Sources of the passive pen's inputs, which of them feed which component of InputState, and their thresholds.
// One mapping is in force at a time: that of the application that owns the force. Fixed size, handed to the tick.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

namespace omni::base {

// Inputs of the passive pen, computed by the service: the layer only converts and snapshots them.
enum class InputComponent : std::uint8_t {
  kTipForce = 0,     // 0..1, normal force on the tip over loop::InputConfig::tip_force_full_N
  kSelect = 1,       // 0 or 1: tip force over its threshold, with hysteresis
  kSecondary = 2,    // 0 or 1
  kMenu = 3,         // 0 or 1
  kSqueeze = 4,      // 0..1
  kThumbstickX = 5,  // -1..1
  kThumbstickY = 6,  // -1..1
  kThumbstickClick = 7,
  kDocked = 8,
  kCount = 9
};
inline constexpr int kInputComponentCount = static_cast<int>(InputComponent::kCount);

// `press_count` and `release_count` count edges over 0.5 since the service started, so that a press that
// came and went between two syncs is still one press. `t_change_ns` is the Hall sample's time of the last change.
struct InputValue {
  float value = 0;
  std::uint32_t press_count = 0;
  std::uint32_t release_count = 0;
  std::uint32_t reserved = 0;
  std::int64_t t_change_ns = 0;
};

struct InputState {
  std::array<InputValue, kInputComponentCount> components{};
};
static_assert(std::is_trivially_copyable_v<InputState>);

inline constexpr int kMaxKeys = 32;  // different keys in all mappings together; config refuses more

// Events that the tick detects from the pen, and keys. Defined in docs/howto/apps.md.
enum class InputSource : std::uint8_t {
  kTipForce = 0,      // 0..1: force on the tip over tip_force_full_N
  kPress = 1,         // that force over press_N, with hysteresis
  kTap = 2,           // a short touch; on for click_s from its end
  kDoubleTap = 3,     // two of them at one place; on for click_s
  kDwell = 4,         // touches and stays: on until it moves or lifts
  kHoverDwell = 5,    // stays in the air: on until it moves or touches
  kDetent = 6,        // pressed hard, past a detent pulse; on until the force has fallen
  kFlick = 7,         // there and back across the pen's axis, in the air; on for click_s
  kFlickAxial = 8,    // the same along the axis
  kAway = 9,          // put down: untracked, far, or lying still
  kThumbstickX = 10,  // -1..1, where the scene has a joystick
  kThumbstickY = 11,
  kFirstKey = 16,  // kMaxKeys of them
  kCount = 16 + kMaxKeys
};
inline constexpr int kSourceCount = static_cast<int>(InputSource::kCount);

using SourceMask = std::uint64_t;
static_assert(kSourceCount <= 64);

constexpr SourceMask SourceBit(InputSource source) noexcept { return SourceMask{1} << static_cast<unsigned>(source); }
constexpr SourceMask KeyBit(int slot) noexcept {
  return SourceMask{1} << (static_cast<unsigned>(InputSource::kFirstKey) + static_cast<unsigned>(slot));
}

// The largest of the sources in `plus`, less the largest of those in `minus`.
struct ComponentSources {
  SourceMask plus = 0;
  SourceMask minus = 0;  // thumbstick axes only
};

// Defaults are for a hand at a desk; an application may have its own (apps.d, [inputs]).
struct InputThresholds {
  double tip_force_full_N = 1.0;  // tip force 1.0
  double press_N = 0.15;          // press goes down here ...
  double release_N = 0.08;        // ... and up here
  double tap_force_N = 0.10;      // a touch that never reaches it is no tap
  double tap_speed_m_s = 0.035;   // into the surface; a share of it, out of it at the end
  double tap_max_s = 0.25;        // a longer touch is no tap
  double tap_travel_m = 0.003;    // nor is one that slides further
  double double_tap_s = 0.40;     // from the end of the first to the beginning of the second
  double double_tap_distance_m = 0.010;
  double dwell_s = 0.8;
  double dwell_radius_m = 0.002;
  double detent_press_N = 0.8;
  double detent_release_N = 0.5;
  double detent_pulse_N = 0.12;  // pulse at the detent; 0: none
  double flick_speed_m_s = 0.5;
  double flick_s = 0.25;          // there and back within this
  double away_untracked_s = 2.0;  // untracked for this long
  double away_distance_m = 0.15;  // tip further than this from the core's centre, for away_untracked_s
  double away_still_s = 20.0;     // in the air and not moved by away_still_m for this long: not held
  double away_still_m = 0.001;
  double click_s = 0.050;  // length of a click of tap, double tap and flick
};

struct InputMapping {
  std::array<ComponentSources, kInputComponentCount> components{};
  InputThresholds thresholds;

  ComponentSources& at(InputComponent component) noexcept { return components[static_cast<std::size_t>(component)]; }
  const ComponentSources& at(InputComponent component) const noexcept {
    return components[static_cast<std::size_t>(component)];
  }
  // All sources that some component uses.
  SourceMask used() const noexcept {
    SourceMask mask = 0;
    for (const ComponentSources& sources : components) mask |= sources.plus | sources.minus;
    return mask;
  }
};
static_assert(std::is_trivially_copyable_v<InputMapping>);

// What applications without a mapping of their own get.
constexpr InputMapping DefaultMapping() noexcept {
  InputMapping mapping;
  const auto feed = [&mapping](InputComponent component, InputSource source) {
    mapping.components[static_cast<std::size_t>(component)].plus = SourceBit(source);
  };
  feed(InputComponent::kTipForce, InputSource::kTipForce);
  feed(InputComponent::kSelect, InputSource::kPress);
  feed(InputComponent::kSecondary, InputSource::kDoubleTap);
  feed(InputComponent::kMenu, InputSource::kFlick);
  feed(InputComponent::kSqueeze, InputSource::kDetent);
  feed(InputComponent::kThumbstickX, InputSource::kThumbstickX);
  feed(InputComponent::kThumbstickY, InputSource::kThumbstickY);
  feed(InputComponent::kThumbstickClick, InputSource::kFlickAxial);
  feed(InputComponent::kDocked, InputSource::kAway);
  return mapping;
}

// One key, of all devices together. It is down while press_count != release_count.
struct KeyState {
  std::uint32_t press_count = 0;
  std::uint32_t release_count = 0;  // press_count, or one less
  std::int64_t t_press_ns = 0;      // CLOCK_MONOTONIC of the newest event, stamped by the kernel
  std::int64_t t_release_ns = 0;
};

struct KeyStates {
  std::array<KeyState, kMaxKeys> slots{};
};
static_assert(std::is_trivially_copyable_v<KeyStates>);

}  // namespace omni::base
