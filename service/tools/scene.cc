// omni scene explain: what of a file is loaded, what is skipped and why, and what it costs.
#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "service/config/device_file.h"
#include "service/tools/command_line.h"
#include "service/tools/commands.h"
#include "service/tools/scene_source.h"
#include "service/tools/scene_text.h"

namespace omni::tools {
namespace {

struct ExplainArguments {
  std::string scene;
  bool fit = false;
  bool touch_all = false;
  bool as_json = false;
};

int Explain(const ExplainArguments& arguments) {
  const std::string path = FindScene(arguments.scene);
  const base::Result<LoadedScene> loaded = LoadScene(path, {.touch_untagged = arguments.fit || arguments.touch_all,
                                                            .fit = arguments.fit,
                                                            .hull_radius_m = config::DefaultDevice().hull_radius_m});
  if (!loaded.ok()) return Fail("omni scene explain", loaded.error());
  if (arguments.as_json) {
    std::cout << SceneJson(path, *loaded).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
  } else {
    std::cout << SceneText(path, *loaded);
  }
  return kExitOk;
}

}  // namespace

void AddScene(CLI::App& app) {
  auto arguments = std::make_shared<ExplainArguments>();
  CLI::App* scene = app.add_subcommand("scene", "scene files");
  scene->require_subcommand(1);
  CLI::App* explain = scene->add_subcommand("explain", "what of a glTF file is loaded, what not and why, and its cost");
  explain->add_option("file", arguments->scene, "a .glb or .gltf file, or the name of a shipped scene")->required();
  explain->add_flag("--fit", arguments->fit, "scale and move the model into reach, as placement = \"fit\" does");
  explain->add_flag("--touch-all", arguments->touch_all, "touch all of a file without haptic tags (--fit does too)");
  explain->add_flag("--json", arguments->as_json, "as JSON");
  explain->callback([arguments] { throw CLI::RuntimeError(Explain(*arguments)); });
}

}  // namespace omni::tools
