// A soft body for an object of a scene: taken from the cache, or built and kept there.
#pragma once

#include <cstdint>
#include <string>

#include "service/haptics/deformable/build/build_soft_body.h"
#include "service/haptics/geometry/mesh.h"
#include "service/scene/cache/cache_store.h"

namespace omni::scene {

inline constexpr std::uint32_t kSoftTets = 2000;  // most tetrahedra, in the service and in tools

struct SoftLoadReport {
  haptics::SoftBuildReport build;  // zeros if it was taken from the cache, but for `bytes` and `surface_nodes`
  bool cached = false;             // taken from the cache, not built
  std::string cache;               // what the cache did, in words
  double load_ms = 0;
};

// Seconds to minutes unless it is in the cache; `cache` may be null. The key is the mesh, the options and the code. A
// cached block that is damaged, or of another mesh, is rebuilt. options.progress returning false ends it with
// "cancelled" and leaves nothing behind. Other errors: those of BuildSoftBody, or memory.
base::Result<haptics::SoftBody> LoadSoftBody(const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options,
                                             CacheStore* cache, SoftLoadReport& report);

}  // namespace omni::scene
