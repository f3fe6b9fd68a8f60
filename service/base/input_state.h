// Inputs of the passive pen, computed by the service: the layer only converts and snapshots them.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

namespace omni::base {

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

}  // namespace omni::base
