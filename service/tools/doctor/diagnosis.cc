#include "service/tools/doctor/diagnosis.h"

#include <unistd.h>

#include <string_view>

#include "service/client/connection.h"
#include "service/config/paths.h"
#include "service/protocol/socket_path.h"
#include "service/tools/common/service_link.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {
namespace {

constexpr DiagnosisEntry kDiagnoses[] = {
    {"OpenXR runtime", LookForRuntime},
    {"layer manifest", LookForLayer},
    {"layer library", CheckLayerLibrary},
    {"layer enabled", CheckEnabledLayers},
    {"installations", LintBadInstallation},
    {"switches", LintDisabledByEnvironment},
    {"duplicates", LintDuplicates},
    {"architectures", LintExplicitLayerArchitectures},
    {"order", LintOrdering},
    {"loader", LintSkippedByLoader},
    {"Steam", CheckSteam},
    {"socket folder", CheckSocketFolder},
    {"service", LookForService},
    {"emergency stop", CheckStop},
    {"device", LookForDevice},
    {"calibration", CheckCalibration},
    {"room", CheckRoom},
    {"real-time", CheckRealtime},
    {"applications", CheckApplications},
    {"alignment", CheckAlignment},
};

bool StartsOnDemand(const std::string& socket_path) {
  return protocol::PathProblem(socket_path).empty() &&
         protocol::FindService(socket_path) == protocol::ServiceState::kOnDemand;
}

}  // namespace

std::span<const DiagnosisEntry> DiagnosisTable() { return kDiagnoses; }

std::string Surroundings::EnvironmentVariable(const std::string& name) const {
  const auto found = environment.find(name);
  return found == environment.end() ? std::string() : found->second;
}

Surroundings SurroundingsOfThisProcess(const std::string& socket_path) {
  Surroundings surroundings;
  for (char** entry = ::environ; entry != nullptr && *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos) continue;
    surroundings.environment.emplace(text.substr(0, equals), text.substr(equals + 1));
  }
  surroundings.socket_path = socket_path.empty() ? client::DefaultSocketPath() : socket_path;
  surroundings.stop_file = config::UserStopFile();
  surroundings.app_folders = config::AppFolders();
  surroundings.scenes_folder = config::ScenesFolder();
  surroundings.share = config::ShareFolder();
  surroundings.loader = QueryLoader();
  base::Result<nlohmann::json> status = FetchStatus(socket_path);
  if (status.ok()) {
    surroundings.service = {.running = true, .on_demand = false, .error = {}, .status = std::move(*status)};
  } else {
    surroundings.service = {
        .running = false, .on_demand = StartsOnDemand(surroundings.socket_path), .error = status.error(), .status = {}};
  }
  return surroundings;
}

}  // namespace omni::tools
