// Interaction profiles that the pen supports: those of the layer (layer/profiles), as "oculus/touch_controller".
#pragma once

#include <span>
#include <string_view>

namespace omni::config {

std::span<const std::string_view> ProfileNames();

}  // namespace omni::config
