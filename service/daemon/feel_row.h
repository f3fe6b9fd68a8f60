// A material's feel as haptics has it and as a row of the protocol, either way.
#pragma once

#include "service/haptics/material.h"
#include "service/protocol/haptic_scene.h"

namespace omni::daemon {

haptics::MaterialFeel FeelOf(const protocol::HapticFeel& row);

// Of a scene's material, in the range of the protocol.
protocol::HapticFeel FeelRow(const haptics::Material& material);

}  // namespace omni::daemon
