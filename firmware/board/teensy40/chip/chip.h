// The chip's identity.
#pragma once

#include "firmware/core/link/settings.h"

namespace omni::board {

// The core's defaults with this chip's own number as serial: "omni-" and ten hexadecimal digits of the fuses.
firmware::Settings ChipSettings() noexcept;

}  // namespace omni::board
