// Whether input can be built into a scene, and whether bytes that come from elsewhere (a cache file, another process)
// are a scene that the tick can use: every offset, index, count and value in range. Set-up only.
#pragma once

#include <cstddef>
#include <string>

#include "service/base/result.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::haptics {

// `scene` may hold any bytes; until this returns Ok, call nothing but block(). Errors are clauses: "has a damaged
// tree".
base::Status CheckScene(const Scene& scene);

// Errors say what to change.
base::Status CheckInput(const SceneInput& input);
base::Status CheckJoystick(const JoystickInput& joystick);
base::Status CheckVehicle(const VehicleInput& vehicle);
base::Status CheckMaterial(const Material& material, std::size_t index);

inline constexpr double kMaxTipRadius_m = 0.01;
inline constexpr float kMaxReliefStep = 1e4F;        // of a band of a relief, texels
inline constexpr double kMaxTextureTransform = 1e6;  // of each number of InputTexture::to_image

// Six digits; for messages.
std::string NumberText(double x);

// "object 3 "wall"".
std::string Where(const InputObject& object, std::size_t index);

}  // namespace omni::haptics
