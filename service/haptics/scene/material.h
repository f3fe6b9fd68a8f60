// Haptic material as the renderer names it: service/base/material.h.
#pragma once

#include <cstdint>

#include "service/base/material.h"

namespace omni::haptics {

using base::Extrude;
using base::Falloff;
using base::Material;
using base::MaterialParameters;
using base::Sculpt;
using base::Softness;
using base::SoftnessModel;
using base::Symmetry;

// The parameters of one of the scene's materials, as the application wants them.
struct MaterialChange {
  std::uint32_t material = 0xFFFFFFFF;  // index into the scene's; one that it has not: ignored
  MaterialParameters parameters;
};
inline constexpr std::uint32_t kMaxLiveMaterials = 16;  // that differ from the scene's at a time

}  // namespace omni::haptics
