// omni doctor: each diagnosis checks one thing and reports the finding in one sentence, with a fix.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace omni::tools {

inline constexpr const char* kLayerName = "XR_APILAYER_OMNI_stylus";

enum class Verdict { kOk, kWarn, kFail };  // warn: works, but not as well as it could

struct Finding {
  Verdict verdict = Verdict::kOk;
  std::string what;
  std::string fix;    // empty when ok
  std::string apply;  // a command that `omni doctor --fix` can run for it; empty: a person has to
};

// The service's status, requested once for all diagnoses.
struct ServiceAnswer {  // NOLINT(bugprone-exception-escape): says so of json's constructor, which is noexcept
  bool running = false;
  bool on_demand = false;  // systemd starts it with the first application
  std::string error;       // when not running
  nlohmann::json status;   // when running
};

// The layers that the OpenXR loader of this machine lists.
struct LoaderAnswer {
  bool asked = false;               // false: no loader is installed
  std::string error;                // why it could not list the layers
  std::vector<std::string> layers;  // implicit ones that are not disabled, and explicit ones
};

// Everything that the diagnoses examine. Tests pass fabricated ones.
struct Surroundings {
  std::map<std::string, std::string> environment;
  std::filesystem::path root = "/";  // system folders are resolved below it
  std::string socket_path;
  std::string stop_file;                 // latch of an emergency stop
  std::vector<std::string> app_folders;  // of application files, in order of precedence
  std::string scenes_folder;
  std::filesystem::path share;  // beside this program: ../share, of a build tree or an installation; empty: unknown
  ServiceAnswer service;
  LoaderAnswer loader;

  // Empty: not set.
  std::string EnvironmentVariable(const std::string& name) const;
  // Set, even if empty: how the OpenXR loader reads its enable and disable variables.
  bool HasVariable(const std::string& name) const { return environment.count(name) != 0; }
  std::filesystem::path SystemPath(const std::string& path) const { return root / path.substr(1); }
};

Surroundings SurroundingsOfThisProcess(const std::string& socket_path);

struct DiagnosisEntry {
  const char* name;
  Finding (*look)(const Surroundings&);
};
// In the order in which problems should be fixed.
std::span<const DiagnosisEntry> DiagnosisTable();

Finding LookForLayer(const Surroundings& surroundings);
Finding CheckLayerLibrary(const Surroundings& surroundings);
Finding CheckEnabledLayers(const Surroundings& surroundings);
Finding LookForRuntime(const Surroundings& surroundings);
Finding CheckSocketFolder(const Surroundings& surroundings);
Finding LookForService(const Surroundings& surroundings);
Finding CheckStop(const Surroundings& surroundings);
Finding LookForDevice(const Surroundings& surroundings);
Finding CheckCalibration(const Surroundings& surroundings);
Finding CheckRoom(const Surroundings& surroundings);
Finding CheckRealtime(const Surroundings& surroundings);
Finding CheckApplications(const Surroundings& surroundings);
Finding CheckAlignment(const Surroundings& surroundings);
Finding CheckSteam(const Surroundings& surroundings);

// The six portable rules of OpenXR-API-Layers-GUI (github.com/fredemmott/OpenXR-API-Layers-GUI), over all layers of
// this machine, not only ours: any of them can keep applications from starting.
Finding LintBadInstallation(const Surroundings& surroundings);
Finding LintDisabledByEnvironment(const Surroundings& surroundings);
Finding LintDuplicates(const Surroundings& surroundings);
Finding LintExplicitLayerArchitectures(const Surroundings& surroundings);
Finding LintOrdering(const Surroundings& surroundings);
Finding LintSkippedByLoader(const Surroundings& surroundings);

// Findings of `omni doctor` as text and as JSON.
struct Diagnosed {
  std::string name;
  Finding finding;
};

// Every diagnosis once, in the table's order.
std::vector<Diagnosed> Diagnose(const Surroundings& surroundings);

// `status` is omnid's, null if it does not run: a simulation is reported first.
std::string DoctorText(const std::vector<Diagnosed>& findings, const nlohmann::json& status);
nlohmann::json DoctorJson(const std::vector<Diagnosed>& findings, const nlohmann::json& status);

bool AnyFailed(const std::vector<Diagnosed>& findings);

}  // namespace omni::tools
