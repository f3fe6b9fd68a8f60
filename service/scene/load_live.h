// Makes all parts of a scene that change while it is in use, before it is in use: for callers that can wait, as tools
// can. The service hands a scene to the tick first and its soft bodies when they are ready
// (daemon/scenes/scene_builder.cc).
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "service/haptics/scene/scene.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/load_soft_body.h"

namespace omni::scene {

struct LiveReport {
  std::uint32_t soft_bodies = 0, sculpt_sessions = 0;
  std::vector<std::string> lines;  // why a tagged object has none, one sentence each
  double load_ms = 0;
};

// Gives `scene` what haptics/live/make_live.h plans, soft bodies included. Seconds to minutes unless these are in the
// cache; `cache` may be null; `progress` is called now and then with 0 ... 1, and false ends it. Equal scenes get equal
// parts, from the cache or not. An object whose part cannot be made stays as it was, with a line. `soft_tets`: of a
// soft body, at most, [100, 400000].
LiveReport LoadLive(haptics::Scene& scene, CacheStore* cache, std::uint32_t soft_tets = kSoftTets,
                    const std::function<bool(double done)>& progress = {});

}  // namespace omni::scene
