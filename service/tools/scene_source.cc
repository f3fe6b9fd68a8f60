#include "service/tools/scene_source.h"

#include <filesystem>

#include "service/config/paths.h"

namespace omni::tools {

namespace fs = std::filesystem;

base::Result<LoadedScene> LoadScene(const std::string& path, const scene::LoadOptions& options) {
  LoadedScene loaded;
  auto input = scene::LoadSceneFile(path, options, loaded.load);
  if (!input.ok()) return base::Error{input.error()};
  auto scene = haptics::BuildScene(*input, loaded.build);
  if (!scene.ok()) return base::Error{path + ": " + scene.error()};
  loaded.scene = std::move(*scene);
  return loaded;
}

std::string FindScene(const std::string& name) {
  std::error_code error;
  if (fs::is_regular_file(name, error)) return name;
  const fs::path shipped = fs::path(config::ScenesFolder()) / (name + ".glb");
  return fs::is_regular_file(shipped, error) ? shipped.string() : name;
}

std::string FindHandScript(const std::string& scene_path) {
  fs::path script(scene_path);
  script.replace_extension(".hand.json");
  std::error_code error;
  return fs::is_regular_file(script, error) ? script.string() : std::string();
}

}  // namespace omni::tools
