// A built scene and its reports as one block of bytes for the cache.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "service/haptics/scene/scene.h"
#include "service/scene/scene_file.h"

namespace omni::scene {

struct CachedScene {
  haptics::Scene scene;
  LoadReport load;  // with `cached` set
  haptics::BuildReport build;
};

std::vector<std::byte> Pack(const haptics::Scene& scene, const LoadReport& load, const haptics::BuildReport& build);

// Empty: done. Otherwise what is wrong with the block, none of which is trusted: haptics::CheckScene.
std::string Unpack(const std::vector<std::byte>& block, CachedScene& cached);

}  // namespace omni::scene
