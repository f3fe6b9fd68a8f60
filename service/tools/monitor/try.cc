// omni try: omnid on the digital twin, and a page on which the mouse is the hand.
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/config/files/device_file.h"
#include "service/config/paths.h"
#include "service/monitor/monitor.h"
#include "service/sim/twin/twin.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/terminal.h"
#include "service/tools/monitor/monitor.h"
#include "service/tools/scene/scene.h"
#include "service/tools/setup/setup.h"

namespace omni::tools {
namespace {

constexpr const char* kTryCommand = "omni try";

struct TryArguments {
  std::string scene = "extrusion";
  std::string up = "y";
  int port = 0;
  bool open = true;
  double seconds = std::numeric_limits<double>::infinity();
  std::string twin_record;
};

// The scenes that Omni ships, in the order of the page.
const std::vector<monitor::SceneChoice>& ShippedChoices() {
  static const std::vector<monitor::SceneChoice> choices = {
      {"extrusion", "Clay", "Press on a face until it takes hold, then pull it out or push it in."},
      {"dragon", "Dragon", "A dragon of soft rubber: press, and it gives way."},
      {"racetrack", "Race track", "The pen is the stick: lean it to steer the car, and feel the walls."},
  };
  return choices;
}

std::vector<std::string> EnvironmentLines(const TrialService& service) {
  return {"export OMNI_SOCKET=" + service.socket(),
          "export XR_API_LAYER_PATH=" + config::ShareFolder() + "/openxr/1/api_layers/explicit.d",
          "export XR_ENABLE_API_LAYERS=XR_APILAYER_OMNI_stylus"};
}

int Try(const TryArguments& arguments) {
  const EndSignals signals;
  const base::Result<std::string> folder = FindPage();
  if (!folder.ok()) return Fail(kTryCommand, folder.error());
  const base::Result<std::string> scene = FindScene(arguments.scene);
  if (!scene.ok()) return Fail(kTryCommand, scene.error());
  const auto service = TrialService::Start(arguments.twin_record);
  if (!service.ok()) return Fail(kTryCommand, service.error());

  const base::DeviceGeometry& device = config::DefaultDevice();
  monitor::MonitorOptions options{.port = static_cast<std::uint16_t>(arguments.port),
                                  .page_folder = *folder,
                                  .socket_path = (*service)->socket(),
                                  .control = true,
                                  .hello = {.version = OMNI_VERSION,
                                            .control = true,
                                            .hand = true,
                                            .scenes = ShippedChoices(),
                                            .max_file_bytes = monitor::kMaxDroppedBytes,
                                            .environment = EnvironmentLines(**service),
                                            .device = device},
                                  // Of a base of the person's own: this omnid has the digital twin.
                                  .setup_steps = [](const nlohmann::json&) { return SetupStepRows(nullptr); }};
  bool shipped = false;
  for (const monitor::SceneChoice& choice : ShippedChoices()) {
    options.scene_paths[choice.name] = ShippedScene(choice.name);
    shipped |= ShippedScene(choice.name) == *scene;
  }
  const monitor::AimLimitOptions limit{.hand_stiffness_N_m = sim::HandScript{}.stiffness_N_m,
                                       .force_max_N = device.force_max_N};
  auto trial = std::make_unique<monitor::Trial>(monitor::TrialOptions{.socket_path = (*service)->socket(),
                                                                      .hand_path = (*service)->hand(),
                                                                      .folder = (*service)->folder(),
                                                                      .hull_radius_m = device.hull_radius_m,
                                                                      .z_up = arguments.up == "z",
                                                                      .aim_limit = limit});
  trial->ChooseScene(*scene, std::filesystem::path(*scene).filename().string(), shipped);
  const auto monitor = monitor::Monitor::Start(options, std::move(trial));
  if (!monitor.ok()) return Fail(kTryCommand, monitor.error());

  std::printf("open  %s\n", (*monitor)->address().c_str());
  std::printf("The base, the pen and its hand are simulated (digital twin). The mouse is the hand. Ctrl-C ends.\n");
  std::printf("An OpenXR application gets the pen with\n");
  for (const std::string& line : options.hello.environment) std::printf("  %s\n", line.c_str());
  std::fflush(stdout);
  if (arguments.open) OpenBrowser((*monitor)->browser_address());
  const std::int64_t start_ns = base::MonotonicNow_ns();
  while (!EndSignals::asked() && static_cast<double>(base::MonotonicNow_ns() - start_ns) * 1e-9 < arguments.seconds) {
    (*monitor)->Step();
    const std::string ended = (*service)->EndReason();
    if (!ended.empty()) return Fail(kTryCommand, ended);
  }
  return kExitOk;
}

}  // namespace

void AddTry(Command& app) {
  auto arguments = std::make_shared<TryArguments>();
  Command command = app.AddCommand("try", "try Omni without hardware: a page on which the mouse is the hand");
  command.Add("scene", arguments->scene, "name of a scene (extrusion, dragon, racetrack) or a .glb file").ShowDefault();
  AddUp(command, arguments->up);
  command.Add("--port", arguments->port, "of 127.0.0.1 (default: any that is free)").Range(1, 65535);
  command.Add("!--no-open", arguments->open, "do not open a browser");
  command.Add("--seconds", arguments->seconds, "end after this many seconds (default: at Ctrl-C)").Positive();
  command.Add("--twin-record", arguments->twin_record, "CSV file of the twin's true pose, forces and currents");
  command.SetAction(arguments, Try);
}

}  // namespace omni::tools
