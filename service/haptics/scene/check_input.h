// Rejects input that cannot be built, with errors that say what to change. Set-up only.
#pragma once

#include <cstddef>
#include <string>

#include "service/base/result.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::haptics {

base::Status CheckInput(const SceneInput& input);
base::Status CheckJoystick(const JoystickInput& joystick);
base::Status CheckVehicle(const VehicleInput& vehicle);
base::Status CheckMaterial(const Material& material, std::size_t index);

inline constexpr double kMaxTipRadius_m = 0.01;
inline constexpr double kMaxTextureTransform = 1e6;  // of each number of InputTexture::to_image

// Six digits; for messages.
std::string Number(double x);

// "object 3 "wall"".
std::string Where(const InputObject& object, std::size_t index);

}  // namespace omni::haptics
