// What is wrong with a message about a haptic scene; null: nothing. Used by validate.cc, the gate.
#pragma once

#include "service/protocol/haptic_scene.h"

namespace omni::protocol {

const char* Problem(const HapticSceneLoad& load) noexcept;
const char* Problem(const HapticSceneEnd& end) noexcept;
const char* Problem(const HapticScenePlace& place) noexcept;
const char* Problem(const HapticSceneEnable& enable) noexcept;
const char* Problem(const HapticNodes& nodes) noexcept;
const char* Problem(const HapticMaterial& material) noexcept;
const char* Problem(const HapticSceneState& state) noexcept;
const char* Problem(const HapticSceneTable& table) noexcept;
const char* Problem(const HapticNodeRow& row) noexcept;
const char* Problem(const base::MaterialParameters& parameters) noexcept;

}  // namespace omni::protocol
