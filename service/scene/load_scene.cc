#include "service/scene/load_scene.h"

#include <chrono>
#include <exception>
#include <new>
#include <utility>

#include "service/haptics/scene/check_scene.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/cache/cached_scene.h"
#include "service/scene/scene_reader.h"

namespace omni::scene {
namespace {

// All that a built scene depends on: the code, the bytes that were read, the options, and the name in its messages.
CacheKey KeyOf(const std::string& path, const LoadOptions& options, const Digest& bytes) {
  Sha256 hash;
  hash.Add(std::string_view(kBuildStamp));
  hash.Add(std::as_bytes(std::span(bytes)));
  hash.Add(std::string_view(path));
  for (const double x :
       {options.offset_base_m.x, options.offset_base_m.y, options.offset_base_m.z, options.scale, options.hull_radius_m,
        options.fit ? 1.0 : 0.0, options.touch_untagged ? 1.0 : 0.0, options.all_kinematic ? 1.0 : 0.0}) {
    hash.Add(x);
  }
  return {"scene", hash.Finish()};
}

// A scene from the cache, if there is a valid one. Otherwise `load.cache` says why there is none.
std::optional<haptics::Scene> FromCache(CacheStore& cache, const CacheKey& key, LoadReport& load,
                                        haptics::BuildReport& build) {
  std::string damage;
  std::optional<std::vector<std::byte>> block = cache.Get(key, damage);
  if (block) {
    CachedScene cached;
    damage = Unpack(*block, cached);
    if (damage.empty()) {
      load = std::move(cached.load);
      build = std::move(cached.build);
      return std::move(cached.scene);
    }
    cache.Remove(key);
  }
  load.cache = damage.empty() ? "not in the cache" : "the cached file " + damage + ": rebuilt";
  return std::nullopt;
}

void ToCache(CacheStore& cache, const CacheKey& key, const haptics::Scene& scene, LoadReport& load,
             const haptics::BuildReport& build) {
  if (scene.header().triangle_count < kCachedFromTriangles) {
    load.cache = "not cached: below " + std::to_string(kCachedFromTriangles) + " triangles, quickly built";
  } else if (cache.Put(key, Pack(scene, load, build))) {
    load.cache += load.cache.empty() ? "kept" : ", kept";
  } else {
    load.cache = "off: " + (cache.problem().empty() ? "too large to keep" : cache.problem());
  }
}

base::Result<haptics::Scene> Load(const std::string& path, const LoadOptions& options, CacheStore* cache,
                                  LoadReport& load, haptics::BuildReport& build) {
  SceneReader reader(path, options, load);
  if (!reader.ReadBytes()) return haptics::Scene();
  if (cache && !cache->problem().empty()) load.cache = "off: " + cache->problem();
  if (cache && !cache->problem().empty()) cache = nullptr;
  const CacheKey key = cache ? KeyOf(path, options, reader.FinishDigest()) : CacheKey{};
  if (cache) {
    if (std::optional<haptics::Scene> cached = FromCache(*cache, key, load, build)) return std::move(*cached);
  }
  const haptics::SceneInput input = reader.MakeInput();
  base::Result<haptics::Scene> scene = haptics::BuildScene(input, build);
  if (!scene.ok()) return base::Error{path + ": " + scene.error()};
  if (cache) ToCache(*cache, key, *scene, load, build);
  return scene;
}

}  // namespace

base::Result<haptics::Scene> LoadScene(const std::string& path, const LoadOptions& options, CacheStore* cache,
                                       LoadReport& load, haptics::BuildReport& build) {
  const auto start = std::chrono::steady_clock::now();
  load = {};
  build = {};
  base::Result<haptics::Scene> scene = base::Error{};
  try {
    scene = Load(path, options, cache, load, build);
  } catch (const std::bad_alloc&) {
    scene = base::Error{path + ": does not fit into memory; simplify the model"};
  } catch (const std::exception& error) {
    scene = base::Error{path + ": " + error.what()};
  }
  load.load_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return scene;
}

}  // namespace omni::scene
