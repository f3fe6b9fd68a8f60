// Parts of `omni scene`: loading a scene for a tool, and what is shown of it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/load_scene.h"
#include "service/scene/scene_file.h"

namespace omni::tools {

// Loading a scene for a tool: file -> Scene, with both reports, through the user's cache.
struct LoadedScene {
  haptics::Scene scene;
  scene::LoadReport load;
  haptics::BuildReport build;
  scene::LiveReport live;  // of LoadLiveScene
};

// As a command's --fit, --touch-all and --up say.
template <class Arguments>
scene::LoadOptions LoadOptionsOf(const Arguments& arguments) {
  return {.touch_untagged = arguments.fit || arguments.touch_all, .z_up = arguments.up == "z", .fit = arguments.fit};
}

// `cached`: through the user's cache (config::CacheFolder), as omnid does; false: always built.
base::Result<LoadedScene> LoadScene(const std::string& path, const scene::LoadOptions& options, bool cached = true);

// The same with everything that changes while the scene is in use: soft bodies, which may take minutes the first time,
// and sculptable surfaces.
base::Result<LoadedScene> LoadLiveScene(const std::string& path, const scene::LoadOptions& options);

// Name of a scene as typed by a user -> its file (config/paths.h).
base::Result<std::string> FindScene(const std::string& name);

// A scene that we ship: "dragon" -> <scenes>/dragon.glb.
std::string ShippedScene(const std::string& name);

// The hand script that goes with a scene: <same folder>/<name>.hand.json; empty: there is none.
std::string FindHandScript(const std::string& scene_path);

// Which features a loaded scene uses: each on or off, and why.
struct SceneFeature {
  std::string name;  // at most 10 characters
  bool on = false;
  std::string why;
};

// In a fixed order, all of them: also for the empty scene of an untagged file.
std::vector<SceneFeature> FeaturesOf(const LoadedScene& loaded);

// What loading a scene costs the process, counted by the system: for `omni scene cost` and, in a fresh child of it
// each, `omni-bench scene`.
struct ProcessUse {
  std::uint64_t read_bytes = 0;  // rchar of /proc/self/io: all that read() and pread() returned
  std::uint64_t threads = 0;     // entries of /proc/self/task
  std::uint64_t rss_bytes = 0;   // VmRSS of /proc/self/status
};
ProcessUse MeasureThisProcess();

// Loads `path` and reports the differences: bytes_file, bytes_read (by the system), bytes_counted (by us),
// images_decoded, threads (more than before), rss_MB (more than before), load_ms, build_ms, cached, skipped, triangles;
// and what the service would allocate besides, computed without allocating it: soft_bodies, soft_bytes_max, sculpted,
// sculpted_bytes.
base::Result<nlohmann::ordered_json> SceneCost(const std::string& path, const scene::LoadOptions& options, bool cached);

// Output of `omni scene explain` about a loaded scene.

// What is loaded, what is skipped and why, bytes, cost, materials, warnings. `path` is only printed.
std::string SceneText(const std::string& path, const LoadedScene& scene);

nlohmann::json SceneJson(const std::string& path, const LoadedScene& scene);

// omni scene edits, undo, redo, save: what was sculpted in a running service.

// A line for the scene, one for each object.
std::string EditsText(const nlohmann::json& edits);

// omni scene recover: `rows` as its --json prints them.
std::string JournalsText(const std::string& folder, const nlohmann::json& rows);

// The race in a status, for people.

// "2 laps, last 9.84 s, best 9.61 s, now 3.20 s; 52 mm/s; 4 hits"; empty: no race is on.
std::string RaceText(const nlohmann::json& status);

}  // namespace omni::tools
