// Keys by the names of the Linux input system (linux/input-event-codes.h): "KEY_B", "BTN_LEFT", or a number, "183".
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace omni::config {

inline constexpr std::uint16_t kHighestKey = 0x2FF;  // KEY_MAX

// Empty: no such key.
std::optional<std::uint16_t> KeyCode(std::string_view name);

std::string KeyNameOf(std::uint16_t code);

}  // namespace omni::config
