// Materials, converted between the application's structure and the service's.
#pragma once

#include "layer/include/openxr/omni_haptic_scene.h"
#include "service/base/material.h"

namespace omni::layer {

// All values are finite.
bool IsMaterial(const XrHapticMaterialOMNIX1& material) noexcept;

// In the ranges of service/base/material.h; dynamic friction is at most static friction.
base::MaterialParameters ToParameters(const XrHapticMaterialOMNIX1& material) noexcept;

void Put(const base::MaterialParameters& parameters, XrHapticMaterialOMNIX1& material) noexcept;

}  // namespace omni::layer
