// A glTF file -> a scene for the tick, and the parts of it that change while it is in use: made, or taken from the
// cache if all that they depend on is the same.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/haptics/deformable/build/build_soft_body.h"
#include "service/haptics/geometry/mesh.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/build_estimate.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/scene_file.h"

namespace omni::scene {

// Scenes below are built faster than a file is written and synced.
inline constexpr std::uint32_t kCachedFromTriangles = 5000;

// `cache` may be null. An untagged file gives the empty scene unless `options` request it (LoadReport::skipped).
// Ended by options.watch: the error "cancelled", without a cache entry. Reports are filled on failure too. Errors:
// "<file>: <JSON pointer or object>: what, limit, what to do".
base::Result<haptics::Scene> LoadScene(const std::string& path, const LoadOptions& options, CacheStore* cache,
                                       LoadReport& load, haptics::BuildReport& build);

// What a build is to be granted: for the block that it makes, and while it makes it.
struct BuildNeed {
  std::uint64_t kept_bytes = 0, peak_bytes = 0;
};
BuildNeed NeedToRead(std::uint64_t json_bytes, std::uint64_t file_bytes);  // the JSON, and images of tags
BuildNeed NeedOf(const BuildEstimate& estimate);                           // all of it
BuildNeed NeedOf(const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options);

// The same in steps, without a cache, for callers that decide between them. Each returns whether to go on; when it is
// false the load ends with an error that only says so. Throws std::bad_alloc.
struct LoadSteps {
  std::function<bool(const BuildNeed& need)> admit;  // the JSON has been read, and no mesh; empty: yes
  std::function<bool(const Digest& bytes)> build;    // all bytes have been read; this is the hash of them
};
base::Result<haptics::Scene> LoadInSteps(const std::string& path, const LoadOptions& options, const LoadSteps& steps,
                                         LoadReport& load, haptics::BuildReport& build);

// The JSON's part of a file, of which no more than its header is read; what is no such file counts as a whole.
std::uint64_t JsonBytesOf(int descriptor);
std::uint64_t FileBytesOf(int descriptor);

// The place of a file's built scene in a cache, which it shares with LoadScene.
class CachedPlace {
 public:
  // All that a built scene depends on: the code, the bytes that were read, the options, and the name in its messages.
  CachedPlace(CacheStore* cache, const std::string& path, const LoadOptions& options, const Digest& bytes);

  // A scene, if there is a valid one. Otherwise `load.cache` says why there is none.
  std::optional<haptics::Scene> Take(LoadReport& load, haptics::BuildReport& build);
  // Keeps a scene, packed with its reports (cached_scene.h), and says in `load.cache` whether it did.
  void Keep(std::uint32_t triangles, std::span<const std::byte> packed, LoadReport& load);

 private:
  CacheStore* cache_;  // null: there is none, or it is off
  CacheKey key_;
};

// A soft body for an object of a scene: taken from the cache, or built and kept there (load_live.cc).
inline constexpr std::uint32_t kSoftTets = 2000;  // most tetrahedra, in the service and in tools

struct SoftLoadReport {
  haptics::SoftBuildReport build;  // zeros if it was taken from the cache, but for `bytes` and `surface_nodes`
  bool cached = false;             // taken from the cache, not built
  std::string cache;               // what the cache did, in words
  double load_ms = 0;
};

// Seconds to minutes unless it is in the cache; `cache` may be null. The key is the mesh, the options and the code. A
// cached block that is damaged, or of another mesh, is rebuilt, by `build`. options.progress returning false ends it
// with "cancelled" and leaves nothing behind. Other errors: those of BuildSoftBody, or memory.
using SoftBuild = std::function<base::Result<haptics::SoftBody>(
    const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options, haptics::SoftBuildReport& report)>;
base::Result<haptics::SoftBody> BuildSoftBodyHere(const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options,
                                                  haptics::SoftBuildReport& report);
base::Result<haptics::SoftBody> LoadSoftBody(const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options,
                                             CacheStore* cache, SoftLoadReport& report,
                                             const SoftBuild& build = BuildSoftBodyHere);

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
