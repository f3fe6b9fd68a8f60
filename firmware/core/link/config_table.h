// Settings that the host may read and, in idle, change: never beyond what the base was built for.
#pragma once

#include "firmware/core/link/settings.h"

namespace omni::firmware {

enum class ConfigStatus : std::uint8_t { kOk, kUnknownId, kOutOfRange };

// The value in force; kUnknownId leaves `value` alone.
ConfigStatus GetConfig(const Settings& settings, std::uint16_t id, float& value) noexcept;

// `built` are the settings as constructed: limits may only be tightened, coils differ from them by their tolerance.
ConfigStatus SetConfig(const Settings& built, std::uint16_t id, float value, Settings& settings) noexcept;

// Finite, positive where only that makes sense, limits in their order.
bool AreValid(const Settings& settings) noexcept;

}  // namespace omni::firmware
