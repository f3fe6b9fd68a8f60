// Haptic material as the renderer names it (service/base/material.h), and how large a scene may be.
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

inline constexpr std::uint32_t kMaxObjects = 64;  // more: BuildScene fails, with the number
inline constexpr std::uint32_t kMaxRegions = 16;  // extrude regions; further ones stay rigid, with a report line
inline constexpr std::uint32_t kMaxSculpted = 4;  // sculpted objects; further ones stay rigid, with a report line
inline constexpr std::uint32_t kMaxTriangles = 4'000'000;  // in a whole scene
inline constexpr std::uint32_t kMaxTextures = 64;
inline constexpr std::uint32_t kMaxReliefs = 16;
inline constexpr std::uint32_t kMaxTexels = 64u << 20;  // of all images together
inline constexpr std::uint32_t kNoIndex = 0xFFFFFFFF;

}  // namespace omni::haptics
