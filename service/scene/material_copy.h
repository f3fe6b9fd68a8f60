// A copy of a binary glTF file in which haptic materials have other numbers; everything else stays as it is.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "service/base/material.h"
#include "service/base/result.h"
#include "service/scene/scene_file.h"

namespace omni::scene {

struct ChangedMaterial {
  std::uint16_t material = 0;       // as LoadSceneFile numbers them
  base::MaterialParameters values;  // in range
};

// The bytes of the copy. The numbers are written as OMNI_haptic_material of the glTF materials, the strongest place of
// a tag; a glTF material that unchanged surfaces have as well is copied for the changed ones. `uses`: of the report
// with which LoadSceneFile read this file. Errors: not a .glb; a mesh that several nodes show with different haptic
// materials.
base::Result<std::string> GlbWithMaterials(const std::string& path, std::span<const MaterialUse> uses,
                                           std::span<const ChangedMaterial> changed);

}  // namespace omni::scene
