// Settings from the service for an application's OpenXR layer: sent after Welcome, and again when they change.
#pragma once

#include <type_traits>

#include "service/protocol/control.h"

namespace omni::protocol {

enum class HandSetting : std::uint32_t { kUnset = 0, kLeft = 1, kRight = 2 };

inline constexpr float kLongestRest_s = 86400;

struct AppSettings {
  MessageHeader header{.type = MessageType::kAppSettings, .size = sizeof(AppSettings)};
  HandSetting hand = HandSetting::kUnset;  // the hand that holds the pen
  float rest_after_s = 0;                  // put down after lying still for so long; 0: the layer's default, < 0: never
  char profile[128] = {};                  // interaction profile path to prefer, terminated; empty: the layer's order
};
static_assert(std::is_trivially_copyable_v<AppSettings> && sizeof(AppSettings) == 152);

}  // namespace omni::protocol
