// A built scene and its reports as one block of bytes for the cache.
#pragma once

#include <string>

#include "service/haptics/scene/scene.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/scene_file.h"

namespace omni::scene {

struct CachedScene {
  haptics::Scene scene;
  LoadReport load;  // with `cached` set
  haptics::BuildReport build;
};

// What follows the scene's own block.
std::string PackReports(const LoadReport& load, const haptics::BuildReport& build);
CacheBlock Pack(const haptics::Scene& scene, const LoadReport& load, const haptics::BuildReport& build);

// Empty: done, and the scene has the memory of `block`. Otherwise what is wrong with it; none of it is trusted:
// haptics::CheckScene. Without a scene it is the empty one.
std::string Unpack(CacheBlock block, CachedScene& cached);

}  // namespace omni::scene
