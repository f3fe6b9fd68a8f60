// A glTF file -> a scene for the tick, and the parts of it that change while it is in use: made, or taken from the
// cache if all that they depend on is the same.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/haptics/deformable/build/build_soft_body.h"
#include "service/haptics/geometry/mesh.h"
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

// A soft body for an object of a scene: taken from the cache, or built and kept there (load_live.cc).
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

// All parts of a scene that change while it is in use, before it is in use: for callers that can wait, as tools can.
// The service hands a scene to the tick first and its soft bodies when they are ready (daemon/scenes/scene_builder.cc).
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
