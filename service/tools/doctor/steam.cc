// Games of Steam run in a container (pressure-vessel) that imports OpenXR layers and sockets of the host only on
// request. [github.com/ValveSoftware/steam-runtime/issues/765: opt-in since 2026-02, experimental]
#include "service/protocol/socket_path.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

Finding CheckSteam(const Surroundings& surroundings) {
  namespace fs = std::filesystem;
  const std::string home = surroundings.Variable("HOME");
  std::error_code error;
  const bool steam = !home.empty() && (fs::exists(fs::path(home) / ".steam", error) ||
                                       fs::exists(fs::path(home) / ".local/share/Steam", error));
  if (!steam) return {Verdict::kOk, "not installed for this user", {}};
  if (surroundings.Has("PRESSURE_VESSEL_IMPORT_OPENXR_1_LAYERS"))
    return {Verdict::kOk, "PRESSURE_VESSEL_IMPORT_OPENXR_1_LAYERS is set: Steam games see the layer", {}};
  const std::string folder = protocol::FolderOf(surroundings.socket_path);
  return {Verdict::kWarn, "Steam games run in a container that imports OpenXR layers only on request",
          "set a game's launch options to: PRESSURE_VESSEL_IMPORT_OPENXR_1_LAYERS=1 "
          "PRESSURE_VESSEL_IMPORT_OPENXR_1_RUNTIMES=1 "
          "PRESSURE_VESSEL_FILESYSTEMS_RW=" +
              folder + " %command% (docs/howto/openxr-layer.md)"};
}

}  // namespace omni::tools
