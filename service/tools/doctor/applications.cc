// Are the application files valid, and do their scenes load?
#include "service/config/files/app_file.h"
#include "service/config/files/device_file.h"
#include "service/daemon/scenes/scene_builder.h"
#include "service/tools/doctor/diagnosis.h"
#include "service/tools/scene/scene_source.h"

namespace omni::tools {
Finding CheckApplications(const Surroundings& surroundings) {
  const config::AppTable table = config::LoadAppTable(surroundings.app_folders, surroundings.scenes_folder);
  if (!table.problems.empty()) {
    return {Verdict::kFail, table.problems.front(), "correct that file; omnid skips it until then"};
  }
  if (table.entries.empty()) {
    return {Verdict::kWarn, "no application has a scene", "add a file to ~/.config/omni/apps.d (docs/howto/apps.md)"};
  }
  for (const config::AppEntry& entry : table.entries) {
    if (entry.scene.empty()) continue;  // it configures inputs only
    const base::Result<std::string> file = FindScene(entry.scene);
    const base::Result<LoadedScene> scene =
        file.ok() ? LoadScene(*file, daemon::LoadOptionsOf(entry, config::DefaultDevice().hull_radius_m))
                  : base::Error{file.error()};
    if (!scene.ok()) {
      return {Verdict::kFail, "the scene of \"" + entry.application_glob + "\" does not load: " + scene.error(),
              "correct the scene, or its name in " + entry.file};
    }
  }
  return {Verdict::kOk, std::to_string(table.entries.size()) + " application entries, all scenes load", {}};
}

}  // namespace omni::tools
