#include "service/tools/scene/scene.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "service/config/files/app_file.h"
#include "service/config/files/device_file.h"
#include "service/config/paths.h"
#include "service/config/text/text_file.h"
#include "service/daemon/scenes/scene_builder.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/load_scene.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/terminal.h"

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

// omni scene explain: what of a file is loaded, what is skipped and why, and what it costs. omni scene cost: the same
// as counted by the system. omni scene cache: the cached built scenes. The rest: scene_edit.cc, scene_recover.cc.

namespace {

struct ExplainArguments {
  std::string scene;
  std::string up = "y";
  std::string app;
  bool fit = false;
  bool touch_all = false;
  bool as_json = false;
  bool no_cache = false;
  bool clear = false;
};

int Explain(const ExplainArguments& arguments) {
  const base::Result<std::string> path = FindScene(arguments.scene);
  if (!path.ok()) return FailWith(arguments.as_json, "omni scene explain", path.error());
  scene::LoadOptions options = LoadOptionsOf(arguments);
  options.hull_radius_m = config::DefaultDevice().hull_radius_m;
  options.tip_radius_m = config::NibRadius_m(config::DefaultDevice().magnet);
  if (!arguments.app.empty()) {
    const base::Result<std::string> text = config::ReadTextFile(arguments.app);
    if (!text.ok()) return FailWith(arguments.as_json, "omni scene explain", text.error());
    const auto app = config::ParseAppFile(*text, arguments.app, config::ScenesFolder());
    if (!app.ok()) return FailWith(arguments.as_json, "omni scene explain", app.error());
    options = daemon::LoadOptionsOf(*app, options.hull_radius_m, options.tip_radius_m);
  }
  const base::Result<LoadedScene> loaded = LoadScene(*path, options, !arguments.no_cache);
  if (!loaded.ok()) return FailWith(arguments.as_json, "omni scene explain", loaded.error());
  if (arguments.as_json) {
    PrintJson(SceneJson(*path, *loaded));
  } else {
    Print(SceneText(*path, *loaded));
  }
  return kExitOk;
}

int Cost(const ExplainArguments& arguments) {
  const base::Result<std::string> path = FindScene(arguments.scene);
  if (!path.ok()) return Fail("omni scene cost", path.error());
  const auto cost = SceneCost(*path, {.touch_untagged = arguments.touch_all}, !arguments.no_cache);
  if (!cost.ok()) return Fail("omni scene cost", cost.error());
  PrintJson(*cost);
  return kExitOk;
}

int Cache(const ExplainArguments& arguments) {
  scene::CacheStore store(config::CacheFolder());
  if (!store.problem().empty()) return FailWith(arguments.as_json, "omni scene cache", store.problem());
  const scene::CacheUse use = arguments.clear ? store.Clear() : store.Usage();
  if (arguments.as_json) {
    PrintJson(nlohmann::json{
        {"folder", store.folder()}, {"files", use.files}, {"bytes", use.bytes}, {"removed", arguments.clear}});
    return kExitOk;
  }
  std::printf("%s: %llu files, %.1f MB%s\n", store.folder().c_str(), static_cast<unsigned long long>(use.files),
              static_cast<double>(use.bytes) * 1e-6, arguments.clear ? " removed" : "");
  return kExitOk;
}

}  // namespace

void AddScene(Command& app) {
  auto arguments = std::make_shared<ExplainArguments>();
  Command scene = app.AddCommand("scene", "scene files and sculpted surfaces");
  scene.RequireCommand();
  Command explain =
      scene.AddCommand("explain", "show what of a glTF file is loaded, what is not and why, and its cost");
  explain.Add("file", arguments->scene, "a .glb or .gltf file, or the name of a shipped scene").Required();
  explain.Add("--fit", arguments->fit, "scale and move the model into reach, as placement = \"fit\" does");
  explain.Add("--app", arguments->app, "as an application's file (apps.d) says, whatever scene it names");
  AddUp(explain, arguments->up);
  explain.Add("--touch-all", arguments->touch_all,
              "make a file without haptic tags touchable everywhere (--fit does too)");
  explain.Add("--json", arguments->as_json, "as JSON");
  explain.Add("--no-cache", arguments->no_cache, "build it even if the scene is cached");
  Command cost = scene.AddCommand("cost", "load a scene and print what it cost this process, as JSON");
  cost.Add("file", arguments->scene, "a .glb or .gltf file, or the name of a shipped scene").Required();
  cost.Add("--touch-all", arguments->touch_all, "make a file without haptic tags touchable everywhere");
  cost.Add("--no-cache", arguments->no_cache, "build it even if the scene is cached");
  cost.SetAction(arguments, Cost);
  Command cache = scene.AddCommand("cache", "show the built scenes cached on disk");
  cache.Add("--clear", arguments->clear, "remove them");
  cache.Add("--json", arguments->as_json, "as JSON");
  cache.SetAction(arguments, Cache);
  explain.SetAction(arguments, Explain);
  AddSceneEdits(scene);
  AddSceneRecover(scene);
}

}  // namespace omni::tools
