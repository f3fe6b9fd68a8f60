// What applications need besides.
#include "service/config/files/app_file.h"
#include "service/config/files/device_file.h"
#include "service/daemon/scenes/scene_builder.h"
#include "service/protocol/socket_path.h"
#include "service/tools/doctor/diagnosis.h"
#include "service/tools/scene/scene.h"

namespace omni::tools {

// Are the application files valid, and do their scenes load?
Finding CheckApplications(const Surroundings& surroundings) {
  const config::AppTable table = config::LoadAppTable(surroundings.app_folders, surroundings.scenes_folder);
  if (!table.problems.empty()) {
    return {Verdict::kFail, table.problems.front(), "correct that file; omnid skips it until then"};
  }
  if (table.entries.empty()) {
    return {Verdict::kWarn, "no application has a scene", "add a file to ~/.config/omni/apps.d (docs/howto/apps.md)"};
  }
  const base::DeviceGeometry& device = config::DefaultDevice();
  const double tip_radius_m = config::NibRadius_m(device.magnet);
  for (const config::AppEntry& entry : table.entries) {
    if (entry.scene.empty()) continue;  // it configures inputs only
    const base::Result<std::string> file = FindScene(entry.scene);
    const base::Result<LoadedScene> scene =
        file.ok() ? LoadScene(*file, daemon::LoadOptionsOf(entry, device.hull_radius_m, tip_radius_m))
                  : base::Error{file.error()};
    if (!scene.ok()) {
      return {Verdict::kFail, "the scene of \"" + entry.application_glob + "\" does not load: " + scene.error(),
              "correct the scene, or its name in " + entry.file};
    }
  }
  return {Verdict::kOk, std::to_string(table.entries.size()) + " application entries, all scenes load", {}};
}

// Games of Steam run in a container (pressure-vessel) that imports OpenXR layers and sockets of the host only on
// request. [github.com/ValveSoftware/steam-runtime/issues/765: opt-in since 2026-02, experimental]
Finding CheckSteam(const Surroundings& surroundings) {
  namespace fs = std::filesystem;
  const std::string home = surroundings.EnvironmentVariable("HOME");
  std::error_code error;
  const bool steam = !home.empty() && (fs::exists(fs::path(home) / ".steam", error) ||
                                       fs::exists(fs::path(home) / ".local/share/Steam", error));
  if (!steam) return {Verdict::kOk, "not installed for this user", {}};
  if (surroundings.HasVariable("PRESSURE_VESSEL_IMPORT_OPENXR_1_LAYERS"))
    return {Verdict::kOk, "PRESSURE_VESSEL_IMPORT_OPENXR_1_LAYERS is set: Steam games see the layer", {}};
  const std::string folder = protocol::FolderOf(surroundings.socket_path);
  return {Verdict::kWarn, "Steam games run in a container that imports OpenXR layers only on request",
          "set a game's launch options to: PRESSURE_VESSEL_IMPORT_OPENXR_1_LAYERS=1 "
          "PRESSURE_VESSEL_IMPORT_OPENXR_1_RUNTIMES=1 "
          "PRESSURE_VESSEL_FILESYSTEMS_RW=" +
              folder + " %command% (docs/howto/openxr-layer.md)"};
}

}  // namespace omni::tools
