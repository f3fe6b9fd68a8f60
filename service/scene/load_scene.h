// A glTF file -> a scene for the tick: read, repair, index; or taken from the cache, if all that it depends on is the
// same.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/scene_file.h"

namespace omni::scene {

// Scenes below are built faster than a file is written and synced.
inline constexpr std::uint32_t kCachedFromTriangles = 5000;

// `cache` may be null. An untagged file gives the empty scene unless `options` request it (LoadReport::skipped).
// Reports are filled on failure too. Errors: "<file>: <JSON pointer or object>: what, limit, what to do".
base::Result<haptics::Scene> LoadScene(const std::string& path, const LoadOptions& options, CacheStore* cache,
                                       LoadReport& load, haptics::BuildReport& build);

}  // namespace omni::scene
