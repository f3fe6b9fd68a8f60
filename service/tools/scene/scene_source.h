// Loading a scene for a tool: file -> Scene, with both reports, through the user's cache.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/load_scene.h"
#include "service/scene/scene_file.h"

namespace omni::tools {

struct LoadedScene {
  haptics::Scene scene;
  scene::LoadReport load;
  haptics::BuildReport build;
  scene::LiveReport live;  // of LoadLiveScene
};

// `cached`: through the user's cache (config::CacheFolder), as omnid does; false: always built.
base::Result<LoadedScene> LoadScene(const std::string& path, const scene::LoadOptions& options, bool cached = true);

// The same with everything that changes while the scene is in use: soft bodies, which may take minutes the first time,
// and sculptable surfaces.
base::Result<LoadedScene> LoadLiveScene(const std::string& path, const scene::LoadOptions& options);

// Name of a scene as typed by a user -> its file (config/scene_name.h).
base::Result<std::string> FindScene(const std::string& name);

// A scene that we ship: "dragon" -> <scenes>/dragon.glb.
std::string ShippedScene(const std::string& name);

// The hand script that goes with a scene: <same folder>/<name>.hand.json; empty: there is none.
std::string FindHandScript(const std::string& scene_path);

}  // namespace omni::tools
