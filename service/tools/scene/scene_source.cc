#include "service/tools/scene/scene_source.h"

#include <filesystem>
#include <optional>

#include "service/config/paths.h"
#include "service/config/scene_name.h"
#include "service/scene/load_scene.h"
#include "service/tools/common/progress.h"

namespace omni::tools {

namespace fs = std::filesystem;

base::Result<LoadedScene> LoadScene(const std::string& path, const scene::LoadOptions& options, bool cached) {
  LoadedScene loaded;
  std::optional<scene::CacheStore> cache;
  if (cached) cache.emplace(config::CacheFolder());
  auto scene = scene::LoadScene(path, options, cache ? &*cache : nullptr, loaded.load, loaded.build);
  if (!scene.ok()) return base::Error{scene.error()};
  loaded.scene = std::move(*scene);
  return loaded;
}

base::Result<LoadedScene> LoadLiveScene(const std::string& path, const scene::LoadOptions& options) {
  base::Result<LoadedScene> loaded = LoadScene(path, options);
  if (!loaded.ok()) return loaded;
  scene::CacheStore cache(config::CacheFolder());
  loaded->live = scene::LoadLive(loaded->scene, &cache, scene::kSoftTets, ProgressOnTerminal("soft bodies"));
  return loaded;
}

base::Result<std::string> FindScene(const std::string& name) { return config::FindScene(name, config::ScenesFolder()); }

std::string ShippedScene(const std::string& name) { return config::ScenesFolder() + "/" + name + ".glb"; }

std::string FindHandScript(const std::string& scene_path) {
  fs::path script(scene_path);
  script.replace_extension(".hand.json");
  std::error_code error;
  return fs::is_regular_file(script, error) ? script.string() : std::string();
}

}  // namespace omni::tools
