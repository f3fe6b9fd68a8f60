// Output of `omni scene explain` about a loaded scene.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/tools/scene/scene_source.h"

namespace omni::tools {

// What is loaded, what is skipped and why, bytes, cost, materials, warnings. `path` is only printed.
std::string SceneText(const std::string& path, const LoadedScene& scene);

nlohmann::json SceneJson(const std::string& path, const LoadedScene& scene);

}  // namespace omni::tools
