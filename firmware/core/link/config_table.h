// Settings that the host may read and, in idle, change: never beyond the base's built-in limits.
#pragma once

#include "firmware/core/link/settings.h"

namespace omni::firmware {

enum class ConfigStatus : std::uint8_t { kOk, kUnknownId, kOutOfRange };

// The value in force; kUnknownId leaves `value` alone.
ConfigStatus GetConfig(const Settings& settings, std::uint16_t id, float& value) noexcept;

// `built`: the settings as constructed. Limits may only be tightened; coils may differ by their tolerance.
ConfigStatus SetConfig(const Settings& built, std::uint16_t id, float value, Settings& settings) noexcept;

// Finite, positive where required, limits in order.
bool AreValid(const Settings& settings) noexcept;

}  // namespace omni::firmware
